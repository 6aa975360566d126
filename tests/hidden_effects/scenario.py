"""From a seed: a rig, an excitation, an effect or none, noise; and the runs that they give."""

from dataclasses import dataclass

import numpy as np
from effects import ASKED_FOR, LIBRARY, SIZES, Scale
from excitation import operator_force
from noise import LEVELS, draw_disturbance, draw_noise
from outside import OUTSIDE
from physics import Unstable, simulate
from rigs import Rig, draw_rig

KINDS = {"fault_free": 0.2, "single": 0.5, "two": 0.15, "outside": 0.15}
PAIRS = ("two", "two_of_one_block")
ONE_AS_A_PAIR = (
    {"manipulator.coulomb_friction", "manipulator.asymmetric_friction"},  # the one contains the other
    {"robot.lag", "robot.velocity_limit"},  # a lag that saturates, which the engine does not have
)
CONTACT_ONLY = {"object.impact_damping"}
GRIPPED_ONLY = {name for name in [*LIBRARY, *ASKED_FOR, *OUTSIDE] if ".object" in "." + name.removeprefix("outside.")} - {
    "object.parameters", "object.impact_damping"}
SETTLE_s = 8.0  # a measured manipulator has come to rest before the record starts
ATTEMPTS = 60


@dataclass
class Run:
    """One record: what was measured, what was put on top, and the inputs of the engine, settling included."""

    operator_N: np.ndarray
    disturbance: object
    force_noise_N: np.ndarray  # without spikes
    full: dict
    settle_ticks: int

    @property
    def result(self):
        """What the record holds."""
        return {name: values[self.settle_ticks :] for name, values in self.full.items()}


@dataclass
class Scenario:
    """Everything that a seed draws."""

    seed: int
    attempt: int
    kind: str
    effects: list          # [(name, size, Change)]
    rig: Rig
    base: dict             # true fields without the effect
    true: dict             # and with it
    chances: dict
    noise: dict
    noise_level: str
    richer: bool
    excitation: str
    scale: Scale
    runs: dict             # record, validate, repeat, standstill -> Run


def choose(seed, effect=None, size=None, kind=None, noise=None):
    """(kind, [names], size, noise level), each from the seed where it is not given. `effect`: names with a comma."""
    rng = np.random.default_rng([seed, 77])
    kind = kind or str(rng.choice(list(KINDS), p=list(KINDS.values())))
    if effect:
        names = [] if effect == "none" else effect.split(",")
        assert set(names) <= {*LIBRARY, *ASKED_FOR, *OUTSIDE}, f"no such effect: {effect}"
        kind = {0: "fault_free", 1: "single", 2: "two"}[len(names)]
        kind = "outside" if any(name in OUTSIDE for name in names) else kind
    elif kind in PAIRS:
        names = draw_pair(rng, of_one_block=kind == "two_of_one_block")
    else:
        names = {"fault_free": [], "single": [str(rng.choice(list(LIBRARY)))],
                 "outside": [str(rng.choice(list(OUTSIDE)))]}[kind]
    drawn_size = str(rng.choice(list(SIZES)[:2] if kind in PAIRS else list(SIZES)))
    drawn_noise = str(rng.choice(list(LEVELS)))
    return kind, names, size or drawn_size, noise or drawn_noise


def draw_pair(rng, of_one_block):
    """Two effects of the library, neither of which needs another kind of object, and which are not one."""
    while True:
        names = [str(name) for name in rng.choice(sorted(set(LIBRARY) - CONTACT_ONLY), 2, replace=False)]
        is_of_one_block = names[0].split(".")[0] == names[1].split(".")[0]
        if is_of_one_block == of_one_block and set(names) not in ONE_AS_A_PAIR:
            return names


def settling(p):
    """Ticks before the record starts."""
    return int(round(SETTLE_s / p["period_s"])) if p["manipulator_is_measured"] else 0


def is_stable(p, drive_N):
    """After a push of half a second the motion dies down; it may keep on hunting, but little."""
    rate_Hz = 1.0 / p["period_s"]
    t = np.arange(int(16 * rate_Hz)) / rate_Hz
    push_N = np.where((t > 1.0) & (t < 1.5), drive_N, 0.0)
    try:
        result = simulate(dict(p, settle_ticks=0), push_N)
    except Unstable:
        return False
    first, last = (t > 1) & (t < 4), t > 12
    signals = [result["object_m"], result["clean_force_N"]]
    return all(np.isfinite(y).all() and np.std(y[last]) < 0.5 * np.std(y[first]) for y in signals)


def drive(rng, rig, t):
    """(kind, operator force in N) that moves the object by some millimetres."""
    kind, shape = operator_force(rng, t, rig.true["contact"] > 0)
    free = dict(rig.true, surface_m=1e3)
    peak_m = np.max(np.abs(simulate(free, shape)["object_m"]))
    return kind, np.round(shape * rng.uniform(0.004, 0.015) / peak_m, 4)


