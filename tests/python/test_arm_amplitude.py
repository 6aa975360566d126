"""`berth reduce --amplitude` against a two-link arm of our own: Lagrange's equations in absolute angles, by numpy and scipy."""

import tomllib

import numpy as np
import pytest
from conftest import EXIT_INPUT, RIG_FOLDER, command, one_json_object
from scipy.integrate import solve_ivp

ARM = tomllib.loads((RIG_FOLDER.parent / "arms" / "ess.toml").read_text())
OBJECT_kg, OBJECT_N_per_m = 100.0, 0.3 * 7895.683520871487
OBJECT_N_s_per_m = 2 * 0.02 * np.sqrt(OBJECT_N_per_m * OBJECT_kg)


def across_z(vector):
    return np.array([-vector[1], vector[0]])


def along(angle):
    return np.array([np.cos(angle), np.sin(angle)])


class Arm:
    """Coordinates: x, y and angle of the satellite (none where it is held), angles of the links in the world, angles of the
    motors in the world, less that of the body before. The object pushes the tool along x; across, a rail holds it."""

    def __init__(self, is_held, is_guided):
        self.is_held, self.is_guided = is_held, is_guided
        joints = ARM["joint"]
        self.stiffness, self.damping = (np.array([joint[key] for joint in joints]) for key in
                                        ("stiffness_N_m_per_rad", "damping_N_m_s_per_rad"))
        self.motor = np.array([joint["rotor_inertia_kg_m2"] * joint["gear_ratio"] ** 2 for joint in joints])
        w = 2 * np.pi * np.array([joint["servo_frequency_Hz"] for joint in joints])
        self.servo_stiffness = self.motor * w ** 2
        self.servo_damping = 2 * np.array([joint["servo_damping_ratio"] for joint in joints]) * w * self.motor
        self.torque_limit = np.array([joint["torque_limit_N_m"] for joint in joints])
        self.command = np.array([joint["initial_rad"] for joint in joints])
        shoulder = np.array(joints[0]["origin_m"][:2])
        upper, fore = joints[1]["origin_m"][0], ARM["tool"]["origin_m"][0]
        # Mass, inertia and, by body turned along, where the centre is from the satellite's.
        self.bodies = [(ARM["base"]["mass_kg"], ARM["base"]["inertia_kg_m2"][5], 0, [None, 0, 0])] + [
            (joints[0]["link"]["mass_kg"], joints[0]["link"]["inertia_kg_m2"][5], 1,
             [shoulder, joints[0]["link"]["centre_m"][0], 0]),
            (joints[1]["link"]["mass_kg"], joints[1]["link"]["inertia_kg_m2"][5], 2,
             [shoulder, upper, joints[1]["link"]["centre_m"][0]]),
            (ARM["payload"]["mass_kg"], ARM["payload"]["inertia_kg_m2"][5], 2, [shoulder, upper, fore])]
        self.tool = [shoulder, upper, fore]
        self.rest = np.concatenate((np.zeros(3), np.cumsum(self.command), self.command))
        self.home = self.place(self.rest, self.tool)
        self.used = np.arange(3 if is_held else 0, 7)

    def place(self, q, way):
        spot = q[:2].copy()
        if way[0] is not None:
            spot += along(q[2]) * way[0][0] + across_z(along(q[2])) * way[0][1]
        return spot + way[1] * along(q[3]) + way[2] * along(q[4])

    def jacobian(self, q, way):
        found = np.zeros((2, 7))
        found[:, :2] = np.eye(2)
        if way[0] is not None:
            found[:, 2] = across_z(along(q[2]) * way[0][0] + across_z(along(q[2])) * way[0][1])
        found[:, 3], found[:, 4] = way[1] * across_z(along(q[3])), way[2] * across_z(along(q[4]))
        return found

    def centripetal(self, q, rate, way):
        """Of a place's acceleration what no acceleration of the coordinates is in."""
        found = -way[1] * along(q[3]) * rate[3] ** 2 - way[2] * along(q[4]) * rate[4] ** 2
        if way[0] is not None:
            found -= (along(q[2]) * way[0][0] + across_z(along(q[2])) * way[0][1]) * rate[2] ** 2
        return found

    def inertia(self, q):
        matrix = np.zeros((7, 7))
        for mass, turning, angle, way in self.bodies:
            jacobian = self.jacobian(q, way)
            matrix += mass * jacobian.T @ jacobian
            matrix[2 + angle, 2 + angle] += turning
        matrix[5, 5], matrix[6, 6] = self.motor
        return matrix

    def forces(self, q, rate):
        found = np.zeros(7)
        for mass, _, _, way in self.bodies:
            found -= mass * self.jacobian(q, way).T @ self.centripetal(q, rate, way)
        joint, joint_rate = np.diff(q[2:5]), np.diff(rate[2:5])
        spring = self.stiffness * (q[5:] - joint) + self.damping * (rate[5:] - joint_rate)
        servo = np.clip(self.servo_stiffness * (self.command - q[5:]) - self.servo_damping * rate[5:],
                        -self.torque_limit, self.torque_limit)
        found[5:] += servo - spring
        found[3:5] += spring
        found[2:4] -= spring
        wheel = ARM["attitude"]
        torque = -wheel["stiffness_N_m_per_rad"] * q[2] - wheel["damping_N_m_s_per_rad"] * rate[2]
        found[2] += np.clip(torque, -wheel["torque_limit_N_m"], wheel["torque_limit_N_m"])
        tool_x, tool_v = self.place(q, self.tool)[0] - self.home[0], (self.jacobian(q, self.tool) @ rate)[0]
        found -= self.jacobian(q, self.tool)[0] * (OBJECT_N_per_m * tool_x + OBJECT_N_s_per_m * tool_v)
        return found

    def acceleration(self, q, rate):
        used = self.used
        jacobian, bent = self.jacobian(q, self.tool), self.centripetal(q, rate, self.tool)
        matrix = self.inertia(q) + OBJECT_kg * np.outer(jacobian[0], jacobian[0])
        force = self.forces(q, rate) - OBJECT_kg * jacobian[0] * bent[0]
        rows = jacobian[1:2][:, used] if self.is_guided else np.zeros((0, len(used)))
        all_of_it = np.block([[matrix[np.ix_(used, used)], rows.T], [rows, np.zeros((len(rows),) * 2)]])
        solved = np.linalg.solve(all_of_it, np.concatenate((force[used], -bent[1:1 + len(rows)])))
        found = np.zeros(7)
        found[used] = solved[:len(used)]
        return found

    def mode(self, near_Hz):
        """Eigenvalue and shape of small motions, by differences of the equations themselves."""
        n, step = len(self.used), 1e-7

        def rates(values):
            q, rate = self.rest.copy(), np.zeros(7)
            q[self.used] += values[:n]
            rate[self.used] = values[n:]
            return np.concatenate((rate[self.used], self.acceleration(q, rate)[self.used]))

        matrix = np.column_stack([(rates(step * e) - rates(-step * e)) / (2 * step) for e in np.eye(2 * n)])
        values, vectors = np.linalg.eig(matrix)
        # The rail's own directions are not held by the differences: motions that leave it are none.
        rail = self.jacobian(self.rest, self.tool)[1, self.used]
        fits = (values.imag > 0) & ((np.abs(rail @ vectors[:n]) < 1e-6 * np.abs(vectors[:n]).max(axis=0))
                                    if self.is_guided else True)
        at = np.flatnonzero(fits)[np.argmin(np.abs(np.log(values[fits].imag / (2 * np.pi * near_Hz))))]
        shape = np.zeros(7, complex)
        shape[self.used] = vectors[:n, at]
        return values[at], shape / (self.jacobian(self.rest, self.tool)[0] @ shape)

    def least_change(self, q, jacobian, wanted):
        """In the measure of the inertia's diagonal in berth's coordinates: satellite, joints, motors."""
        to_joints = np.eye(7)
        to_joints[3, 2] = to_joints[4, 2] = to_joints[4, 3] = 1.0  # world angles by the satellite's and the joints'
        used = self.used
        measure = np.diag(to_joints.T @ self.inertia(self.rest) @ to_joints)[used]
        by = (jacobian @ to_joints)[:, used]
        change = np.zeros(7)
        change[used] = by.T / measure[:, None] @ np.linalg.solve(by / measure @ by.T, wanted)
        return to_joints @ change

    def start(self, s, shape, amplitude_m):
        c = amplitude_m * (1 + 1j * s.real / s.imag)
        q, rate = self.rest + (c * shape).real, (c * s * shape).real
        rows = slice(0, 2 if self.is_guided else 1)
        for _ in range(30):
            miss = (self.place(q, self.tool) - self.home - [amplitude_m, 0])[rows]
            q = q - self.least_change(q, self.jacobian(q, self.tool)[rows], miss)
        jacobian = self.jacobian(q, self.tool)[rows]
        return q, rate - self.least_change(q, jacobian, jacobian @ rate)

    def swing(self, s, shape, amplitude_m):
        found, is_even = [], True
        for side_m in (amplitude_m, -amplitude_m):
            q, rate = self.start(s, shape, side_m)

            def turning(_, values):
                return (self.jacobian(values[:7], self.tool) @ values[7:])[0]

            turning.terminal = 6  # the start may count
            done = solve_ivp(lambda _, v: np.concatenate((v[7:], self.acceleration(v[:7], v[7:]))),
                             (0, 20 / (s.imag / (2 * np.pi))), np.concatenate((q, rate)), events=turning, rtol=1e-9,
                             atol=1e-9 * amplitude_m, max_step=0.02, first_step=1e-4)
            times = done.t_events[0]
            late = times > 1e-3
            times = np.concatenate(([0.0], times[late][:4]))
            ways = [self.place(at[:7], self.tool)[0] for at in
                    np.vstack(([np.concatenate((q, rate))], done.y_events[0][late][:4]))]
            heights = np.abs(np.diff(ways))
            decrement = np.log(heights[0] / heights[3]) / 1.5
            found.append((2 / times[4], decrement / np.hypot(decrement, 2 * np.pi)))
            steps = np.log(heights[:-1] / heights[1:])
            is_even = is_even and np.abs(steps - steps.mean()).max() < 0.5 * steps.mean()
        return *np.mean(found, axis=0), is_even


