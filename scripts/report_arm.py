"""The arm of a run as a moving picture seen from the side: where its bodies were, from the log's angles alone."""
import base64
import json

import numpy as np
import report_object

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


def view_of(is_planar, direction):
    """Coordinates that go to the right and up: those of a planar arm's plane; of one in space the vertical plane that shows
    more of the direction."""
    if is_planar:
        return [0, 1]
    return [0, 2] if abs(direction[0]) >= abs(direction[1]) else [1, 2]


def direction_of(manipulator):
    way = np.array([manipulator[f"direction_{part}"] for part in "xyz"], float)
    return way / np.linalg.norm(way)


def square_of(base_m, axes, view):
    """Corners of the square that stands for the satellite, (n, 4, 2)."""
    corners = np.zeros((4, 3))
    corners[:, view] = BASE_HALF_m * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    return (base_m[:, None] + np.einsum("nij,kj->nki", axes, corners))[..., view]


def box(points, margin_m):
    """Lowest and highest corner round (n, points, 2)."""
    return {"low": (points.min(axis=(0, 1)) - margin_m).tolist(), "high": (points.max(axis=(0, 1)) + margin_m).tolist()}


def parts_of(log):
    """What is drawn, in the plane of the picture, each (n, points, 2), and the direction there."""
    config = log.config["manipulator"]["arm"]
    is_planar = config["kind"] == "planar"
    direction = direction_of(log.config["manipulator"])
    view = view_of(is_planar, direction)
    points, axes = places(config, log.arm)
    arm = points[..., view]
    parts = {"base": square_of(points[:, 0], axes, view), "mount": arm[:, :2], "links": arm[:, 1:]}
    target = report_object.in_picture(log, arm[:, -1], direction[view])
    if target is not None:
        parts["object"] = target
    whole = min(map(len, parts.values()))  # of a log that was cut between two of its records
    return {name: part[:whole] for name, part in parts.items()}, direction[view], view


def encoded(values):
    return base64.b64encode(np.ascontiguousarray(values, dtype="<f4").tobytes()).decode()


def scene(log):
    """What the page's script draws, as JSON; "null" for a run without an arm."""
    config = log.config["manipulator"].get("arm")
    if not isinstance(config, dict) or not log.arm or len(log.tick_s) == 0:
        return "null"
    step = max(1, round(1.0 / (FRAMES_PER_s * log.period_s)), -(-len(log.tick_s) // FRAMES_MAX))
    parts, direction, view = parts_of(log)
    tool = parts["links"][:, -1:]
    drawn = np.concatenate(list(parts.values()), axis=1)[::step]
    ends = np.cumsum([part.shape[1] for part in parts.values()]).tolist()
    return json.dumps({
        "step_s": step * log.period_s, "start_s": float(log.tick_s[0]), "frames": len(drawn), "points": encoded(drawn),
        "count": drawn.shape[1], "parts": dict(zip(parts, zip([0, *ends], ends))), "is_block": log.is_contact,
        "boxes": {"whole": box(drawn, 0.3), "tool": box(tool, 0.5 * max(1e-3, np.ptp(tool, axis=(0, 1)).max()))},
        "force": encoded(log.tick["used_force_N"][::step]), "direction": direction.tolist(),
        "plane": "{} to the right, {} up".format(*("xyz"[axis] for axis in view)),
    }, separators=(",", ":"), allow_nan=False)
