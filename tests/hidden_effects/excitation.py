"""Operator force over time, N: what a record is made of. Shapes have a peak of about 1; the caller scales them."""

import numpy as np

KINDS = ["multisine", "chirp", "steps", "minimum_jerk"]


def multisine(rng, t):
    """Sum of 12 to 30 sines, 0.08 to 5 Hz, random phases; the amplitude falls with frequency in some draws."""
    count = int(rng.integers(12, 31))
    f_Hz = np.exp(np.linspace(np.log(0.08), np.log(rng.uniform(3.0, 5.0)), count)) * rng.uniform(0.97, 1.03, count)
    weight = f_Hz ** -rng.choice([0.0, 0.5])
    phase = rng.uniform(0, 2 * np.pi, count)
    return np.sum(weight[:, None] * np.sin(2 * np.pi * f_Hz[:, None] * t + phase[:, None]), axis=0)


def chirp(rng, t):
    """0.1 to 5 Hz, logarithmic, there and back."""
    low, high = rng.uniform(0.08, 0.2), rng.uniform(3.0, 5.0)
    half = t[-1] / 2
    s = np.where(t < half, t, t[-1] - t) / half
    f_Hz = low * (high / low) ** s
    return np.sin(2 * np.pi * np.cumsum(f_Hz) * (t[1] - t[0]) + rng.uniform(0, 2 * np.pi))


def steps(rng, t):
    """Levels held for 0.4 to 2.5 s."""
    out = np.zeros_like(t)
    at = 0.0
    while at < t[-1]:
        out[t >= at] = rng.uniform(-1.0, 1.0)
        at += rng.uniform(0.4, 2.5)
    return out


def minimum_jerk(rng, t):
    """Moves between levels, 0.4 to 2 s each, with pauses."""
    out = np.zeros_like(t)
    at, level = 0.0, 0.0
    while at < t[-1]:
        move_s, goal = rng.uniform(0.4, 2.0), rng.uniform(-1.0, 1.0)
        s = np.clip((t - at) / move_s, 0.0, 1.0)
        out = np.where(t >= at, level + (goal - level) * s**3 * (10.0 - 15.0 * s + 6.0 * s**2), out)
        at += move_s + rng.uniform(0.0, 0.6)
        level = goal
    return out


def tremor(rng, t):
    """A hand's tremor: narrow-band noise around 8 to 12 Hz, standard deviation 1."""
    period_s = t[1] - t[0]
    f_Hz = np.fft.rfftfreq(len(t), period_s)
    shape = np.exp(-0.5 * ((f_Hz - rng.uniform(8.0, 12.0)) / 0.7) ** 2)
    noise = np.fft.irfft(np.fft.rfft(rng.standard_normal(len(t))) * shape, len(t))
    return noise / np.std(noise)


def operator_force(rng, t, contact=False):
    """A force of peak 1 that starts and ends at rest, with tremor in half of the draws; (kind, force)."""
    kind = str(rng.choice(KINDS))
    force = {"multisine": multisine, "chirp": chirp, "steps": steps, "minimum_jerk": minimum_jerk}[kind](rng, t)
    force = force / np.max(np.abs(force))
    if contact:
        force = 0.6 + 0.7 * force  # presses more than it lifts off
    edge = np.clip(np.minimum(t - 0.3, t[-1] - 0.3 - t) / 0.5, 0.0, 1.0)
    force = force * edge**2 * (3.0 - 2.0 * edge)
    if rng.random() < 0.5:
        force = force + rng.uniform(0.002, 0.03) * tremor(rng, t)
    return kind, force