def reduce(*options):
    done = command("reduce", "ess", "--json", "--direction", "1,0", *options)
    assert done.returncode == 0, done.stderr.decode()
    return one_json_object(done.stdout)


@pytest.mark.long
@pytest.mark.parametrize("options,amplitude_m,limited", [
    (("--held", "--guided"), 0.1, []),
    (("--held", "--guided"), 0.25, ["joint 1", "joint 2"]),
    (("--held",), 0.05, []),
    (("--guided",), 0.03, None),
    (("--guided",), 0.1, ["joint 1", "joint 2", "wheel"]),
    ((), 0.02, None),
])
@pytest.mark.first(3)
def test_the_swing_is_that_of_an_arm_of_our_own(options, amplitude_m, limited):
    found = reduce(*options, "--amplitude", f"{amplitude_m / 2!r}:{amplitude_m!r}:2")["amplitudes"]
    arm = Arm("--held" in options, "--guided" in options)
    s, shape = arm.mode(found["small"]["frequency_Hz"])
    assert s.imag / (2 * np.pi) == pytest.approx(found["small"]["frequency_Hz"], rel=1e-6)
    assert -s.real / abs(s) == pytest.approx(found["small"]["damping_ratio"], rel=1e-5)
    frequency_Hz, damping_ratio, is_even = arm.swing(s, shape, amplitude_m)
    row = found["rows"][-1]
    assert row["amplitude_m"] == pytest.approx(amplitude_m, rel=1e-12)
    assert row["full"]["frequency_Hz"] == pytest.approx(frequency_Hz, rel=1e-5)
    assert row["full"]["damping_ratio"] == (pytest.approx(damping_ratio, rel=1e-4) if is_even else None)
    if limited is not None:
        assert row["at_limit"] == limited


