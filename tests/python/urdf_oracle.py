"""What Pinocchio makes of a URDF file whose other joints are locked, against what berth makes of it.

Of the file this module reads for itself which joints there are and where they are held: nothing is taken from berth but
the names of the joints that move and of the base.
"""

import json
import tomllib
import xml.etree.ElementTree as ElementTree

import numpy as np
import pinocchio
from conftest import EXIT_INPUT, command


def ranges_of(robot):
    """Joint name -> where it is held as long as nobody says where, by the rules of the guide, mimic left out."""
    values = {}
    for joint in robot.findall("joint"):
        limit = joint.find("limit")
        value = 0.0
        if joint.get("type") in ("revolute", "prismatic") and limit is not None:
            lower, upper = float(limit.get("lower", 0)), float(limit.get("upper", 0))
            if lower < upper and not lower <= 0 <= upper:
                value = (lower + upper) / 2
        values[joint.get("name")] = value
    return values


def held_values(robot, moving, holds):
    """The same with what is asked for, what moves (which starts where its range is nearest to 0), and mimic."""
    values = {**ranges_of(robot), **holds}
    joints = {joint.get("name"): joint for joint in robot.findall("joint")}
    for name in moving:
        limit = joints[name].find("limit")
        if joints[name].get("type") == "revolute":
            values[name] = float(np.clip(0.0, float(limit.get("lower", 0)), float(limit.get("upper", 0))))

    def value_of(name):
        mimic = joints[name].find("mimic") if joints[name].get("type") not in ("fixed", "floating") else None
        if mimic is None or mimic.get("joint") not in joints:
            return values[name]
        return float(mimic.get("multiplier", 1)) * value_of(mimic.get("joint")) + float(mimic.get("offset", 0))

    return {name: value_of(name) for name in joints}


def set_value(model, q, name, value):
    joint = model.joints[model.getJointId(name)]
    if joint.nq == 1:
        q[joint.idx_q] = value
    elif joint.nv == 1:
        q[joint.idx_q:joint.idx_q + 2] = np.cos(value), np.sin(value)


def with_other_link_names(text):
    """Pinocchio cannot lock the joints of a file in which a link has a joint's name."""
    robot = ElementTree.fromstring(text)
    for link in robot.findall("link"):
        link.set("name", "link " + link.get("name"))
    for end in [*robot.findall("joint/parent"), *robot.findall("joint/child")]:
        end.set("link", "link " + end.get("link"))
    return ElementTree.tostring(robot, encoding="unicode")


def locked_model(text, moving, holds, has_root=True):
    """Free in space, all but `moving` locked. `has_root`: the root floats by itself, else by a joint of the file."""
    root = [pinocchio.JointModelFreeFlyer()] if has_root else []
    model = pinocchio.buildModelFromXML(with_other_link_names(text), *root)
    q = pinocchio.neutral(model)
    for name, value in held_values(ElementTree.fromstring(text), moving, holds).items():
        if model.existJointName(name):
            set_value(model, q, name, value)
    free = [model.names[1], *moving]
    locked = [model.getJointId(name) for name in list(model.names)[1:] if name not in free]
    reduced = pinocchio.buildReducedModel(model, locked, q)
    assert list(reduced.names)[1:] == free
    return reduced


def disagreement(file, options, text, random, states, holds=None, has_root=True):
    """Largest difference of inertia matrix and bias forces at random states, each relative to its largest entry, and
    the arm file's content. None and the message where berth refuses."""
    done = command("arm", file, *options)
    if done.returncode == EXIT_INPUT:
        return None, done.stderr.decode().strip()
    assert done.returncode == 0, done.stderr.decode()
    arm = tomllib.loads(done.stdout.decode())
    moving = [joint["name"] for joint in arm["joint"]]
    model = locked_model(text, moving, holds or {}, has_root)
    data = model.createData()
    made = []
    for _ in range(states):
        quaternion = random.normal(size=4)
        made.append({"position_m": random.normal(size=3), "attitude": quaternion / np.linalg.norm(quaternion),
                     "turn_rate_rad_per_s": random.normal(size=3), "velocity_m_per_s": random.normal(size=3),
                     "link_rad": random.uniform(-3, 3, size=len(moving)),
                     "link_rad_per_s": random.normal(size=len(moving))})
    asked = json.dumps([{key: value.tolist() for key, value in state.items()} for state in made])
    answered = command("arm", file, *options, "--states", "/dev/stdin", input=asked.encode())
    assert answered.returncode == 0, answered.stderr.decode()
    order = [3, 4, 5, 0, 1, 2, *range(6, 6 + len(moving))]  # Pinocchio has linear velocities first
    first = 0 if arm["base"]["is_free"] else 6  # a base that is held may have any inertia
    worst = np.zeros(2)
    for state, ours in zip(made, json.loads(answered.stdout)):
        q = pinocchio.neutral(model)
        q[:7] = np.concatenate([state["position_m"], state["attitude"][[1, 2, 3, 0]]])
        for name, angle in zip(moving, state["link_rad"]):
            set_value(model, q, name, angle)
        v = np.concatenate([state["velocity_m_per_s"], state["turn_rate_rad_per_s"], state["link_rad_per_s"]])
        model.gravity.linear[:] = 0
        upper = np.triu(pinocchio.crba(model, data, q))
        inertia = upper + np.triu(upper, 1).T
        bias = pinocchio.nonLinearEffects(model, data, q, v)
        for i, (key, other) in enumerate((("inertia", inertia), ("bias", bias))):
            mine = np.asarray(ours[key])
            mine = mine[np.ix_(order, order)] if key == "inertia" else mine[order]
            mine, other = (part[first:, first:] if key == "inertia" else part[first:] for part in (mine, other))
            worst[i] = max(worst[i], np.abs(mine - other).max() / np.abs(other).max())
    return worst, arm
