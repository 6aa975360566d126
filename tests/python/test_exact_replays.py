"""Hidden effects whose own history a replay has to follow exactly: down to the noise, with the size that was hidden.

A bent spring of the manipulator makes each window depend on where it starts; a grip that gives way decides all that
follows. Records come from the generator of tests/hidden_effects, which shares no code with the program.
"""

import json

import pytest
from conftest import command
from hidden_record import hidden_and_told, slow


@pytest.mark.parametrize("seed, effect, block", [
    slow(102, "manipulator.quadratic_stiffness", "manipulator"),
    slow(105, "manipulator.cubic_stiffness", "manipulator"),
    (103, "manipulator.backlash", "manipulator"), (104, "object.loss_of_contact", "force"),
])
@pytest.mark.first(1)
def test_what_was_hidden_is_named_with_its_size_and_leaves_noise(seed, effect, block, tmp_path):
    [hidden], told = hidden_and_told(tmp_path, seed, "--effect", effect, "--size", "large")
    found = next(one for one in told["blocks"] if one["block"] == block)
    print(hidden["parameters"], [(c["effect"], [(p["name"], p["value"]) for p in c["parameters"]]) for c in found["causes"]],
          found["residual"]["fit"])
    assert told["verdict"] == "named" and [c["effect"] for c in found["causes"]] == [effect]
    for parameter in found["causes"][0]["parameters"]:
        assert parameter["value"] == pytest.approx(hidden["parameters"][parameter["name"]], rel=1e-3)
    assert found["residual"]["fit"]["after"] < 1.1 * found["residual"]["fit"]["floor"]


@pytest.mark.parametrize("seed", [
    7214,  # whole ticks lost, and a parameter of the object
    7274,  # spikes of the sensor, beside a drift of the robot
])
@pytest.mark.first(1)
def test_what_happened_to_single_samples_of_unseen_data_is_known_there_too(seed, tmp_path):
    _, told = hidden_and_told(tmp_path, seed, "--kind", "two")
    floor_N = json.loads((tmp_path / "truth/truth.json").read_text())["floor_rms"]["force_N"]
    assert told["verdict"] == "named" and (tmp_path / "record/validate.csv").exists()
    assert told["residual"]["force_N"]["held_out"]["after"] < 1.1 * floor_N


@pytest.mark.slow
def test_setpoints_lost_in_unseen_data_are_known_there_too(tmp_path):
    """Each stands out of the noise of a stiff contact by a thousand; one short way of 29 is not found."""
    hidden_and_told(tmp_path, 7175, "--kind", "single", "--effect", "robot.lost_commands", "--size", "tiny")
    told = json.loads((tmp_path / "out/diagnosis.json").read_text())["residual"]["force_N"]["held_out"]
    assert told["after"] < 0.002 * told["before"]


@pytest.mark.parametrize("seed, size", [
    slow(115151, "large"), slow(115284, "small"), slow(137311, "large"),
    slow(126268, "large"), slow(148076, "large"),
])
def test_lost_setpoints_that_ring_together_are_told_apart(seed, size, tmp_path):
    """Three within a few ticks cancel each other in a stiff contact, and others in a row would stand in for them; one in
    nine, which the noise of the reports hides, rings into the next ones."""
    _, told = hidden_and_told(tmp_path, seed, "--kind", "single", "--effect", "robot.lost_commands", "--size", size)
    floor_N = json.loads((tmp_path / "truth/truth.json").read_text())["floor_rms"]["force_N"]
    assert told["verdict"] == "named" and [cause["effect"] for cause in told["causes"]] == ["robot.lost_commands"]
    for part in ("fit", "held_out"):
        assert told["residual"]["force_N"][part]["after"] < 1.1 * floor_N, part


def test_a_velocity_limit_acts_between_the_ticks(tmp_path):
    """Of a robot whose way is known to a micrometre, ticks of a limit on its setpoints leave thirty."""
    [hidden], told = hidden_and_told(tmp_path, 115264, "--kind", "single", "--effect", "robot.velocity_limit", "--size", "large")
    floor_m = json.loads((tmp_path / "truth/truth.json").read_text())["floor_rms"]["robot_position_m"]
    [cause] = told["causes"]
    assert told["verdict"] == "named" and cause["effect"] == "robot.velocity_limit"
    assert cause["parameters"][0]["value"] == pytest.approx(hidden["parameters"]["velocity_limit_m_per_s"], rel=1e-4)
    assert told["residual"]["robot_position_m"]["held_out"]["after"] < 1.1 * floor_m