@pytest.mark.parametrize("options", [(), ("--held", "--guided"), ("--guided",), ("--pose", "0.4,-0.9", "--guided"),
                                     ("--held", "--guided", "--set", "object.stiffness_N_per_m=20000")])
def test_small_swings_are_those_of_the_linear_arm(options):
    found = reduce(*options, "--amplitude", "1e-6:1e-4:2")
    small = found["amplitudes"]["small"]
    assert small == found["poses"][0]["coupled"]["full"]
    for row in found["amplitudes"]["rows"]:
        assert row["full"]["frequency_Hz"] == pytest.approx(small["frequency_Hz"], rel=1e-5)
        assert row["full"]["damping_ratio"] == pytest.approx(small["damping_ratio"], rel=1e-4)
        assert row["at_limit"] == []


def test_it_departs_with_the_square_of_the_amplitude():
    """Joints and springs are linear: what geometry does is even in the deflection."""
    found = reduce("--held", "--guided", "--amplitude", "0.025:0.1:3")["amplitudes"]
    off = [row["full"]["frequency_Hz"] / found["small"]["frequency_Hz"] - 1 for row in found["rows"]]
    assert off[1] / off[0] == pytest.approx(4.0, rel=0.1)
    assert off[2] / off[1] == pytest.approx(4.0, rel=0.1)


