"""Measurement noise: white, coloured (first-order), resolution; and the losses of samples."""

from dataclasses import dataclass

import numpy as np
from physics import Disturbance
from rigs import log_uniform
from scipy.signal import lfilter

LEVELS = {"low": 0.002, "medium": 0.01, "high": 0.04}  # of the force's rms
COMMAND_m = {"low": (5e-8, 1e-7), "medium": (1e-7, 3e-7), "high": (3e-7, 1e-6)}  # of a measured manipulator
POSITION_m = {"low": (1e-6, 3e-6), "medium": (3e-6, 8e-6), "high": (8e-6, 20e-6)}


@dataclass
class Noise:
    """White plus first-order coloured noise of one channel, and the step that its values are rounded to."""

    white: float
    coloured: float
    corner_Hz: float
    step: float

    def draw(self, rng, ticks, period_s):
        """One run's noise, resolution not included."""
        a = np.exp(-2 * np.pi * self.corner_Hz * period_s)
        innovations = np.sqrt(1 - a**2) * rng.standard_normal(ticks)
        innovations[0] /= np.sqrt(1 - a**2)  # stationary from the first sample on
        return self.white * rng.standard_normal(ticks) + self.coloured * lfilter([1.0], [1.0, -a], innovations)

    @property
    def rms(self):
        """Floor of the channel, resolution included."""
        return float(np.sqrt(self.white**2 + self.coloured**2 + self.step**2 / 12.0))

    def spectrum(self, frequencies_Hz, period_s):
        """Variance per sample and frequency: 1 everywhere would be white noise of variance 1."""
        a = np.exp(-2 * np.pi * self.corner_Hz * period_s)
        z = np.exp(-2j * np.pi * frequencies_Hz * period_s)
        return (
            self.white**2 + self.step**2 / 12.0 + self.coloured**2 * (1 - a**2) / np.abs(1.0 - a * z) ** 2
        )


def draw_noise(rng, level, force_rms_N, measured_manipulator):
    """{channel: Noise} at a level."""
    force = LEVELS[level] * force_rms_N * log_uniform(rng, 0.7, 1.4)
    position = log_uniform(rng, *POSITION_m[level])
    command = log_uniform(rng, *COMMAND_m[level]) if measured_manipulator else 0.0
    quantised = rng.random() < 0.4

    def channel(rms, most_coloured, step_low, step_high, finest):
        coloured = rms * rng.uniform(0.0, most_coloured)
        step = float(f"{rms * rng.uniform(step_low, step_high):.2g}") if quantised else finest
        return Noise(float(np.sqrt(rms**2 - coloured**2)), float(coloured), log_uniform(rng, 0.5, 30.0), step)

    return {
        "force_N": channel(force, 0.7, 0.2, 1.0, 1e-7),
        "robot_position_m": channel(position, 0.5, 0.2, 1.0, 1e-9),
        "command_position_m": Noise(command, 0.0, 1.0, 1e-8 if measured_manipulator else 1e-11),
    }


def draw_disturbance(rng, noise, ticks, period_s, chances):
    """One run's noise and losses. `chances`: command_lost, force_lost, tick_lost, spike (probabilities), spike_N."""
    d = Disturbance.none(ticks)
    d.force_noise_N = noise["force_N"].draw(rng, ticks, period_s)
    d.robot_noise_m = noise["robot_position_m"].draw(rng, ticks, period_s)
    d.command_noise_m = noise["command_position_m"].draw(rng, ticks, period_s)
    for name in ("command", "force", "tick"):
        happens = rng.random(ticks) < chances.get(name + "_lost", 0.0)
        setattr(d, name + "_is_lost", happens.astype(np.uint8))
    hit = rng.random(ticks) < chances.get("spike", 0.0)
    size = chances.get("spike_N", 0.0) * rng.choice([-1.0, 1.0], ticks) * (1.0 + 0.1 * rng.standard_normal(ticks))
    spikes_N = np.where(hit, size, 0.0)
    return d, spikes_N
