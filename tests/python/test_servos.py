"""Why no dead band of a real servo is named: it is buried in what else the servo does."""

import gzip
import pathlib

import numba
import numpy as np
import pytest
import scipy.optimize
from conftest import data_folder


@numba.njit
def servo(command, parameters, form, deadband, start, parts=10):
    """A position servo by itself, 50 rows a second: dead time, gain and offset, second order within limits of velocity
    and acceleration. Dead band: 1 of commands, 2 the drive rests, 3 the drive sees what is beyond it."""
    dead_time_s, w, damping, velocity_max, acceleration_max, gain, offset = parameters
    step_s = 0.02 / parts
    angle, velocity, held = start, 0.0, gain * command[0] + offset
    angles = np.zeros(len(command))
    for row in range(len(command)):
        angles[row] = angle
        for part in range(parts):
            sent = int(np.floor(((row * parts + part) * step_s - dead_time_s) / 0.02 + 1e-9))
            goal = gain * command[max(sent, 0)] + offset
            if form != 1 or abs(goal - held) > deadband:
                held = goal
            error = held - angle
            if form >= 2:
                beyond = error - np.sign(error) * deadband
                error = 0.0 if abs(error) < deadband else beyond if form == 3 else error
            pull = w * w * error - 2.0 * damping * w * velocity
            velocity += step_s * min(max(pull, -acceleration_max), acceleration_max)
            velocity = min(max(velocity, -velocity_max), velocity_max)
            angle += step_s * velocity
    return angles


@pytest.mark.parametrize("form", [1, 2, 3])
def test_a_dead_band_is_buried_in_what_else_a_real_servo_does(form):
    """Why none is named: a program of its own, with all else that these rollouts show, is off by several times what the
    dead band would do that is read from where the servo comes to rest. Fitted, that predicts unseen rollouts no better;
    put into the data on top, and then known, it explains no share worth a name."""
    record = (data_folder() or pathlib.Path("absent")) / "hobby_servo/paired_real_sim.csv.gz"
    if not record.exists():
        pytest.skip("NOT TRIED ON MEASURED DATA: no hobby_servo/paired_real_sim.csv.gz in $BERTH_DATA or ../shared/data")
    table = np.loadtxt(gzip.open(record, "rt"), delimiter=",", skiprows=1)
    rollouts = [table[table[:, 0] == number] for number in np.unique(table[:, 0])]
    scales, begin = np.array([0.02, 25.0, 1.2, 1.5, 50.0, 1.0, 0.01]), np.array([0.6, 1.0, 1.0, 1.0, 1.0, 1.0, -1.0])
    size = 0.009  # half turns: PROVENANCE.md of these data

    def moved(places, one, form, size):
        return servo(one[:, 2], places * scales, form, size, one[0, 3])

    def errors(places, chosen, form, size):
        return np.concatenate([moved(places, one, form, size) - one[:, 3] for one in chosen])

    def unseen_rms(chosen, form, size, begin):
        places = scipy.optimize.least_squares(errors, begin, args=(chosen[1::2], form, size), diff_step=2e-3).x
        return places, np.sqrt(np.mean(errors(places, chosen[::2], form, size) ** 2))

    places, without = unseen_rms(rollouts, 0, 0.0, begin)
    _, with_it = unseen_rms(rollouts, form, size, places)
    effects = [moved(places, one, form, size) - moved(places, one, 0, 0.0) for one in rollouts]
    effect = np.sqrt(np.mean(np.concatenate(effects) ** 2))
    added = [one.copy() for one in rollouts]
    for one, by in zip(added, effects):
        one[:, 3] += by
    _, ignored = unseen_rms(added, 0, 0.0, places)
    _, known = unseen_rms(added, form, size, places)
    print(f"half turns rms: dead band {effect:.4f}; unseen rollouts {without:.4f} without it, {with_it:.4f} with it; "
          f"with another one put in {ignored:.4f} where it is ignored, {known:.4f} where it is known")
    assert without < 0.0330  # its authors' own simulation, of all rollouts
    assert effect < 0.3 * without
    assert with_it > 0.98 * without
    assert known > 0.98 * ignored