def scale_of(result, operator_N, p):
    """What the record does without noise and effect."""
    T = p["period_s"]
    x, F = result["robot_m"], result["spring_N"]
    x_command = result["command_m"]
    return Scale(
        position_m=float(np.max(np.abs(x - (p["surface_m"] if p["contact"] else 0.0)))),
        velocity_m_per_s=float(np.max(np.abs(np.diff(x_command))) / T),
        acceleration_m_per_s2=float(np.max(np.abs(np.diff(x_command, 2))) / T**2),
        force_rms_N=float(np.std(result["clean_force_N"])),
        force_peak_N=float(np.max(np.abs(result["clean_force_N"]))),
        pull_peak_N=float(-np.min(F)), drive_rms_N=float(np.std(operator_N)), duration_s=len(x) * T, period_s=T)


def apply(base, changes):
    """(true fields, chances) with the changes made."""
    true, chances = dict(base), {}
    for change in changes:
        true |= change.fields
        chances |= change.chances
    true["sensor_step_N"] = max(true["sensor_step_N"], base["sensor_step_N"])
    return true, chances


def attempt_draw(seed, attempt, kind, names, size, noise_level):
    """A scenario without its runs, or None if its loop would not be stable or too weakly damped to measure on."""
    rng = np.random.default_rng([seed, attempt])
    measured = any(name.startswith("manipulator.") for name in names) or (not names and rng.random() < 0.25)
    may_contact = not GRIPPED_ONLY & set(names)
    contact = bool(CONTACT_ONLY & set(names)) or (may_contact and rng.random() < 0.2)
    rig = draw_rig(rng, contact, measured, soft_grip="object.loss_of_contact" in names)
    rate_Hz = rig.values["loop.rate_Hz"]
    t = np.arange(int(rng.uniform(20, 60) * rate_Hz)) / rate_Hz
    try:
        excitation, operator_N = drive(rng, rig, t)
        result = simulate(rig.true, operator_N)
    except Unstable:
        return None
    scale = scale_of(result, operator_N, rig.true)
    peak_N = float(np.max(np.abs(operator_N)))
    if scale.position_m > 0.04 or not is_stable(rig.true, peak_N):
        return None
    noise = draw_noise(rng, noise_level, scale.force_rms_N, measured)
    base = dict(rig.true, sensor_step_N=noise["force_N"].step, robot_step_m=noise["robot_position_m"].step,
                command_step_m=noise["command_position_m"].step)
    base["settle_ticks"] = settling(base)
    if noise["force_N"].step > 1e-6:
        rig.values["sensor.resolution_N"] = noise["force_N"].step
    richer = bool(rng.random() < 0.5)
    effects = []
    for name in names:
        s = SIZES[size] * rng.uniform(0.75, 1.3)
        effects.append((name, size, {**LIBRARY, **ASKED_FOR, **OUTSIDE}[name](rng, s, scale, rig, richer)))
    true, chances = apply(base, [change for _, _, change in effects])
    if not is_stable(true, peak_N) and not true["sensor_periodic_N"]:
        return None
    return Scenario(seed, attempt, kind, effects, rig, base, true, chances, noise, noise_level, richer, excitation,
                    scale, {"record": operator_N})


def run(scenario, name, operator_N, command_m=None):
    """One run of the true loop; its noise is drawn by seed and name alone."""
    p = scenario.true
    settle = int(p["settle_ticks"])
    operator_N = np.concatenate([np.zeros(settle), operator_N])
    rng = np.random.default_rng([scenario.seed, scenario.attempt, *name.encode()])
    disturbance, spikes_N = draw_disturbance(rng, scenario.noise, len(operator_N), p["period_s"], scenario.chances)
    noise_N = disturbance.force_noise_N
    disturbance.force_noise_N = noise_N + spikes_N
    if command_m is not None:
        command_m = command_m + disturbance.command_noise_m
    return Run(operator_N, disturbance, noise_N, simulate(p, operator_N, disturbance, command_m), settle)


def draw(seed, effect=None, size=None, kind=None, noise=None):
    """The scenario of a seed with all its runs."""
    chosen = choose(seed, effect, size, kind, noise)
    for attempt in range(ATTEMPTS):
        scenario = attempt_draw(seed, attempt, *chosen)
        if scenario is None:
            continue
        try:
            make_runs(scenario)
        except Unstable:
            continue
        moved_m = np.max(np.abs(scenario.runs["record"].result["clean_robot_m"]))
        if moved_m < 4.0 * scenario.scale.position_m + abs(scenario.true["surface_m"]):
            return scenario
    raise RuntimeError(f"seed {seed}: no stable loop in {ATTEMPTS} attempts")


def make_runs(scenario):
    """The record, and for some seeds another excitation, the same again, and the rig at rest."""
    operator_N = scenario.runs["record"]
    rng = np.random.default_rng([scenario.seed, scenario.attempt, 3])
    wants = dict(zip(["validate", "repeat", "standstill"], rng.random(3) < [0.6, 0.3, 0.5]))
    runs = {"record": run(scenario, "record", operator_N)}
    rate_Hz = scenario.rig.values["loop.rate_Hz"]
    if wants["validate"]:
        t = np.arange(int(rng.uniform(15, 30) * rate_Hz)) / rate_Hz
        runs["validate"] = run(scenario, "validate", drive(rng, scenario.rig, t)[1])
    if wants["repeat"]:
        runs["repeat"] = run(scenario, "repeat", operator_N)
    if wants["standstill"]:
        ticks = int(8 * rate_Hz)
        rest_m = np.zeros(ticks + int(scenario.true["settle_ticks"]))
        runs["standstill"] = run(scenario, "standstill", np.zeros(ticks), rest_m)
    scenario.runs = runs
