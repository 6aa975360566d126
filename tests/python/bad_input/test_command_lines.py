"""Command lines that are wrong: one line that names the option, the key or the file and says what to do.

A row is the command line, as for a shell, and words of the message. `run` writes into {out}, which must not be there
afterwards, and so does `map`.
"""

import shlex

from refusals import Bad, each

# usage, --set and their values
RUN = [
    ("run ess --set robot.dead_time=1", "--set robot.dead_time=1", "robot.dead_time_ms"),
    ("run ess --set dead_time_ms=1", "--set dead_time_ms=1", "robot.dead_time_ms"),
    ("run ess --set robot.dead_time_ms", "--set robot.dead_time_ms", "section.key=value"),
    ("run ess --set robot.dead_time_ms=", "robot.dead_time_ms", "number"),
    ("run ess --set 'robot.dead_time_ms=1 ms'", "robot.dead_time_ms", "number", "1 ms"),
    ("run ess --set robot.dead_time_ms=0x10", "robot.dead_time_ms", "number"),
    ("run ess --set =1", "--set =1"),
    ("run ess --set manipulator.mass_kg=-1", "manipulator.mass_kg", "greater than 0"),
    ("run ess --set manipulator.mass_kg=nan", "manipulator.mass_kg", "finite"),
    ("run ess --set manipulator.mass_kg=1e400", "manipulator.mass_kg"),
    ("run ess --set loop.rate_Hz=7", "loop.rate_Hz", "5", "8"),
    ("run ess --set bus.ideal=yes", "bus.ideal", "true or false"),
    ("run ess --set solver.kind=exact", "solver.kind", "cvode"),
    ("run ess --set", "--set"),
    ("run ess --nonsense", "--nonsense", "--help"),
    ("run ess another", "another", "--help"),
    ("run", "RIG", "--help"),
    ("replay", "LOG", "--help"),
    ("candump", "LOG", "--help"),
    ("deadtime", "RIG", "--help"),
    ("frobnicate", "frobnicate", "there are run, replay, "),
    ("", "subcommand", "--help"),
    ("--nonsense", "--help"),
    ("run ess --no-log --set solver.kind=cvode --set solver.relative_tolerance=1e-300 "
     "--set solver.absolute_tolerance_m=1e-300", "cvode", "solver.relative_tolerance"),
]

