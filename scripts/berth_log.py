"""Reads a log of `berth run` into numpy arrays, and asks `berth summary` for the run's result."""
import json
import os
import re
import subprocess
import tomllib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pyulog import ULog

# Names of the numbers in the log, as in firmware/supervisor.c and firmware/limits.c.
STATES = ("start", "ready", "running", "holding", "fault", "stopped")
STOP_CAUSES = ("none", "requested", "enable_off", "sensor_stale", "operator_stale", "emergency_stop",
               "feedback_stale", "robot_fault", "sensor_saturated", "force_limit", "position_limit", "not_finite",
               "bus_off", "missed_ticks", "send_refused", "setpoint_stale",
               "following_error", "link_quality", "dead_time_power", "growth")
LIMITS = ("not_finite", "position", "velocity", "acceleration")  # by bit number


class InputError(Exception):
    """What is wrong with the files given, in a sentence for the person who gave them."""


def behind_latest(log):
    """A log that was named through the link `latest`, by the name of its run: a later run moves the link."""
    folder = log.parent
    return folder.parent / os.readlink(folder) / log.name if folder.name == "latest" and folder.is_symlink() else log


@dataclass(frozen=True)
class ConfigRow:
    """One line of the resolved configuration; `key` ends in its unit, `note` says what it is."""
    section: str
    key: str
    value: str
    note: str


@dataclass(frozen=True)
class Log:
    """One run. `tick`, `rig` and `arm` map field names (unit last) to arrays, `tick_s` and `rig_s` are their times in s;
    `rig` is what was really so, known only to a simulated rig, else empty; `arm` has the ticks' times, and is empty
    without one; so does `side`, of the robot's axes beside that of the loop."""
    path: Path
    tick: dict
    tick_s: np.ndarray
    rig: dict
    rig_s: np.ndarray
    arm: dict
    side: dict
    config: dict
    config_text: str
    config_rows: list
    config_hash: str
    version: str

    @property
    def period_s(self):
        return 1.0 / self.config["loop"]["rate_Hz"]

    @property
    def is_contact(self):
        return self.config["object"]["kind"] == "contact"


def _rows(text):
    section = ""
    for line in text.splitlines():
        if line.startswith("["):
            section = line.strip("[] ")
        elif match := re.match(r'(\w+) = ("(?:[^"\\]|\\.)*"|\[.*\]|\S+)\s*(?:# (.*))?$', line):
            yield ConfigRow(section, match[1], match[2].strip('"'), match[3] or "")


def read_log(path):
    """The log at `path`, up to its last whole record. Raises InputError."""
    path = Path(path)
    try:
        ulog = ULog(str(path), ["tick", "rig", "arm", "side"])
    except Exception as error:  # a damaged file can make pyulog raise anything
        raise InputError(f"{path}: cannot be read as a ULog file ({error})") from error
    infos = ulog.msg_info_dict
    if "berth_config" not in infos:
        raise InputError(f"{path}: carries no configuration; is it a log of berth, and not cut in its header?")
    config_text = infos["berth_config"]
    config = tomllib.loads(config_text)
    topics = {topic.name: topic.data for topic in ulog.data_list}
    tick = topics.get("tick", {})
    rig = topics.get("rig", {})
    none = np.empty(0)
    period_s = 1.0 / config["loop"]["rate_Hz"]
    return Log(path=path,
               tick=tick,
               tick_s=1e-9 * tick["scheduled_ns"] if tick else none,
               rig=rig,
               arm=topics.get("arm", {}),
               side=topics.get("side", {}),
               # The time stamp is cut to us; the rig is recorded once a tick.
               rig_s=period_s * np.rint(1e-6 * rig["timestamp"] / period_s) if rig else none,
               config=config,
               config_text=config_text,
               config_rows=list(_rows(config_text)),
               config_hash=infos.get("berth_config_hash", "unknown"),
               version=infos.get("ver_sw", "unknown"))


def read_summary(path, berth):
    """What `berth summary LOG --json` says: the numbers that `berth run` told. Raises InputError."""
    try:
        done = subprocess.run([str(berth), "summary", str(path), "--json"], capture_output=True, text=True)
    except OSError as error:
        raise InputError(f"{berth}: cannot be started ({error.strerror}); build it with `make all` or name it with "
                         "--berth") from error
    if done.returncode != 0:
        raise InputError(done.stderr.strip().removeprefix("berth: ") or f"{berth} summary failed")
    return json.loads(done.stdout)


def intervals(active, time_s, period_s):
    """Start and end (s) of each stretch in which `active` holds; the last tick lasts one period."""
    edges = np.diff(np.concatenate(([0], np.asarray(active, dtype=np.int8), [0])))
    starts = np.flatnonzero(edges == 1)
    ends = np.flatnonzero(edges == -1)
    return list(zip(time_s[starts], time_s[ends - 1] + period_s))


def stretches(values, time_s, period_s):
    """(value, start, end) of each stretch of equal `values`, times in s."""
    if len(values) == 0:
        return []
    starts = np.concatenate(([0], np.flatnonzero(np.diff(values)) + 1))
    ends = np.concatenate((time_s[starts[1:]], [time_s[-1] + period_s]))
    return [(int(values[i]), time_s[i], end) for i, end in zip(starts, ends)]


def write_whole(path, content):
    """Writes a file so that it is there whole or, if writing fails, as it was before."""
    partial = path.with_name(path.name + ".partial")
    try:
        partial.write_bytes(content)
        os.replace(partial, path)
    except OSError as error:
        partial.unlink(missing_ok=True)
        raise InputError(f"{path}: cannot be written ({error.strerror})") from error
