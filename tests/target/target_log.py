"""What the tests ask of the log of a loop on the target."""

import itertools
import re
from pathlib import Path

import numpy as np
from pyulog import ULog

ROOT = Path(__file__).resolve().parents[2]


def state_names():
    """Names of the supervisor's states by number, from the DBC."""
    [values] = re.findall(r'VAL_ 17 state (.*) ;', (ROOT / "firmware" / "can" / "berth.dbc").read_text())
    return dict((int(number), name) for number, name in re.findall(r'(\d+) "(\w+)"', values))


def cause_names():
    """Names of the causes of a stop by number, from the firmware's table, which is in the order of its enum."""
    table = (ROOT / "firmware" / "supervisor.c").read_text()
    return dict(enumerate(re.findall(r'\[STOP_\w+\] = "(\w+)"', table)))


class TargetLog:
    """Ticks and lines of a log, and what they say of the run."""

    def __init__(self, path):
        self.ulog = ULog(str(path))
        self.tick = self.topic("tick")

    def topic(self, name):
        return self.ulog.get_dataset(name).data

    def has_topic(self, name):
        return any(one.name == name for one in self.ulog.data_list)

    @property
    def before_end(self):
        """Which ticks come before somebody asked for an orderly stop, as the run's end does."""
        return self.tick["stop"] == 0

    def states(self):
        """The states in the order in which they were reached, until the run's end."""
        names = state_names()
        return ["start"] + [name for name, _ in itertools.groupby(
            names[int(number)] for number in self.tick["state"][self.before_end]) if name != "start"]

    def stop_cause(self):
        """The cause at the run's end."""
        return cause_names()[int(self.tick["stop_cause"][self.before_end][-1])]

    def last_state(self):
        return state_names()[int(self.tick["state"][-1])]

    def missed_ticks(self):
        return int(self.tick["missed_ticks"].sum())

    def check_no_tick_is_missing(self):
        """Every tick that the loop ran is in the log: its index goes on by one and what was missed."""
        steps = np.diff(self.tick["index"])
        np.testing.assert_array_equal(steps, 1 + self.tick["missed_ticks"][1:].astype(int))

    def check_ran_to_the_end(self, ticks):
        """Without a stop on the way, and every tick in time."""
        assert self.states() == ["start", "ready", "running"]
        assert np.count_nonzero(self.before_end) == ticks
        self.check_no_tick_is_missing()
        assert self.missed_ticks() == 0

    def check_arm_moves_as(self, simulated):
        """Tool, satellite and joints to 2 % of how far they move, under the same orders."""
        here, there = self.topic("arm"), simulated.topic("arm")
        for field in ("tool_x_m", "tool_y_m", "base_turn_rad", "joint_1_rad"):
            moved = np.ptp(there[field])
            assert moved > 1e-3
            # The run is released by frames that may come a tick later or earlier.
            count = min(len(here[field]), len(there[field])) - 400
            apart = min(np.abs(here[field][shift:count + shift] - there[field][:count]).max() for shift in range(4))
            assert apart < 0.02 * moved, field
        assert set(np.unique(here["order"])) == set(np.unique(there["order"]))