# eigenvalues and limits
STABILITY = [
    ("eigen ess --seed -1", "--seed", "0 to 9223372036854775807"),
    ("eigen ess --amplitude ''", "--amplitude"),
    ("eigen ess --jitter ''", "--jitter", "needs a name"),
    ("eigen ess --set object.hysteresis_force_N=10", "object.hysteresis_length_m", "is missing",
     "object.hysteresis_force_N"),
    ("map ess --x robot.dead_time_ms=0.1:1:3 --y object.mass_kg=50:60:2", "none of its points is a loop",
     "robot.dead_time_ms", "one period"),
    ("map ess --vary mass --x-range 100:200", "none of its points is a loop", "negative"),
    ("limits ess --set manipulator.stiffness_N_per_m=0 --set object.stiffness_N_per_m=0", "z = 1", "stiffness"),
    ("map ess --x profile.amplitude_m=0.001:0.01:5 --y object.mass_kg=50:100:4", "profile.amplitude_m", "--amplitude"),
    ("limits ess --set object.cubic_stiffness_N_per_m3=-1e7 --amplitude 1e300", "at 1e+300 m", "no linear loop"),
    ("eigen ess --set robot.dead_time_ms=1e5", "40007 eigenvalues", "robot.dead_time_ms"),
    ("limits ess --set robot.dead_time_ms=1e5", "40007 eigenvalues", "robot.dead_time_ms"),
    ("map ess --set robot.dead_time_ms=1e5 --vary mass", "40007 eigenvalues", "robot.dead_time_ms"),
    ("eigen ess --set object.mass_kg=0", "object.mass_kg", "greater than 0"),
    ("eigen ess --set object.mass_kg=0 --json", "object.mass_kg", "greater than 0"),
    ("eigen ess --set object.mass_kg=-1", "object.mass_kg", "greater than 0"),
    ("eigen ess --set object.mass_kg=-1 --json", "object.mass_kg", "greater than 0"),
    ("eigen ess --set object.stiffness_N_per_m=nan", "object.stiffness_N_per_m", "finite"),
    ("eigen ess --set object.stiffness_N_per_m=nan --json", "object.stiffness_N_per_m", "finite"),
    ("eigen ess --set robot.dead_time_ms=inf", "robot.dead_time_ms", "finite"),
    ("eigen ess --set robot.dead_time_ms=inf --json", "robot.dead_time_ms", "finite"),
    ("eigen nosuchrig", "nosuchrig", "no shipped rig"),
    ("eigen nosuchrig --json", "nosuchrig", "no shipped rig"),
    ("limits ess --set object.mass_kg=0", "object.mass_kg", "greater than 0"),
    ("limits ess --set object.mass_kg=0 --json", "object.mass_kg", "greater than 0"),
    ("limits ess --set object.mass_kg=-1", "object.mass_kg", "greater than 0"),
    ("limits ess --set object.mass_kg=-1 --json", "object.mass_kg", "greater than 0"),
    ("limits ess --set object.stiffness_N_per_m=nan", "object.stiffness_N_per_m", "finite"),
    ("limits ess --set object.stiffness_N_per_m=nan --json", "object.stiffness_N_per_m", "finite"),
    ("limits ess --set robot.dead_time_ms=inf", "robot.dead_time_ms", "finite"),
    ("limits ess --set robot.dead_time_ms=inf --json", "robot.dead_time_ms", "finite"),
    ("limits nosuchrig", "nosuchrig", "no shipped rig"),
    ("limits nosuchrig --json", "nosuchrig", "no shipped rig"),
    ("eigen ess --amplitude 0.3 --set object.cubic_stiffness_N_per_m3=-1e7", "berth: --amplitude: at "),
    ("eigen ess --amplitude 1.0 --set object.cubic_stiffness_N_per_m3=-1e7", "berth: --amplitude: at "),
    ("eigen ess --amplitude 1e+300 --set object.cubic_stiffness_N_per_m3=-1e7", "berth: --amplitude: at "),
    ("limits ess --amplitude 0.3 --set object.cubic_stiffness_N_per_m3=-1e7", "berth: --amplitude: at "),
    ("limits ess --amplitude 1.0 --set object.cubic_stiffness_N_per_m3=-1e7", "berth: --amplitude: at "),
    ("limits ess --amplitude 1e+300 --set object.cubic_stiffness_N_per_m3=-1e7", "berth: --amplitude: at "),
]

