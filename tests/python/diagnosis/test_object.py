"""The object and the force upon it: what relaxes, rings or is bent, setpoints that the contact feels, and records without
setpoints."""

import re

import numpy as np
import pytest
from checks import (Between, at, causes, check, doubt, interval, named, near, no_note, not_verdict, nothing, size,
                    verdict)
from conftest import EXIT_DONE, command
from make_chain import FORCE_NOISE_N, RESONANCE_Hz, lossy_before_resonance
from make_object import (HELD, NOISE_N, SOFT, SPECIMEN_NOISE_N, SPECIMEN_ROWS, behind_a_bent_way, cubic_N, dahl_N, lagging,
                         lossy_on_foam, parts_that_ring, relaxing, specimen, touched)
from scipy.interpolate import CubicSpline
from table import Refused, Row, each

PART = ("partly_explained", "unknown")


# --- what the library lacks ---------------------------------------------------------------------------------------
@check
def no_cause_makes_the_error_larger(told):
    for one in told.found["blocks"]:
        fit = one["residual"]["fit"]
        assert fit["after"] < 1.05 * fit["retuned"], one["block"]


# An object that relaxes is to its force what a sensor that lags is before another damping and mass.
RELAXING = [(3, 6000.0, 20.0, 1500.0, 0.03, 55.0), (1, 4000.0, 15.0, 800.0, 0.025, 33.0),
            (2, 6000.0, 20.0, 600.0, 0.05, 45.0)]
LACKING = [
    *[Row(f"an object that relaxes in {tau_s} s is not named",
          touched(seed=seed, law=relaxing(k, d, k1, tau_s), stiffness_N_per_m=1.03 * k, damping_N_s_per_m=given_d),
          verdict("partly_explained", "unknown", "one_of"), slow=seed != 1) for seed, k, d, k1, tau_s, given_d in RELAXING],
    *[Row(f"a sensor that lags by {tau_s} s is",
          touched(seed=seed, law=lagging(4000.0, 35.0, tau_s), stiffness_N_per_m=4100.0, damping_N_s_per_m=33.0),
          named("sensor.lag"), slow=seed != 4) for seed, tau_s in ((4, 0.012), (5, 0.03))],
    Row("a sensor that lags is before another damping too",
        touched(seed=6, law=lagging(4000.0, 80.0, 0.03), stiffness_N_per_m=4100.0, damping_N_s_per_m=33.0),
        named("object.parameters", "sensor.lag")),
    # Other damping than the rig's lowers the error.
    Row("what rings for longer than the parts last is not named", parts_that_ring(), not_verdict("named", "one_of"),
        given=SOFT | HELD),
    # Slow noise is taken to be in the force.
    *[Row(f"behind a robot that bends its way by {bend_per_m2}/m2, seed {seed}",
          behind_a_bent_way(bend_per_m2=bend_per_m2, seed=seed), verdict(*PART), no_cause_makes_the_error_larger(),
          slow=(bend_per_m2, seed) != (8.0, 4)) for bend_per_m2, seed in ((8.0, 4), (8.0, 3), (20.0, 3))],
]


# --- setpoints that are lost --------------------------------------------------------------------------------------
@check
def interval_holds_the_lost_share(told):
    low, high = told.parameter("lost_command_probability")["ci95"]
    assert low < told.truth["lost_share"] < high


@check
def interval_holds_it_or_part(told):
    """A loss in twenty rings into the next ones, and not all are told from each other."""
    is_named = "robot.lost_commands" in told.causes
    low, high = told.parameter("lost_command_probability")["ci95"] if is_named else (0.0, 0.0)
    assert "robot.resonance" in told.causes
    assert low < told.truth["lost_share"] < high or told.verdict == "partly_explained"


@check
def resonance_is_at(told, frequency_Hz):
    assert told.cause("robot.resonance")["parameters"][0]["value"] == near(frequency_Hz, rel=0.005)


@check
def rounding_explains_no_share(told):
    """No replay tells what it does: the next row is rounded as it comes."""
    [cause] = told.found["causes"]
    assert cause["effect"] == "sensor.quantisation" and cause["share_explained"] is None


@check
def named_or_doubted(told):
    """The smallest of so many are not found, and something small may stand in for them, which is said."""
    assert told.verdict == "named" or told.block("robot")["doubts"]


@check
def lost_share_is_told(told, rows=12000):
    share, made_N2, of_robot = (told.truth[name] for name in ("lost_share", "made_N2", "of_robot"))
    loss = told.cause("robot.lost_commands")
    explained = loss["share_explained"]
    if loss["shown_by"] == "robot":
        assert abs(explained - of_robot) < 0.05
    else:  # below the noise of its reports
        rms = told.at("residual.force_N.fit")
        told_N2 = explained * (rms["before"]**2 - rms["floor"]**2)
        by_noise_N2 = 2 * NOISE_N * np.sqrt(made_N2 / rows)
        assert abs(told_N2 - made_N2) < 0.15 * made_N2 + 3 * by_noise_N2
    low, high = loss["parameters"][0]["ci95"]
    middle, half = (low + high) / 2, (high - low) / 2
    assert abs(middle - share) < 1.5 * half  # a draw in 300 is further off
    assert half < max(share, 0.01)


