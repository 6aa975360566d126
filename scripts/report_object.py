"""What the tool of an arm meets, for the moving picture: a gripped panel or a block of material. The log has where it is
along the robot's direction alone; its length and depth are the picture's."""
import numpy as np

OVERHANG_m = 0.8  # of a block, beyond how far the tool moves across the direction
PANEL_m = 2.0
DEPTH_m = 0.4  # of a block
PANEL_POINTS = 13


def grip_offsets(log):
    """By how much (m) robot and gripped object lie apart where neither pulls the other, at each record: told from the
    sensor's spring, before a grip that of the next one; None if it never gripped."""
    rig = log.rig
    held = np.flatnonzero(rig["spring_force_N"])
    if len(held) == 0:
        return None
    stretch_m = rig["spring_force_N"] / log.config["sensor"]["stiffness_N_per_m"]
    apart_m = (rig["robot_position_m"] - rig["object_position_m"] - stretch_m)[held]
    following = np.minimum(np.searchsorted(held, np.arange(len(stretch_m))), len(held) - 1)
    return apart_m[following]


def bent_panel(tip_m, rest_m, low_m, high_m):
    """A cantilever bent by a force at its end, which is at `low_m` across; its root stays where the end is at rest. Heights
    along the direction and places across it, (n, PANEL_POINTS, 2)."""
    share = np.linspace(0.0, 1.0, PANEL_POINTS)
    along = rest_m[:, None] + (tip_m - rest_m)[:, None] * (3 * share**2 - share**3) / 2
    return np.stack((along, np.broadcast_to(high_m + (low_m - high_m) * share, along.shape)), axis=-1)


def pressed_block(face_m, low_m, high_m):
    """A block whose face is at `face_m`, from `low_m` to `high_m` across: its corners, (n, 4, 2)."""
    back_m = np.full_like(face_m, face_m.min() + DEPTH_m)
    corners = ((face_m, low_m), (face_m, high_m), (back_m, high_m), (back_m, low_m))
    return np.stack([np.stack((along, np.full_like(along, across)), axis=-1) for along, across in corners], axis=1)


def outline(log, across_m):
    """Heights and places across of the object at each record, where the tool is at `across_m`; None where the log does not
    tell where it is."""
    if not log.rig:
        return None
    position_m = log.rig["object_position_m"]
    if log.is_contact:
        face_m = np.maximum(log.config["object"]["surface_position_m"], position_m)
        return pressed_block(face_m, across_m.min() - OVERHANG_m, across_m.max() + OVERHANG_m)
    offset_m = grip_offsets(log)
    if offset_m is None:
        return None
    return bent_panel(offset_m + position_m, offset_m, across_m.min(), across_m.max() + PANEL_m)


def in_picture(log, tool, way):
    """The outline in the picture's plane, (n, points, 2), from the tool's places there, (n, 2), and the robot's direction as
    the plane shows it; None where there is none to draw, or the plane shows nothing of the direction."""
    shown = np.linalg.norm(way)
    if shown < 0.5:
        return None
    along = way / shown
    sideways = np.array([-along[1], along[0]])
    found = outline(log, tool @ sideways)
    if found is None:
        return None
    start = tool[0] @ along - shown * log.tick["manipulator_position_m"][0]
    return (start + shown * found[..., :1]) * along + found[..., 1:] * sideways