@pytest.mark.long
def test_one_percent_is_where_it_says():
    found = reduce("--held", "--amplitude", "0.05:0.3:4")["amplitudes"]
    for key, name, known in (("frequency_m", "frequency_Hz", "reduced"), ("damping_m", "damping_ratio", "reduced"),
                             ("frequency_m", "frequency_Hz", "small"), ("damping_m", "damping_ratio", "small")):
        at_m = found["reduced_off_1_percent" if known == "reduced" else "size_alone_1_percent"][key]
        rows = reduce("--held", "--amplitude", f"{0.998 * at_m!r}:{at_m!r}:2")["amplitudes"]["rows"]
        off = [abs(found[known][name] / row["full"][name] - 1) for row in rows]
        assert off[0] < 0.01 < off[1] < 0.011


def test_a_beam_of_several_modes_swings_too():
    done = command("reduce", "ess-beam", "--json", "--direction", "1,0", "--held", "--amplitude", "1e-5:1e-4:2",
                   "--set", "object.modes=3")
    amplitudes = one_json_object(done.stdout)["amplitudes"]
    assert amplitudes["rows"][0]["full"]["frequency_Hz"] == pytest.approx(amplitudes["small"]["frequency_Hz"], rel=1e-5)
    assert amplitudes["rows"][0]["full"]["damping_ratio"] == pytest.approx(amplitudes["small"]["damping_ratio"], rel=1e-3)


def test_an_arm_in_space_swings_too(tmp_path):
    arm = tmp_path / "seven.toml"
    arm.write_bytes(command("arm", RIG_FOLDER.parents[1] / "tests" / "arms" / "seven.urdf", "--tool", "gripper").stdout)
    done = command("reduce", "ess", "--json", "--arm", arm, "--direction", "1,0,0.5", "--guided", "--amplitude", "1e-6:1e-5:2")
    assert done.returncode == 0, done.stderr.decode()
    amplitudes = one_json_object(done.stdout)["amplitudes"]
    for row in amplitudes["rows"]:
        assert row["full"]["frequency_Hz"] == pytest.approx(amplitudes["small"]["frequency_Hz"], rel=1e-4)
        assert row["full"]["damping_ratio"] == pytest.approx(amplitudes["small"]["damping_ratio"], rel=1e-3)


def test_beyond_the_arm_s_reach_there_is_no_swing():
    rows = reduce("--held", "--amplitude", "0.01:20:2")["amplitudes"]["rows"]
    assert rows[0]["full"] is not None and rows[1]["full"] is None
    assert b"does not swing so far" in command("reduce", "ess", "--held", "--amplitude", "0.01:20:2").stdout


def seven_of(folder):
    arm = folder / "seven.toml"
    arm.write_bytes(command("arm", RIG_FOLDER.parents[1] / "tests" / "arms" / "seven.urdf", "--tool", "gripper").stdout)
    return arm


def test_a_mode_that_the_tool_does_not_show_is_no_swing(tmp_path):
    """Of the seven joints a mode at 7.14 Hz is the nearest to the reduction's 10.27 Hz, and does not move the tool."""
    words = ("reduce", "ess", "--arm", seven_of(tmp_path), "--direction", "1,0,0.5")
    coupled = one_json_object(command(*words, "--json").stdout)["poses"][0]["coupled"]
    assert coupled["reduced"]["frequency_Hz"] == pytest.approx(10.27, rel=1e-3) and coupled["full"] is None
    shown = command(*words).stdout.decode()
    assert "none near" in shown and "it shows 0.3278, 1.183, 1.891, 3.172 Hz" in shown
    refused = command(*words, "--amplitude", "1e-4:0.1:4")
    assert refused.returncode == EXIT_INPUT and "is within a factor of 2" in refused.stderr.decode()


def test_a_swing_that_takes_too_many_steps_is_given_up(tmp_path):
    """A shoulder so stiff and damped that it settles a million times faster than the tool swings."""
    arm = tmp_path / "stiff.toml"
    text = (RIG_FOLDER.parent / "arms" / "ess.toml").read_text()
    for own, key, stiff in (("68349.5994859", "stiffness_N_m_per_rad", "1e12"),
                            ("1064.763365217", "damping_N_m_s_per_rad", "1e9")):
        assert text.count(f"{key} = {own}") == 1
        text = text.replace(f"{key} = {own}", f"{key} = {stiff}")
    arm.write_text(text)
    done = command("reduce", "ess", "--json", "--arm", arm, "--direction", "1,0", "--held",
                   "--amplitude", "0.01:0.1:2")
    assert done.returncode == 0, done.stderr.decode()
    for row in one_json_object(done.stdout)["amplitudes"]["rows"]:
        assert row["full"] is None and row["not_measured"].startswith("not followed: CVODE: ")


