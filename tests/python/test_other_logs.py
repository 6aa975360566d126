"""ULog files of other programs, and our logs as other programs save them again."""

import struct

import numpy as np
import pytest
from conftest import EXIT_INPUT, command, replay_json, topic, without_checksums
from pyulog import ULog

SHORT = {"run.duration_s": 2.0}


def message(kind, content):
    return struct.pack("<HB", len(content), ord(kind)) + content


def keyed(kind, key, value, before=b""):
    return message(kind, before + bytes([len(key)]) + key.encode() + value)


def subscription(number, name):
    return message("A", struct.pack("<BH", 0, number) + name.encode())


HEADER = b"ULog\x01\x12\x35\x01" + bytes(8)
FLAGS = message("B", bytes(40))
FORMAT = message("F", b"wind:uint64_t timestamp;float speed;")
NAME = keyed("I", "char[7] sys_name", b"Gyropod")
DATA = b"".join(message("D", struct.pack("<HQf", 3, 10**6 + n, 0.5 * n)) for n in range(50))
# Every kind of message that the format has beside ours: parameters, defaults, several infos, texts, marks.
PASSED_OVER = [keyed("P", "float GAIN_P", struct.pack("<f", 1.5)),
               keyed("Q", "float GAIN_P", struct.pack("<f", 1.5), b"\x01"),
               keyed("M", "char[2] perf", b"ok", b"\x00"), message("L", struct.pack("<BQ", 54, 5) + b"take-off"),
               message("C", struct.pack("<BHQ", 54, 1, 5) + b"take-off"), message("S", b"\x2f\x73\x13\x20\x25\x0c\xbb\x12"),
               message("R", struct.pack("<H", 3)), message("O", struct.pack("<H", 20))]


def other_log(path, info=NAME, topics=("wind",)):
    """A whole log of another program, with every kind of message in both of its sections."""
    subscriptions = b"".join(subscription(3 + n, name) for n, name in enumerate(topics))
    body = b"".join(PASSED_OVER[3:])
    path.write_bytes(HEADER + FLAGS + FORMAT + info + b"".join(PASSED_OVER[:3]) + subscriptions + DATA + body + DATA)
    return path


@pytest.mark.parametrize("words", [["replay"], ["candump"], ["diagnose", "--rig", "ess"]], ids=lambda words: words[0])
def test_a_log_of_another_program_is_told_as_such(words, tmp_path):
    log = other_log(tmp_path / "other.ulg")
    assert [len(data.data["speed"]) for data in ULog(str(log)).data_list] == [100]  # pyulog takes it as it is
    out = ["--out", tmp_path / "out"] if words[0] == "diagnose" else []
    done = command(words[0], log, *words[1:], *out)
    told = done.stderr.decode()
    assert done.returncode == EXIT_INPUT and done.stdout == b"" and told.count("\n") == 1
    assert told.startswith(f"berth: {log}: is a Gyropod log: no berth topics; these are inside: wind;"), told


def test_a_log_without_a_name_and_one_of_many_topics(tmp_path):
    log = other_log(tmp_path / "other.ulg", info=b"", topics=[f"topic_{n:02}" for n in range(12)])
    told = command("replay", log).stderr.decode()
    assert "is a log of another program" in told and "topic_00, " in told and "topic_07 and 4 more" in told, told


def test_a_broken_message_is_damage(tmp_path):
    log = other_log(tmp_path / "other.ulg", info=message("?", b"nothing that the format knows"))
    assert f"is damaged at byte {len(HEADER + FLAGS + FORMAT)}" in command("replay", log).stderr.decode()


@pytest.mark.parametrize("rig", ["ess", "ess-pose"])
def test_a_log_that_pyulog_saves_again_replays_as_before(rig, logs, tmp_path):
    """pyulog puts the ticks before the frames of their time."""
    result, log = logs(rig, SHORT)
    again = tmp_path / "again.ulg"
    ULog(str(log)).write_ulog(str(again))
    assert again.read_bytes() != log.read_bytes()
    assert replay_json(again) == {"log": str(again), "equal": True, "ticks": result["ticks"], "cut": False, "gap": False,
                                  "checksums": False, "damage": None, "whole_until_s": None}
    for name in ("tick", "can_frame"):
        for field, values in topic(log, name).items():
            assert np.array_equal(values, topic(again, name)[field], equal_nan=True), field
    for path in (log, again):
        assert command("candump", path).returncode == 0
    for bus in ("robot", "sensor"):
        ours, saved = (path.with_suffix(f".{bus}.candump.log").read_bytes() for path in (log, again))
        assert ours == saved


def test_what_other_programs_add_to_our_log_is_passed_over(logs, tmp_path):
    result, log = logs("ess", SHORT)
    data = without_checksums(log.read_bytes())
    again = tmp_path / "more.ulg"
    again.write_bytes(data[:16 + 43] + b"".join(PASSED_OVER[:3]) + data[16 + 43:] + b"".join(PASSED_OVER[3:-1]))
    assert replay_json(again)["ticks"] == result["ticks"]


def test_other_message_ids_are_those_of_the_subscriptions(logs, tmp_path):
    result, log = logs("ess", SHORT)
    data = without_checksums(log.read_bytes())
    at, made = 16, data[:16]
    while at < len(data):
        size, kind = struct.unpack_from("<HB", data, at)
        content = bytearray(data[at + 3 : at + 3 + size])
        place = {ord("A"): 1, ord("D"): 0}.get(kind)
        if place is not None:
            content[place] += 40
        made += struct.pack("<HB", size, kind) + content
        at += 3 + size
    (tmp_path / "ids.ulg").write_bytes(made)
    assert replay_json(tmp_path / "ids.ulg")["ticks"] == result["ticks"]
