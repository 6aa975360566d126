"""`berth eigen`, `berth limits` and the prediction of `berth run`, from outside."""

import json
import math
import sys
import time

import numpy as np
import pytest
from conftest import EXIT_INPUT, ROOT, command, one_json_object, run_json, settings

sys.path.insert(0, str(ROOT / "scripts"))
from loop_matrix import Loop, loop_matrices  # noqa: E402

# Largest |z| of the one-period map, by an independent program from the definitions.
REFERENCE = {"ess": 0.999254356, "ess-50hz": 0.994238761, "ess-half-dead-time": 0.999298199}


def ask(subcommand, rig, values=None):
    """`berth SUBCOMMAND RIG --json`: the object."""
    done = command(subcommand, rig, "--json", *settings(values or {}))
    assert done.returncode == 0, done.stderr.decode()
    return one_json_object(done.stdout)


@pytest.mark.parametrize("rig", REFERENCE)
def test_reference_values_to_nine_digits(rig):
    told = ask("eigen", rig)
    print(f"{rig}: |z| = {told['spectral_radius']:.12f}, reference {REFERENCE[rig]}")
    assert round(told["spectral_radius"], 9) == REFERENCE[rig]
    assert told["stable"] is True
    period_s = 0.02 if rig == "ess-50hz" else 0.0025
    assert told["growth_per_s"] == pytest.approx(math.log(told["spectral_radius"]) / period_s, rel=1e-12)


@pytest.mark.parametrize("rig", REFERENCE)
def test_eigenvalues_come_by_falling_magnitude_and_in_pairs(rig):
    told = ask("eigen", rig)
    z = np.array([complex(*pair) for pair in told["eigenvalues"]])
    assert (np.diff(np.abs(z)) <= 0.0).all()
    assert abs(z[0]) == told["spectral_radius"]
    assert np.allclose(np.sort_complex(z), np.sort_complex(z.conj()))


@pytest.mark.long
@pytest.mark.parametrize("rig, values", [
    ("ess", {}), ("ess-50hz", {}), ("ess", {"object.stiffness_N_per_m": 23687}),
    ("ess", {"robot.transfer_frequency_Hz": 12, "robot.interpolation": "hold", "sensor.low_pass_order": 1}),
])
def test_at_each_limit_the_largest_eigenvalue_has_magnitude_1_and_is_the_mode_named(rig, values):
    limits = ask("limits", rig, values)
    at_limits = 0
    for key, parameter in limits["parameters"].items():
        for side in ("below", "above"):
            limit = parameter[side]
            if limit is None or limit["jump"]:
                continue
            told = ask("eigen", rig, {**values, key: repr(limit["value"])})
            z = complex(*told["eigenvalues"][0])
            assert abs(z) == pytest.approx(1.0, abs=1e-9), (key, side)
            rate_Hz = next(r["rate_Hz"] for r in limits["rates"] if r["rate_Hz"] == (50 if rig == "ess-50hz" else 400))
            assert abs(np.angle(z)) * rate_Hz / (2 * np.pi) == pytest.approx(limit["frequency_Hz"], rel=1e-4)
            # Six digits of the limit are right: a millionth to either side decides.
            for factor in (1 - 1e-6, 1 + 1e-6):
                is_stable = ask("eigen", rig, {**values, key: repr(limit["value"] * factor)})["growth_per_s"] < 0
                assert is_stable is ((factor > 1) == (limit["stable"] == "above")), (key, side)
            at_limits += 1
    print(f"{rig} {values}: {at_limits} limits checked")
    assert at_limits >= 5


@pytest.mark.long
def test_stable_intervals_hold_what_eigenvalues_say():
    parameter = ask("limits", "ess-50hz")["parameters"]["object.mass_kg"]
    intervals = parameter["stable_intervals"]
    print(f"50 Hz, object mass: {intervals}")
    assert len(intervals) > 1
    low, high = parameter["range"]
    for mass_kg in np.geomspace(low * 1.01, high * 0.99, 60):
        inside = any(start < mass_kg < end for start, end in intervals)
        assert ask("eigen", "ess-50hz", {"object.mass_kg": repr(float(mass_kg))})["stable"] is inside


