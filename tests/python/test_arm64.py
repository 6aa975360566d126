"""The firmware gives the same bits on arm64, under qemu-user.

Build first: make CROSS_COMPILE=aarch64-linux-gnu- build/aarch64-linux-gnu/replay build/aarch64-linux-gnu/berth-loop
"""

import re
import subprocess

import numpy as np
import pytest
from conftest import (ARM64_BUILD, DISTURBED, EXIT_DIFFERENT, ROOT, TICK, data_id, patched, record_type, replay_json,
                      run_json, settings, topic, ulog_messages, without_checksums)
from test_compensation import UNITS
from test_replay import VARIANTS

CASES = {
    "ess": ("ess", {}),
    "ess-50hz": ("ess-50hz", {}),
    "disturbed": ("ess", DISTURBED),
    **{variant: ("ess", VARIANTS[variant])
       for variant in ("rk4", "semi-implicit Euler", "inverse filter", "force interface with chirp", "limits act")},
    "contact": ("concept-copper", {}),
    "a whole arm": ("ess-berthing", {}),
    "the pose of a whole arm": ("ess-pose", {}),
    "a beam gripped along all axes": ("ess-berthing-pose", {}),
}


@pytest.mark.long
@pytest.mark.parametrize("case", CASES)
def test_a_log_from_here_replays_bit_for_bit_on_arm64(case, logs, arm64):
    result, log = logs(*CASES[case])
    replayed = replay_json(log, program=arm64)
    assert replayed["equal"] and replayed["ticks"] == result["ticks"] and not replayed["gap"]


@pytest.mark.long
@pytest.mark.parametrize("case", CASES)
def test_a_log_from_arm64_replays_bit_for_bit_here(case, tmp_path, arm64):
    rig, overrides = CASES[case]
    result = run_json(rig, tmp_path, *settings(overrides), program=arm64)
    replayed = replay_json(result["log"])
    assert replayed["equal"] and replayed["ticks"] == result["ticks"] and not replayed["gap"]


@pytest.mark.parametrize("rig", ["ess", "concept-copper"])
@pytest.mark.parametrize("unit", UNITS)
def test_compensation_replays_bit_for_bit_on_arm64(unit, rig, tmp_path, arm64):
    result = run_json(rig, tmp_path, *settings(UNITS[unit] | {"run.duration_s": 5.0, "sensor.noise_N": 1.0}))
    replayed = replay_json(result["log"], program=arm64)
    assert replayed["equal"] and replayed["ticks"] == result["ticks"]


@pytest.mark.parametrize("rig", ["ess", "ess-50hz"])
def test_the_simulated_rig_may_round_differently_there_and_no_more(rig, logs, tmp_path, arm64):
    """Its matrices come from libm and vectorised code; the motion agrees to what frames resolve."""
    here, log = logs(rig)
    there = run_json(rig, tmp_path, program=arm64)
    assert there["config_hash"] == here["config_hash"]
    difference_m = topic(there["log"])["manipulator_position_m"] - topic(log)["manipulator_position_m"]
    assert np.abs(difference_m).max() < 1e-10


def test_a_difference_is_found_there_too(logs, tmp_path, arm64):
    data = without_checksums(logs("ess", {"run.duration_s": 1.0})[1].read_bytes())
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


FUNCTION = re.compile(r"^[0-9a-f]+ <(.+)>:$")
BRANCH = re.compile(r"\s(?:call|jmp|j\w+|bl|b|b\.\w+|cbn?z|tbn?z)\s.*<([^>+]+)(?:\+0x[0-9a-f]+)?>")
INDIRECT = re.compile(r"\s(?:call\s+\*|blr\s)")
# Where a function calls through a pointer: parts of the (mangled) names of all that it may call.
LAYOUTS = ("decode_force", "decode_wrench2i_force", "decode_wrench2i_torque", "decode_wrench2m_force",
           "decode_wrench2m_torque", "decode_wrench3i_fx_fy", "decode_wrench3i_fz_tx", "decode_wrench3i_ty_tz",
           "decode_wrench3m_x", "decode_wrench3m_y", "decode_wrench3m_z", "decode_wrench2u_force",
           "decode_wrench2u_torque", "decode_wrench2s_first", "decode_wrench2s_second")
