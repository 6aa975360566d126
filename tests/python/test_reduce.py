"""What `berth reduce` says beside its numbers: what it left out, what it passed over, how far it looked."""

import pytest
from conftest import RIG_FOLDER, command, one_json_object


def reduce(*words):
    return one_json_object(command("reduce", *words, "--json").stdout)


@pytest.mark.parametrize("key,value,says", [
    ("robot.jitter_ms", "1", "up to 1 ms early or late"),
    ("robot.clock", "free", "by a clock of its own"),
    ("sensor.loss_probability", "0.01", "frames are lost"),
])
def test_what_changes_from_period_to_period_is_named_and_left_out(key, value, says):
    steady, varying = reduce("ess"), reduce("ess", "--set", f"{key}={value}")
    assert steady["left_out"] == []
    assert len(varying["left_out"]) == 1 and says in varying["left_out"][0]
    assert varying["poses"] == steady["poses"]
    assert says in command("reduce", "ess", "--set", f"{key}={value}").stderr.decode()


HELD = {"is_free = true": "is_free = false", 'actuator = "wheel"': 'actuator = "none"'}


@pytest.mark.parametrize("rig,is_held", [("ess-berthing", False), ("ess", False), ("ess", True), ("ess-pose", False)])
def test_the_full_arm_in_the_loop_is_the_one_of_eigen_and_run(rig, is_held, tmp_path):
    """Its tool is as free as in a run: nothing guides it."""
    text = (RIG_FOLDER.parent / "arms" / "ess.toml").read_text()
    for own, other in HELD.items() if is_held else ():
        assert text.count(own) == 1
        text = text.replace(own, other)
    arm = tmp_path / "arm.toml"
    arm.write_text(text)
    known = one_json_object(command("eigen", rig, "--json", "--set", f"manipulator.arm={arm}").stdout)
    [pose] = reduce(rig, *["--held"] * is_held)["poses"]
    assert pose["loop"]["full"]["growth_per_s"] == pytest.approx(known["growth_per_s"], rel=1e-6)
    [guided] = reduce("ess", "--guided", *["--held"] * is_held)["poses"]
    assert guided["loop"]["full"]["growth_per_s"] != pytest.approx(known["growth_per_s"], rel=0.1)


def test_with_further_axes_it_says_which_of_them_move():
    assert reduce("ess-berthing")["compared"] == []
    compared = reduce("ess-pose")["compared"]
    assert len(compared) == 3
    assert "model is without" in compared[0] and "along x alone" in compared[1] and "all axes" in compared[2]
    shown = command("reduce", "ess-pose").stdout.decode()
    assert all(line in shown for line in compared)


def test_a_mode_of_the_attitude_control_is_marked_and_passed_over():
    """At this pose the tool has more of it than of any other that is held."""
    words = ("ess", "--pose", "1.35,-0.5")
    [pose] = reduce(*words)["poses"]
    held = [mode for mode in pose["modes"] if mode["frequency_Hz"] > 0.0]
    slow = max(held, key=lambda mode: mode["share"])
    assert slow["frequency_Hz"] < 0.05 and slow["attitude_share"] > 0.99
    assert pose["reduced"]["attitude_share"] < 0.01
    assert pose["reduced"]["share"] == max(mode["share"] for mode in held if mode is not slow)
    shown = command("reduce", *words).stdout.decode()
    assert shown.count("held by the attitude control") == sum(mode["attitude_share"] > 0.5 for mode in held)


def test_below_the_shortest_dead_time_nothing_is_said():
    limit = reduce("ess", "--guided")["poses"][0]["dead_time_limit_ms"]
    assert limit["looked_from"] == 2.5 and limit["full"] == 0.0
    [shortest] = reduce("ess", "--guided", "--set", "robot.dead_time_ms=2.5")["poses"]
    assert shortest["loop"]["full"]["growth_per_s"] > 0.0 > shortest["loop"]["reduced"]["growth_per_s"]
    assert "< 2.5" in command("reduce", "ess", "--guided").stdout.decode()
    ideal = reduce("ess", "--set", "robot.interpolation=hold", "--set", "robot.dead_time_ms=0", "--set",
                   "bus.ideal=true")["poses"][0]["dead_time_limit_ms"]
    assert ideal["looked_from"] == pytest.approx(0.025) and ideal["looked_to"] == 25.0