@pytest.mark.long
def test_dead_time_margin_is_what_may_be_added():
    limits = ask("limits", "ess-50hz")
    dead_time_ms = 40.0 + limits["margin"]["dead_time_margin_ms"]
    assert ask("eigen", "ess-50hz", {"robot.dead_time_ms": repr(dead_time_ms - 1e-3)})["stable"] is True
    assert ask("eigen", "ess-50hz", {"robot.dead_time_ms": repr(dead_time_ms + 1e-3)})["stable"] is False


@pytest.mark.long
def test_rates_are_judged_as_eigenvalues_say():
    for rate in ask("limits", "ess-50hz")["rates"]:
        done = command("eigen", "ess-50hz", "--json", *settings({"loop.rate_Hz": rate["rate_Hz"]}))
        if rate["stable"] is None:
            assert done.returncode == EXIT_INPUT and rate["refusal"].split(":")[0] in done.stderr.decode()
        else:
            assert one_json_object(done.stdout)["stable"] is rate["stable"], rate


@pytest.mark.long
def test_the_table_for_a_person_has_every_parameter_of_the_json():
    table = command("limits", "ess").stdout.decode()
    for key, parameter in ask("limits", "ess")["parameters"].items():
        assert key in table
        for side in ("below", "above"):
            if parameter[side] is not None:
                assert f"{parameter[side]['value']:.6g}" in table


# --- prediction beside measurement --------------------------------------------------------------------------------
@pytest.mark.parametrize("rig", REFERENCE)
def test_run_tells_the_predicted_growth_beside_the_measured_one(rig, logs):
    result, _ = logs(rig)
    print(f"{rig}: measured {result['growth_per_s']:.6f} /s, predicted {result['prediction']['growth_per_s']:.6f} /s")
    assert result["prediction"]["growth_per_s"] == pytest.approx(ask("eigen", rig)["growth_per_s"], rel=1e-9)
    assert result["growth_per_s"] == pytest.approx(result["prediction"]["growth_per_s"], rel=0.01)


@pytest.mark.parametrize("rig, values, why", [
    ("ess", {"robot.dead_time_ms": 5000}, "eigenvalues, for more than 400 ask `berth eigen`"),
    ("ess", {"robot.backlash_m": 1e-4}, "has no linearisation"),
    ("ess", {"manipulator.arm": "ess", "robot.dead_time_ms": 6000}, "lower loop.rate_Hz, robot.dead_time_ms"),
    ("ess", {"manipulator.arm": "ess", "robot.jitter_ms": 0.3}, "a manipulator of one degree of freedom alone"),
])
def test_no_prediction_where_the_rig_is_not_linear_or_its_dead_time_very_long(rig, values, why, tmp_path):
    told = run_json(rig, tmp_path, *settings({"run.duration_s": 2, **values}))
    assert told["prediction"]["growth_per_s"] is None and why in told["why_not_predicted"]
    shown = command("run", rig, "--no-log", *settings({"run.duration_s": 2, **values})).stdout.decode()
    assert f"  not predicted  {told['why_not_predicted']}\n" in shown


