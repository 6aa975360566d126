"""Runs of `berth run`, diagnosed with the rig that made them, with a wrong one, and with one that has effects already, as
the extended rig of an earlier diagnosis has: those are known within tolerances like everything else."""

import math
import tomllib

import numpy as np
import pytest
from checks import (Between, at, causes, check, doubt, has_cause, interval, named, name_of, near, no_note, note, nothing, prints, size,
                    verdict)
from conftest import EXIT_DONE, command, one_json_object, run_json, settings
from make_run import MOVING, NOISE_m, NOISE_N, NOISY
from recipes import recipe, program_digest, run_with
from table import Row, each

PICOMETRE_m = 1e-11  # a step of the wire
SHORT = MOVING | {"run.duration_s": 20, "profile.frequency_end_Hz": 4, "sensor.noise_N": NOISE_N}
QUIET = {"run.duration_s": 20}
WHOLE_STEPS = {"sensor_channel.layout": '"three_frames_intel"'}
FORCE, ROBOT = "residual.force_N.fit.before", "residual.robot_position_m.fit.before"


@check
def extended_rig_runs(told):
    done = command("run", told.out / "extended.toml", "--no-log", "--json")
    assert done.returncode == EXIT_DONE, done.stderr.decode()


@check
def has_no_block(told, name):
    assert name not in [one["block"] for one in told.found["blocks"]]


@check
def fits(told, **expected):
    """Which parameters of the cause were fitted."""
    assert {name_of(one): one["fitted"] for one in told.found["causes"][0]["parameters"]} == expected


# --- with the rig that made them, and with a wrong one ------------------------------------------------------------
HOLDS = [{}, {"robot.lag_ms": 15}, {"robot.lag_ms": 15, "robot.velocity_limit_m_per_s": 0.1},
         {"robot.velocity_limit_m_per_s": 0.1}, {"robot.backlash_m": 2e-4},
         {"robot.transfer_frequency_Hz": 12, "robot.transfer_damping_ratio": 0.6}, {"robot.dead_time_ms": 18.3}]
LIMITS = [{"limits.velocity_m_per_s": 0.05}, {"limits.acceleration_m_per_s2": 0.3}]
WRONG = [("robot.dead_time_ms", 14.0, "robot.dead_time", "dead_time_ms", near(17.5, rel=1e-3, abs=0.05)),
         ("sensor.bias_N", 1.5, "sensor.bias", "bias_N", near(0.0, rel=1e-3, abs=0.05)),
         ("object.mass_kg", 60.0, "object.parameters", "mass_kg", near(100.0, rel=1e-3, abs=0.05))]
UNDAMPED = {"object.damping_N_s_per_m": 0}

AS_GIVEN = [
    Row("of the rig that made a log only noise is left", run_with(SHORT), nothing(), at(FORCE, near(NOISE_N, rel=0.05)),
        at("residual.command_position_m.fit.before", near(PICOMETRE_m / np.sqrt(12), rel=0.05)), at(ROBOT, Between(high=1e-14))),
    *[Row(f"without noise the steps of the wire are no fault, {'several frames' if keys else 'one frame'}",
          run_with(QUIET | keys), nothing(), at(FORCE, Between(0.0, 0.01)), given=keys) for keys in ({}, WHOLE_STEPS)],
    *[Row(f"a robot that jumps to its setpoints, {' and '.join(more) or 'by itself'}",
          run_with(SHORT | {"robot.interpolation": '"hold"'} | more), nothing(), at(ROBOT, Between(high=2e-8)),
          at(FORCE, near(NOISE_N, rel=0.05)), given={"robot.interpolation": '"hold"'} | more, slow=n > 2)
      for n, more in enumerate(HOLDS)],
    *[Row(f"a wrong {key} is put right", run_with(SHORT), named(effect), size(name, right), extended_rig_runs(),
          given={key: wrong}) for key, wrong, effect, name, right in WRONG],
    # The base goes as far as it may, filter and spring with it: what is left looks like many things.
    Row("a force that is older than its tolerance is no second mode",
        run_with(SHORT | {"sensor.sample_phase_ms": 1.3, "run.duration_s": 30, "robot.feedback_noise_m": NOISE_m}),
        causes("sensor.delay"), interval("delay_ms", 2.5 + 1.2)),
    # The sensor's spring is a twentieth of what the rig file says, which no effect is: an object that hangs on another
    # one of no mass does the same.
    Row("a body of a hundredth is told in part",
        run_with(SHORT | {"sensor.stiffness_N_per_m": 1e6, "run.duration_s": 30, "robot.feedback_noise_m": NOISE_m}),
        verdict("partly_explained"), has_cause("object.parameters"), doubt(None, "hundredth"), slow=True),
    Row("another mass in the firmware than in the log", run_with(SHORT), verdict("software_mismatch"),
        at("block", "manipulator"), given={"manipulator.mass_kg": 201}),
    *[Row(f"a limit of the firmware that acted is no mismatch, {next(iter(limit))}", run_with(SHORT | limit),
          verdict("nothing_detectable"), has_no_block("manipulator"), note("limits of the firmware acted"), given=limit)
      for limit in LIMITS],
    # Six lost samples in 20 s.
    Row("a probability stays one", run_with(SHORT | {"loop.lost_sample_probability": 0.0007, "run.seed": 3}),
        causes("loop.lost_samples"), at("causes.0.parameters.0.key", "loop.lost_sample_probability"),
        at("causes.0.parameters.0.ci95.0", 0.0), at("causes.0.parameters.0.ci95.1", Between(0.0, 0.01)),
        prints("lost_sample_probability = 0.00075424 (0 to 0.0016)")),
    Row("what was not fitted stands as given", run_with(SHORT | UNDAMPED),
        fits(mass_kg=True, damping_N_s_per_m=False, stiffness_N_per_m=True, damping_ratio=True),
        prints("damping_N_s_per_m = 0, as given"), given=UNDAMPED | {"object.mass_kg": 60}),
]