@pytest.mark.slow
def test_friction_is_fitted_with_slopes_as_wide_as_the_error_is_far(tmp_path):
    """With a presliding way of 0.1 um, each reversal falls into another sub-step: slopes over less say nothing."""
    others = [one["effect"] for one in json.loads(command("effects", "--json").stdout)
              if one["effect"] not in ("manipulator.coulomb_friction", "object.parameters")]
    hidden, told = hidden_and_told(tmp_path, 126204, "--kind", "two",
                                   options=[word for name in others for word in ("--without", name)])
    [friction_N] = [one["parameters"]["coulomb_friction_N"] for one in hidden if one["effect"] == "manipulator.coulomb_friction"]
    found = {one["name"]: one["value"] for cause in told["causes"] for one in cause["parameters"]}
    left = told["residual"]["command_position_m"]["fit"]
    print(friction_N, found, left)
    assert found["coulomb_friction_N"] == pytest.approx(friction_N, rel=1e-3)
    assert left["after"] < 1.2 * left["floor"]


@pytest.mark.slow
def test_friction_is_found_at_another_presliding_way_once_its_asymmetry_is_known(tmp_path):
    """Alone it fits best at a way that is wrong by half, and with the asymmetry beside it stayed there."""
    friction = ("manipulator.coulomb_friction", "manipulator.gravity_offset", "manipulator.asymmetric_friction")
    others = [one["effect"] for one in json.loads(command("effects", "--json").stdout) if one["effect"] not in friction]
    [hidden], told = hidden_and_told(tmp_path, 115037, "--kind", "single", "--effect", friction[2], "--size", "large",
                                     rows=4000, options=[word for name in others for word in ("--without", name)])
    found = {one["name"]: one["value"] for cause in told["causes"] for one in cause["parameters"]}
    for name in ("coulomb_friction_N", "damping_asymmetry_N_s_per_m"):
        assert found[name] == pytest.approx(hidden["parameters"][name], rel=2e-3), name
    left = told["residual"]["command_position_m"]["fit"]
    assert left["after"] < 0.002 * left["before"]


@pytest.mark.parametrize("seed, effect, size", [
    # A clock that slips once in the record, and one that slips backwards.
    (31125, "loop.clock_drift", "tiny"), (31191, "loop.clock_drift", "small"),
    # Two slips that the noise of the reports leaves dozens of ticks.
    (159223, "loop.clock_drift", "large"),
    # Ticks that a coarse force, or many chance repetitions, hide in one channel.
    (31020, "loop.lost_samples", "tiny"), (31086, "loop.lost_samples", "small"),
    (31171, "sensor.dropouts", "large"),
])
@pytest.mark.first(1)
def test_intervals_hold_what_slips_and_what_is_lost(seed, effect, size, tmp_path):
    """Twice the stated 95 %: a draw is outside once in ten thousand."""
    [hidden], told = hidden_and_told(tmp_path, seed, "--kind", "single", "--effect", effect, "--size", size)
    assert told["verdict"] == "named" and [c["effect"] for c in told["causes"]] == [effect]
    for parameter in told["causes"][0]["parameters"]:
        true, (low, high) = hidden["parameters"][parameter["name"]], parameter["ci95"]
        print(parameter["name"], true, parameter["value"], low, high)
        assert abs(parameter["value"] - true) < high - low and high > low


@pytest.mark.parametrize("seed, size", [
    # A slip that noise hides in the reports, one in a part that was held out, and slips of which each is off by more.
    (159157, "medium"), (148026, "large"), (148293, "large"),
])
@pytest.mark.first(1)
def test_slips_of_a_clock_are_in_the_ticks_in_which_the_force_shows_them(seed, size, tmp_path):
    """A stiff contact answers to a slip in another tick with ten times the noise."""
    [hidden], told = hidden_and_told(tmp_path, seed, "--kind", "single", "--effect", "loop.clock_drift", "--size", size)
    assert told["verdict"] == "named" and [cause["effect"] for cause in told["causes"]] == ["loop.clock_drift"]
    found = {one["name"]: one["value"] for one in told["causes"][0]["parameters"]}
    print(hidden["parameters"], found, told["residual"]["force_N"])
    assert found["clock_drift_ppm"] == pytest.approx(hidden["parameters"]["clock_drift_ppm"], rel=0.03)
    floor_N = json.loads((tmp_path / "truth/truth.json").read_text())["floor_rms"]["force_N"]
    assert told["residual"]["force_N"]["fit"]["after"] < 1.1 * floor_N