# --- wrong input --------------------------------------------------------------------------------------------------
@pytest.mark.long
@pytest.mark.parametrize("values, effect", [
    ({"robot.clock": "free", "robot.clock_drift_ppm": 50}, "a clock of its own"),
    ({"robot.jitter_ms": 0.5}, "up to 0.5 ms early or late"),
    ({"sensor.loss_probability": 0.1}, "frames are lost"),
    ({"run.lateness_file": "sim_hal/rigs/late-up-to-500us.json"}, "wakes late by 0 to 500 us"),
], ids=["clock", "jitter", "losses", "late wake-ups"])
@pytest.mark.first(2)
def test_limits_are_those_of_the_loop_without_what_varies_and_say_so(values, effect):
    told, without, eigen = ask("limits", "ess", values), ask("limits", "ess"), ask("eigen", "ess", values)
    [left_out] = told["left_out"]
    assert effect in left_out and without["left_out"] == []
    assert told["because"] == eigen["because"] + f"; the limits are those without what changes it from tick to tick ({left_out})"
    assert told["prediction"] == eigen["prediction"] and told["growth_per_s"] == eigen["growth_per_s"]
    assert told["without"] == {key: without[key] for key in ("stable", "spectral_radius", "growth_per_s")}
    assert "without what changes from tick to tick" in told["margin"]["note"]
    assert told["margin"]["dead_time_margin_ms"] == pytest.approx(without["margin"]["dead_time_margin_ms"], rel=1e-6)
    for key in ("parameters", "rates", "buys", "nearest_limit"):
        assert told[key] == without[key], key
    lines = command("limits", "ess", *settings(values)).stdout.decode().splitlines()
    assert "Lyapunov exponent" in lines[0] and lines[1].startswith("  the rest is without what changes")
    assert lines[2].startswith("  left out: ") and effect in lines[2]
    assert any(line.startswith("  margin ") and "without what changes" in line for line in lines)
    assert "left out" not in command("limits", "ess").stdout.decode()


@pytest.mark.long
def test_lines_of_limits_end_where_their_words_end():
    text = command("limits", "ess").stdout.decode()
    assert not [line for line in text.splitlines() if line != line.rstrip()]


@pytest.mark.long
def test_no_narrow_band_of_the_dead_time_is_stepped_over():
    """Along the dead time |z| swings once a period: up to the margin every tenth of a period is stable by its own
    eigenvalues, and just beyond it is not."""
    rig = ["ess", "--set", "robot.interpolation=hold", "--set", "object.mass_kg=110.2", "--set",
           "object.stiffness_N_per_m=5641", "--set", "sensor.low_pass_frequency_Hz=19", "--set",
           "manipulator.damping_N_s_per_m=119"]
    own_ms = 31.52
    told = one_json_object(command("limits", *rig, "--set", f"robot.dead_time_ms={own_ms}", "--json").stdout)
    margin_ms = told["margin"]["dead_time_margin_ms"]
    # More than a period below the next wider band, at 68.08 ms.
    assert 60.0 < margin_ms < 66.0

    def is_stable(dead_time_ms):
        done = command("eigen", *rig, "--set", f"robot.dead_time_ms={dead_time_ms}", "--json")
        return json.loads(done.stdout)["stable"]

    assert all(is_stable(own_ms + margin_ms - 0.25 * i - 0.001) for i in range(40))
    assert not is_stable(own_ms + margin_ms + 0.001)


@pytest.mark.long
def test_limits_of_a_softening_spring_end_and_keep_the_rig_in_a_stable_interval():
    """Far along some parameters the spring softens to nothing, and there is no linear loop to judge."""
    softening = settings({"object.cubic_stiffness_N_per_m3": -1e7})
    found = one_json_object(command("limits", "ess", *softening, "--json").stdout)
    assert found["stable"]
    for key, parameter in found["parameters"].items():
        assert any(low <= parameter["value"] <= high for low, high in parameter["stable_intervals"]), key
    for key in ("manipulator.stiffness_N_per_m", "object.mass_kg"):
        limit = found["parameters"][key]["above"]["value"]
        for factor in (0.9999, 1.0001):
            done = command("eigen", "ess", *softening, *settings({key: factor * limit}), "--json")
            assert one_json_object(done.stdout)["stable"] == (factor < 1.0), key


@pytest.mark.long
@pytest.mark.parametrize("samples", [2, 4])
def test_limits_of_a_sensor_that_samples_faster_than_the_loop_runs(samples):
    """Rates of which the sensor's is no multiple have no eigenvalues: they are not possible, all else is told."""
    found = ask("limits", "ess", {"sensor.rate_Hz": 400 * samples})
    assert found["stable"] and found["nearest_limit"]["key"] == "object.mass_kg"
    refused = {rate["rate_Hz"] for rate in found["rates"] if "does not go into" in rate.get("refusal", "")}
    assert 1000 in refused and 400 not in refused
    assert not any("does not go into" in rate.get("refusal", "") for rate in found["rates_with_delays_in_ticks"])
    rank = {gain.get("delays_stay"): gain for gain in found["buys"]["rank"]}
    assert rank["in ms"]["to"] is None and rank["in ticks"]["less"] and rank["in ticks"]["more"]