# --- with a rig that has the effect -------------------------------------------------------------------------------
LONG = SHORT | NOISY | {"run.duration_s": 30}
# The first value is the size.
KNOWN = {
    "robot.backlash": {"robot.backlash_m": 2e-4},
    "robot.lag": {"robot.lag_ms": 8.0},
    "robot.gain": {"robot.gain_error": -0.03},
    "robot.periodic_error": {"robot.periodic_error_m": 1e-4, "robot.periodic_error_pitch_m": 0.005,
                             "robot.periodic_error_phase_rad": 1.0},
    "robot.deadband": {"robot.deadband_m": 2e-4},
    "object.cubic_stiffness": {"object.cubic_stiffness_N_per_m3": 2e6},
    "object.coulomb_friction": {"object.coulomb_friction_N": 5.0, "object.coulomb_presliding_m": 1e-4},
    "object.second_mode": {"object.second_mass_kg": 20.0, "object.second_frequency_Hz": 7.0,
                           "object.second_damping_ratio": 0.05},
    "sensor.bias": {"sensor.bias_N": 5.0},
    "sensor.drift": {"sensor.drift_N_per_s": 0.3},
}
QUICK_KNOWN = list(KNOWN)[:6]
BY_CHANCE = {
    "sensor.spikes": {"sensor.spike_probability": 0.003, "sensor.spike_N": 20.0},
    "sensor.dropouts": {"sensor.loss_probability": 0.01},
    "robot.lost_commands": {"robot.lost_command_probability": 0.01},
}
PLAY = LONG | {"robot.backlash_m": 2e-4}
TOLERANCES = [(0.4, "nothing_detectable", []), (0.1, "named", ["robot.backlash"]), (0.0, "named", ["robot.backlash"])]


def in_size(keys, share):
    """The same with `share` of the first one."""
    first, *_ = keys
    return {**keys, first: share * keys[first]}


@recipe(program_digest)
def run_of(folder, values, rig_values, tolerances):
    """A run of `ess`, beside a rig file with other values and these tolerances."""
    assert command("run", "ess", *settings(values), "--out", folder).returncode == EXIT_DONE
    printed = command("run", "ess", "--print-config", *settings(rig_values)).stdout.decode()
    (folder / "rig.toml").write_text(printed + "\n[tolerances]\n" + "".join(
        f'"{key}" = {value}\n' for key, value in tolerances.items()))


@check
def says_of_one_tolerance(told, key):
    """That nothing uses it, and of no other one."""
    [one] = [note for note in told.found["notes"] if "tolerance of" in note]
    assert key in one


@check
def extended_states_tolerances(told, is_so):
    assert ("[tolerances]" in (told.out / "extended.toml").read_text()) == is_so


@check
def the_next_one_knows(told):
    """The extended rig explains a later run that is 2 % off, and names the effect in one that is half as large again."""
    extended = told.out / "extended.toml"
    later = Row("later", run_with(LONG | {"robot.backlash_m": 2.04e-4, "run.seed": 2, "profile.frequency_end_Hz": 3}),
                rig=extended).told(told.out.with_name("later"))
    assert later.verdict == "nothing_detectable", str(later)
    worn = Row("worn", run_with(LONG | {"robot.backlash_m": 3e-4, "run.seed": 3}), rig=extended)
    named("robot.backlash")(worn.told(told.out.with_name("worn")))


