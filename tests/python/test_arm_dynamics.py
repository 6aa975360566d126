"""The arm's equations of motion against Pinocchio and MuJoCo, which read the same URDF file."""

import json
import os

import mujoco
import numpy as np
import pinocchio
import pytest
from conftest import ROOT, command

ARMS = ROOT / "tests" / "arms"
SEED = int(os.environ.get("BERTH_SEED", "20260617"))
STATES = 200
AGREE = 1e-9  # relative to the largest entry


class Spatial:
    """Pinocchio's free flyer, linear velocity before angular; ours is the other way round."""

    urdf, options, dimension, turns, joints = ARMS / "seven.urdf", ("--tool", "gripper"), 3, 3, 7
    root = pinocchio.JointModelFreeFlyer

    @staticmethod
    def attitude(random):
        quaternion = random.normal(size=4)
        return quaternion / np.linalg.norm(quaternion)

    @staticmethod
    def placed(position, attitude):
        return np.concatenate([position, attitude[[1, 2, 3, 0]]])

    @staticmethod
    def axes(attitude):
        return pinocchio.Quaternion(attitude[[1, 2, 3, 0]]).matrix()


class Planar:
    urdf, options, dimension, turns, joints = ARMS / "two_link.urdf", ("--planar",), 2, 1, 2
    root = pinocchio.JointModelPlanar

    @staticmethod
    def attitude(random):
        return random.uniform(-3, 3, size=1)

    @staticmethod
    def placed(position, attitude):
        return np.concatenate([position, [np.cos(attitude[0]), np.sin(attitude[0])]])

    @staticmethod
    def axes(attitude):
        c, s = np.cos(attitude[0]), np.sin(attitude[0])
        return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def in_space(kind, linear, angular):
    """Linear and angular vectors of any kind as two of three."""
    if kind is Spatial:
        return np.asarray(linear), np.asarray(angular)
    return np.array([*linear, 0.0]), np.array([0.0, 0.0, *angular])


def random_states(kind, random):
    return [{
        "position_m": random.normal(size=kind.dimension),
        "attitude": kind.attitude(random),
        "turn_rate_rad_per_s": random.normal(size=kind.turns),
        "velocity_m_per_s": random.normal(size=kind.dimension),
        "link_rad": random.uniform(-3, 3, size=kind.joints),
        "link_rad_per_s": random.normal(size=kind.joints),
        "torque_N_m": 50 * random.normal(size=kind.joints),
        "tool_torque_N_m": 20 * random.normal(size=kind.turns),
        "tool_force_N": 100 * random.normal(size=kind.dimension),
    } for _ in range(STATES)]


def berth_at(kind, states, folder):
    file = folder / "states.json"
    file.write_text(json.dumps([{key: value.tolist() for key, value in state.items()} for state in states]))
    done = command("arm", kind.urdf, *kind.options, "--states", file)
    assert done.returncode == 0, done.stderr.decode()
    return json.loads(done.stdout)


@pytest.fixture(scope="module", params=[Spatial, Planar], ids=["spatial", "planar"])
def compared(request, tmp_path_factory):
    """Random states and what we make of them."""
    kind = request.param
    print(f"seed {SEED}; again: BERTH_SEED={SEED} pytest tests/python/test_arm_dynamics.py")
    states = random_states(kind, np.random.default_rng(SEED))
    return kind, states, berth_at(kind, states, tmp_path_factory.mktemp("arm"))


def pinocchio_order(kind):
    """Places of Pinocchio's velocities in ours: angular first here, linear first there."""
    base = [*range(kind.turns, kind.turns + kind.dimension), *range(kind.turns)]
    return [*base, *range(len(base), len(base) + kind.joints)]


def pinocchio_model(kind):
    model = pinocchio.buildModelFromUrdf(str(kind.urdf), kind.root())
    model.gravity.linear[:] = 0
    return model


def pinocchio_q(kind, model, state):
    """Continuous joints are unit circles there."""
    q = pinocchio.neutral(model)
    q[:kind.dimension + (4 if kind is Spatial else 2)] = kind.placed(state["position_m"], state["attitude"])
    for joint, angle in zip(list(model.joints)[2:], state["link_rad"]):
        q[joint.idx_q:joint.idx_q + joint.nq] = angle if joint.nq == 1 else (np.cos(angle), np.sin(angle))
    return q


def assert_close(ours, other):
    ours, other = np.asarray(ours), np.asarray(other)
    assert ours.shape == other.shape
    assert np.abs(ours - other).max() <= AGREE * np.abs(other).max()


