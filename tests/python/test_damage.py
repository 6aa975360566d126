"""Logs that were cut or damaged: whole records survive, the rest is said; nothing crashes or hangs."""

import random
import re
import warnings

import pytest
from conftest import (EXIT_DIFFERENT, EXIT_DONE, EXIT_INPUT, FRAME, TICK, command, data_id,
                      one_json_object, replay_json, ulog_messages)
from pyulog import ULog

# Messages of every kind and some of the run itself, in a file that is small enough for many cuts.
SHORT = {"run.duration_s": 0.3}
BLOCKS = {"run.duration_s": 3.0}  # a few of them
SEED = 20240607
BLOCK_KEY = b"\x14char[38] berth_block"
BLOCK_BYTES = 3 + len(BLOCK_KEY) + 38


@pytest.fixture(scope="module")
def original(logs):
    """A whole log: its bytes and its messages."""
    data = logs("ess", SHORT)[1].read_bytes()
    return data, list(ulog_messages(data))


def header_end(messages):
    return next(message.at for message in messages if message.type == "D")


def whole_ticks(messages, cut):
    """Ticks whose record lies before the cut."""
    return sum(data_id(message) == TICK and message.end <= cut for message in messages)


def replay(path):
    """Exit code, object or None, message. A crash would be a negative exit code, a hang a timeout."""
    done = command("replay", path, "--json")
    message = done.stderr.decode(errors="replace")
    assert done.returncode in (EXIT_DONE, EXIT_DIFFERENT, EXIT_INPUT), (done.returncode, message)
    assert "internal error" not in message
    if done.returncode == EXIT_INPUT and done.stdout != b"":
        result = one_json_object(done.stdout)
        why = "is damaged between" if result["damage"] else "records are missing"
        assert result["equal"] and (result["gap"] or result["damage"]) and f"berth: {path}: {why}" in message
        return done.returncode, result, message
    if done.returncode == EXIT_INPUT:
        assert done.stdout == b"" and message.startswith(f"berth: {path}") and len(message.splitlines()) == 1
        return done.returncode, None, message
    assert message == ""
    return done.returncode, one_json_object(done.stdout), message


def check_cut(data, messages, cut, path):
    path.write_bytes(data[:cut])
    exit_code, result, message = replay(path)
    config_end = next(m.end for m in messages if m.type == "I" and b" berth_config" in m.content[:40]
                      and b"_hash" not in m.content[:40])
    if cut < config_end:
        assert exit_code == EXIT_INPUT, f"cut at {cut}"
        return
    assert exit_code == EXIT_DONE, f"cut at {cut}: {message}{result}"
    first_block = next(m.at for m in messages if m.content.startswith(BLOCK_KEY))
    is_seen = cut not in [m.end for m in messages if m.at < first_block] and cut < len(data)
    assert result["ticks"] == whole_ticks(messages, cut), f"cut at {cut}"
    assert result["equal"] and not result["gap"] and result["cut"] is is_seen, f"cut at {cut}"


@pytest.mark.long
def test_a_log_cut_in_its_header(original, tmp_path):
    """Every byte of the first messages, then coarse steps, then around the last messages."""
    data, messages = original
    end = header_end(messages)
    cuts = [*range(0, 200), *range(200, end, 97), *range(end - 150, end + 1)]
    for cut in cuts:
        check_cut(data, messages, cut, tmp_path / "cut.ulg")


@pytest.mark.long
def test_a_log_cut_anywhere_in_its_data(original, tmp_path):
    data, messages = original
    random_source = random.Random(SEED)
    end = header_end(messages)
    every_byte_of_a_tick = range(end, messages[[data_id(m) == TICK for m in messages].index(True) + 3].end)
    cuts = [*every_byte_of_a_tick[::3], *(random_source.randrange(end, len(data)) for _ in range(150)), len(data)]
    print(f"seed {SEED}")
    for cut in cuts:
        check_cut(data, messages, cut, tmp_path / "cut.ulg")


def test_pyulog_reads_what_was_whole_before_the_cut(original, tmp_path):
    data, messages = original
    random_source = random.Random(SEED)
    topics = header_end(messages)
    for cut in [random_source.randrange(topics + 2000, len(data)) for _ in range(40)]:
        (tmp_path / "cut.ulg").write_bytes(data[:cut])
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            ticks = ULog(str(tmp_path / "cut.ulg")).get_dataset("tick").data["index"]
        assert list(ticks) == list(range(whole_ticks(messages, cut))), f"seed {SEED}, cut at {cut}"