def of_known(effect, keys):
    """5 % where nothing is said. Held at 3 % less, others stood in for the rest: a gain of the sensor for a cubic stiffness,
    a gain of the robot for a lag."""
    first, true = next(iter(keys.items()))
    slow = effect not in QUICK_KNOWN
    return [Row(f"{effect} that is 3 % less in the rig file", run_with(LONG | keys), verdict("nothing_detectable"),
                given=in_size(keys, 0.97), slow=slow),
            Row(f"{effect} that is 25 % less in the rig file", run_with(LONG | keys), named(effect),
                size(first.split(".")[1], near(true, rel=0.02)), given=in_size(keys, 0.75), slow=slow)]


def by_chance(effect, keys):
    """A rig file that has the spikes is not wrong as there are spikes."""
    slow = effect == "robot.lost_commands"
    return [Row(f"{effect} as given, within its interval", run_with(LONG | keys), verdict("nothing_detectable"), given=keys,
                slow=slow),
            Row(f"{effect} five times as often as given", run_with(LONG | keys), named(effect), given=in_size(keys, 0.2),
                slow=slow)]


WITH_EFFECTS = [
    *[row for effect, keys in KNOWN.items() for row in of_known(effect, keys)],
    # A spring's stiffness that comes to nothing would be another body; what is added to it may be gone.
    Row("a known cubic stiffness that is gone", run_with(LONG), named("object.cubic_stiffness"),
        size("cubic_stiffness_N_per_m3", Between(-2e4, 2e4)), given=KNOWN["object.cubic_stiffness"]),
    *[row for effect, keys in BY_CHANCE.items() for row in by_chance(effect, keys)],
    *[Row(f"play with a stated tolerance of {tolerance}", run_of(values=PLAY, rig_values={"robot.backlash_m": 1.5e-4},
                                                                 tolerances={"robot.backlash_m": tolerance}),
          verdict(told), causes(*effects), extended_states_tolerances(True)) for tolerance, told, effects in TOLERANCES],
    Row("what one diagnosis found the next one knows", run_with(PLAY), causes("robot.backlash"),
        extended_states_tolerances(False), the_next_one_knows()),
    Row("a tolerance that nothing uses", run_of(values=PLAY, rig_values={}, tolerances={
        "bus.bit_rate_bit_per_s": 0.1, "object.mass_kg": 0.03}), says_of_one_tolerance("bus.bit_rate_bit_per_s")),
]


# --- a force that comes between two ticks waits for the next one --------------------------------------------------
PERIOD_ms = 2.5
SAMPLED = MOVING | NOISY
SAMPLERS = {  # and the age in ms, by hand: sampled at the phase, taken at the first tick after it has come
    "late": ({"sensor.delay_ms": 6.0}, 7.5),
    "in the tick": ({"sensor.delay_ms": 4.0, "sensor.sample_phase_ms": 1.2}, 6.3),
    "just before": ({"sensor.delay_ms": 0.5, "sensor.sample_phase_ms": 2.0}, 0.5),
    "four a tick": ({"sensor.rate_Hz": 1600.0, "sensor.delay_ms": 3.1, "sensor.sample_phase_ms": 0.4}, 3.35),
}


def sensor_of(rig):
    return tomllib.loads(rig.read_text())["sensor"]


def age_of(sensor, sampler):
    """By hand: of a sample when the next one, or the tick, comes."""
    sample_ms = 1e3 / sampler["sensor.rate_Hz"] if "sensor.rate_Hz" in sampler else PERIOD_ms
    phase_ms = sensor["sample_phase_ms"]
    return sample_ms * math.ceil((phase_ms + sensor["delay_ms"]) / sample_ms - 1e-9) - phase_ms


@check
def rig_files_have_the_sampler(told, sampler, age_ms):
    given, extended = (sensor_of(told.out / f"{name}.toml") for name in ("given", "extended"))
    assert all(given[key.split(".")[1]] == value for key, value in sampler.items())
    assert age_of(extended, sampler) == near(age_ms, abs=0.4)  # re-tuned within the tolerance


@check
def extended_rig_explains_it(told, log):
    [delay] = told.found["causes"][0]["parameters"]
    assert age_of(sensor_of(told.out / "extended.toml"), {}) == near(delay["value"], abs=2e-6)
    again = Row("again", log, rig=told.out / "extended.toml").told(told.out.with_name("again"))
    assert again.verdict == "nothing_detectable", str(again)