def test_blanks_and_a_plus_are_no_mistake():
    assert reduce("ess", "--pose", " 0.9, +1.3")["poses"] == reduce("ess", "--pose", "0.9,1.3")["poses"]


def test_it_says_what_was_looked_at():
    found = reduce("ess", "--held", "--direction", "0.6,0.8")
    assert (found["direction"], found["guided"], found["base_free"]) == ([0.6, 0.8], False, False)
    shown = command("reduce", "ess", "--held", "--direction", "0.6,0.8").stdout.decode()
    assert "at 1.35, -1.7 rad, along (0.6, 0.8), tool free across, satellite held" in shown
    assert reduce("ess", "--guided")["guided"] is True
    assert "along (1, 0), tool guided by a rail that no run has" in command("reduce", "ess", "--guided").stdout.decode()


def test_a_beam_of_a_rig_with_an_arm_meets_that_arm(tmp_path):
    """As the same rig without arm and axes whose manipulator is the arm's reduction."""
    found = reduce("ess-berthing-pose")
    arm = found["poses"][0]["reduced"]
    assert found["object"]["arm_at_start"] == arm
    text = (RIG_FOLDER / "ess-berthing-pose.toml").read_text()
    text = text[:text.index("[axis.y]")].replace('arm = "ess"\n', "")
    text = text[:text.index("[wrench]")] + text[text.index("[object]"):]
    rig = tmp_path / "one.toml"
    rig.write_text(text)
    without = reduce(rig, *(word for key in ("mass_kg", "damping_N_s_per_m", "stiffness_N_per_m")
                            for word in ("--set", f"manipulator.{key}={arm[key]!r}")))["object"]
    assert without["arm_at_start"] is None
    for model in ("reduced", "full"):
        assert without["loop"][model]["growth_per_s"] == pytest.approx(
            found["object"]["loop"][model]["growth_per_s"], rel=1e-6)


@pytest.mark.long
def test_a_long_dead_time_ends_the_search_and_not_the_answer():
    late = ("ess", "--held", "--set", "object.mass_kg=1", "--set", "object.stiffness_N_per_m=1", "--set",
            "object.damping_N_s_per_m=0.1", "--set", "robot.dead_time_ms=300")
    limit = reduce(*late)["poses"][0]["dead_time_limit_ms"]
    assert limit["looked_to"] == 500.0 and limit["full"] is None
    assert "> 500" in command("reduce", *late).stdout.decode()


def test_an_object_that_is_too_stiff_at_any_size_is_no_factor_of_zero():
    words = ("ess", "--set", "robot.dead_time_ms=300", "--set", "object.mass_kg=2000")
    limit = reduce(*words)["poses"][0]["object_limit"]
    assert limit["full"] == 0.0 and limit["looked_from"] == 0.01
    assert "< 0.01" in command("reduce", *words).stdout.decode()


@pytest.mark.long
def test_where_dead_time_makes_it_stable_again_is_told():
    """A light beam on a stiff manipulator: over a turn of its swing at 7.1 Hz the late force takes energy, gives it, and
    takes it again. Against the eigenvalues to either side of every edge."""
    settings = [word for setting in (
        "manipulator.stiffness_N_per_m=4e5", "manipulator.damping_N_s_per_m=200", "object.beam_mass_kg_per_m=0.5",
        "object.beam_stiffness_N_m2=2e6", "object.modes=2") for word in ("--set", setting)]
    limit = reduce("ess-beam", *settings)["object"]["dead_time_limit_ms"]
    (from_ms, first_ms), (again_ms, to_ms) = limit["full_stable"]
    assert (from_ms, to_ms) == (limit["looked_from"], limit["looked_to"]) and first_ms == limit["full"]
    for dead_time_ms, grows in ((from_ms, False), (0.99 * first_ms, False), (1.01 * first_ms, True),
                                (0.99 * again_ms, True), (1.01 * again_ms, False), (to_ms, False)):
        loop = one_json_object(command("eigen", "ess-beam", "--json", *settings, "--set",
                                       f"robot.dead_time_ms={dead_time_ms}").stdout)
        assert (loop["growth_per_s"] > 0.0) == grows, dead_time_ms
    shown = command("reduce", "ess-beam", *settings).stdout.decode()
    assert "stable again, all modes, ms" in shown and f" {again_ms:.4g} to > {to_ms:.4g}\n" in shown
    assert "stable again" not in command("reduce", "ess-beam").stdout.decode()