# maps
MAP = [
    ("map ess", "--vary"),
    ("map ess --vary mass --x object.mass_kg=1:2:3", "either"),
    ("map ess --vary colour", "elasticity or mass"),
    ("map ess --x object.mass_kg=1:2:3", "--y is missing"),
    ("map ess --x object.mass_kg=300:10:5 --y robot.dead_time_ms=3:9:4", "did you mean 10:300?"),
    ("map ess --x object.mass_kg=10:10:5 --y robot.dead_time_ms=3:9:4", "no width"),
    ("map ess --x object.mass_kg=10:20:1 --y robot.dead_time_ms=3:9:4", "2 to"),
    ("map ess --x object.mass_kg=10:20:1.5 --y robot.dead_time_ms=3:9:4", "whole number"),
    ("map ess --x object.mass_kg=nan:20:5 --y robot.dead_time_ms=3:9:4", "finite"),
    ("map ess --x object.mass_kg=1:inf:5 --y robot.dead_time_ms=3:9:4", "finite"),
    ("map ess --x object.mass_kg=one:20:5 --y robot.dead_time_ms=3:9:4", '"one" is not a number'),
    ("map ess --x object.mas_kg=1:20:5 --y robot.dead_time_ms=3:9:4", "object.mass_kg"),
    ("map ess --x object.kind=1:20:5 --y robot.dead_time_ms=3:9:4", "not a number"),
    ("map ess --x bus.ideal=0:1:2 --y robot.dead_time_ms=3:9:4", "not a number"),
    ("map ess --x object.mass_kg=-5:20:5 --y robot.dead_time_ms=3:9:4", "greater than 0"),
    ("map ess --x manipulator.substeps=1:5:4 --y robot.dead_time_ms=3:9:4", "whole number"),
    ("map ess --x object.mass_kg=1:2:3 --y object.mass_kg=1:2:3", "x axis already"),
    ("map ess --x object.mass_kg --y robot.dead_time_ms=3:9:4", "KEY=FROM:TO:COUNT"),
    ("map ess --vary mass --grid 200", "NXxNY"),
    ("map ess --vary mass --grid 1x5", "2 to"),
    ("map ess --vary mass --grid 999999x999999", "more than"),
    ("map ess --vary mass --grid 99999999999999999999x5", "whole number"),
    ("map ess --vary mass --x-range 0:1", "greater than 0"),
    ("map ess --vary mass --x-range 1", "FROM:TO"),
    ("map ess --vary mass --y-range -1:1", "0 or more"),
    ("map ess --vary mass --threads 0", "1"),
    ("map ess --vary mass --set manipulator.stiffness_N_per_m=0", "frequency ratio"),
    ("map ess --vary mass --set object.mass_kg=0", "object.mass_kg"),
    ("map ess --vary elasticity --grid 10000x10000", "1e+08 points take about", "GB of memory", "--yes"),
    ("map ess --vary mass --model rig", "--model"),
]

# an object that is a beam
BEAM = [
    ("run ess-beam --set object.modes=9", "object.modes: must be from 1 to 8 (is 9)"),
    ("run ess-beam --set object.modes=0", "object.modes"),
    ("run ess-beam --set object.beam_length_m=-1", "object.beam_length_m"),
    ("run ess-beam --set object.beam_length_m=1e9", "object.beam_length_m: must be from 0.001 to 10000"),
    ("run ess-beam --set object.beam_mass_kg_per_m=nan", "object.beam_mass_kg_per_m"),
    ("run ess-beam --set object.beam_damping_ratio=1.5", "object.beam_damping_ratio"),
    ("run ess-beam --set object.beam_stiffness_N_m2=1e14", "object.beam_stiffness_N_m2: gives mode "),
    ("run ess-beam --set object.beam_root_stiffness_N_m_per_rad=1e-9",
     "object.beam_root_stiffness_N_m_per_rad: is next to no spring"),
    ("run ess-beam --set object.mass_kg=90", "object.mass_kg: follows from the beam"),
    ("run ess-beam --set object.coulomb_friction_N=1", "cannot be put into a beam"),
    ("run ess-beam --no-log --set robot.backlash_m=1e-4",
     "object.modes: a beam of several modes knows no effects beside it: leave out robot.backlash"),
    ("run ess --set object.modes=3", 'object.modes: counts with object.kind = "beam" only'),
    ("map ess --x object.beam_length_m=1:2:2 --y object.mass_kg=50:100:2", 'counts with object.kind = "beam" only'),
    ("map ess-beam --x object.mass_kg=50:100:2 --y object.beam_length_m=1:2:2",
     "object.mass_kg follows from object.beam_length_m"),
]