def test_pinocchio(compared):
    kind, states, results = compared
    model = pinocchio_model(kind)
    data = model.createData()
    order = pinocchio_order(kind)
    tool = model.getFrameId("gripper" if kind is Spatial else "hand")
    for state, ours in zip(states, results):
        q = pinocchio_q(kind, model, state)
        v = np.concatenate([state["velocity_m_per_s"], state["turn_rate_rad_per_s"], state["link_rad_per_s"]])
        upper = np.triu(pinocchio.crba(model, data, q))
        inertia = upper + np.triu(upper, 1).T
        assert_close(np.asarray(ours["inertia"])[np.ix_(order, order)], inertia)
        assert_close(np.asarray(ours["bias"])[order], pinocchio.nonLinearEffects(model, data, q, v))

        pinocchio.computeJointJacobians(model, data, q)
        pinocchio.updateFramePlacements(model, data)
        jacobian = pinocchio.getFrameJacobian(model, data, tool, pinocchio.LOCAL_WORLD_ALIGNED)
        force, torque = in_space(kind, state["tool_force_N"], state["tool_torque_N_m"])
        torques = np.concatenate([np.zeros(kind.dimension + kind.turns), state["torque_N_m"]])
        driven = torques + jacobian.T @ np.concatenate([force, torque])
        assert_close(np.asarray(ours["acceleration"])[order], pinocchio.aba(model, data, q, v, driven))

        pinocchio.forwardKinematics(model, data, q, v)
        pinocchio.updateFramePlacements(model, data)
        assert_close(ours["tool_m"], data.oMf[tool].translation[:kind.dimension])
        momentum = pinocchio.computeCentroidalMomentum(model, data, q, v)
        about_origin = momentum.angular + np.cross(data.com[0], momentum.linear)
        linear, angular = in_space(kind, ours["momentum"]["linear"], ours["momentum"]["angular"])
        assert_close(linear, momentum.linear)
        assert_close(angular, about_origin)
        assert ours["kinetic_J"] == pytest.approx(pinocchio.computeKineticEnergy(model, data, q, v), rel=AGREE)

        axes = kind.axes(state["attitude"])
        twist = np.asarray(ours["jacobian"])[:, order] @ v
        linear, angular = in_space(kind, twist[kind.turns:], twist[:kind.turns])
        assert_close(np.concatenate([axes @ linear, axes @ angular]), jacobian @ v)


@pytest.mark.parametrize("is_free", [True, False], ids=["free", "held"])
@pytest.mark.parametrize("kind", [Spatial, Planar], ids=["spatial", "planar"])
def test_gravity(kind, is_free, tmp_path):
    """On a satellite that floats and on one that is held, pulled askew: accelerations against Pinocchio's."""
    print(f"seed {SEED}; again: BERTH_SEED={SEED} pytest tests/python/test_arm_dynamics.py -k gravity")
    gravity = [1.3, -9.1, 3.7 if kind is Spatial else 0.0]
    text = command("arm", kind.urdf, *kind.options).stdout.decode()
    assert "is_free = true" in text and "gravity_m_per_s2 = [0, 0, 0]" in text
    arm = tmp_path / "arm.toml"
    arm.write_text(text.replace("is_free = true", f"is_free = {str(is_free).lower()}")
                   .replace("gravity_m_per_s2 = [0, 0, 0]", f"gravity_m_per_s2 = {gravity}"))
    states = random_states(kind, np.random.default_rng(SEED))[:50]
    if not is_free:
        still = {"position_m": np.zeros(kind.dimension), "turn_rate_rad_per_s": np.zeros(kind.turns),
                 "velocity_m_per_s": np.zeros(kind.dimension),
                 "attitude": np.eye(4)[0] if kind is Spatial else np.zeros(1)}
        states = [{**state, **still} for state in states]
    file = tmp_path / "states.json"
    file.write_text(json.dumps([{key: value.tolist() for key, value in state.items()} for state in states]))
    done = command("arm", arm, "--states", file)
    assert done.returncode == 0, done.stderr.decode()

    model = pinocchio.buildModelFromUrdf(str(kind.urdf), kind.root())
    model.gravity.linear[:] = gravity
    data = model.createData()
    order, base = pinocchio_order(kind), kind.dimension + kind.turns
    tool = model.getFrameId("gripper" if kind is Spatial else "hand")
    for state, ours in zip(states, json.loads(done.stdout)):
        q = pinocchio_q(kind, model, state)
        v = np.concatenate([state["velocity_m_per_s"], state["turn_rate_rad_per_s"], state["link_rad_per_s"]])
        pinocchio.computeJointJacobians(model, data, q)
        pinocchio.updateFramePlacements(model, data)
        jacobian = pinocchio.getFrameJacobian(model, data, tool, pinocchio.LOCAL_WORLD_ALIGNED)
        pushed = jacobian.T @ np.concatenate(in_space(kind, state["tool_force_N"], state["tool_torque_N_m"]))
        driven = pushed + np.concatenate([np.zeros(base), state["torque_N_m"]])
        if is_free:
            assert_close(np.asarray(ours["acceleration"])[order], pinocchio.aba(model, data, q, v, driven))
        else:
            upper = np.triu(pinocchio.crba(model, data, q))
            inertia = upper + np.triu(upper, 1).T
            bias = pinocchio.nonLinearEffects(model, data, q, v)
            held = np.linalg.solve(inertia[base:, base:], (driven - bias)[base:])
            assert_close(np.asarray(ours["acceleration"])[-kind.joints:], held)