# --- blocks -------------------------------------------------------------------------------------------------------
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
def of_blocks(logs):
    data = logs("ess", BLOCKS)[1].read_bytes()
    return data, list(ulog_messages(data))


def test_the_oracle_knows_the_published_sums():
    assert (xxh64(b""), xxh64(b"abc")) == (0xEF46DB3751D8E999, 0x44BC2CF5AD770999)


def test_every_byte_is_in_a_block_with_its_checksum(original):
    data, _ = original
    begin = 0
    ends = block_ends(data)
    assert len(ends) >= 2
    for message in ends:
        word = "last" if message is ends[-1] else "more"
        text = f"{begin:016x} {xxh64(data[begin : message.at]):016x} {word}"
        assert message.content == BLOCK_KEY + text.encode()
        begin = message.end
    assert begin == len(data)


def damage_of(path):
    """What `replay` and `summary` say: exit code of the first, its object or None, the damaged bytes."""
    done = command("summary", path, "--json")
    exit_code, result, message = replay(path)
    assert done.returncode == exit_code == EXIT_INPUT, (done.returncode, exit_code, message)
    if match := re.search(r"is damaged in its header, before byte (\d+)", message):
        return None, 0, int(match[1])
    if "is not a ULog file" in message:
        return None, 0, 7
    match = re.search(r"is damaged between byte (\d+) and byte (\d+); what is before that is whole: (\d+) ticks", message)
    told = one_json_object(done.stdout)
    place = {"from_byte": int(match[1]), "to_byte": int(match[2])}
    assert result["damage"] == told["damage"] == place
    assert result["ticks"] == told["ticks"] == int(match[3]) and result["equal"] and not result["cut"]
    return result, int(match[1]), int(match[2])


def check_damage(damaged, at, messages, path):
    """It is found, the place lies within what is told, and what lies before the damaged block is whole."""
    path.write_bytes(damaged)
    result, begin, end = damage_of(path)
    assert begin <= at < end + BLOCK_BYTES, f"byte {at} is not within {begin} to {end}"
    if result is not None:
        assert result["ticks"] == whole_ticks(messages, begin)


def swapped(data):
    """The second and the third block after the header, and where they begin."""
    _, first, second, third, *_ = block_ends(data)
    return (data[: first.end] + data[second.end : third.end] + data[first.end : second.end] + data[third.end :],
            first.end)