@pytest.mark.long
def test_short_dead_times_are_looked_at_as_well():
    """Below a tenth of the rig's own: at once it is unstable, after 0.4 of 20 ms it is not, later it is again."""
    rig = {
        "loop.rate_Hz": 50, "robot.interpolation": "hold", "bus.ideal": "true", "sensor.delay_ms": 0,
        "manipulator.mass_kg": 298.8, "manipulator.stiffness_N_per_m": 0, "manipulator.damping_N_s_per_m": 20.26,
        "manipulator.integrator": "semi_implicit_euler", "manipulator.substeps": 4, "object.mass_kg": 21.805,
        "object.stiffness_N_per_m": 331.4, "object.damping_N_s_per_m": 12.0, "object.second_mass_kg": 9.218,
        "object.second_frequency_Hz": 2.1346, "object.second_damping_ratio": 0.0625,
        "sensor.stiffness_N_per_m": 12573772, "sensor.damping_ratio": 0.01528, "sensor.low_pass_order": 1,
        "sensor.low_pass_frequency_Hz": 53.135,
    }
    found = ask("limits", "ess", {**rig, "robot.dead_time_ms": 120})["parameters"]["robot.dead_time_ms"]
    assert found["range"][0] == 0.0
    judged = [ask("eigen", "ess", {**rig, "robot.dead_time_ms": 0.4 * i})["stable"] for i in range(30)]
    assert not judged[0] and any(judged)
    for i, stable in enumerate(judged):
        assert any(low <= 0.4 * i <= high for low, high in found["stable_intervals"]) is stable, i


@pytest.mark.long
@pytest.mark.parametrize("values", [
    {"manipulator.stiffness_N_per_m": 0, "manipulator.mass_kg": 35, "manipulator.damping_N_s_per_m": 2,
     "object.mass_kg": 15, "object.stiffness_N_per_m": 30, "object.damping_N_s_per_m": 1},
    {"manipulator.damping_N_s_per_m": 0, "object.stiffness_N_per_m": 1500, "object.damping_N_s_per_m": 0.5},
], ids=["no spring", "no damper"])
def test_limits_where_a_pole_of_the_open_loop_lies_on_the_circle_are_good_to_six_digits(values):
    checked = 0
    for key, parameter in ask("limits", "ess", values)["parameters"].items():
        for limit in parameter["limits"]:
            if limit["jump"] or key.endswith("_ms"):
                continue
            beyond = [ask("eigen", "ess", {**values, key: repr(limit["value"] * (1 + aside))})["spectral_radius"] > 1
                      for aside in (-1e-6, 1e-6)]
            assert beyond == ([True, False] if limit["stable"] == "above" else [False, True]), (key, limit)
            checked += 1
    assert checked >= 3


@pytest.mark.long
def test_a_verdict_of_harmonics_that_do_not_settle_says_that_it_is_a_guess():
    abrupt = settings({"robot.acceleration_limit_m_per_s2": 0.3})
    for subcommand in ("eigen", "limits"):
        words = command(subcommand, "ess-50hz", *abrupt).stdout.decode().splitlines()
        assert words[0].endswith(" (A GUESS: the describing function did not settle)") and any("NOT SETTLED" in line for line in words)
        told = one_json_object(command(subcommand, "ess-50hz", "--json", *abrupt).stdout)
        assert told["describing_function"]["settled"] is False and told["growth"]["origin"] == "run_without_noise"
    assert "GUESS" not in command("eigen", "ess", *abrupt).stdout.decode()


