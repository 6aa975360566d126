"""What a user can get wrong: exit code 2, one clear message that names the place, stdout empty, no files."""

import gzip
import random
import re
import subprocess

import pytest
from conftest import EXIT_DONE, EXIT_INPUT, RIG_FOLDER, RIGS, ROOT, command, one_json_object, settings

ESS = (RIG_FOLDER / "ess.toml").read_text()


def line_of(text, part):
    """Number of the first line that contains `part`."""
    return next(i for i, line in enumerate(text.splitlines(), 1) if part in line)


def refused(*arguments, contains=(), out=None):
    """Runs and checks everything that every refusal has in common; the message."""
    done = command(*arguments)
    message = done.stderr.decode(errors="replace")
    assert done.returncode == EXIT_INPUT, (done.returncode, message)
    assert done.stdout == b""
    assert message.startswith("berth: ") and message.count("\n") == 1 and "internal error" not in message, message
    for part in contains:
        assert part in message, message
    if out is not None:
        assert not out.exists(), list(out.rglob("*"))
    return message


# --- rig files ----------------------------------------------------------------------------------------------------
# name: (text to replace, its replacement, what the message must say); the place is that of the replacement.
FILES = {
    "unknown key": ("dead_time_ms = 17.5", "ded_time_ms = 17.5",
                    ["robot.ded_time_ms", "unknown key", "robot.dead_time_ms"]),
    "key without its unit": ("dead_time_ms = 17.5", "dead_time = 17.5", ["robot.dead_time", "robot.dead_time_ms"]),
    "key with another unit": ("dead_time_ms = 17.5", "dead_time_s = 0.0175",
                              ["robot.dead_time_s", "robot.dead_time_ms"]),
    "unknown section": ("[robot]", "[robbot]", ["robbot", "robot."]),
    "unknown empty section": ("[loop]", "[lop]\n[loop]", ["lop", "unknown section", "loop"]),
    "key outside sections": ("[run]", "rate_Hz = 400\n[run]", ["rate_Hz", "loop.rate_Hz"]),
    "negative mass": ("mass_kg = 200.0", "mass_kg = -200.0", ["manipulator.mass_kg", "greater than 0", "-200"]),
    "no mass": ("mass_kg = 100.0", "mass_kg = 0", ["object.mass_kg", "greater than 0"]),
    "nan": ("mass_kg = 200.0", "mass_kg = nan", ["manipulator.mass_kg", "finite", "nan"]),
    "inf": ("mass_kg = 200.0", "mass_kg = inf", ["manipulator.mass_kg", "finite", "inf"]),
    "-inf": ("initial_position_m = 0.01", "initial_position_m = -inf", ["manipulator.initial_position_m", "finite"]),
    "infinite duration": ("duration_s = 60.0", "duration_s = inf", ["run.duration_s", "finite"]),
    "too large a number": ("mass_kg = 200.0", "mass_kg = 1e999", []),
    "text for a number": ("mass_kg = 200.0", 'mass_kg = "heavy"', ["manipulator.mass_kg", "a number", "heavy"]),
    "boolean for a number": ("mass_kg = 200.0", "mass_kg = true", ["manipulator.mass_kg", "a number", "true"]),
    "list for a number": ("mass_kg = 200.0", "mass_kg = [1, 2]", ["manipulator.mass_kg", "a number"]),
    "table for a number": ("mass_kg = 200.0", "mass_kg = {a = 1}", ["manipulator.mass_kg", "a number"]),
    "date for a number": ("mass_kg = 200.0", "mass_kg = 2001-01-01", ["manipulator.mass_kg", "a number"]),
    "number for a word": ('interpolation = "linear"', "interpolation = 3", ["robot.interpolation", "quotes"]),
    "unknown word": ('interpolation = "linear"', 'interpolation = "cubic"',
                     ["robot.interpolation", '"linear"', '"hold"', "cubic"]),
    "number for a boolean": ("[robot]", "[bus]\nideal = 1\n[robot]", ["bus.ideal", "true or false"]),
    "fraction for a whole number": ("low_pass_order = 2", "low_pass_order = 1.5",
                                    ["sensor.low_pass_order", "whole"]),
    "probability above 1": ("[robot]", "[bus]\nloss_probability = 1.5\n[robot]", ["bus.loss_probability", "0 to 1"]),
    "rate that does not divide": ("rate_Hz = 400", "rate_Hz = 399", ["loop.rate_Hz", "320", "400"]),
    "rate of 0": ("rate_Hz = 400", "rate_Hz = 0", ["loop.rate_Hz", "greater than 0"]),
    "rate beyond any loop": ("rate_Hz = 400", "rate_Hz = 2000000", ["loop.rate_Hz", "1000000"]),
    "linear dead time below a tick": ("dead_time_ms = 17.5", "dead_time_ms = 2.4",
                                      ["robot.dead_time_ms", "one period", "linear", "hold"]),
    "delay below the time on the bus": ("delay_ms = 2.5", "delay_ms = 0.05", ["sensor.delay_ms", "bus.ideal"]),
    "sensor order": ("low_pass_order = 2", "low_pass_order = 3", ["sensor.low_pass_order", "0, 1 or 2"]),
    "start outside the limits": ("initial_position_m = 0.01", "initial_position_m = 7.0",
                                 ["manipulator.initial_position_m", "limits.position_max_m"]),
    "profile without a file": ("[robot]", '[profile]\nkind = "file"\n[robot]', ["profile.file", "missing"]),
    "filter without a robot to invert": ("[robot]", "[inverse_filter]\nenabled = true\n[robot]",
                                         ["inverse_filter.enabled", "robot.transfer_frequency_Hz"]),
    "more ticks than a run may have": ("duration_s = 60.0", "duration_s = 1e9", ["run.duration_s", "ticks"]),
    "name that leaves the folder": ('name = "ess"', 'name = "../ess"', ["name"]),
    "name with a line break": ('name = "ess"', 'name = "e\\nss"', ["name"]),
    "name of the wrong type": ('name = "ess"', "name = 3", ["name", "quotes"]),
    "description too long for a log": ("Solar generator", "Solar generator" * 500, ["description", "2000"]),
    "syntax error": ("dead_time_ms = 17.5", "dead_time_ms = = 17.5", []),
    "open bracket": ("[robot]", "[robot", []),
    "bracket alone": ("[robot]", "[\n[robot]", ["syntax"]),
    "open quotes": ('interpolation = "linear"', 'interpolation = "linear', []),
    "duplicate key": ("dead_time_ms = 17.5", "dead_time_ms = 17.5\ndead_time_ms = 20.0", ["dead_time_ms"]),
    "duplicate section": ("[object]", "[robot]\n[object]", ["robot"]),
}
# Where the error is noticed in a later line than the one that was changed.
LINES_LATER = {"unknown section": 1, "key outside sections": 0, "number for a boolean": 1, "probability above 1": 1,
               "filter without a robot to invert": 1, "duplicate key": 1, "duplicate section": 12,
               "bracket alone": 13}