def of_sampler(name, sampler, age_ms):
    log = run_with(SAMPLED | sampler)
    says = f"the force is {age_ms:g} ms old"
    if abs(age_ms - PERIOD_ms) < 1.0:  # what is known of the rig leaves that open, nearly
        found = [verdict("nothing_detectable", "partly_explained")]
    else:
        found = [named("sensor.delay"), interval("delay_ms", age_ms), extended_rig_explains_it(log)]
    return [Row(f"a force {name}, with the rig that made it", log, verdict("nothing_detectable"),
                rig_files_have_the_sampler(sampler, age_ms), no_note(says) if sampler["sensor.delay_ms"] == age_ms else note(says),
                given=sampler),
            Row(f"a force {name}, whose age is not known", log, *found, slow=name not in ("late", "in the tick"))]


AGES = [row for name, (sampler, age_ms) in SAMPLERS.items() for row in of_sampler(name, sampler, age_ms)]


@pytest.mark.long
@each(AS_GIVEN + WITH_EFFECTS + AGES)
def test_run(row, tmp_path):
    row.check(tmp_path / "out")


# --- a log without noise is replayed to the steps of the wire ----------------------------------------------------
FINE = {"sensor.resolution_N": 1e-9, "profile.kind": "multisine", "profile.amplitude_m": 0.01, "profile.duration_s": 20,
        "run.duration_s": 20}
LINEAR = [({}, 1e-7), ({"robot.transfer_frequency_Hz": 10}, 3e-7),
          ({"robot.transfer_frequency_Hz": 10, "robot.transfer_damping_ratio": 1.0}, 3e-7),
          ({"robot.transfer_frequency_Hz": 10, "loop.rate_Hz": 250}, 3e-7),
          ({"robot.transfer_frequency_Hz": 10, "loop.rate_Hz": 1000}, 3e-7),
          ({"robot.transfer_frequency_Hz": 10, "loop.rate_Hz": 50, "robot.dead_time_ms": 60}, 3e-6),
          ({"robot.lag_ms": 10}, 1e-7), ({"robot.lag_ms": 10, "robot.transfer_frequency_Hz": 10}, 5e-6),
          ({"robot.interpolation": "hold"}, 1e-7), ({"robot.interpolation": "hold", "robot.transfer_frequency_Hz": 10}, 1e-5),
          ({"robot.interpolation": "hold", "robot.lag_ms": 6}, 5e-6), ({"robot.gain_error": 0.05}, 1e-7),
          ({"sensor.low_pass_order": 1, "sensor.delay_ms": 1.1}, 1e-7)]


@pytest.mark.long
@pytest.mark.parametrize("options, most_N", LINEAR, ids=lambda value: str(value)[:60])
def test_a_log_without_noise_is_replayed_to_the_steps_of_the_wire(options, most_N, tmp_path):
    """The simulation goes exactly from event to event; the replay knows the robot's way between two ticks as well."""
    log = run_json("ess", tmp_path, *settings(FINE | options))["log"]
    rig = tmp_path / "rig.toml"
    rig.write_bytes(command("run", "ess", *settings({"sensor.resolution_N": 1e-9} | options), "--print-config").stdout)
    done = command("diagnose", log, "--rig", rig, "--json", "--out", tmp_path / "out")
    assert done.returncode == 0, done.stderr.decode()
    blocks = one_json_object(done.stdout)["blocks"]
    error = {block["block"]: block["residual"]["fit"]["before"] for block in blocks}
    assert error["manipulator"] < 1e-11 and error["robot"] < 1e-8 and error["force"] < most_N, error
    assert not any(block["causes"] for block in blocks)


@pytest.mark.long
def test_what_the_time_limit_leaves_out_is_said(tmp_path):
    """A block that was not searched to the end is never called free of faults."""
    hidden = {"robot.backlash_m": 2e-4, "robot.feedback_noise_m": 5e-6, "sensor.noise_N": 0.2, "profile.kind": "multisine",
              "profile.amplitude_m": 0.01, "run.duration_s": 12}
    log = run_json("ess", tmp_path, *settings(hidden))["log"]
    told = {}
    for limit_s in ("0", "600"):
        done = command("diagnose", log, "--rig", "ess", "--json", "--time-limit", limit_s, "--out", tmp_path / limit_s)
        assert done.returncode == 0, done.stderr.decode()
        told[limit_s] = one_json_object(done.stdout)
    assert told["600"]["not_tried"] == [] and told["600"]["verdict"] == "named"
    cut = told["0"]
    assert "robot.backlash" in cut["not_tried"] and cut["verdict"] == "unknown" and cut["causes"] == []
    assert all(block["verdict"] == "unknown" for block in cut["blocks"] if block["block"] != "manipulator")
    [note] = [note for note in cut["notes"] if "--time-limit" in note]
    assert "robot.backlash" in note and "processor time" in note