@pytest.mark.slow
def test_a_slip_in_the_middle_of_a_fast_move_and_a_disturbance_behind_it_are_both_exact(tmp_path):
    """Of the robot's error the moves are all: a guess that is a tenth of a second off explains nothing."""
    (clock, periodic), told = hidden_and_told(tmp_path, 214234, "--kind", "two")
    assert told["verdict"] == "named"
    for hidden, cause in zip((clock, periodic), told["causes"], strict=True):
        assert cause["effect"] == hidden["effect"]
        for parameter in cause["parameters"]:
            true, (low, high) = hidden["parameters"][parameter["name"]], parameter["ci95"]
            print(parameter["name"], true, parameter["value"], low, high)
            assert abs(parameter["value"] - true) < high - low


@pytest.mark.slow
def test_a_sensors_lag_of_about_a_tick_is_not_taken_for_a_slip_in_another_tick(tmp_path):
    (lag, clock), told = hidden_and_told(tmp_path, 651224, "--kind", "two")
    assert told["verdict"] == "named"
    found = {cause["effect"]: cause["parameters"][0] for cause in told["causes"]}
    print(found, lag, clock)
    assert set(found) == {"sensor.lag", "loop.clock_drift"}
    low, high = found["sensor.lag"]["ci95"]
    assert low < lag["parameters"]["lag_ms"] < high
    assert found["loop.clock_drift"]["value"] == pytest.approx(clock["parameters"]["clock_drift_ppm"], rel=0.03)


@pytest.mark.slow
def test_a_friction_that_falls_with_velocity_is_not_told_as_less_damping(tmp_path):
    """The hidden friction has a Stribeck curve, ours has none: what that leaves would suit 15 % less damping."""
    hidden, told = hidden_and_told(tmp_path, 661103, "--kind", "two_of_one_block")
    causes = sorted(cause["effect"] for cause in told["causes"])
    assert causes == sorted(one["effect"] for one in hidden) == ["object.backlash", "object.coulomb_friction"]


@pytest.mark.slow
def test_a_resonance_that_a_lag_and_a_longer_dead_time_match_is_told_in_part(tmp_path):
    """A second-order lag that hardly swings; the reports have nothing against it."""
    _, told = hidden_and_told(tmp_path, 812, "--effect", "robot.lag,robot.dead_time")
    robot = next(block for block in told["blocks"] if block["block"] == "robot")
    print(robot["verdict"], robot["doubts"])
    assert told["verdict"] == "partly_explained" and "two other effects together do as well" in robot["doubts"]


@pytest.mark.slow
def test_setpoints_that_only_the_force_decodes_are_counted(tmp_path):
    """Behind dry friction of 26 times the noise no loss stands out by itself."""
    effects, told = hidden_and_told(tmp_path, 214044, "--kind", "two")
    [lost] = [one for one in effects if one["effect"] == "robot.lost_commands"]
    [cause] = [one for one in told["causes"] if one["effect"] == "robot.lost_commands"]
    [chance] = cause["parameters"]
    print(lost["parameters"], chance)
    assert told["verdict"] == "partly_explained" and 0.0 < chance["value"] < lost["parameters"]["lost_command_probability"]
    # Play of a third of the noise stands in for them in the reports.
    robot = next(block for block in told["blocks"] if block["block"] == "robot")
    assert robot["verdict"] == "partly_explained" and "hardly shows in the reports" in robot["doubts"][-1]


@pytest.mark.slow
def test_a_force_that_follows_an_unexplained_robot_is_not_called_free_of_faults(tmp_path):
    """A limit that winds up, which the library lacks: the force swings with what is left of it, and hides 2 N."""
    _, told = hidden_and_told(tmp_path, 214134, "--kind", "two")
    force = next(block for block in told["blocks"] if block["block"] == "force")
    assert told["verdict"] == "partly_explained" and force["verdict"] == "unknown"


