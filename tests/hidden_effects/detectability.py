"""How clearly a record shows an effect, from the truth alone.

Per channel, s(d) = the blocks replayed from the recorded inputs with their true parameters and the effect, minus the
same without it and with the base moved by d within the rig's tolerances. Another effect stays in both: with parameters
that are as free as they are to a diagnosis, where the effect would be shown without that (a heavier object does most of
what a second mass does). What the best base leaves, whitened by the noise's own spectrum,

    chi2 = min_d sum_channels sum_f |S(d)|^2 / (N * noise(f)),

is twice the logarithm of the likelihood ratio against it: least squares within bounds, from a first step with the
sensitivities over the whole tolerances. "Detectable" asks for

    chi2 - p ln N >= 100   and   rms of what is left >= 0.2 of the floor's rms in one channel,

p parameters of the effect, N samples of all channels together.
"""

import numpy as np
from effects import Change
from parameters import FIELDS
from physics import Disturbance, replay_manipulator, simulate
from rigs import FIELD_OF_KEY
from scenario import apply
from scipy.optimize import least_squares, lsq_linear

CHI2_MARGIN = 100.0
LEAST_SHARE = 0.2  # of the floor's rms
CHANNELS = ["command_position_m", "robot_position_m", "force_N"]


def replayed(p, run, losses=None):
    """{channel: values} of the blocks with fields p, without noise and rounding, from the recorded inputs."""
    settle = int(p["settle_ticks"])
    hardware = simulate(dict(p, sensor_step_N=0.0, robot_step_m=0.0), run.operator_N, losses, run.full["command_m"])
    command_m = replay_manipulator(p, run.operator_N - run.full["force_N"])
    channels = {"command_position_m": command_m, "robot_position_m": hardware["robot_m"],
                "force_N": hardware["force_N"]}
    return {name: values[settle:] for name, values in channels.items()}


def losses_of(chances, run):
    """The losses and spikes that the run had, as far as `chances` has them."""
    had, losses = run.disturbance, Disturbance.none(len(run.operator_N))
    for name in ("command", "force", "tick"):
        if name + "_lost" in chances:
            setattr(losses, name + "_is_lost", getattr(had, name + "_is_lost"))
    if "spike" in chances:
        losses.force_noise_N = had.force_noise_N - run.force_noise_N
    return losses


def with_effects(scenario, run, changes, base=None):
    """{channel: values} of the replay with these changes; `base`: other fields than the true ones."""
    true, chances = apply(base or scenario.base, changes)
    channels = replayed(true, run, losses_of(chances, run))
    if any("resolution_N" in change.parameters for change in changes):
        channels["force_N"] = (run.full["force_N"] - run.force_noise_N)[run.settle_ticks :]
    return channels