DRIVE_SETUP = ("node_id", "heartbeat_ms", "our_heartbeat", "life_time_factor", "period_us", "interpolation_time",
               "interpolation_index", "encoder_counts", "encoder_revolutions", "gear_motor_revolutions",
               "gear_shaft_revolutions", "feed_counts", "feed_shaft_revolutions", "polarity", "homing_method")
THROUGH_POINTERS = {"manipulator_step": ("rk4", "semi_implicit_euler"), "app_step": LAYOUTS + DRIVE_SETUP,
                    "receive_frames": LAYOUTS, "receive_frame": LAYOUTS, "sensor_channel_receive": LAYOUTS,
                    "command_robot": DRIVE_SETUP, "robot_channel_send": DRIVE_SETUP,
                    "cia402_setup_step": DRIVE_SETUP, "value_of": DRIVE_SETUP}
# Neither do functions that move bytes and know nothing of numbers.
DEAD_ENDS = re.compile(r"^(__assert_fail|abort|__stack_chk_fail|_Unwind_Resume|__cxa_\w+|mem(set|cpy|move))(@|$)")


def reachable(program, objdump, roots):
    """Code that the linked program can get to from these functions: {function: lines}. The linker has optimised across
    files, so that the objects hold no code. Failed assertions end the program and are not followed."""
    functions, lines = {}, []
    for line in tool(objdump, "-d", "--no-show-raw-insn", program).splitlines():
        if match := FUNCTION.match(line):
            lines = functions.setdefault(match[1], [])
        elif line.strip():
            lines.append(line)
    found, waiting = {}, list(roots)
    while waiting:
        name = waiting.pop()
        if name not in found and not DEAD_ENDS.match(name):
            found[name] = functions.get(name, [])
            waiting += [match[1] for line in found[name] if (match := BRANCH.search(line))]
            for part in THROUGH_POINTERS.get(name, ()):
                called = [other for other in functions if re.search(rf"(\d|^){part}(\D|$)", other)]
                assert called, f"{part} is not in the program"
                waiting += called
    return found


@pytest.mark.long
@pytest.mark.parametrize("build, prefix, fused, program", [
    (ROOT / "build", "", FUSED_X86, "berth"),
    (ROOT / "build", "", FUSED_X86, "berth-loop"),
    pytest.param(ARM64_BUILD, "aarch64-linux-gnu-", FUSED_A64, "replay", marks=pytest.mark.arm64),
    pytest.param(ARM64_BUILD, "aarch64-linux-gnu-", FUSED_A64, "berth-loop", marks=pytest.mark.arm64),
])
def test_no_fused_multiply_add_and_no_libm_in_the_step(program, build, prefix, fused):
    code = reachable(build / program, prefix + "objdump", ["app_start", "app_step"])
    assert code["app_step"] and code["app_start"]
    multiplications = 0
    for name, lines in code.items():
        assert not LIBM.match(name.removeprefix("__").split("@")[0]), f"{name} is called"
        found = [line.strip() for line in lines if fused.search(line + " ")]
        assert not found, f"{name}: {found[:3]}"
        indirect = [line.strip() for line in lines if INDIRECT.search(line)]
        assert not indirect or name in THROUGH_POINTERS, f"{name}: {indirect[:3]}: where this leads is not known here"
        multiplications += sum(bool(re.search(r"\s(fmul|v?mulsd)\s", line)) for line in lines)
    print(f"{len(code)} functions, {multiplications} multiplications: {', '.join(sorted(code))}")
    assert multiplications > 50  # it was the arithmetic that was read


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