def test_from_nothing_nothing_is_concluded():
    words = ("--held", "--guided", "--pose", "1.35,-0.01", "--amplitude", "0.001:0.3:4")
    found = reduce(*words)["amplitudes"]
    for row in found["rows"]:
        assert row["full"] is None and row["not_measured"] == "does not swing so far"
    for of in ("reduced_off_1_percent", "size_alone_1_percent"):
        assert found[of] == {"frequency_m": None, "frequency_determined": False, "damping_m": None,
                             "damping_determined": False}
    shown = command("reduce", "ess", "--direction", "1,0", *words).stdout.decode()
    assert shown.count("frequency not determined, damping ratio not determined") == 2 and "nowhere" not in shown
    # Looked at and found to be within is another thing.
    near = reduce("--held", "--guided", "--amplitude", "0.001:0.01:2")["amplitudes"]["reduced_off_1_percent"]
    assert near == {"frequency_m": None, "frequency_determined": True, "damping_m": None, "damping_determined": True}


def test_energy_that_goes_between_modes_is_no_damping():
    """At 0.6694 m the last half swings are larger than the first; nothing in the arm drives it."""
    found = reduce("--amplitude", "0.3:1:4")["amplitudes"]
    uneven = found["rows"][2]
    assert uneven["full"]["frequency_Hz"] > 0 and uneven["full"]["damping_ratio"] is None
    assert uneven["not_measured"] == "no measure: energy goes between modes"
    for row in found["rows"]:
        assert row["full"]["damping_ratio"] is None or row["full"]["damping_ratio"] > 0
    assert b"no measure: energy goes between modes" in command("reduce", "ess", "--direction", "1,0", "--amplitude",
                                                               "0.3:1:4").stdout
    # What one mode does is a measure, at a limit too.
    assert all(row["not_measured"] is None for row in reduce("--held", "--amplitude", "0.1:0.3:2")["amplitudes"]["rows"])


def test_the_wheel_s_momentum_is_a_limit_too(tmp_path):
    arm = tmp_path / "small-wheel.toml"
    text = (RIG_FOLDER.parent / "arms" / "ess.toml").read_text()
    assert text.count("momentum_limit_N_m_s = 500.0") == 1
    arm.write_text(text.replace("momentum_limit_N_m_s = 500.0", "momentum_limit_N_m_s = 0.01"))
    words = ("--amplitude", "0.001:0.002:2")
    assert reduce(*words, "--arm", arm)["amplitudes"]["rows"][-1]["at_limit"] == ["wheel's momentum"]
    assert reduce(*words)["amplitudes"]["rows"][-1]["at_limit"] == []


@pytest.mark.parametrize("effect,key", [("object.cubic_stiffness_N_per_m3=2e7", "object.cubic_stiffness_N_per_m3"),
                                        ("robot.backlash_m=0.001", "robot.backlash_m")])
def test_effects_that_are_not_linear_are_named(effect, key):
    refused = command("reduce", "ess", "--direction", "1,0", "--set", effect, "--amplitude", "0.01:0.1:2")
    assert refused.returncode == EXIT_INPUT and key in refused.stderr.decode() and not refused.stdout
    done = command("reduce", "ess", "--direction", "1,0", "--set", effect, "--json")
    assert [line.split(":")[0] for line in one_json_object(done.stdout)["left_out"]] == [key]
    assert f"{key}: a reduction is of small motions" in command("reduce", "ess", "--set", effect).stderr.decode()
    assert reduce("--held")["left_out"] == []
    of_an_arm = command("eigen", "ess", "--set", 'manipulator.arm="ess"', "--set", effect)
    assert of_an_arm.returncode == EXIT_INPUT and key in of_an_arm.stderr.decode()


def test_an_input_from_outside_is_no_effect_on_the_swing():
    done = reduce("--held", "--amplitude", "0.01:0.02:2", "--set", "sensor.spike_probability=0.001", "--set",
                  "sensor.spike_N=50")
    assert done["left_out"] == []


def test_where_the_guide_leaves_no_way_nothing_is_springy():
    """Stretched along the direction, an arm that a rail holds across cannot move."""
    poses = reduce("--held", "--guided", "--pose", "0,0", "--sweep", "2=-0.001:0.001:3")["poses"]
    assert [pose["reduced"] is None for pose in poses] == [False, True, False]
    poses = reduce("--held", "--guided", "--sweep", "2=-0.001:0.001:3")["poses"]
    assert [pose["reduced"] is None for pose in poses] == [False, True, False]
