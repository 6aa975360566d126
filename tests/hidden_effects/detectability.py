"""How clearly a record shows its effect, from the truth alone.

Per channel, s = what the effect adds: the record without its noise, minus the replay of the effect-free block with its
true parameters, from the same recorded inputs. A re-tuning of the base within the rig's tolerances can take away J d,
J the sensitivities of the replay (finite differences), d bounded. What is left, whitened by the noise's own spectrum,

    chi2 = min_d sum_channels sum_f |S - (J d)|^2 / (N * noise(f)),

is twice the logarithm of the likelihood ratio against the best base. "Detectable" asks for

    chi2 - p ln N >= 100   and   rms of what is left >= 0.2 of the floor's rms in one channel,

p parameters of the effect, N samples of all channels together.
"""

import numpy as np
from physics import replay_manipulator, simulate
from rigs import FIELD_OF_KEY
from scipy.optimize import lsq_linear

CHI2_MARGIN = 100.0
LEAST_SHARE = 0.2  # of the floor's rms
CHANNELS = ["command_position_m", "robot_position_m", "force_N"]


def replayed(p, run):
    """{channel: values} of the blocks with fields p, without noise, from the recorded inputs."""
    settle = int(p["settle_ticks"])
    full = dict(p, settle_ticks=0, sensor_step_N=0.0, robot_step_m=0.0)
    result = run.full
    hardware = simulate(full, run.operator_N, command_m=result["command_m"])
    command_m = replay_manipulator(full, run.operator_N - result["force_N"])
    channels = {"command_position_m": command_m, "robot_position_m": hardware["clean_robot_m"],
                "force_N": hardware["force_N"]}
    return {name: values[settle:] for name, values in channels.items()}


def without_noise(scenario, run):
    """{channel: values} of the record, its measurement noise taken away."""
    settle = int(scenario.true["settle_ticks"])
    d, r = run.disturbance, run.result
    return {
        "command_position_m": r["command_m"] - d.command_noise_m[settle:],
        "robot_position_m": r["robot_m"] - d.robot_noise_m[settle:],
        "force_N": r["force_N"] - run.force_noise_N[settle:],
    }


def whitened(values, noise, period_s):
    """A signal in units of the noise: its squared sum is what the noise's likelihood sees."""
    n = len(values)
    spectrum = np.fft.rfft(values) / np.sqrt(n * noise.spectrum(np.fft.rfftfreq(n, period_s), period_s))
    spectrum[1 : (n + 1) // 2] *= np.sqrt(2.0)  # the other half
    return np.concatenate([spectrum.real, spectrum.imag])


def tunable(scenario):
    """[(field, true value, lowest, highest)] of the parameters with a tolerance."""
    for key, tolerance in scenario.rig.tolerances.items():
        if key.startswith("manipulator.") and not scenario.base["manipulator_is_measured"]:
            continue  # the firmware's, and exact
        name, unit = FIELD_OF_KEY[key]
        nominal = scenario.rig.values[key] * unit
        yield name, scenario.base[name], nominal * (1 - tolerance), nominal * (1 + tolerance)


def assess(scenario):
    """The effect's trace in the record: {channel: {added_rms, left_rms, floor_rms}, chi2, ...}; {} if there is none."""
    if not scenario.effects:
        return {}
    run, T = scenario.runs["record"], scenario.base["period_s"]
    base = scenario.base
    before = replayed(base, run)
    clean = without_noise(scenario, run)
    channels = [c for c in CHANNELS if c != "command_position_m" or base["manipulator_is_measured"]]
    added = {c: clean[c] - before[c] for c in channels}

    columns, low, high = [], [], []
    for name, value, lowest, highest in tunable(scenario):
        change = 0.5 * (highest - lowest) * (1 if value < 0.5 * (lowest + highest) else -1)
        after = replayed(dict(base, **{name: value + change}), run)
        columns.append({c: (after[c] - before[c]) / change * (highest - lowest) for c in channels})
        low.append((lowest - value) / (highest - lowest))
        high.append((highest - value) / (highest - lowest))

    def stacked(signals):
        return np.concatenate([whitened(signals[c], scenario.noise[c], T) for c in channels])

    s, J = stacked(added), np.column_stack([stacked(column) for column in columns])
    low = np.minimum(low, -1e-9)  # the truth itself is always allowed
    high = np.maximum(high, 1e-9)
    d = lsq_linear(J, s, (low, high)).x
    left = {c: added[c] - sum(share * column[c] for share, column in zip(d, columns)) for c in channels}
    chi2 = float(np.sum((s - J @ d) ** 2))
    count = sum(len(added[c]) for c in channels)
    parameters = sum(len(change.parameters) for _, _, change in scenario.effects)
    result = {c: {"added_rms": rms(added[c]), "left_rms": rms(left[c]), "floor_rms": scenario.noise[c].rms}
              for c in channels}
    share = max(result[c]["left_rms"] / result[c]["floor_rms"] for c in channels)
    margin = chi2 - parameters * float(np.log(count))
    return {"channels": result, "chi2": chi2, "margin": margin, "share_of_floor": share,
            "detectable": bool(margin >= CHI2_MARGIN and share >= LEAST_SHARE)}


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))