# grips and events
EVENTS = [
    ("run ess --set run.grip_close_s=2.0 --set run.grip_release_s=1.0",
     "run.grip_release_s: must be later than run.grip_close_s"),
    ("run ess --set run.grip_close_s=inf", "run.grip_close_s"),
    ("run ess --set object.kind=contact --set run.grip_release_s=2.0", "run.grip_release_s: needs a gripped object"),
    ("run ess --set object.kind=contact --set run.grip_close_s=2.0", "run.grip_close_s: needs a gripped object"),
    ("run ess --no-log --set run.grip_close_s=2.0 --set robot.backlash_m=0.0001 --set solver.kind=cvode",
     "solver.kind: CVODE integrates"),
    ("run ess --set run.dead_time_jump_s=1 --set run.dead_time_jump_ms=-14", "run.dead_time_jump_ms"),
    ("run ess --no-log --set run.grip_release_s=1 --set solver.kind=cvode --set object.cubic_stiffness_N_per_m3=1000000.0",
     "solver.kind"),
    ("run concept-copper --set run.grip_release_s=1", "run.grip_release_s"),
]

# force sensors
SENSOR = [
    ("run ess --set sensor_channel.layout=four_frames", "sensor_channel.layout", "three_frames_motorola"),
    ("run ess --set sensor_channel.axis=w", "sensor_channel.axis", '"z"'),
    ("run ess --set sensor.rate_Hz=0.5", "sensor.rate_Hz", "must be 0"),
    ("run ess --set sensor.rate_Hz=9000", "sensor.rate_Hz", "queue up"),
    ("run ess --set sensor.rate_Hz=3000 --set sensor_channel.layout=three_frames_intel", "sensor.rate_Hz", "queue up"),
    ("run ess --set sensor.rate_Hz=4000 --set loop.rate_Hz=100 --set robot.dead_time_ms=20", "sensor.rate_Hz",
     "at most 32 frames"),
    ("run ess --set sensor.delay_ms=0.3 --set sensor_channel.layout=three_frames_intel", "sensor.delay_ms",
     "time on the bus"),
]

# compensation
COMPENSATION = [
    ("run ess --with magic", "magic", "prediction"),
    ("compensate ess --dead-time nan", "--dead-time"),
    ("compensate ess --dead-time -1", "--dead-time"),
    ("compensate ess --dead-time 1e9", "--dead-time"),
    ("compensate ess --stiffness nan", "--stiffness"),
    ("compensate ess --stiffness -1", "--stiffness"),
    ("compensate ess --stiffness 1e9", "--stiffness"),
    ("compensate ess --mass nan", "--mass"),
    ("compensate ess --mass -1", "--mass"),
    ("compensate ess --mass 1e9", "--mass"),
    ("compensate ess --noise nan", "--noise"),
    ("compensate ess --noise -1", "--noise"),
    ("compensate ess --noise 1e9", "--noise"),
    ("compensate ess --margin-ms nan", "--margin-ms"),
    ("compensate ess --margin-ms -1", "--margin-ms"),
    ("compensate ess --margin-ms 1e9", "--margin-ms"),
    ("compensate ess --margin-dB nan", "--margin-dB"),
    ("compensate ess --margin-dB -1", "--margin-dB"),
    ("compensate ess --margin-dB 1e9", "--margin-dB"),
    ("compensate ess --duration nan", "--duration"),
    ("compensate ess --duration -1", "--duration"),
    ("compensate ess --duration 1e9", "--duration"),
]

