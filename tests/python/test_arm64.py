"""The firmware gives the same bits on arm64, under qemu-user.

Build first: make CROSS_COMPILE=aarch64-linux-gnu- all
"""

import re
import subprocess

import numpy as np
import pytest
from conftest import (ARM64_BUILD, DISTURBED, EXIT_DIFFERENT, ROOT, TICK, data_id, patched, record_type, replay_json,
                      run_json, settings, topic, ulog_messages)
from test_replay import VARIANTS

CASES = {
    "ess": ("ess", {}),
    "ess-50hz": ("ess-50hz", {}),
    "disturbed": ("ess", DISTURBED),
    **{variant: ("ess", VARIANTS[variant])
       for variant in ("rk4", "semi-implicit Euler", "inverse filter", "force interface with chirp", "limits act")},
    "contact": ("concept-copper", {}),
}


@pytest.mark.parametrize("case", CASES)
def test_a_log_from_here_replays_bit_for_bit_on_arm64(case, logs, arm64):
    result, log = logs(*CASES[case])
    replayed = replay_json(log, program=arm64)
    assert replayed["equal"] and replayed["ticks"] == result["ticks"] and not replayed["gap"]


@pytest.mark.parametrize("case", CASES)
def test_a_log_from_arm64_replays_bit_for_bit_here(case, tmp_path, arm64):
    rig, overrides = CASES[case]
    result = run_json(rig, tmp_path, *settings(overrides), program=arm64)
    replayed = replay_json(result["log"])
    assert replayed["equal"] and replayed["ticks"] == result["ticks"] and not replayed["gap"]


@pytest.mark.parametrize("rig", ["ess", "ess-50hz"])
def test_the_simulated_rig_may_round_differently_there_and_no_more(rig, logs, tmp_path, arm64):
    """Its matrices come from libm and vectorised code; growth and motion agree to what frames resolve."""
    here, log = logs(rig)
    there = run_json(rig, tmp_path, program=arm64)
    assert there["config_hash"] == here["config_hash"]
    assert there["growth_per_s"] == pytest.approx(here["growth_per_s"], rel=1e-4)
    difference_m = topic(there["log"])["manipulator_position_m"] - topic(log)["manipulator_position_m"]
    assert np.abs(difference_m).max() < 1e-10


def test_a_difference_is_found_there_too(logs, tmp_path, arm64):
    data = logs("ess", {"run.duration_s": 1.0})[1].read_bytes()
    tick = [message for message in ulog_messages(data) if data_id(message) == TICK][123]
    (tmp_path / "x.ulg").write_bytes(
        patched(data, tick, record_type(data, "tick"), "force_N", lambda value: np.nextafter(value, 1e9)))
    difference = replay_json(tmp_path / "x.ulg", EXIT_DIFFERENT, program=arm64)["first_difference"]
    assert (difference["tick"], difference["field"]) == (123, "force_N")


# --- what could make the bits differ ------------------------------------------------------------------------------
# Every fused floating-point instruction of A64, SIMD included: FMADD, FMSUB, FNMADD, FNMSUB, FMLA, FMLS, FCMLA, ...
FUSED_A64 = re.compile(r"\s(fn?m(add|sub|la|ls)\w*|fcmla|bf?fmla\w*|fmlal\w*|fmlsl\w*)\s")
FUSED_X86 = re.compile(r"\svf(n?m(add|sub)|maddsub|msubadd)\w*\s")
LIBM = re.compile(r"^(a?(sin|cos|tan)h?|sincos|atan2|exp(2|10|m1)?|log(2|10|1p|b)?|pow|sqrt|cbrt|hypot|fma|fmod|"
                  r"remainder|remquo|floor|ceil|l?l?round|trunc|l?l?rint|nearbyint|fmin|fmax|fdim|fabs|copysign|"
                  r"frexp|ldexp|scalbl?n|modf|ilogb|nextafter|tgamma|lgamma|erfc?)[fl]?$")


def tool(*words):
    """The output of a binary tool."""
    return subprocess.run(words, cwd=ROOT, capture_output=True, check=True, timeout=120).stdout.decode()


def firmware_objects(build):
    """The object files of the step: all of the firmware but its main()."""
    objects = [path for path in sorted((build / "obj" / "firmware").rglob("*.o")) if path.name != "main.c.o"]
    sources = [path for path in (ROOT / "firmware").rglob("*.c*") if path.suffix in (".c", ".cpp")]
    assert {path.name for path in objects} >= {path.name + ".o" for path in sources if path.name != "main.c"}
    return objects


@pytest.mark.parametrize("build, prefix, fused", [
    (ROOT / "build", "", FUSED_X86),
    pytest.param(ARM64_BUILD, "aarch64-linux-gnu-", FUSED_A64, marks=pytest.mark.arm64),
], ids=["x86-64", "arm64"])
def test_no_fused_multiply_add_and_no_libm_in_the_step(build, prefix, fused):
    multiplications = 0
    for path in firmware_objects(build):
        code = tool(prefix + "objdump", "-d", "--no-show-raw-insn", path)
        found = [line.strip() for line in code.splitlines() if fused.search(line + " ")]
        assert not found, f"{path.name}: {found[:3]}"
        multiplications += len(re.findall(r"\s(fmul|v?mulsd)\s", code))
        needed = [line.split()[-1].split("@")[0] for line in tool(prefix + "nm", "-u", path).splitlines()]
        assert not [name for name in needed if LIBM.match(name)], f"{path.name}: {needed}"
    assert multiplications > 20  # the disassembly was really read


@pytest.mark.arm64
def test_the_patterns_would_find_what_they_look_for(tmp_path):
    """The same expression with contraction allowed, and a call of libm."""
    source = tmp_path / "fused.c"
    source.write_text("double floor(double); double f(double a, double b, double c) { return a * b + c; }\n"
                      "double g(double a) { return floor(a); }\n")
    for compiler, flags, fused in (("gcc", ["-mfma"], FUSED_X86), ("aarch64-linux-gnu-gcc", [], FUSED_A64)):
        prefix = compiler.removesuffix("gcc")
        target = tmp_path / (prefix + "fused.o")
        tool(compiler, "-O2", "-ffp-contract=fast", "-fno-builtin", *flags, "-c", source, "-o", target)
        assert fused.search(tool(prefix + "objdump", "-d", "--no-show-raw-insn", target))
        assert LIBM.match(tool(prefix + "nm", "-u", target).split()[-1])
