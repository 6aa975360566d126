"""The checksums of a log tell damage, with its place, from a cut and from a difference of the firmware."""

import random
import re

import numpy as np
import pytest
from conftest import (BLOCK_KEY, EXIT_DIFFERENT, EXIT_DONE, EXIT_INPUT, GARBAGE, TICK, command, data_id,
                      one_json_object, patched, record_type, replay_json, ulog_messages, with_garbage,
                      without_checksums)
from pyulog import ULog

PERIOD_s = 0.0025
SHORT = {"run.duration_s": 3.0}  # some blocks
SEED = 20240607
BLOCK_BYTES = 3 + len(BLOCK_KEY) + 38
CUT_TICKS = {"replay": "replayed up to the last whole tick", "summary": "told up to the last whole tick"}


def xxh64(data):
    """By its specification, seed 0."""
    p1, p2, p3, p4, p5 = (0x9E3779B185EBCA87, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9, 0x85EBCA77C2B2AE63,
                          0x27D4EB2F165667C5)
    mask = (1 << 64) - 1

    def rotated(x, n):
        return (x << n | x >> 64 - n) & mask

    def lane(acc, value):
        return rotated((acc + value * p2) & mask, 31) * p1 & mask

    def number(at, size):
        return int.from_bytes(data[at : at + size], "little")

    lanes, at = [p1 + p2 & mask, p2, 0, -p1 & mask], 0
    while at + 32 <= len(data):
        lanes = [lane(acc, number(at + 8 * i, 8)) for i, acc in enumerate(lanes)]
        at += 32
    acc = p5
    if len(data) >= 32:
        acc = sum(rotated(x, n) for x, n in zip(lanes, (1, 7, 12, 18))) & mask
        for x in lanes:
            acc = ((acc ^ lane(0, x)) * p1 + p4) & mask
    acc = acc + len(data) & mask
    for size, of, turn, times, plus in ((8, None, 27, p1, p4), (4, p1, 23, p2, p3), (1, p5, 11, p1, 0)):
        while at + size <= len(data):
            acc ^= lane(0, number(at, 8)) if of is None else number(at, size) * of & mask
            acc = (rotated(acc, turn) * times + plus) & mask
            at += size
    acc = (acc ^ acc >> 33) * p2 & mask
    acc = (acc ^ acc >> 29) * p3 & mask
    return acc ^ acc >> 32


def block_ends(data):
    """The messages that end blocks."""
    return [message for message in ulog_messages(data) if message.content.startswith(BLOCK_KEY)]


@pytest.fixture(scope="module")
def original(logs):
    """A whole log: its bytes and its messages."""
    data = logs("ess", SHORT)[1].read_bytes()
    return data, list(ulog_messages(data))


def ticks_before(messages, byte):
    """Ticks whose record lies before this byte."""
    return sum(data_id(message) == TICK and message.end <= byte for message in messages)


def told(path, exit_code, subcommands=("replay", "summary")):
    """What `replay` and `summary` agree on: its object, which is None where the header is damaged, and the message."""
    objects, messages = [], []
    for subcommand in subcommands:
        done = command(subcommand, path, "--json")
        assert done.returncode == exit_code, (subcommand, done.returncode, done.stdout, done.stderr)
        objects.append(one_json_object(done.stdout) if done.stdout else {})
        messages.append(done.stderr.decode())
    for key in ("checksums", "cut", "damage", "whole_until_s", "ticks"):
        assert objects[0].get(key) == objects[-1].get(key)
    assert messages[0] == messages[-1]
    return objects[0] or None, messages[0]


# --- the file format ----------------------------------------------------------------------------------------------
def test_the_oracle_knows_the_published_sums():
    assert (xxh64(b""), xxh64(b"abc")) == (0xEF46DB3751D8E999, 0x44BC2CF5AD770999)


def test_every_byte_is_in_a_block_with_its_checksum(original):
    data, _ = original
    begin = 0
    ends = block_ends(data)
    assert len(ends) >= 4
    for message in ends:
        word = "last" if message is ends[-1] else "more"
        text = f"{begin:016x} {xxh64(data[begin : message.at]):016x} {word}"
        assert message.content == BLOCK_KEY + text.encode()
        begin = message.at  # the next block begins with it
    assert ends[-1].end == len(data)


def test_pyulog_passes_over_what_ends_a_block(original, tmp_path):
    data, messages = original
    (tmp_path / "whole.ulg").write_bytes(data)
    log = ULog(str(tmp_path / "whole.ulg"))
    assert not log.file_corruption
    assert list(log.get_dataset("tick").data["index"]) == list(range(ticks_before(messages, len(data))))