def mujoco_model(kind):
    """The same file with a free joint at its root. MuJoCo would fuse what is fixed and round what is small."""
    specification = mujoco.MjSpec.from_string(kind.urdf.read_text())
    specification.compiler.fusestatic = False
    specification.option.gravity = [0, 0, 0]
    root = specification.worldbody.first_body()
    root.add_freejoint()
    for joint in specification.joints:
        joint.limited = mujoco.mjtLimited.mjLIMITED_FALSE
    return specification.compile()


def test_mujoco(compared):
    """Velocities of MuJoCo's free joint: linear in the world's axes, angular in the body's."""
    kind, states, results = compared
    model = mujoco_model(kind)
    data = mujoco.MjData(model)
    assert model.nv == 6 + kind.joints
    tool = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, "gripper" if kind is Spatial else "hand")
    for state, ours in zip(states, results):
        axes = kind.axes(state["attitude"])
        position, _ = in_space(kind, state["position_m"], np.zeros(kind.turns))
        linear, angular = in_space(kind, state["velocity_m_per_s"], state["turn_rate_rad_per_s"])
        half = 0.5 * state["attitude"][0]
        quaternion = state["attitude"] if kind is Spatial else [np.cos(half), 0, 0, np.sin(half)]
        data.qpos[:] = np.concatenate([position, quaternion, state["link_rad"]])
        data.qvel[:] = np.concatenate([axes @ linear, angular, state["link_rad_per_s"]])
        data.qfrc_applied[6:] = state["torque_N_m"]
        force, torque = in_space(kind, state["tool_force_N"], state["tool_torque_N_m"])
        mujoco.mj_forward(model, data)
        applied = np.zeros(model.nv)
        mujoco.mj_applyFT(model, data, force, torque, data.xpos[tool].copy(), tool, applied)
        data.qfrc_applied[:] = applied
        data.qfrc_applied[6:] += state["torque_N_m"]
        mujoco.mj_forward(model, data)

        into = np.zeros((model.nv, len(ours["bias"])))  # of our velocities MuJoCo's
        for column, unit in enumerate(np.eye(kind.turns + kind.dimension)):
            base_linear, base_angular = in_space(kind, unit[kind.turns:], unit[:kind.turns])
            into[:6, column] = np.concatenate([axes @ base_linear, base_angular])
        into[6:, kind.turns + kind.dimension:] = np.eye(kind.joints)
        inertia = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, inertia)
        turning = np.concatenate([axes @ np.cross(angular, linear), np.zeros(3 + kind.joints)])
        assert_close(ours["inertia"], into.T @ inertia @ into)
        assert_close(ours["bias"], into.T @ (data.qfrc_bias + inertia @ turning))
        mujoco.mj_subtreeVel(model, data)
        momentum = model.body_subtreemass[0] * data.subtree_linvel[0]
        about_origin = data.subtree_angmom[0] + np.cross(data.subtree_com[0], momentum)
        our_linear, our_angular = in_space(kind, ours["momentum"]["linear"], ours["momentum"]["angular"])
        assert_close(our_linear, momentum)
        assert_close(our_angular, about_origin)

        ours_base = np.asarray(ours["acceleration"])[:kind.turns + kind.dimension]
        ours_linear, ours_angular = in_space(kind, ours_base[kind.turns:], ours_base[:kind.turns])
        # d/dt (R v) = R (v' + w x v)
        in_world = axes @ (ours_linear + np.cross(angular, linear))
        all_ours = np.concatenate([in_world, ours_angular, np.asarray(ours["acceleration"])[-kind.joints:]])
        assert_close(all_ours, data.qacc)