def lossy(seed, lost_share, lag_ms, slow):
    if lost_share < 0.06:
        found = named(*["robot.lost_commands"] + ["robot.lag"] * (lag_ms > 0.0))
    else:
        found = named_or_doubted()
    return Row(f"{lost_share:.0%} lost before foam, lag of {lag_ms} ms, seed {seed}",
               lossy_on_foam(seed=seed, lost_share=lost_share, lag_ms=lag_ms), found, lost_share_is_told(),
               *[interval("lag_ms", lag_ms, wider=1.0)] * (lag_ms > 0.0), rig="concept-foam", slow=slow)


FOAMS = [(0.02, 0.0), (0.08, 0.0), (0.02, 10.0), (0.05, 10.0)]
LOST = [
    Row("nothing lost before foam", lossy_on_foam(seed=1, lost_share=0.0, lag_ms=0.0), verdict("nothing_detectable"),
        rig="concept-foam"),
    Row("a force in steps of 1 N", lossy_on_foam(seed=2, lost_share=0.0, lag_ms=0.0, force_step_N=1.0),
        rounding_explains_no_share(), rig="concept-foam"),
    *[lossy(seed, *case, slow=seed == 12 or case == FOAMS[3]) for seed in (11, 12) for case in FOAMS],
    Row("a resonance without losses", lossy_before_resonance(seed=21, lost_share=0.0), named("robot.resonance"),
        resonance_is_at(RESONANCE_Hz)),
    *[Row(f"losses before a resonance, seed {seed}", lossy_before_resonance(seed=seed, lost_share=0.02),
          named("robot.lost_commands", "robot.resonance"), interval_holds_the_lost_share(),
          resonance_is_at(RESONANCE_Hz), at("residual.force_N.fit.after", Between(high=1.5 * FORCE_NOISE_N)),
          slow=True) for seed in (22, 23)],
    Row("of many losses before a resonance no share is told without a doubt",
        lossy_before_resonance(seed=24, lost_share=0.05), interval_holds_it_or_part(), slow=True),
]


# --- the measured motion of a test machine ------------------------------------------------------------------------
@check
def says_that_the_motion_drives(told):
    assert any("robot_position_m drives the force" in note for note in told.found["notes"])
    assert [one["block"] for one in told.found["blocks"]] == ["force"]


@check
def leaves_and_extends_the_motion(told):
    header = (told.out / "series.csv").read_text().splitlines()[0]
    assert "robot_position_m" in header and "command_position_m" not in header
    extended = command("run", told.out / "extended.toml", "--no-log", "--json")
    assert extended.returncode == EXIT_DONE, extended.stderr.decode()


@check
def no_robot_is_detectable(told):
    assert not any(size["effect"].startswith("robot.") for size in told.found["detectable"])


@check
def noise_of_the_motion_is_told(told, noise_m):
    """What it makes of the force and the noise of the sensor are all that is left; a spline through the noise as well as
    through the motion would leave several times as much."""
    spline = CubicSpline(np.arange(SPECIMEN_ROWS) / 200.0, noise_m * np.random.default_rng(5).standard_normal(SPECIMEN_ROWS))
    unsmoothed_N = np.std(8000.0 * spline(spline.x) + 60.0 * spline(spline.x, 1))
    found = [re.search(r"noise of (\S+) m from row to row: .* is (\S+) N rms of the (\S+) N", note)
             for note in told.found["notes"]]
    [match] = [match for match in found if match]
    assert float(match[1]) == near(noise_m, rel=0.05)
    assert float(match[3]) == near(np.hypot(SPECIMEN_NOISE_N, float(match[2])), rel=0.05)
    assert float(match[2]) < unsmoothed_N / 3


SPECIMEN = [
    Row("of a spring and a damper only noise is left", specimen(), says_that_the_motion_drives(), nothing(),
        at("residual.force_N.held_out.after", near(SPECIMEN_NOISE_N, rel=0.05)), no_robot_is_detectable(),
        no_note("from row to row")),
    *[Row(f"a cubic spring in measured motion with {noise_m} m of noise", specimen(law=cubic_N, noise_m=noise_m),
          says_that_the_motion_drives(), named("object.cubic_stiffness"), size("cubic_stiffness_N_per_m3", near(5e6, rel=0.02)),
          interval("cubic_stiffness_N_per_m3", 5e6, wider=0.2), leaves_and_extends_the_motion())
      for noise_m in (0.0, 1e-6)],
    Row("hysteresis in measured motion", specimen(law=dahl_N), says_that_the_motion_drives(), named("object.hysteresis"),
        size("hysteresis_force_N", near(6.0, rel=0.02)), interval("hysteresis_force_N", 6.0, wider=0.2),
        size("hysteresis_length_m", near(8e-4, rel=0.02)), interval("hysteresis_length_m", 8e-4, wider=0.2),
        leaves_and_extends_the_motion(), slow=True),
    # Through the damper the noise as it was measured would be 0.08 N.
    Row("noise of 5 um in the motion makes no cause", specimen(law=cubic_N, noise_m=5e-6), says_that_the_motion_drives(),
        named("object.cubic_stiffness"), size("cubic_stiffness_N_per_m3", near(5e6, rel=0.02)), no_note("from row to row")),
    Row("what noise of 50 um in the motion makes of the force", specimen(noise_m=5e-5), says_that_the_motion_drives(),
        noise_of_the_motion_is_told(5e-5)),
    Refused("a motion alone", specimen(has_force=False), "robot_position_m with force_N"),
]


@pytest.mark.long
@each(LACKING + LOST + SPECIMEN)
def test_object(row, tmp_path):
    row.check(tmp_path / "out")