@pytest.mark.parametrize("seed", [214184, 214054])
@pytest.mark.slow
def test_dry_friction_of_the_manipulator_is_exact_beside_a_second_effect(tmp_path, seed):
    """The replay sticks and turns at other moments with every other size: a fit by itself ends beside the truth."""
    hidden, told = hidden_and_told(tmp_path, seed, "--kind", "two")
    assert told["verdict"] in ("named", "one_of")
    [friction] = [one for one in hidden if one["effect"].startswith("manipulator.")]
    assert friction["effect"] in [cause["effect"] for cause in told["causes"]]
    [last] = [cause for cause in told["causes"] if cause["effect"] == friction["effect"]]
    [dry] = [parameter for parameter in last["parameters"] if parameter["name"] == "coulomb_friction_N"]
    true_N = friction["parameters"]["coulomb_friction_N"]
    print(seed, true_N, dry)
    assert abs(dry["value"] - true_N) < 1e-3 * true_N
    low, high = dry["ci95"]
    assert low < true_N < high  # neither of the noise alone: the replay is a little off, however small that is
    [block] = [block for block in told["blocks"] if block["block"] == "manipulator"]
    unseen = block["residual"]["held_out"]
    # Steps of the replay are off by 3e-4 of what friction does at most; here both those of the fit and of the unseen record.
    assert unseen["after"] < max(1.25 * unseen["floor"], 4.3e-4 * unseen["before"])


@pytest.mark.slow
def test_what_comes_in_bursts_is_no_spike(tmp_path):
    """Slips of a clock that is left out of the library ring in a stiff contact."""
    _, told = hidden_and_told(tmp_path, 159223, "--kind", "single", "--effect", "loop.clock_drift", "--size", "large",
                              options=("--without", "loop.clock_drift"))
    assert told["verdict"] != "named" and "sensor.spikes" not in [cause["effect"] for cause in told["causes"]]


@pytest.mark.parametrize("seed, effect, size, neighbour", [
    # A pendulum, which fits a negative cubic on one record and not on another with more way, or hardly on one.
    (31257, "outside.object_softening", "medium", "object.cubic_stiffness"),
    (31157, "outside.object_softening", "medium", "object.cubic_stiffness"),
    (31077, "outside.sensor_curvature", "small", "object.cubic_stiffness"),
    # One that acts otherwise far out, and two that act otherwise early than late.
    (126167, "outside.object_softening", "large", "object.cubic_stiffness"),
    (126307, "outside.robot_gain_drift", "tiny", "robot.gain"), (126197, "outside.sensor_warming", "tiny", "sensor.bias"),
])
@pytest.mark.slow
def test_a_neighbour_of_what_the_library_lacks_is_told_as_a_part(seed, effect, size, neighbour, tmp_path):
    _, told = hidden_and_told(tmp_path, seed, "--kind", "outside", "--effect", effect, "--size", size)
    assert told["verdict"] == "partly_explained" and [c["effect"] for c in told["causes"]] == [neighbour]


@pytest.mark.parametrize("seed, causes", [(751047, ["object.coulomb_friction", "object.parameters"]),
                                          slow(751147, ["object.coulomb_friction"])])
@pytest.mark.slow
def test_friction_that_falls_with_speed_is_told_as_a_part(seed, causes, tmp_path):
    """It fits down to the noise as dry friction beside less damping: half of it, or as little as the rig allows."""
    _, told = hidden_and_told(tmp_path, seed, "--kind", "outside", "--effect", "outside.object_stribeck")
    assert told["verdict"] == "partly_explained" and [cause["effect"] for cause in told["causes"]] == causes
    [force] = [block for block in told["blocks"] if block["block"] == "force"]
    assert any("falls with speed" in doubt for doubt in force["doubts"])


@pytest.mark.parametrize("seed, effect, doubt", [
    (861007, "outside.robot_lag_drift", "as a low-pass does"), (861107, "outside.robot_lag_drift", "as a low-pass does"),
    # A bend over the position, as which a sine of a longer period than the way passes.
    (861117, "outside.robot_curvature", "less than one and a half periods"),
])
@pytest.mark.slow
def test_what_fits_to_the_noise_is_told_as_a_part_where_it_acts_otherwise(seed, effect, doubt, tmp_path):
    _, told = hidden_and_told(tmp_path, seed, "--kind", "outside", "--effect", effect)
    assert told["verdict"] == "partly_explained"
    [robot] = [block for block in told["blocks"] if block["block"] == "robot"]
    assert any(doubt in one for one in robot["doubts"])


@pytest.mark.slow
def test_a_mode_whose_mass_may_be_none_is_not_named(tmp_path):
    """Parameters a little beyond their tolerances, which a small second mode fits as well; its interval holds zero."""
    _, told = hidden_and_told(tmp_path, 148021, "--kind", "single", "--effect", "object.parameters", "--size", "tiny")
    assert "object.second_mode" not in [cause["effect"] for cause in told["causes"]]