# Two pairs of slow modes at a high rate: roots of the polynomial come out as if they were real.
TWO_SLOW_MODES = {
    "loop.rate_Hz": 800, "bus.ideal": "true", "robot.interpolation": "hold", "robot.dead_time_ms": 5.85,
    "manipulator.mass_kg": 34.6, "manipulator.stiffness_N_per_m": 21.8, "manipulator.damping_N_s_per_m": 6.7,
    "object.mass_kg": 15.17, "object.stiffness_N_per_m": 29.0, "object.damping_N_s_per_m": 1.1,
    "object.second_mass_kg": 4.95, "object.second_frequency_Hz": 2.148, "object.second_damping_ratio": 0.046,
    "sensor.stiffness_N_per_m": 2.19e5, "sensor.damping_ratio": 0.276, "sensor.low_pass_frequency_Hz": 16.06,
    "sensor.low_pass_damping_ratio": 1.114, "sensor.delay_ms": 1.25, "sensor.lag_ms": 7.3,
}


@pytest.mark.long
def test_two_slow_modes_at_a_high_rate_are_judged_as_their_eigenvalues_and_rounding_makes_no_limits():
    found = ask("limits", "ess", TWO_SLOW_MODES)
    for gain in found["buys"]["rank"]:
        if gain["to"] is not None and gain["key"] == "object.mass_kg":
            then = next(way for way in (gain["less"], gain["more"]) if way and way["value"] == gain["to"])
            assert gain["gain_per_s"] + then["growth_per_s"] == pytest.approx(found["growth_per_s"], abs=1e-5)
    limits = found["parameters"]["object.second_frequency_Hz"]["limits"]
    assert len(limits) <= 4
    for limit in limits:
        stable = [ask("eigen", "ess", {**TWO_SLOW_MODES, "object.second_frequency_Hz": limit["value"] * factor})["stable"]
                  for factor in (0.999, 1.001)]
        assert stable == ([False, True] if limit["stable"] == "above" else [True, False])


FREE = {"manipulator.stiffness_N_per_m": 0, "object.stiffness_N_per_m": 0}


@pytest.mark.parametrize("values, stable", [
    ({}, None), ({"manipulator.damping_N_s_per_m": 0, "object.damping_N_s_per_m": 0}, None),
    ({"object.mass_kg": 500}, False), ({"manipulator.stiffness_N_per_m": 1}, True),
])
def test_what_no_spring_holds_is_neither_stable_nor_unstable_unless_another_mode_grows(values, stable):
    told = ask("eigen", "ess", {**FREE, **values})
    assert told["stable"] is stable
    words = command("eigen", "ess", *settings({**FREE, **values})).stdout.decode().splitlines()[0]
    assert {None: "ess: undetermined", True: "ess: stable", False: "ess: unstable"}[stable] in words


@pytest.mark.long
def test_a_thousand_samples_of_dead_time_take_seconds():
    """The slow mode hardly differs from the pole of the manipulator: found without all eigenvalues at once."""
    long = {"loop.rate_Hz": 10000, "bus.ideal": "true", "robot.dead_time_ms": 100}
    start = time.monotonic()
    assert ask("limits", "ess", long)["stable"]
    assert time.monotonic() - start < 20.0


def test_a_sensor_rate_whose_period_in_ns_does_not_go_into_the_loops_is_told_with_both_periods():
    thrice = settings({"bus.ideal": "true", "sensor.rate_Hz": 1200})
    words = command("eigen", "ess", *thrice).stdout.decode()
    assert "every 833333 ns (1200 Hz), which does not go into the loop's period of 2500000 ns (400 Hz)" in words


@pytest.mark.long
def test_where_nothing_damps_and_nothing_pulls_a_limit_that_cannot_be_told_is_called_rough():
    """To first order every spring grows, however soft: |z| - 1 = 9e-8 m/N, which is not counted below 1e-10."""
    undamped = {"manipulator.stiffness_N_per_m": 0, "manipulator.damping_N_s_per_m": 0, "object.damping_N_s_per_m": 0}
    for limit in ask("limits", "ess", undamped)["parameters"]["object.stiffness_N_per_m"]["limits"]:
        if limit["value"] < 1.0:
            assert limit["jump"] and "rough" in limit["jump_reason"], limit


