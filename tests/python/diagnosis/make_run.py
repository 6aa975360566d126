"""Runs of rig `ess`, and their columns changed as a logger, a sensor or its wiring would change them."""

import numpy as np
from conftest import EXIT_DONE, command, settings, topic
from recipes import as_table, changed, program_digest, recipe, run_with, save

PERIOD_s = 0.0025
NOISE_m, NOISE_N = 5e-6, 0.2
NOISY = {"robot.feedback_noise_m": NOISE_m, "sensor.noise_N": NOISE_N}
MOVING = {"profile.kind": "multisine", "profile.amplitude_m": 0.01}
LONG = MOVING | NOISY | {"run.duration_s": 30}
FAULTLESS_RUN = NOISY | MOVING | {"profile.duration_s": 30, "run.duration_s": 30}
COLUMNS = ["t_s", "command_position_m", "robot_position_m", "force_N"]


def evenly_stamped(columns):
    return columns | {"t_s": PERIOD_s * np.arange(len(columns["t_s"]))}


# A rig that is as its file says, with the noise of its sensors.
FAULTLESS = changed(record=as_table(log=run_with(FAULTLESS_RUN), names=COLUMNS), by=evenly_stamped)


def faultless(by, **given):
    """The recipe of the faultless record with its columns changed."""
    return changed(record=FAULTLESS, by=by, **given)


# --- digits, parts, rows and stamps -------------------------------------------------------------------------------
def coarse_command(columns, step_m):
    return columns | {"command_position_m": step_m * np.round(columns["command_position_m"] / step_m)}


