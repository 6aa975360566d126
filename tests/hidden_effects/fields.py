"""The parameters of the simulated truth in SI units: name, value that switches it off, meaning.

The C struct of loop.c is written from this list, so the two cannot disagree.
"""

FIELDS = [
    # loop
    ("period_s", 0.0025, "T"),
    ("substep_s", 1e-4, "longest step of the integration"),
    ("settle_ticks", 0, "ticks before the record starts, at rest; not written"),
    ("free_clock", 0, "1: the robot takes the newest setpoint once per period of its own"),
    ("clock_drift", 0.0, "its period is T (1 + this)"),
    ("clock_phase_s", 0.0, "its instant next to the first row of the record"),
    # manipulator: M x'' + D x' + K x + ... = F_op - F
    ("manipulator_mass_kg", 200.0, "M"),
    ("manipulator_damping_N_s_per_m", 125.0, "D"),
    ("manipulator_stiffness_N_per_m", 7900.0, "K"),
    ("manipulator_is_measured", 0, "0: firmware, exact zero-order hold; 1: hardware, with the terms below"),
    ("manipulator_friction_up_N", 0.0, "Coulomb friction where x' > 0"),
    ("manipulator_friction_down_N", 0.0, "Coulomb friction where x' < 0"),
    ("manipulator_damping_asymmetry_N_s_per_m", 0.0, "D + this where x' > 0, D - this where x' < 0"),
    ("manipulator_presliding_m", 1e-6, "length over which friction builds up"),
    ("manipulator_stribeck_N", 0.0, "Coulomb friction is larger by it at rest"),
    ("manipulator_stribeck_m_per_s", 0.01, "velocity over which that is lost"),
    ("manipulator_cubic_N_per_m3", 0.0, "K3 x^3"),
    ("manipulator_quadratic_N_per_m2", 0.0, "K2 x^2"),
    ("manipulator_gap_m", 0.0, "full width of the gap in the spring"),
    ("manipulator_gravity_N", 0.0, "constant force"),
    ("command_step_m", 1e-11, "resolution of the setpoint that is sent"),
    # robot
    ("robot_dead_time_s", 0.0175, "T_R"),
    ("robot_dead_time_drift", 0.0, "T_R + this * t"),
    ("robot_deadband_m", 0.0, "smaller changes of the setpoint are ignored"),
    ("robot_gain", 1.0, "g"),
    ("robot_gain_drift_per_s", 0.0, "g (1 + this * t)"),
    ("robot_curvature_per_m2", 0.0, "u (1 - this * u^2): kinematic error"),
    ("robot_velocity_limit_m_per_s", 1e9, "V"),
    ("robot_acceleration_limit_m_per_s2", 1e9, "A"),
    ("robot_windup_per_s", 0.0, "integral action that winds up while a limit acts"),
    ("robot_windup_leak_s", 0.2, "time constant with which it unwinds"),
    ("robot_lag_s", 0.0, "tau"),
    ("robot_lag_drift", 0.0, "tau + this * t"),
    ("robot_resonance_rad_per_s", 0.0, "w; 0: none"),
    ("robot_resonance_damping", 0.7, "z"),
    ("robot_backlash_m", 0.0, "play, full width"),
    ("robot_hysteresis_m", 0.0, "amplitude of a rate-independent hysteresis of the position"),
    ("robot_hysteresis_length_m", 1e-3, "travel over which it builds up"),
    ("robot_periodic_m", 0.0, "a"),
    ("robot_pitch_m", 0.01, "L"),
    ("robot_periodic_rad", 0.0, "phi"),
    ("robot_step_m", 0.0, "resolution of the measured robot position"),
    # sensor spring
    ("spring_stiffness_N_per_m", 2e7, "k_S"),
    ("spring_damping_N_s_per_m", 4472.0, "d_S"),
    ("grip_N", 1e12, "the grip cannot pull harder"),
    # object
    ("object_mass_kg", 100.0, "m"),
    ("object_stiffness_N_per_m", 2368.0, "k"),
    ("object_damping_N_s_per_m", 19.0, "d"),
    ("contact", 0, "1: material beyond the surface, pushed by a tool of mass m"),
    ("surface_m", 0.0, "where it starts"),
    ("impact_damping_s_per_m", 0.0, "Hunt-Crossley: k p (1 + c p') in place of k p + d p'"),
    ("object_cubic_N_per_m3", 0.0, "k3 x^3"),
    ("object_quadratic_N_per_m2", 0.0, "k2 x^2"),
    ("object_gap_m", 0.0, "full width of the gap in the spring"),
    ("object_drift_per_s", 0.0, "k (1 + this * t)"),
    ("object_softening_m", 0.0, "L: k L sin(x / L) in place of k x; 0: none"),
    ("object_drag_N_s2_per_m2", 0.0, "this * v |v|"),
    ("object_friction_N", 0.0, "Fc, with presliding"),
    ("object_presliding_m", 1e-6, "length over which it builds up"),
    ("object_static_ratio", 1.0, "static to sliding friction"),
    ("object_stribeck_m_per_s", 0.01, "velocity over which the static part is lost"),
    ("object_hysteresis_N", 0.0, "Fh"),
    ("object_hysteresis_length_m", 1e-3, "xh"),
    ("object_hysteresis_exponent", 0.0, "Bouc-Wen's n; 0: Dahl"),
    ("relaxation_N_per_m", 0.0, "kR of a spring and a damper in a row"),
    ("relaxation_s", 1.0, "their time constant"),
    ("second_mass_kg", 0.0, "m2; 0: none"),
    ("second_stiffness_N_per_m", 0.0, "k2"),
    ("second_damping_N_s_per_m", 0.0, "d2"),
    # sensor
    ("low_pass_order", 2, "0, 1 or 2"),
    ("low_pass_rad_per_s", 125.6, "w_L"),
    ("low_pass_damping", 0.7, "z_L"),
    ("tool_mass_kg", 0.0, "of the tool between sensor and object; low-pass of order 2"),
    ("sensor_lag_s", 0.0, "a further first-order lag"),
    ("sensor_delay_s", 0.0025, "T_S"),
    ("sensor_gain", 1.0, "g"),
    ("sensor_curvature_per_N", 0.0, "F (1 + this * abs(F))"),
    ("sensor_even_per_N", 0.0, "F + this * F^2"),
    ("sensor_crosstalk", 0.0, "share of the operator's force that the sensor sees"),
    ("sensor_bias_N", 0.0, "b"),
    ("sensor_drift_N_per_s", 0.0, "r t"),
    ("sensor_warming_N", 0.0, "this * (1 - exp(-t / warming_s))"),
    ("sensor_warming_s", 5.0, "its time constant"),
    ("sensor_periodic_N", 0.0, "a"),
    ("sensor_periodic_rad_per_s", 0.0, "2 pi f"),
    ("sensor_periodic_rad", 0.0, "phi"),
    ("sensor_saturation_N", 1e12, "S"),
    ("sensor_step_N", 1e-7, "resolution; the wire's is 0.1 uN"),
]

DEFAULTS = {name: value for name, value, _ in FIELDS}


def c_struct():
    """The parameters as a C struct."""
    lines = [f"    double {name}; /* {meaning} */" for name, _, meaning in FIELDS]
    return "struct truth {\n" + "\n".join(lines) + "\n};\n"