@pytest.mark.parametrize("values, loop", [
    ({"loop.rate_Hz": 1, "robot.dead_time_ms": 3000, "sensor.delay_ms": 1000}, Loop(1, 3.0, 1.0)),
    ({"loop.rate_Hz": 100000, "robot.dead_time_ms": 0.01, "sensor.delay_ms": 0, "bus.ideal": "true"},
     Loop(100000, 1e-5, 0.0)),
    ({"manipulator.damping_N_s_per_m": 1e6}, Loop(400, 17.5e-3, 2.5e-3, D=1e6)),
    ({"manipulator.mass_kg": 1e-3}, Loop(400, 17.5e-3, 2.5e-3, M=1e-3)),
    ({"sensor.low_pass_frequency_Hz": 1e-4}, Loop(400, 17.5e-3, 2.5e-3, f_L=1e-4)),
], ids=["1 Hz", "100 kHz", "damper", "light", "slow low-pass"])
def test_compensation_that_is_switched_off_refuses_no_rig(values, loop):
    expected = np.abs(np.linalg.eigvals(loop_matrices(loop))).max()
    assert ask("eigen", "ess", values)["spectral_radius"] == pytest.approx(expected, rel=1e-9)


@pytest.mark.long
def test_a_limit_at_a_jump_names_the_mode_that_goes_and_not_a_stable_one_nearer_to_the_circle():
    undamped = {"sensor.damping_ratio": 0}
    limit = ask("limits", "ess", undamped)["parameters"]["sensor.delay_ms"]["above"]
    assert limit["jump_reason"] == "the force becomes a tick older"
    z = np.linalg.eigvals(loop_matrices(Loop(400, 17.5e-3, 2.500001e-3, zeta_S=0.0)))[0]
    goes = z[np.argmax(np.abs(z))]
    assert abs(goes) > 1.01 and limit["value"] == pytest.approx(2.5, abs=2e-6)
    assert limit["frequency_Hz"] == pytest.approx(abs(np.angle(goes)) * 400 / (2 * np.pi), rel=1e-5)


@pytest.mark.long
def test_a_rough_limit_is_no_advice_on_how_to_make_a_loop_stable():
    undamped = {"manipulator.stiffness_N_per_m": 0, "manipulator.damping_N_s_per_m": 0, "object.damping_N_s_per_m": 0}
    told = ask("limits", "ess", undamped)
    limits = [limit for parameter in told["parameters"].values() for limit in parameter["limits"]]
    assert {limit["rough"] for limit in limits} == {True, False}
    assert all(limit["rough"] == ("rough" in (limit["jump_reason"] or "")) for limit in limits)
    nearest = told["nearest_limit"]
    assert told["stable"] is False and not nearest["rough"] and nearest["factor"] is None  # it starts from 0
    assert f"makes it stable: {nearest['key']} from 0 to " in command("limits", "ess", *settings(undamped)).stdout.decode()
    beyond = {**undamped, nearest["key"]: 1.01 * nearest["value"]}
    assert ask("eigen", "ess", beyond)["stable"] is True


def test_a_map_tells_of_a_rig_that_no_spring_holds_what_its_eigenvalues_tell(tmp_path):
    axes = ("--x", "object.mass_kg=50:150:3", "--y", "object.damping_N_s_per_m=0:10:3", "--out", tmp_path)
    for held, stable in ((FREE, None), ({**FREE, "object.mass_kg": 500}, False), ({}, True)):
        told = one_json_object(command("map", "ess", *axes, "--json", *settings(held)).stdout)
        assert told["own"]["stable"] is stable is ask("eigen", "ess", held)["stable"]


@pytest.mark.parametrize("duration_s,is_measured", [(8, False), (20, True)])
def test_a_fall_while_limits_act_to_the_end_is_no_decay(tmp_path, duration_s, is_measured):
    """The velocity limit acts for 7.7 s: until then it bounds the motion, and the eigenvalues alone tell."""
    result = run_json("ess", tmp_path, *(word for setting in (
        "limits.velocity_m_per_s=0.01", "manipulator.initial_position_m=0.05", "object.damping_N_s_per_m=400",
        f"run.duration_s={duration_s}") for word in ("--set", setting)))
    assert 0.0025 * result["limit_ticks"]["velocity"] == pytest.approx(7.7, abs=0.1)
    assert result["stable"] is True and (result["growth_per_s"] is not None) is is_measured
