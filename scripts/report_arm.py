"""The arm of a run as a moving picture seen from the side: where its bodies were, from the log's angles alone."""
import base64
import json

import numpy as np

# Pictures a second that a page keeps: what moves is slow.
FRAMES_PER_s = 20.0
FRAMES_MAX = 6000
JOINTS_MAX = 7
BASE_HALF_m = 0.8  # of the square that stands for the satellite


def turned_about(axis, angle_rad):
    """Rotations about one axis, an angle each (Rodrigues): (n, 3, 3)."""
    x, y, z = axis
    hat = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    sine, cosine = np.sin(angle_rad)[:, None, None], np.cos(angle_rad)[:, None, None]
    return np.eye(3) + sine * hat + (1 - cosine) * (hat @ hat)


def base_axes(arm, is_planar):
    """Axes of the base in the world, (n, 3, 3)."""
    if is_planar:
        return turned_about((0, 0, 1), arm["base_turn_rad"])
    w, x, y, z = (arm[f"base_quaternion_{part}"] for part in "wxyz")
    rows = [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def frame_of(table):
    return np.array(table.get("origin_m", [0, 0, 0]), float), np.reshape(
        np.array(table.get("axes", [1, 0, 0, 0, 1, 0, 0, 0, 1]), float), (3, 3))


def places(config, arm):
    """Origins of base, joints and tool in the world, m: (n, joints + 2, 3), and the base's axes."""
    axes = base = base_axes(arm, config["kind"] == "planar")
    origin = np.stack([arm[f"base_{part}_m"] for part in "xyz"], axis=-1)
    found = [origin]
    for number, joint in enumerate(config["joint"]):
        offset, turn = frame_of(joint)
        origin = origin + axes @ offset
        axes = axes @ turn @ turned_about(joint["axis"], arm[f"joint_{number}_rad"])
        found.append(origin)
    found.append(origin + axes @ frame_of(config["tool"])[0])
    return np.stack(found, axis=1), base


def side_view(points, is_planar):
    """x and y of a planar arm, x and z of one in space."""
    return points[..., [0, 1]] if is_planar else points[..., [0, 2]]


def direction_of(manipulator):
    way = np.array([manipulator[f"direction_{part}"] for part in "xyz"], float)
    return way / np.linalg.norm(way)


def scene(log):
    """What the page's script draws, as JSON; "null" for a run without an arm."""
    config = log.config["manipulator"].get("arm")
    if not isinstance(config, dict) or not log.arm or len(log.tick_s) == 0:
        return "null"
    step = max(1, round(1.0 / (FRAMES_PER_s * log.period_s)), -(-len(log.tick_s) // FRAMES_MAX))
    arm = {name: values[::step] for name, values in log.arm.items()}
    is_planar = config["kind"] == "planar"
    points, base = places(config, arm)
    corners = BASE_HALF_m * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], float)
    if not is_planar:
        corners = corners[:, [0, 2, 1]]
    square = points[:, :1] + np.einsum("nij,kj->nki", base, corners)
    drawn = side_view(np.concatenate((square, points[:, 1:]), axis=1), is_planar)
    low, high = drawn.min(axis=(0, 1)) - 0.5, drawn.max(axis=(0, 1)) + 0.5
    way = direction_of(log.config["manipulator"])
    return json.dumps({
        "step_s": step * log.period_s, "start_s": float(log.tick_s[0]), "frames": len(drawn),
        "points": base64.b64encode(np.ascontiguousarray(drawn, dtype="<f4").tobytes()).decode(),
        "count": drawn.shape[1], "low": low.tolist(), "high": high.tolist(),
        "force": base64.b64encode(np.ascontiguousarray(log.tick["used_force_N"][::step], dtype="<f4").tobytes()).decode(),
        "direction": side_view(way, is_planar).tolist(),
        "plane": "x to the right, y up" if is_planar else "x to the right, z up",
    }, separators=(",", ":"), allow_nan=False)
