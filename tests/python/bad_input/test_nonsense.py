"""Rig files with random small changes, and extreme values of every number: they run or are refused, and nothing crashes."""

import random
import re

import pytest
from conftest import EXIT_DONE, EXIT_INPUT, RIG_FOLDER, RIGS, command, one_json_object, settings

SEED = 33
MUTANTS_PER_RIG = 80
NUMBERS = ["0", "-1", "1e308", "-1e308", "1e-308", "5e-324", "inf", "-inf", "nan", "1e999", "9223372036854775807",
           "-9223372036854775808", "18446744073709551616", "0x7fffffff", "1_000", "+3", "1e10", "0.5", "true", '"x"']


def mutate(text, source):
    """One to three small changes of the kind that fingers and editors make."""
    for _ in range(source.randint(1, 3)):
        lines = text.split("\n")
        at = source.randrange(len(lines))
        kind = source.choice(["number", "number", "number", "delete", "insert", "swap", "repeat", "drop"])
        if kind == "number":
            numbers = list(re.finditer(r"(?<== )[-+.\w]+", text))
            hit = source.choice(numbers)
            text = text[: hit.start()] + source.choice(NUMBERS) + text[hit.end() :]
            continue
        place = source.randrange(len(text))
        if kind == "delete":
            text = text[:place] + text[place + source.randint(1, 4) :]
        elif kind == "insert":
            text = text[:place] + source.choice('=[]{}".,#\n\t \\\0\x7f\u00e9e-0') + text[place:]
        elif kind == "swap":
            other = source.randrange(len(lines))
            lines[at], lines[other] = lines[other], lines[at]
            text = "\n".join(lines)
        elif kind == "repeat":
            text = "\n".join(lines[:at] + [lines[at]] + lines[at:])
        else:
            text = "\n".join(lines[:at] + lines[at + 1 :])
    return text


@pytest.mark.long
@pytest.mark.parametrize("rig", RIGS)
def test_mutated_rigs_run_or_are_refused_and_never_crash(rig, tmp_path):
    original = (RIG_FOLDER / f"{rig}.toml").read_text()
    counts = {EXIT_DONE: 0, EXIT_INPUT: 0}
    path = tmp_path / "mutant.toml"
    for i in range(MUTANTS_PER_RIG):
        seed = f"{SEED} {rig} {i}"
        path.write_text(mutate(original, random.Random(seed)))
        done = command("run", path, "--json", "--no-log", *settings({"run.duration_s": 0.3}))
        message = done.stderr.decode(errors="replace")
        what = f"seed {seed!r}: exit code {done.returncode}, {message}\n{path.read_text()}"
        assert done.returncode in counts, what
        counts[done.returncode] += 1
        if done.returncode == EXIT_DONE:
            assert one_json_object(done.stdout)["rig"], what
        else:
            assert done.stdout == b"" and done.stderr.startswith(b"berth: ") and done.stderr.count(b"\n") == 1, what
            assert b"internal error" not in done.stderr, what
    print(f"seed {SEED} {rig}: {counts}")
    assert min(counts.values()) > 5


@pytest.mark.long
def test_extreme_values_of_every_number_run_or_are_refused(tmp_path):
    """Every key of the resolved rig, one at a time, at values that overflow, underflow or change sign."""
    printed = command("run", "ess", "--print-config").stdout.decode()
    section = ""
    keys = []
    for line in printed.splitlines():
        if line.startswith("["):
            section = line.strip("[]")
        elif match := re.match(r"(\w+) = (\S+)", line):
            if section and re.fullmatch(r"[-+.\de]+|inf", match[2]):
                keys.append(f"{section}.{match[1]}")
    assert len(keys) > 50
    slow = {"run.duration_s", "loop.rate_Hz"}  # many ticks are not the point here
    for key in keys:
        for value in ("0", "1e-300", "1e300", "-1e300", "1e15", "-1"):
            if key in slow and value == "1e15":
                continue
            base = {} if key == "run.duration_s" else {"run.duration_s": 0.3}
            done = command("run", "ess", "--json", "--no-log", *settings({**base, key: value}))
            assert done.returncode in (EXIT_DONE, EXIT_INPUT), f"--set {key}={value}: {done.stderr}"
            assert b"internal error" not in done.stderr, f"--set {key}={value}"
