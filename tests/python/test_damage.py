"""Logs that were cut or damaged: whole records survive, the rest is said; nothing crashes or hangs."""

import random
import warnings

import pytest
from conftest import (EXIT_DIFFERENT, EXIT_DONE, EXIT_INPUT, FRAME, GARBAGE, TICK, command, data_id,
                      one_json_object, replay_json, ulog_messages, with_garbage, without_checksums)
from pyulog import ULog

# Messages of every kind and some of the run itself, in a file that is small enough for many cuts.
SHORT = {"run.duration_s": 0.3}
SEED = 20240607


@pytest.fixture(scope="module")
def original(logs):
    """A whole log without checksums: its bytes and its messages. With them: test_checksums.py."""
    data = without_checksums(logs("ess", SHORT)[1].read_bytes())
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
        assert result["equal"] and result["gap"] and message.startswith(f"berth: {path}: records are missing")
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
    at_boundary = cut in (m.end for m in messages)
    assert result["ticks"] == whole_ticks(messages, cut), f"cut at {cut}"
    assert result["equal"] and not result["gap"] and result["cut"] is not at_boundary, f"cut at {cut}"


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


@pytest.mark.long
def test_flipped_bits_are_an_error_or_a_difference_or_harmless_but_never_a_crash(original, tmp_path):
    data, _ = original
    counts = {EXIT_DONE: 0, EXIT_DIFFERENT: 0, EXIT_INPUT: 0}
    random_source = random.Random(SEED)
    path = tmp_path / "flipped.ulg"
    for i in range(400):
        damaged = bytearray(data)
        at = random_source.randrange(len(data))
        damaged[at] ^= 1 << random_source.randrange(8)
        path.write_bytes(damaged)
        exit_code, _, _ = replay(path)
        counts[exit_code] += 1
    print(f"seed {SEED}: {counts}")
    assert counts[EXIT_DIFFERENT] > 50 and counts[EXIT_INPUT] > 10


def test_any_flipped_byte_of_configuration_and_formats_is_noticed(original, tmp_path):
    data, messages = original
    random_source = random.Random(SEED)
    path = tmp_path / "flipped.ulg"
    checked = [m for m in messages if m.type in "FI" and not m.content.startswith(b"rig:")
               and b"sys_name" not in m.content[:30] and b"ver_sw" not in m.content[:30]]
    for message in checked:
        for _ in range(15):
            damaged = bytearray(data)
            key = message.content.index(b" ") if message.type == "I" else 0  # what stands before it is for others
            if b"berth_assumed" in message.content[:40]:
                key = message.content.index(b"berth_assumed") + len("berth_assumed")  # older logs have none
            at = random_source.randrange(message.at + 3 + key, message.end)
            damaged[at] ^= 1 << random_source.randrange(8)
            path.write_bytes(damaged)
            exit_code, result, _ = replay(path)
            noticed = (exit_code == EXIT_INPUT and result is None) or (result["cut"] and result["ticks"] == 0)
            assert noticed, f"seed {SEED}, byte {at}: {message.content[:40]}"


@pytest.mark.parametrize("kind", GARBAGE)
def test_garbage(kind, original, tmp_path):
    """Long stretches of nonsense at seeded places, in replay and candump alike."""
    data, _ = original
    random_source = random.Random(f"{SEED} {kind}")
    path = tmp_path / "garbage.ulg"
    for _ in range(25):
        at = random_source.randrange(len(data))
        size = random_source.choice([1, 3, 40, 1000, 20000])
        path.write_bytes(with_garbage(kind, data, at, size, random_source))
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
        assert f"damaged at byte {frame.at}" in done.stderr.decode()


def test_records_that_are_missing_in_the_middle_are_said(original, tmp_path):
    """The whole ticks before the gap replay; what follows it cannot."""
    data, messages = original
    ticks = [message for message in messages if data_id(message) == TICK]
    (tmp_path / "gap.ulg").write_bytes(data[: ticks[49].end] + data[ticks[59].end :])
    result = replay_json(tmp_path / "gap.ulg", EXIT_INPUT)
    assert result["equal"] and result["gap"] and result["ticks"] == 50
