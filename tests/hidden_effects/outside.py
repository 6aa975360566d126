"""Effects that the library does not have: what a diagnosis meets on a rig that nobody foresaw."""

import numpy as np
from effects import Change, sign, spring_N


def outside(name, value, **more):
    """A change of one field that has no name in the library."""
    return Change({name: float(value), **more}, {name: float(value)})


def gain_drift(rng, s, scale, rig, richer):
    """The drives warm up and the robot's kinematics grow."""
    return outside("robot_gain_drift_per_s", sign(rng) * 0.4 * s / scale.duration_s)


def lag_drift(rng, s, scale, rig, richer):
    """Grease that warms: the drive's lag changes over the record."""
    return outside("robot_lag_drift", 0.03 * s / scale.duration_s, robot_lag_s=1e-5)


def curvature(rng, s, scale, rig, richer):
    """Kinematic error that grows with the cube of the stroke."""
    return outside("robot_curvature_per_m2", sign(rng) * 0.4 * s / scale.position_m**2)


def hysteretic_gain(rng, s, scale, rig, richer):
    """Wind-up of the gears: a smooth rate-independent hysteresis of the position."""
    return outside("robot_hysteresis_m", 0.1 * s * scale.position_m,
                   robot_hysteresis_length_m=0.3 * scale.position_m)


def drag(rng, s, scale, rig, richer):
    """Air on a solar generator: quadratic in velocity."""
    return outside("object_drag_N_s2_per_m2", s * spring_N(scale, rig) / scale.velocity_m_per_s**2)


def stribeck(rng, s, scale, rig, richer):
    """Friction whose static part is 2 to 3 times the sliding one and fades over a good part of the velocity."""
    Fc = 0.3 * s * spring_N(scale, rig)
    return outside("object_friction_N", Fc, object_static_ratio=rng.uniform(2.0, 3.0),
                   object_stribeck_m_per_s=scale.velocity_m_per_s * rng.uniform(0.1, 0.4), object_presliding_m=1e-5)


def softening(rng, s, scale, rig, richer):
    """A pendulum: k L sin(x / L)."""
    return outside("object_softening_m", scale.position_m / np.sqrt(6.0 * min(s, 0.3)))


def crosstalk(rng, s, scale, rig, richer):
    """The operator's force leaks into the sensor."""
    return outside("sensor_crosstalk", sign(rng) * 0.5 * s * scale.force_rms_N / scale.drive_rms_N)


def sensor_curvature(rng, s, scale, rig, richer):
    """A load cell whose sensitivity depends on the load."""
    return outside("sensor_curvature_per_N", sign(rng) * 0.6 * s / scale.force_peak_N)


def warming(rng, s, scale, rig, richer):
    """A load cell that warms up after it was switched on."""
    return outside("sensor_warming_N", sign(rng) * 2.0 * s * scale.force_rms_N,
                   sensor_warming_s=scale.duration_s * rng.uniform(0.05, 0.15))


OUTSIDE = {
    "outside.robot_gain_drift": gain_drift,
    "outside.robot_lag_drift": lag_drift,
    "outside.robot_curvature": curvature,
    "outside.robot_hysteretic_gain": hysteretic_gain,
    "outside.object_drag": drag,
    "outside.object_stribeck": stribeck,
    "outside.object_softening": softening,
    "outside.sensor_crosstalk": crosstalk,
    "outside.sensor_curvature": sensor_curvature,
    "outside.sensor_warming": warming,
}