# reductions of an arm, and empty values
REDUCE = [
    ("reduce ess --amplitude 0.1", "must be FROM:TO:COUNT"),
    ("reduce ess --amplitude 0:1:3", "must be FROM:TO:COUNT"),
    ("reduce ess --amplitude 1:0.1:3", "must be FROM:TO:COUNT"),
    ("reduce ess --amplitude 0.1:1:1", "must be FROM:TO:COUNT"),
    ("reduce ess --amplitude 0.1:nan:3", "must be FROM:TO:COUNT"),
    ("reduce ess --amplitude 0.1:1:3 --sweep 2=-2:-1:3", "leave --sweep out"),
    ("reduce ess --amplitude ''", "--amplitude"),
    ("reduce concept-foam", "object.kind"),
    ("reduce concept-foam --amplitude 0.001:0.1:4", "object.kind"),
    ("reduce ess --pose ''", "--pose: needs a value"),
    ("reduce ess --direction ''", "--direction: needs a value"),
    ("reduce ess --sweep ''", "--sweep: needs a value"),
    ("reduce ess --arm ''", "--arm: needs a value"),
    ("run ess --out ''", "--out: needs a value"),
    ("map ess --x ''", "--x: needs a value"),
    ("eigen ess --set ''", "--set: needs a value"),
    ("reduce ess --pose 1e7,0", "within"),
    ("reduce ess --sweep 1=-1e7:0:3", "within"),
    ("reduce ess --pose 0x1,0", "--pose"),
    ("reduce ess --pose 1,nan", "--pose"),
    ("reduce ess --direction 0x1,0", "--direction"),
    ("reduce ess --sweep 0x1=0:1:3", "--sweep"),
    ("reduce ess --amplitude 0x1:1:3", "--amplitude"),
    ("reduce ess --pose 1,,2", "--pose"),
    ("reduce ess-pose --guided", "--guided: [axis.*] shows where the tool goes across"),
    ("reduce ess --set robot.dead_time_ms=1000.1", "robot.dead_time_ms: 1000.1 ms is more than 400 periods (1000 ms)"),
    ("reduce ess --sweep 2=0:0:3", "two angles"),
]

# what a change buys
GAINS = [
    ("limits ess --change=0", "--change"),
    ("limits ess --change=100", "--change"),
    ("limits ess --change=-5", "--change"),
    ("limits ess --change=nan", "--change"),
    ("limits ess --change=inf", "--change"),
]

# accuracy of an arm
ACCURACY = [
    ("accuracy ess --repeatability-um nan", "--repeatability-um"),
    ("accuracy ess --repeatability-um 0", "--repeatability-um"),
    ("accuracy ess --repeatability-um -1", "--repeatability-um"),
]

# an arm in the place of the manipulator
ARM = [
    ("limits ess --set robot.jitter_ms=1", "one degree of freedom"),
    ("limits ess --with identification", "one degree of freedom"),
    ("compensate ess", "one degree of freedom"),
    ("eigen ess --set robot.jitter_ms=1", "one degree of freedom"),
    ("map ess --vary mass --set robot.jitter_ms=1", "one degree of freedom"),
    ("map ess --vary mass --set extrapolation.order=1", "one degree of freedom"),
    ("map ess --x manipulator.mass_kg=100:200:2 --y object.mass_kg=50:100:2", "the arm in its place decides"),
]

# presets of robots
ROBOTS = [
    ("run ess --robot abb-emg", "abb-emg", "nearest is abb-egm"),
    ("robots abb-emg", "abb-emg", "nearest is abb-egm"),
    ("eigen ess --robot ''", "--robot"),
    ("limits ess --robot ''", "--robot"),
    ("run ess --robot ''", "--robot"),
]

# amplitudes of effects
EFFECTS = [
    ("eigen ess --set robot.backlash_m=1e-3 --amplitude=-1", "--amplitude"),
    ("eigen ess --set robot.backlash_m=1e-3 --amplitude=nan", "--amplitude"),
    ("eigen ess --set robot.backlash_m=1e-3 --amplitude=inf", "--amplitude"),
    ("eigen ess --set robot.backlash_m=1e-3 --amplitude=far", "--amplitude"),
]


def written(arguments):
    """`run` and `map` with a folder for what they write."""
    words = shlex.split(arguments)
    takes_it = words[:1] in (["run"], ["map"]) and len(words) > 1 and not {"--out", "--no-log"} & set(words)
    return [*words[:2], "--out", "{out}", *words[2:]] if takes_it else words


ALL = RUN + STABILITY + MAP + BEAM + EVENTS + SENSOR + COMPENSATION + REDUCE + GAINS + ACCURACY + ROBOTS + EFFECTS
ON_AN_ARM = [(f"{line} --set manipulator.arm=ess", *says) for line, *says in ARM]


@each([Bad(line or "nothing", written(line), *says) for line, *says in ALL + ON_AN_ARM])
def test_command_line(row, tmp_path):
    row.check(tmp_path)