NO_LINE = {"profile without a file"}  # the key that is wrong is not there


@pytest.mark.parametrize("case", FILES)
def test_rig_file(case, tmp_path):
    old, new, contains = FILES[case]
    assert old in ESS
    text = ESS.replace(old, new, 1)
    path = tmp_path / "bad.toml"
    path.write_text(text)
    out = tmp_path / "out"
    message = refused("run", path, "--out", out, "--json", contains=contains, out=out)
    line = line_of(text, new.split("\n")[0]) + LINES_LATER.get(case, 0)
    place = f"berth: {path}{' (default value)' if case in NO_LINE else f':{line}'}: "
    assert message.startswith(place), message
    for arguments in (["run", path, "--print-config"], ["deadtime", path, "--json"]):
        assert refused(*arguments) == message


def test_a_file_that_is_not_text(tmp_path):
    path = tmp_path / "noise.toml"
    path.write_bytes(random.Random(1).randbytes(1000))
    refused("run", path, contains=[f"{path}:1"])


@pytest.mark.parametrize("name, contains", [
    ("nosuchrig", ["nosuchrig", "no shipped rig", "ess-50hz"]),
    ("nosuch.toml", ["nosuch.toml", "cannot be read"]),
    ("no/such/file", ["no/such/file", "cannot be read"]),
    ("sim_hal", ["sim_hal", "cannot be read"]),
    ("/proc", ["/proc", "cannot be read"]),
    ("", ["no shipped rig"]),
])
def test_rig_that_is_not_there(name, contains, tmp_path):
    for subcommand in (["run", "--out", tmp_path / "out"], ["run", "--print-config"], ["deadtime"]):
        refused(*subcommand, name, contains=contains, out=tmp_path / "out")