def whitened(values, noise, period_s):
    """A signal in units of the noise: its squared sum is what the noise's likelihood sees."""
    n = len(values)
    spectrum = np.fft.rfft(values) / np.sqrt(n * noise.spectrum(np.fft.rfftfreq(n, period_s), period_s))
    spectrum[1 : (n + 1) // 2] *= np.sqrt(2.0)  # the other half
    return np.concatenate([spectrum.real, spectrum.imag])


def stacked(scenario, signals):
    """The whitened channels one after the other; the firmware's own command is no measurement."""
    return np.concatenate([whitened(signals[c], scenario.noise[c], scenario.base["period_s"])
                           for c in measured_channels(scenario)])


def measured_channels(scenario):
    return [c for c in CHANNELS if c != "command_position_m" or scenario.base["manipulator_is_measured"]]


# What a rig file says nothing of is known to 5 % (sim_hal/diagnosis/README.md); these have no tolerance in any drawn rig.
USUAL_TOLERANCE = 0.05
WITHOUT_TOLERANCE = ["sensor_delay_s", "spring_stiffness_N_per_m", "spring_damping_N_s_per_m", "low_pass_damping"]


def tunable(scenario):
    """[(field, true value, lowest, highest)] of the parameters that are known to a tolerance only."""
    for name in WITHOUT_TOLERANCE:
        value = scenario.base[name]  # as in the rig file
        if value > 0.0 and (name != "low_pass_damping" or scenario.base["low_pass_order"] > 1.5):
            yield name, value, value * (1 - USUAL_TOLERANCE), value * (1 + USUAL_TOLERANCE)
    for key, tolerance in scenario.rig.tolerances.items():
        if key.startswith("manipulator.") and not scenario.base["manipulator_is_measured"]:
            continue  # the firmware's, and exact
        name, unit = FIELD_OF_KEY[key]
        nominal = scenario.rig.values[key] * unit
        yield name, scenario.base[name], nominal * (1 - tolerance), nominal * (1 + tolerance)


class Tuning:
    """What re-tuning the base within its tolerances can do to a record."""

    ROUNDS = 5
    LITTLE = 1e4  # chi2; from 631 on it was seen to go to nothing
    STEP = 1e-3  # of a tolerance's width, or of a further parameter: for slopes
    NOTHING = 1.0  # chi2: no more to be gained
    FURTHER_MAX = 1e3  # times where it begins

    def __init__(self, scenario):
        self.scenario = scenario
        run, base = scenario.runs["record"], scenario.base
        before = replayed(base, run)
        self.fields, columns, self.low, self.high = [], [], [], []
        for name, value, lowest, highest in tunable(scenario):
            width = highest - lowest
            change = 0.5 * width * (1 if value < 0.5 * (lowest + highest) else -1)
            after = replayed({**base, name: value + change}, run)
            columns.append({c: (after[c] - before[c]) * (width / change) for c in before})
            self.fields.append((name, value, width))
            self.low.append(min((lowest - value) / width, -1e-9))  # the truth itself is always allowed
            self.high.append(max((highest - value) / width, 1e-9))
        self.J = np.column_stack([stacked(scenario, column) for column in columns])

    def base(self, d):
        """The true fields, tuned by d in units of the tolerances' widths."""
        return self.scenario.base | {name: value + share * width
                                     for share, (name, value, width) in zip(d, self.fields)}

    def left(self, truth, changes, d):
        """{channel: truth less the replay} with these changes and the base tuned by d."""
        other = with_effects(self.scenario, self.scenario.runs["record"], changes, self.base(d))
        return {c: truth[c] - other[c] for c in measured_channels(self.scenario)}

    def step(self, rest, d):
        """The change of d that takes most of a whitened signal away if the sensitivities hold."""
        return lsq_linear(self.J, rest, (np.subtract(self.low, d) - 1e-12, np.subtract(self.high, d) + 1e-12)).x

    def absorb(self, truth, changes):
        """(chi2, {channel: what is left}) of a record after the best re-tuning of the base with these changes; not finite
        where they let a block overflow. First with the sensitivities, and exactly where that leaves little."""
        d, best = np.zeros(len(self.fields)), None
        for _ in range(self.ROUNDS):
            left = self.left(truth, changes, d)
            rest = stacked(self.scenario, left)
            chi2 = float(np.sum(rest**2))
            if best and not chi2 < 0.999 * best[0]:
                break
            best = (chi2, left)
            if not np.isfinite(chi2):
                break
            d = np.clip(d + self.step(rest, d), self.low, self.high)
        return self.fit(truth, lambda _: changes, 0) if 1e-3 < best[0] < self.LITTLE else best

    def fit(self, truth, changes_at, count):
        """The same by least squares within bounds, with the best of `count` further parameters x too, for which there are
        changes_at(x); they begin at 1."""
        low = np.concatenate([np.full(count, -self.FURTHER_MAX), self.low])
        high = np.concatenate([np.full(count, self.FURTHER_MAX), self.high])

        def rest(z):
            return stacked(self.scenario, self.left(truth, changes_at(z[:count]), z[count:]))

        def slopes(z):
            here, made = rest(z), []
            for i, value in enumerate(z):
                step = self.STEP * (1 if value + self.STEP < high[i] else -1)
                made.append((rest(np.where(np.arange(len(z)) == i, z + step, z)) - here) / step)
            return np.nan_to_num(np.column_stack(made), posinf=0.0, neginf=0.0)

        begin = np.concatenate([np.ones(count), np.zeros(len(self.fields))])
        before = rest(begin)
        if not np.all(np.isfinite(before)):
            return float(np.sum(before**2)), self.left(truth, changes_at(begin[:count]), begin[count:])
        stepped = np.concatenate([begin[:count], np.clip(self.step(before, begin[count:]), self.low, self.high)])
        starts = sorted((begin, stepped), key=lambda z: np.nan_to_num(np.sum(rest(z) ** 2), nan=np.inf))
        best = starts[0]
        for method in ("dogbox", "trf"):  # trf was seen to crawl along a bound, dogbox wants independent slopes
            inside = np.clip(best, low + 1e-10, high - 1e-10)
            found = least_squares(rest, inside, slopes, (low, high), method, ftol=1e-5, x_scale="jac", max_nfev=25)
            best = min((found.x, best), key=lambda z: np.sum(rest(z) ** 2))
            if np.sum(rest(best) ** 2) < self.NOTHING:
                break
        return float(np.sum(rest(best) ** 2)), self.left(truth, changes_at(best[:count]), best[count:])


def assess(scenario):
    """Per effect: rms that it adds to each channel, that is left, and of the floor; chi2; detectable or not."""
    if not scenario.effects:
        return []
    run, tuning = scenario.runs["record"], Tuning(scenario)
    changes = [change for _, _, change in scenario.effects]
    everything = with_effects(scenario, run, changes)
    found = []
    for _, _, change in scenario.effects:
        rest = [(other_name, other) for other_name, _, other in scenario.effects if other is not change]
        others = with_effects(scenario, run, [other for _, other in rest])
        added = {c: everything[c] - others[c] for c in measured_channels(scenario)}
        judged = judged_by(scenario, change, added, *tuning.absorb(everything, [other for _, other in rest]))
        if rest and judged["detectable"] and judged["chi2"] < Tuning.LITTLE:
            judged = judged_by(scenario, change, added, *absorb_with(scenario, tuning, everything, rest))
        found.append(judged)
    return found


def absorb_with(scenario, tuning, truth, effects):
    """What is left after the best re-tuning of the base and of these effects' own parameters: [(name, change)]."""
    fields = [field for name, _ in effects for field, _ in FIELDS.get(name, {}).values()]

    def changes_at(x):
        moved = {field: scenario.true[field] * share for field, share in zip(fields, x)}
        return [*(change for _, change in effects), Change(moved, {})]

    return tuning.fit(truth, changes_at, len(fields))


def judged_by(scenario, change, added, chi2, left):
    channels = {c: {"added_rms": rms(added[c]), "left_rms": rms(left[c]), "floor_rms": scenario.noise[c].rms}
                for c in added}
    share = max(channel["left_rms"] / channel["floor_rms"] for channel in channels.values())
    samples = sum(len(values) for values in added.values())
    margin = chi2 - len(change.parameters) * float(np.log(samples))
    return {"channels": channels, "chi2": chi2, "margin": margin, "share_of_floor": share,
            "detectable": bool(margin >= CHI2_MARGIN and share >= LEAST_SHARE)}


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))