DAMAGES = {
    "zeroed tail": lambda data: (data[:-300000] + bytes(300000), len(data) - 300000),
    "zeroed end": lambda data: (data[:-10] + bytes(10), len(data) - 10),
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
def test_damage_is_found_with_its_place(damage, of_blocks, tmp_path):
    data, messages = of_blocks
    check_damage(*DAMAGES[damage](data), messages, tmp_path / "damaged.ulg")


@pytest.mark.long
def test_a_flipped_bit_is_found_wherever_it_is(of_blocks, tmp_path):
    """In the records, in the header, and in each byte of the message that ends a block."""
    data, messages = of_blocks
    random_source = random.Random(SEED)
    places = [random_source.randrange(len(data)) for _ in range(200)]
    places += [random_source.randrange(messages[0].at, block_ends(data)[0].at) for _ in range(40)]
    places += [end.at + at for end in (block_ends(data)[0], block_ends(data)[2], block_ends(data)[-1])
               for at in range(BLOCK_BYTES)]
    for at in places:
        bit = random_source.randrange(8)
        damaged = bytearray(data)
        damaged[at] ^= 1 << bit
        print(f"seed {SEED}: bit {bit} of byte {at}")
        check_damage(damaged, at, messages, tmp_path / "flipped.ulg")


def test_a_power_cut_costs_what_was_not_written_and_no_more(of_blocks, tmp_path):
    """Up to a cut all whole ticks count; pages that the disk knows only as zeros cost their block."""
    data, messages = of_blocks
    end = block_ends(data)[3].end
    (tmp_path / "cut.ulg").write_bytes(data[: end + 5000])
    result = replay_json(tmp_path / "cut.ulg")
    assert result["cut"] and result["ticks"] == whole_ticks(messages, end + 5000)
    check_damage(data[: end + 5000] + bytes(20000), end + 5000, messages, tmp_path / "zeros.ulg")


def test_pyulog_passes_over_what_ends_a_block(of_blocks, tmp_path):
    data, messages = of_blocks
    (tmp_path / "whole.ulg").write_bytes(data)
    log = ULog(str(tmp_path / "whole.ulg"))
    assert not log.file_corruption
    assert list(log.get_dataset("tick").data["index"]) == list(range(whole_ticks(messages, len(data))))


def test_others_than_its_owner_and_group_do_not_read_a_log(logs):
    assert logs("ess", SHORT)[1].stat().st_mode & 0o777 & ~0o640 == 0


def test_any_flipped_byte_of_configuration_and_formats_is_noticed(original, tmp_path):
    data, messages = original
    random_source = random.Random(SEED)
    path = tmp_path / "flipped.ulg"
    for message in (m for m in messages if m.type in "FI" and m.at < header_end(messages)):
        for _ in range(15):
            damaged = bytearray(data)
            at = random_source.randrange(message.at + 3, message.end)
            damaged[at] ^= 1 << random_source.randrange(8)
            path.write_bytes(damaged)
            exit_code, result, _ = replay(path)
            assert exit_code == EXIT_INPUT and result is None, f"seed {SEED}, byte {at}: {message.content[:40]}"


@pytest.mark.parametrize("kind", ["zeros", "ones", "noise", "shifted", "doubled"])
def test_garbage(kind, original, tmp_path):
    """Long stretches of nonsense at seeded places, in replay and candump alike."""
    data, _ = original
    random_source = random.Random(f"{SEED} {kind}")
    path = tmp_path / "garbage.ulg"
    for _ in range(25):
        at = random_source.randrange(len(data))
        size = random_source.choice([1, 3, 40, 1000, 20000])
        stuff = {"zeros": bytes(size), "ones": b"\xff" * size, "noise": random_source.randbytes(size),
                 "shifted": b"", "doubled": data[at : at + size] * 2}[kind]
        path.write_bytes(data[:at] + stuff + data[at + size :])
        replay(path)
        done = command("candump", path, "--json")
        assert done.returncode in (EXIT_DONE, EXIT_INPUT), f"seed {SEED} {kind}, {size} at {at}: {done.stderr}"
        assert b"internal error" not in done.stderr


def test_noise_behind_a_valid_start(original, tmp_path):
    data, messages = original
    random_source = random.Random(SEED)
    for start in (0, 7, 16, header_end(messages)):
        for _ in range(10):
            (tmp_path / "noise.ulg").write_bytes(data[:start] + random_source.randbytes(5000))
            replay(tmp_path / "noise.ulg")


@pytest.mark.parametrize("content", [b"", b"ULog", b"ULog\x01\x12\x35\x01" + bytes(8), b"no log at all\n" * 100])
def test_what_is_no_log_is_said_to_be_none(content, tmp_path):
    (tmp_path / "x.ulg").write_bytes(content)
    for subcommand in ("replay", "candump"):
        done = command(subcommand, tmp_path / "x.ulg")
        assert done.returncode == EXIT_INPUT and done.stdout == b""
        assert str(tmp_path / "x.ulg") in done.stderr.decode()
    assert [path.name for path in tmp_path.iterdir()] == ["x.ulg"]


@pytest.mark.parametrize("path", ["/nonexistent/x.ulg", "/proc", "sim_hal"])
def test_logs_that_cannot_be_read(path):
    for subcommand in ("replay", "candump"):
        done = command(subcommand, path)
        assert done.returncode == EXIT_INPUT and done.stdout == b"" and path in done.stderr.decode()


def test_a_frame_that_claims_more_bytes_than_can_has(original, tmp_path):
    data, messages = original
    frame = next(message for message in messages if data_id(message) == FRAME)
    length_at = frame.at + 5 + 8 + 8 + 8 + 4 + 1
    assert data[length_at] == 8
    (tmp_path / "long.ulg").write_bytes(data[:length_at] + b"\xff" + data[length_at + 1 :])
    for subcommand in ("replay", "candump"):
        done = command(subcommand, tmp_path / "long.ulg")
        assert done.returncode == EXIT_INPUT
        begin, end = map(int, re.search(r"is damaged between byte (\d+) and byte (\d+)", done.stderr.decode()).groups())
        assert begin <= frame.at < end


def test_records_that_are_missing_in_the_middle_are_said(original, tmp_path):
    """The whole ticks before the gap replay; what follows it cannot. With blocks it is damage: this is an older log."""
    data, messages = original
    data = data[:messages[0].at] + b"".join(
        data[m.at : m.end] for m in messages if not m.content.startswith(BLOCK_KEY))
    messages = list(ulog_messages(data))
    ticks = [message for message in messages if data_id(message) == TICK]
    (tmp_path / "gap.ulg").write_bytes(data[: ticks[49].end] + data[ticks[59].end :])
    result = replay_json(tmp_path / "gap.ulg", EXIT_INPUT)
    assert result["equal"] and result["gap"] and result["ticks"] == 50