# --- command line -------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("arguments, contains", [
    (["run", "ess", "--set", "robot.dead_time=1"], ["--set robot.dead_time=1", "robot.dead_time_ms"]),
    (["run", "ess", "--set", "dead_time_ms=1"], ["--set dead_time_ms=1", "robot.dead_time_ms"]),
    (["run", "ess", "--set", "robot.dead_time_ms"], ["--set robot.dead_time_ms", "section.key=value"]),
    (["run", "ess", "--set", "robot.dead_time_ms="], ["robot.dead_time_ms", "number"]),
    (["run", "ess", "--set", "robot.dead_time_ms=1 ms"], ["robot.dead_time_ms", "number", "1 ms"]),
    (["run", "ess", "--set", "robot.dead_time_ms=0x10"], ["robot.dead_time_ms", "number"]),
    (["run", "ess", "--set", "=1"], ["--set =1"]),
    (["run", "ess", "--set", "manipulator.mass_kg=-1"], ["manipulator.mass_kg", "greater than 0"]),
    (["run", "ess", "--set", "manipulator.mass_kg=nan"], ["manipulator.mass_kg", "finite"]),
    (["run", "ess", "--set", "manipulator.mass_kg=1e400"], ["manipulator.mass_kg"]),
    (["run", "ess", "--set", "loop.rate_Hz=7"], ["loop.rate_Hz", "5", "8"]),
    (["run", "ess", "--set", "bus.ideal=yes"], ["bus.ideal", "true or false"]),
    (["run", "ess", "--set", "solver.kind=exact"], ["solver.kind", "cvode"]),
    (["run", "ess", "--set"], ["--set"]),
    (["run", "ess", "--nonsense"], ["--nonsense", "--help"]),
    (["run", "ess", "another"], ["another", "--help"]),
    (["run"], ["RIG", "--help"]),
    (["replay"], ["LOG", "--help"]),
    (["candump"], ["LOG", "--help"]),
    (["deadtime"], ["RIG", "--help"]),
    (["frobnicate"], ["frobnicate", "there are run, replay, "]),
    ([], ["subcommand", "--help"]),
    (["--nonsense"], ["--help"]),
    (["run", "ess", "--no-log", "--set", "solver.kind=cvode", "--set", "solver.relative_tolerance=1e-300",
      "--set", "solver.absolute_tolerance_m=1e-300"], ["cvode", "solver.relative_tolerance"]),
])
def test_command_line(arguments, contains, tmp_path):
    out = ["--out", tmp_path / "out"] if arguments[:2] == ["run", "ess"] else []
    refused(*arguments[:2], *out, *arguments[2:], contains=contains, out=tmp_path / "out")


@pytest.mark.parametrize("arguments", [["--help"], ["run", "--help"], ["--version"]])
def test_asking_for_help_is_no_error(arguments):
    done = command(*arguments)
    assert done.returncode == EXIT_DONE and done.stderr == b"" and done.stdout


@pytest.mark.parametrize("arguments, contains", [
    (["eigen", "ess", "--seed", "-1"], ["--seed", "0 to 9223372036854775807"]),
    (["eigen", "ess", "--amplitude", ""], ["--amplitude"]),
    (["eigen", "ess", "--jitter", ""], ["--jitter", "needs a name"]),
    (["eigen", "ess", "--set", "object.hysteresis_force_N=10"],
     ["object.hysteresis_length_m", "is missing", "object.hysteresis_force_N"]),
    (["map", "ess", "--x", "robot.dead_time_ms=0.1:1:3", "--y", "object.mass_kg=50:60:2"],
     ["none of its points is a loop", "robot.dead_time_ms", "one period"]),
    (["map", "ess", "--vary", "mass", "--x-range", "100:200"], ["none of its points is a loop", "negative"]),
    (["limits", "ess", "--set", "manipulator.stiffness_N_per_m=0", "--set", "object.stiffness_N_per_m=0"],
     ["z = 1", "stiffness"]),
    (["map", "ess", "--x", "profile.amplitude_m=0.001:0.01:5", "--y", "object.mass_kg=50:100:4"],
     ["profile.amplitude_m", "--amplitude"]),
    (["limits", "ess", "--set", "object.cubic_stiffness_N_per_m3=-1e7", "--amplitude", "1e300"],
     ["at 1e+300 m", "no linear loop"]),
    *[([subcommand, "ess", "--set", "robot.dead_time_ms=1e5", *more], ["40007 eigenvalues", "robot.dead_time_ms"])
      for subcommand, more in (("eigen", []), ("limits", []), ("map", ["--vary", "mass"]))],
])
def test_stability_commands(arguments, contains, tmp_path):
    out = ["--out", tmp_path / "out"] if arguments[0] == "map" else []
    message = refused(*arguments, *out, contains=contains, out=tmp_path / "out")
    assert len(message) < 300


def test_a_map_that_memory_does_not_hold(tmp_path):
    done = subprocess.run(
        f"ulimit -v 700000; exec {ROOT}/build/berth map ess --vary mass --grid 20000x20000 --yes --out {tmp_path}/out",
        shell=True, capture_output=True, check=False, timeout=120)
    assert done.returncode == EXIT_INPUT and b"not enough memory" in done.stderr and done.stdout == b""