def in_parts(columns, rows):
    return columns | {"segment": np.arange(len(columns["t_s"])) // rows}


def without_rows(columns, rng, count):
    kept = np.ones(len(columns["t_s"]), bool)
    kept[rng.choice(np.arange(100, len(kept) - 100), count, replace=False)] = False
    return {name: values[kept] for name, values in columns.items()}


def jittered_and_gapped(columns, jitter_ms, seed=5, count=30):
    """Stamps that jitter, and rows that are missing."""
    rng = np.random.default_rng(seed)
    rows = len(columns["t_s"])
    kept = np.ones(rows, bool)
    kept[rng.choice(np.arange(100, rows - 100), count, replace=False)] = False
    jittered_s = columns["t_s"] + 1e-3 * jitter_ms * rng.uniform(-1.0, 1.0, rows)
    return {name: values[kept] for name, values in (columns | {"t_s": jittered_s}).items()}


def missing_rows(columns, seed, count):
    return without_rows(columns, np.random.default_rng(seed), count)


def unevenly_stamped(columns):
    return columns | {"t_s": np.cumsum(np.random.default_rng(3).uniform(0.001, 0.004, len(columns["t_s"])))}


def stamped_in_ms(columns):
    return columns | {"t_s": 1e3 * columns["t_s"]}


def stamped_late(columns):
    """Even in the mean: 0.4 of a row early or late."""
    off_s = np.random.default_rng(4).uniform(-0.4, 0.4, len(columns["t_s"])) * PERIOD_s
    return columns | {"t_s": 1.0 + columns["t_s"] + off_s}


def stamped_late_now_and_then(columns, one_in, late_ms, seed=6):
    """Rows that were due meanwhile come a microsecond after each other."""
    rng = np.random.default_rng(seed)
    t_s = 1.0 + columns["t_s"]
    late = rng.random(len(t_s)) < 1.0 / one_in
    t_s = t_s + np.where(late, 1e-3 * late_ms * rng.uniform(0.25, 1.0, len(t_s)), 0.0)
    apart_s = 1e-6 * np.arange(len(t_s))
    return columns | {"t_s": np.maximum.accumulate(t_s - apart_s) + apart_s}


def at_a_rate_that_changes(columns):
    """A tenth slower in the middle: no step is far from the others, and the sum of them is half a second off."""
    rows = len(columns["t_s"])
    return columns | {"t_s": np.cumsum(PERIOD_s * (1.0 + 0.1 * np.sin(2.0 * np.pi * np.arange(rows) / rows)))}


# --- the robot's reports ------------------------------------------------------------------------------------------
def with_reports(columns, law):
    return columns | {"robot_position_m": law(columns["robot_position_m"])}


def two_rows_late(robot_m):
    return np.concatenate(([robot_m[0]] * 2, robot_m[:-2]))


def rippled(robot_m):
    return robot_m + 3e-5 * np.sin(2 * np.pi * robot_m / 2e-3)


def low_passed(robot_m):
    made = robot_m.copy()
    for n in range(1, len(made)):
        made[n] = made[n - 1] + 0.4 * (robot_m[n] - made[n - 1])
    return made


def moved_with_its_force(columns, by_m=4e-4, stiffness_N_per_m=2368.0):
    """An offset of the motion, which no effect describes, looks like a bias of the force."""
    return columns | {"robot_position_m": columns["robot_position_m"] + by_m,
                      "force_N": columns["force_N"] + by_m * stiffness_N_per_m}


def echoed(columns, decimals):
    return columns | {"robot_position_m": np.round(columns["command_position_m"], decimals)}


def still(columns, channel, noise, constant):
    """Brakes that are on, a sensor that is dead or stuck."""
    return columns | {channel: constant + noise * np.random.default_rng(4).standard_normal(len(columns["t_s"]))}


# --- the force ----------------------------------------------------------------------------------------------------
def biased(columns, at_end_N, jumps):
    """A bias that drifts, or jumps in the middle."""
    share = np.linspace(0.0, 1.0, len(columns["t_s"]))
    return columns | {"force_N": columns["force_N"] + at_end_N * ((share > 0.5) if jumps else share)}


def slightly_biased(columns, standstill):
    rng, rows = np.random.default_rng(4), len(columns["t_s"])
    made = columns | {"force_N": columns["force_N"] + 0.022}
    if standstill:
        made["standstill"] = {"t_s": columns["t_s"], "command_position_m": np.zeros(rows),
                              "robot_position_m": NOISE_m * rng.standard_normal(rows),
                              "force_N": NOISE_N * rng.standard_normal(rows)}
    return made


def crept(columns):
    """A sensor that creeps, of which the library knows nothing."""
    crept_N, made_N = 0.0, columns["force_N"].copy()
    for n, force_N in enumerate(columns["force_N"]):
        made_N[n] += crept_N
        crept_N += PERIOD_s / 6.0 * (0.15 * force_N - crept_N)
    return columns | {"force_N": made_N}


# --- records beside it --------------------------------------------------------------------------------------------
def with_another(columns, role, has_command=True):
    """With a record of noise of its own and another command, or none, in the role of `role`."""
    rng = np.random.default_rng(4)
    other = {name: columns[name] + size * rng.standard_normal(len(columns["t_s"]))
             for name, size in (("robot_position_m", 5e-5), ("force_N", 2.0))}
    if has_command:
        moving = columns | other | {"command_position_m": 1.5 * columns["command_position_m"]}
    else:
        moving = {"t_s": columns["t_s"], "force_N": other["force_N"]}
    return columns | {role: moving}


def with_an_operator(columns, velocity):
    """An operator's way beside it, with its velocity, without, or with next to none."""
    from make_robot import multisine

    rows = min(12000, len(columns["t_s"]))
    rng = np.random.default_rng(13)
    t_s, operator_m = multisine(12000, 14)
    force_N = rng.standard_normal(len(t_s))
    speed_m_per_s = np.gradient(operator_m, PERIOD_s, edge_order=2) * {"with": 1.0, "zero": 1e-6}.get(velocity, 0.0)
    made = {"t_s": t_s, "operator_position_m": operator_m, "operator_velocity_m_per_s": speed_m_per_s,
            "command_position_m": columns["command_position_m"], "force_N": force_N}
    if velocity == "without":
        made.pop("operator_velocity_m_per_s")
    return {name: values[:rows] for name, values in made.items()}


# --- without the robot's reports ----------------------------------------------------------------------------------
WELL_KNOWN = """
name = "well-known"
[manipulator]
mass_kg = 60.0
damping_N_s_per_m = 120.0
stiffness_N_per_m = 6000.0
[robot]
dead_time_ms = { value = 10.0, tolerance = 0.03 }
interpolation = "linear"
[sensor]
stiffness_N_per_m = 400000.0
damping_ratio = 0.03
low_pass_order = 2
low_pass_frequency_Hz = 60.0
low_pass_damping_ratio = 0.7
delay_ms = 5.0
[object]
kind = "gripped"
mass_kg = { value = 12.0, tolerance = 0.03 }
stiffness_N_per_m = { value = 3500.0, tolerance = 0.03 }
damping_N_s_per_m = { value = 25.0, tolerance = 0.03 }
surface_position_m = 0.0
"""


@recipe(program_digest)
def blind(folder, values, rig=None):
    """The command and the force of a run alone; `rig`: the text of a rig file."""
    if rig:
        (folder / "rig.toml").write_text(rig)
    done = command("run", folder / "rig.toml" if rig else "ess", "--out", folder / "run", *settings(values))
    assert done.returncode == EXIT_DONE, done.stderr.decode()
    [log] = (folder / "run").glob("*.ulg")
    tick = topic(log)
    save(folder / "record.csv", None, t_s=1e-6 * tick["timestamp"], command_position_m=tick["command_position_m"],
         force_N=tick["force_N"])


# --- a testing machine --------------------------------------------------------------------------------------------
MACHINE = """\
name = "machine"
[loop]
rate_Hz = 200
[object]
mass_kg = 2.0
stiffness_N_per_m = { value = 3000.0, tolerance = 0.1 }
damping_N_s_per_m = { value = 20.0, tolerance = 0.3 }
[sensor]
low_pass_order = 0
delay_ms = 0.0
[bus]
ideal = true
"""


@recipe()
def machine(folder, taken_at_stamps, rows=6000, noise_N=0.05, seed=4):
    """Motion and force of mass, spring and damper in closed form, with stamps up to 0.3 of a row early or late; the rows
    were taken at them, or evenly."""
    rng = np.random.default_rng(seed)
    due_s = np.arange(rows) / 200.0
    stamp_s = due_s + rng.uniform(-0.3, 0.3, rows) / 200.0
    at_s = stamp_s if taken_at_stamps else due_s
    w = 2.0 * np.pi * np.array([0.3, 0.7, 1.1, 1.9, 2.7])
    angle = np.outer(at_s, w) + rng.uniform(0.0, 2.0 * np.pi, len(w))
    size_m = 1e-3 * np.array([4.0, 2.0, 1.5, 0.6, 0.3])
    position_m, velocity = np.sin(angle) @ size_m, np.cos(angle) @ (size_m * w)
    force_N = -2.0 * (np.sin(angle) @ (size_m * w * w)) + 3000.0 * position_m + 20.0 * velocity
    (folder / "rig.toml").write_text(MACHINE)
    save(folder / "record.csv", t_s=stamp_s, robot_position_m=position_m,
         force_N=force_N + noise_N * rng.standard_normal(rows))
