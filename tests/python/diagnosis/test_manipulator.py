"""The manipulator, whose command and driving force are measured: causes below what a regression errs, rounding, a force
that moved between the rows, friction."""

import tomllib
from functools import partial

import numpy as np
import pytest
from checks import (Between, at, causes, check, interval, named, near, no_note, note, size, verdict,
                    width)
from conftest import EXIT_DONE, EXIT_INPUT, command
from make_manipulator import (FRICTION_N, asymmetric_N, constant_N, cubic_N, driven, ess_pushed, guided, moves, oscillation,
                              pushed, quadratic_N, rubbing_more_one_way, rubbing_with_an_offset, scaled_push, shaken,
                              slow_record, slowly_shaken, sticks_and_slides, written)
from table import Row, each

FIT = "residual.command_position_m.fit"

# --- commands with many digits ------------------------------------------------------------------------------------
STEP_m = 1e-11
SMOOTH = {"manipulator.asymmetric_friction": (asymmetric_N, "damping_asymmetry_N_s_per_m", 20.0),
          "manipulator.cubic_stiffness": (cubic_N, "cubic_stiffness_N_per_m3", 2e6),
          "manipulator.quadratic_stiffness": (quadratic_N, "quadratic_stiffness_N_per_m2", 5e4)}
SMALL = {"manipulator.gravity_offset": (constant_N, "gravity_offset_N", 5e-3, -5e-3),
         "manipulator.asymmetric_friction": (asymmetric_N, "damping_asymmetry_N_s_per_m", 2e-2, 2e-2),
         "manipulator.cubic_stiffness": (cubic_N, "cubic_stiffness_N_per_m3", 5e2, 5e2),
         "manipulator.quadratic_stiffness": (quadratic_N, "quadratic_stiffness_N_per_m2", 10.0, 10.0)}
KNOWN = f"coulomb_friction_N = {FRICTION_N}\n"


@check
def leaves_no_more_than_its_floor(told):
    fit = told.at(FIT)
    assert fit["floor"] == near(STEP_m / np.sqrt(12.0), rel=0.1)
    assert fit["retuned"] == near(fit["floor"], rel=0.1)


@check
def interval_within_2_percent(told, name, true):
    low, high = sorted(told.parameter(name)["ci95"], key=abs)
    assert abs(low) < abs(true) < abs(high) < 1.02 * abs(low)


@check
def less_than_a_ten_thousandth_of_what_it_moves(told, seed):
    rough = Row("rough", pushed(moves=sticks_and_slides, seed=seed)).told(told.out.with_name("rough"))
    assert told.at(f"{FIT}.after") < 1e-4 * rough.at(f"{FIT}.retuned")


PRECISE = [
    # The floor that was estimated beside the rig as given is far above what is left of the one that fits.
    *[Row(f"all parameters {scale} of those given leave rounding alone",
          pushed(moves=partial(moves, scale=scale), step_m=STEP_m), verdict("nothing_detectable"),
          leaves_no_more_than_its_floor()) for scale in (1.0, 0.97, 1.03)],
    *[Row(f"{effect} in steps of 1 nm", pushed(moves=partial(moves, law=law, scale=1.02), step_m=1e-9), named(effect),
          interval(name, true), width(name, less_than=1e-3 * true)) for effect, (law, name, true) in SMOOTH.items()],
    # Forces of a ten thousandth of the push and less.
    *[Row(f"{effect} that is less than a regression errs", guided(law=partial(law, size=given)), named(effect),
          interval_within_2_percent(name, true)) for effect, (law, name, given, true) in SMALL.items()],
    *[Row(f"dry friction that catches between steps, seed {seed}",
          pushed(moves=sticks_and_slides, seed=seed, step_m=1e-9), named("manipulator.coulomb_friction"),
          interval("coulomb_friction_N", FRICTION_N), width("coulomb_friction_N", less_than=2e-3 * FRICTION_N),
          slow=seed > 3) for seed in (3, 4, 5)],
    Row("dry friction that the rig knows", pushed(moves=sticks_and_slides, more=KNOWN), verdict("nothing_detectable")),
    *[Row(f"dry friction that the rig knows leaves next to nothing, seed {seed}",
          pushed(moves=sticks_and_slides, seed=seed, more=KNOWN), verdict("nothing_detectable"),
          less_than_a_ten_thousandth_of_what_it_moves(seed), slow=seed > 4) for seed in (4, 5)],
]

# --- forces with few digits ---------------------------------------------------------------------------------------
DIGITS = [
    *[Row(f"forces written as {digits}", written(digits=digits), verdict("nothing_detectable"),
          note("written are", f"operator_force_N to {unit} N"), at(f"{FIT}.after", Between(low=1e-9)))
      for digits, unit in (("%.2f", "0.01"), ("%.3f", "0.001"), ("%.4g", "0.01"))],
    Row("forces with all digits need no word", written(digits="%.12g"), verdict("nothing_detectable"), no_note("written are")),
    Row("a cause beside few digits", written(digits="%.3f", friction_N=2.0), named("manipulator.coulomb_friction"),
        at("causes.0.parameters.0.value", near(2.0, rel=0.01))),
]