def test_others_than_its_owner_and_group_do_not_read_a_log(logs):
    assert logs("ess", SHORT)[1].stat().st_mode & 0o777 & ~0o640 == 0


# --- damage -------------------------------------------------------------------------------------------------------
def check_damage(data, at, original, path, subcommands=("replay", "summary"), blocks_max=2):
    """Damage at byte `at` is found. The reported range of bytes holds it and begins where a block begins, the times
    hold its time, and what lies before is whole. A block behind a damaged message is damaged, too: it begins with it."""
    path.write_bytes(data)
    result, message = told(path, EXIT_INPUT, subcommands)
    if result is None:
        header = block_ends(original[0])[0].end
        match = re.search(r"is damaged in its header, before byte (\d+): without it no record can be read", message)
        assert at < header and (match or (at < 8 and "is not a ULog file" in message)), message
        return
    damage, messages = result["damage"], original[1]
    begin, end = damage["from_byte"], damage["to_byte"]
    assert begin <= at <= end and begin in [end.end for end in block_ends(original[0])], f"byte {at}: {message}"
    ticks = ticks_before(messages, begin)
    assert result["ticks"] == ticks and result["equal"] and not result["cut"] and result["checksums"]
    assert damage["last_whole_s"] == result["whole_until_s"] == (pytest.approx((ticks - 1) * PERIOD_s) if ticks else None)
    after_s = "" if damage["last_whole_s"] is None else f", after {damage['last_whole_s']:.4f} s"
    before_s = "" if damage["whole_again_s"] is None else f" before {damage['whole_again_s']:.4f} s"
    assert f"is damaged between byte {begin} and byte {end}{after_s}" in message and before_s in message
    assert f"what is before that is whole: {ticks} ticks" in message
    if len(data) == len(original[0]) and damage["whole_again_s"] is not None:  # and in its place again
        assert damage["whole_again_s"] == pytest.approx(ticks_before(messages, end) * PERIOD_s)
        ends = block_ends(original[0])
        assert at < end and [m.at for m in ends].index(end) <= [m.end for m in ends].index(begin) + blocks_max


def swapped(data):
    """The second and the third block after the header, and where they begin."""
    _, first, second, third, *_ = block_ends(data)
    return (data[: first.end] + data[second.end : third.end] + data[first.end : second.end] + data[third.end :],
            first.end)