# --- folders and files --------------------------------------------------------------------------------------------
def test_folder_for_the_log_that_cannot_be_made(tmp_path):
    (tmp_path / "file").write_text("")
    for folder in (tmp_path / "file", tmp_path / "file" / "below", "/proc/nothing", "/dev/null/x"):
        refused("run", "ess", "--out", folder, "--json", contains=[str(folder), "--out"])
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_log_whose_place_is_taken_by_a_folder(tmp_path):
    (tmp_path / "ess.ulg").mkdir()
    refused("run", "ess", "--out", tmp_path, contains=["ess.ulg", "--out"])
    assert [path.name for path in tmp_path.iterdir()] == ["ess.ulg"]


def test_standard_output_that_is_full():
    with open("/dev/full", "wb") as full:
        import subprocess

        done = subprocess.run([ROOT / "build" / "berth", "rigs"], stdout=full, stderr=subprocess.PIPE, timeout=60)
    assert done.returncode == EXIT_INPUT and b"standard output" in done.stderr


PROFILES = {
    "no column t_s": ("time,x\n0,0\n1,1\n", ":1", ["t_s", "time, x"]),
    "two columns to choose from": ("t_s,x,y\n0,0,0\n1,1,1\n", ":1", ["profile.column"]),
    "nan": ("t_s,x\n0,0\n1,nan\n", ":3", ["nan", "finite"]),
    "inf": ("t_s,x\n0,0\n1,inf\n", ":3", ["inf", "finite"]),
    "no number": ("t_s,x\n0,0\n1,one\n", ":3", ["one", "finite"]),
    "empty cell": ("t_s,x\n0,0\n1,\n", ":3", ["finite"]),
    "decreasing time": ("t_s,x\n0,0\n2,1\n1,1\n", ":4", ["t_s", "increase"]),
    "repeated time": ("t_s,x\n0,0\n0,1\n", ":3", ["t_s", "increase"]),
    "missing cell": ("t_s,x\n0,0\n1\n", ":3", ["too few"]),
    "beyond what the loop takes": ("t_s,x\n0,0\n\n9,1e9\n", ":4", ["a position of 1e+09 m is beyond operator.position_limit_m = 2"]),
    "faster than the loop takes": ("t_s,x\n0,0\n0.001,1\n", ":3", ["1000 m/s is beyond operator.velocity_limit_m_per_s = 2"]),
    "one row": ("t_s,x\n0,0\n", "", ["two rows"]),
    "header only": ("t_s,x\n", "", ["two rows"]),
    "empty": ("", ":1", ["t_s"]),
}


@pytest.mark.parametrize("compressed", [False, True], ids=["csv", "csv.gz"])
@pytest.mark.parametrize("case", PROFILES)
def test_profile(case, compressed, tmp_path):
    text, place, contains = PROFILES[case]
    path = tmp_path / ("p.csv.gz" if compressed else "p.csv")
    path.write_bytes(gzip.compress(text.encode()) if compressed else text.encode())
    out = tmp_path / "out"
    message = refused("run", "ess", "--profile", path, "--out", out, "--json", contains=contains, out=out)
    assert message.startswith(f"berth: {path}{place}: ")


def test_profile_that_is_not_there_or_no_file_or_damaged(tmp_path):
    out = tmp_path / "out"
    refused("run", "ess", "--profile", tmp_path / "no.csv", "--out", out, out=out,
            contains=["no.csv", "cannot be read"])
    refused("run", "ess", "--profile", tmp_path, "--out", out, contains=[str(tmp_path), "cannot be read"], out=out)
    whole = gzip.compress("\n".join(["t_s,x", *(f"{i},{i % 7}" for i in range(5000))]).encode())
    (tmp_path / "cut.csv.gz").write_bytes(whole[: len(whole) // 2])
    refused("run", "ess", "--profile", tmp_path / "cut.csv.gz", "--out", out, contains=["cut.csv.gz"], out=out)
    for size in (len(whole) - 8, len(whole) - 1):  # all numbers are there, only the checksum is cut
        (tmp_path / "cut.csv.gz").write_bytes(whole[:size])
        refused("run", "ess", "--profile", tmp_path / "cut.csv.gz", "--out", out, contains=["cut.csv.gz"], out=out)
    (tmp_path / "bad.csv.gz").write_bytes(whole[:200] + bytes(100) + whole[300:])
    refused("run", "ess", "--profile", tmp_path / "bad.csv.gz", "--out", out, contains=["bad.csv.gz"], out=out)


def test_profile_column_that_is_not_there(tmp_path):
    (tmp_path / "p.csv").write_text("t_s,x,y\n0,0,0\n1,1,1\n")
    refused("run", "ess", "--profile", tmp_path / "p.csv", "--set", "profile.column=z", "--out", tmp_path / "out",
            contains=["p.csv:1", "z", "t_s, x, y"], out=tmp_path / "out")


# --- nonsense -----------------------------------------------------------------------------------------------------
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