# --- a force that may have moved between the rows -----------------------------------------------------------------
MOVES = "counts as moving on between them"


@check
def extended_rig_runs(told):
    done = command("run", told.out / "extended.toml", "--no-log", "--json")
    assert done.returncode == EXIT_DONE, done.stderr.decode()


def between_the_rows(is_moving, cubic_N_per_m3, slow):
    found = [named("manipulator.cubic_stiffness"), at("causes.0.parameters.0.value", near(cubic_N_per_m3, rel=0.005))]
    return Row(f"a force that {'moves' if is_moving else 'is held'} between the rows, cubic {cubic_N_per_m3}",
               shaken(moves=is_moving, cubic_N_per_m3=cubic_N_per_m3), note(MOVES) if is_moving else no_note(MOVES),
               at("residual.command_position_m.held_out.after", near(1e-5, rel=0.1)),
               *(found if cubic_N_per_m3 else [verdict("nothing_detectable")]), slow=slow)


MOVING = [
    *[Row(f"a drive with friction, one row in {every}", driven(every=every), note(MOVES) if every > 1 else no_note(MOVES),
          size("coulomb_friction_N", near(30.0, rel=0.02 if every > 1 else 0.005))) for every in (1, 10)],
    Row("a slow record needs no robot that suits it", slow_record(), verdict("nothing_detectable"),
        note("the record does not show the robot"), extended_rig_runs()),
    *[between_the_rows(is_moving, cubic, slow=not is_moving) for is_moving in (True, False) for cubic in (0.0, 3e7)],
    *[Row(f"a slow force that {'moves' if is_moving else 'is held'} shows where the noise is small",
          slowly_shaken(moves=is_moving), verdict("nothing_detectable"), note(MOVES) if is_moving else no_note(MOVES),
          at(f"{FIT}.after", near(1e-6, rel=0.1))) for is_moving in (True, False)],
]

# --- friction, forces that are scaled, and a rate that the rig does not state -------------------------------------
THREE_TONES, TWO_TONES = ((60.0, 1.7), (40.0, 4.9), (30.0, 11.3)), ((60.0, 1.7), (40.0, 4.9))
RATE_Hz = 610.35


@check
def no_cause_is_its_own_rival(told):
    """Dry friction, found second, had been a rival of the offset that was found first."""
    one = told.block("manipulator")
    found = [cause["effect"] for cause in one["causes"]]
    assert "manipulator.coulomb_friction" in found
    assert not set(found) & {other["effect"] for other in one["alternatives"]}


@check
def rig_files_have_the_rate(told):
    for name in ("given.toml", "extended.toml"):
        assert tomllib.loads((told.out / name).read_text())["loop"]["rate_Hz"] == near(RATE_Hz, rel=1e-6)
    assert command("eigen", told.out / "extended.toml").returncode == EXIT_DONE


MORE = [
    Row("forces that are all scaled may be the force's scale", scaled_push(), causes("manipulator.parameters"),
        note("forces that are all", "known weight")),
    # Without dry friction, beside which it had been looked for alone.
    Row("friction that differs between the directions by itself",
        ess_pushed(tones=THREE_TONES, pull=rubbing_more_one_way, steps=20, noise_m=1e-5),
        named("manipulator.asymmetric_friction"), size("damping_asymmetry_N_s_per_m", near(60.0, rel=0.01))),
    Row("a cause is no rival of itself", ess_pushed(tones=TWO_TONES, pull=rubbing_with_an_offset, steps=50, noise_m=1e-6),
        no_cause_is_its_own_rival(), slow=True),
    Row("a rig file without a rate takes the record's", oscillation(), note("610.35", "the rig file states none"),
        causes("manipulator.parameters"), size("stiffness_N_per_m", near(1.0, rel=2e-3)), rig_files_have_the_rate()),
]


@pytest.mark.long
def test_the_rate_that_is_asked_for_is_taken(tmp_path):
    """A record at another rate is refused with the words that make it work."""
    row = Row("", oscillation(rate="[loop]\nrate_Hz = 625"))
    refused = command(*row.command(tmp_path / "out"))
    assert refused.returncode == EXIT_INPUT
    asked_for = refused.stderr.decode().split("say ")[1].split()
    assert float(asked_for[1].removeprefix("loop.rate_Hz=")) == near(RATE_Hz, rel=1e-6)
    row.options = tuple(asked_for[:2])
    assert row.told(tmp_path / "out").causes == ["manipulator.parameters"]


@pytest.mark.long
@each(PRECISE + DIGITS + MOVING + MORE)
def test_manipulator(row, tmp_path):
    row.check(tmp_path / "out")