DAMAGES = {
    "zeroed page": lambda data: (data[:200704] + bytes(4096) + data[204800:], 200704),
    "zeros behind the end": lambda data: (data + bytes(4096), len(data)),
    "garbage behind the end": lambda data: (data + random.Random(SEED).randbytes(999), len(data)),
    "one byte behind the end": lambda data: (data + b"D", len(data)),
    "its own records behind the end": lambda data: (data + data[-5000:], len(data)),
    "swapped blocks": swapped,
    "a block is missing": lambda data: (data[: block_ends(data)[1].end] + data[block_ends(data)[2].end :],
                                        block_ends(data)[1].end),
    "a block is there twice": lambda data: (data[: block_ends(data)[2].end] + data[block_ends(data)[1].end :],
                                            block_ends(data)[2].end),
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_damage_is_found_with_its_place(damage, original, tmp_path):
    check_damage(*DAMAGES[damage](original[0]), original, tmp_path / "damaged.ulg",
                 blocks_max=3 if damage == "swapped blocks" else 2)


def flip(at, bit, original, path):
    damaged = bytearray(original[0])
    damaged[at] ^= 1 << bit
    print(f"seed {SEED}: bit {bit} of byte {at}")
    check_damage(damaged, at, original, path, ["replay"])


@pytest.mark.long
def test_a_flipped_bit_is_found_wherever_it_is(original, tmp_path):
    """In the records, in the header, and in each byte of the message that ends a block."""
    data, messages = original
    random_source = random.Random(SEED)
    ends = block_ends(data)
    places = [random_source.randrange(len(data)) for _ in range(60)]
    places += [random_source.randrange(messages[0].at, ends[0].at) for _ in range(20)]
    places += [end.at + at for end in (ends[0], ends[2], ends[-1]) for at in range(0, BLOCK_BYTES, 3)]
    for at in places:
        flip(at, random_source.randrange(8), original, tmp_path / "flipped.ulg")


@pytest.mark.parametrize("which", [0, pytest.param(1, marks=pytest.mark.long), -1])
def test_every_bit_of_a_length_and_of_a_type(which, original, tmp_path):
    """Of the first record of a block, from which a reader finds all that follow: in the first one and in the last."""
    data, messages = original
    end = block_ends(data)[which - 1 if which < 0 else which].end
    for at in range(end, end + 3):
        for bit in range(8):
            flip(at, bit, original, tmp_path / "flipped.ulg")


@pytest.mark.parametrize("kind", GARBAGE)
def test_garbage_is_damage_or_a_cut_and_never_a_difference(kind, original, tmp_path):
    data, _ = original
    random_source = random.Random(f"{SEED} {kind}")
    path = tmp_path / "garbage.ulg"
    for _ in range(6):
        at = random_source.randrange(8, len(data) - 20000)
        size = random_source.choice([3, 40, 1000, 20000])
        made = with_garbage(kind, data, at, size, random_source)
        if made != data:
            print(f"seed {SEED} {kind}: {size} at {at}")
            path.write_bytes(made)
            assert command("replay", path).returncode == EXIT_INPUT


def test_the_end_of_another_log_is_damage(logs, tmp_path):
    """As a copy leaves it that was broken off on its way over an older file: each block is whole by itself."""
    one, other = (logs("ess", SHORT | {"sensor.noise_N": 1.0, "run.seed": seed})[1].read_bytes() for seed in (1, 2))
    ends = [message.end for message in block_ends(one)]
    assert ends == [message.end for message in block_ends(other)] and one[ends[1] :] != other[ends[1] :]
    for end in ends[:-1]:
        (tmp_path / "mixed.ulg").write_bytes(one[:end] + other[end:])
        damage = replay_json(tmp_path / "mixed.ulg", EXIT_INPUT)["damage"]
        assert damage["from_byte"] == end


# What each command does with a damaged log: it goes on with the whole part, or refuses it.
WITH_DAMAGE = {
    "summary": ([], "configuration"),
    "replay": ([], "equal bit for bit"),
    "compare": ([], "peak force"),
    "report": ([], None),
    "candump": ([], None),
    "export": (["--csv"], None),
    "diagnose": (["--rig", "ess", "--out", "found"], None),
}


@pytest.mark.parametrize("subcommand", WITH_DAMAGE)
def test_each_command_says_what_is_damaged_and_from_when(subcommand, original, tmp_path):
    data, messages = original
    damaged = bytearray(data)
    damaged[200704] ^= 1
    (tmp_path / "whole.ulg").write_bytes(data)
    path = tmp_path / "damaged.ulg"
    path.write_bytes(damaged)
    more, shown = WITH_DAMAGE[subcommand]
    more = [tmp_path / word if word == "found" else word for word in more]
    more = [tmp_path / "whole.ulg", "--page", tmp_path / "both.html"] if subcommand == "compare" else more
    done = command(subcommand, path, *more)
    begin = max(end.end for end in block_ends(data) if end.end <= 200704)
    text = done.stderr.decode()
    assert done.returncode == EXIT_INPUT and f"damaged.ulg: is damaged between byte {begin} and byte " in text, text
    assert f", after {(ticks_before(messages, begin) - 1) * PERIOD_s:.4f} s and before " in text
    if shown is None:
        assert done.stdout == b""
    else:
        assert shown in done.stdout.decode() and "what is before that is whole" in text
    assert sorted(file.name for file in tmp_path.iterdir()) == ["damaged.ulg", "whole.ulg"]


# --- a cut --------------------------------------------------------------------------------------------------------
def zeroed(data, size):
    return data[:-size] + bytes(size)


# Of the file's bytes: what is left, and the byte up to which it is whole.
CUTS = {
    "cut behind a block": lambda data, end: (data[:end], end),
    "cut in a block": lambda data, end: (data[: end + 5000], end + 5000),
    "cut in the message that ends a block": lambda data, end: (data[: end - 5], end - 5),
    "cut in the last message": lambda data, end: (data[:-1], len(data) - 1),
    "zeros behind a block": lambda data, end: (data[:end] + bytes(20000), end),
    "zeros in a block": lambda data, end: (data[: end + 5000] + bytes(20000), end + 5000),
    "zeros in the message that ends a block": lambda data, end: (data[: end - 5] + bytes(20000), end - 5),
    "zeroed tail": lambda data, end: (zeroed(data, 300000), len(data) - 300000),
    "zeroed end": lambda data, end: (zeroed(data, 10), len(data) - 10),
}


@pytest.mark.parametrize("cut", CUTS)
def test_a_cut_costs_what_was_not_written_and_no_more(cut, original, tmp_path):
    """Records that end with zeros by themselves may go with zeros that follow: a tick at most."""
    data, messages = original
    left, whole = CUTS[cut](data, block_ends(data)[3].end)
    (tmp_path / "cut.ulg").write_bytes(left)
    result, message = told(tmp_path / "cut.ulg", EXIT_DONE)
    ticks = ticks_before(messages, whole)
    assert message == "" and result["equal"] and result["cut"] and result["checksums"] and result["damage"] is None
    assert ticks - ("zero" in cut) <= result["ticks"] <= ticks
    assert result["whole_until_s"] == pytest.approx((result["ticks"] - 1) * PERIOD_s)
    for subcommand, words in CUT_TICKS.items():
        shown = command(subcommand, tmp_path / "cut.ulg").stdout.decode()
        assert f"the file is cut: {words}, at {result['whole_until_s']:.4f} s" in shown


@pytest.mark.long
def test_zeros_from_anywhere_are_a_cut(original, tmp_path):
    """As a power cut leaves a file of which the disk knows the length and not all of the content."""
    data, messages = original
    random_source = random.Random(SEED)
    header = block_ends(data)[0].end
    for at in [random_source.randrange(header, len(data) - 1) for _ in range(40)]:
        print(f"seed {SEED}: zeros from {at}")
        (tmp_path / "cut.ulg").write_bytes(data[:at] + bytes(len(data) - at))
        result, _ = told(tmp_path / "cut.ulg", EXIT_DONE, ["replay"])
        ticks = ticks_before(messages, at)
        assert result["cut"] and result["equal"] and ticks - 1 <= result["ticks"] <= ticks


@pytest.mark.long
def test_a_short_log_cut_anywhere(logs, tmp_path):
    """In its header it can be read or not; behind it, each whole tick counts."""
    data = logs("ess", {"run.duration_s": 0.3})[1].read_bytes()
    messages, path = list(ulog_messages(data)), tmp_path / "cut.ulg"
    header = block_ends(data)[0].end
    for at in range(0, len(data), 509):
        path.write_bytes(data[:at])
        done = command("summary", path, "--json")
        if at < header:
            assert done.returncode in (EXIT_DONE, EXIT_INPUT) and (done.stdout or done.stderr), at
            continue
        assert done.returncode == EXIT_DONE, (at, done.stderr)
        result = one_json_object(done.stdout)
        assert result["cut"] and result["damage"] is None and result["ticks"] == ticks_before(messages, at), at


# --- a difference, and logs without checksums ---------------------------------------------------------------------
def test_a_difference_without_damage_is_a_difference(original, tmp_path):
    """A log with a changed value and with checksums that fit: as from another firmware."""
    data, messages = original
    tick = [message for message in messages if data_id(message) == TICK][123]
    changed = patched(data, tick, record_type(data, "tick"), "force_N", lambda value: np.nextafter(value, 1e9))
    path, begin, made = tmp_path / "other.ulg", 0, b""
    for end in block_ends(data):
        made += changed[len(made) : end.at]
        made += changed[end.at : end.end].replace(end.content[-21:-5], f"{xxh64(made[begin:]):016x}".encode())
        begin = end.at
    path.write_bytes(made)
    result = replay_json(path, EXIT_DIFFERENT)
    assert result["first_difference"]["tick"] == 123 and result["damage"] is None and result["checksums"]
    shown = command("replay", path).stdout.decode()
    assert "differs at tick 123 in force_N" in shown and "is not damaged there: its checksums fit" in shown

    path.write_bytes(without_checksums(made))
    assert replay_json(path, EXIT_DIFFERENT)["checksums"] is False
    assert "has no checksums: damage may be the cause" in command("replay", path).stdout.decode()


def saved_by_pyulog(path, again):
    ULog(str(path)).write_ulog(str(again))


def stripped(path, again):
    again.write_bytes(without_checksums(path.read_bytes()))


def with_a_message_of_another_block_in_front(path, again):
    """As a program does that keeps the last text of a key."""
    data = path.read_bytes()
    end = block_ends(data)[-1]
    left = without_checksums(data)
    first = next(message.at for message in ulog_messages(left) if message.type == "A")
    again.write_bytes(left[:first] + data[end.at : end.end] + left[first:])


@pytest.mark.parametrize("duration_s", [0.1, 3.0])
@pytest.mark.parametrize("save", [saved_by_pyulog, stripped, with_a_message_of_another_block_in_front])
def test_a_log_without_checksums_is_read_as_before(save, duration_s, logs, tmp_path):
    run, log = logs("ess", {"run.duration_s": duration_s})
    save(log, tmp_path / "again.ulg")
    result, message = told(tmp_path / "again.ulg", EXIT_DONE)
    assert result["ticks"] == run["ticks"] and result["equal"] and not result["cut"] and message == ""
    assert result["checksums"] is False and result["damage"] is None and result["whole_until_s"] is None
    shown = command("summary", tmp_path / "again.ulg").stdout.decode()
    assert "the log has no checksums" in shown
    assert "checksums" not in command("summary", log).stdout.decode()
