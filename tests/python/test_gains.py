"""What helps most: the ranking of `berth limits`, against another program's eigenvalues."""

import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import command, one_json_object, settings

sys.path.insert(0, str(Path(__file__).parents[2] / "scripts"))
from loop_matrix import Loop, loop_matrices  # noqa: E402

# Keys of the rig file by the other program's names, with the factor to its units.
OTHER_NAME = {
    "loop.rate_Hz": ("rate_Hz", 1.0), "robot.dead_time_ms": ("T_R", 1e-3), "sensor.delay_ms": ("T_S", 1e-3),
    "manipulator.mass_kg": ("M", 1.0), "manipulator.stiffness_N_per_m": ("K", 1.0),
    "manipulator.damping_N_s_per_m": ("D", 1.0), "object.mass_kg": ("m", 1.0), "object.stiffness_N_per_m": ("k", 1.0),
    "object.damping_N_s_per_m": ("d", 1.0), "sensor.stiffness_N_per_m": ("k_S", 1.0),
    "sensor.damping_ratio": ("zeta_S", 1.0), "sensor.low_pass_frequency_Hz": ("f_L", 1.0),
    "sensor.low_pass_damping_ratio": ("zeta_L", 1.0),
}
ESS = {"rate_Hz": 400.0, "T_R": 0.0175, "T_S": 0.0025}
SLOW = {"rate_Hz": 50.0, "T_R": 0.040, "T_S": 0.020}


def limits(rig, *arguments, values=None):
    """`berth limits RIG --json`: the object."""
    done = command("limits", rig, "--json", *arguments, *settings(values or {}))
    assert done.returncode == 0, done.stderr.decode()
    return one_json_object(done.stdout)


def other_growth_per_s(values):
    """ln of the largest |z| by period, of matrices assembled in another language."""
    loop = Loop(**values)
    z = np.linalg.eigvals(np.asarray(loop_matrices(loop)).reshape(-1, *np.asarray(loop_matrices(loop)).shape[-2:])[0])
    return np.log(np.abs(z).max()) / loop.T


def other_margin(values):
    """Smallest |1 + L|: determinants of closed and open loop; no force moves a manipulator of boundless mass."""
    loop = Loop(**values)
    heavy = 1e12
    free = Loop(**{**values, **{name: getattr(loop, name) * heavy for name in "MKD"}})
    closed, cut = (np.linalg.eigvals(loop_matrices(one)[0]) for one in (loop, free))
    modes = np.abs(np.angle(closed[np.abs(closed) > 0.5]))
    angle = np.concatenate([np.geomspace(1e-5, np.pi, 40000), *(m * (1 + np.linspace(-1e-3, 1e-3, 401)) for m in modes)])
    z = np.exp(1j * angle)[:, None]
    return np.abs(np.prod((z - closed) / (z - cut), axis=1)).min()


RIGS = [
    ("ess", ESS, {}), ("ess", ESS, {"object.mass_kg": 210.0}), ("ess-50hz", SLOW, {}),
    ("ess-50hz", SLOW, {"manipulator.damping_N_s_per_m": 0.0, "object.damping_N_s_per_m": 0.0}),
]


def changed_values(own, gain, value):
    """The other program's rig with another value of what `gain` is about."""
    name, factor = OTHER_NAME[gain["key"]]
    changed = {**own, name: value * factor}
    if gain.get("delays_stay") == "in ticks":
        changed.update({delay: own[delay] * own["rate_Hz"] / value for delay in ("T_R", "T_S")})
    return changed


@pytest.mark.long
@pytest.mark.parametrize("rig, own, values", RIGS)
@pytest.mark.parametrize("percent", [10.0, 50.0])
@pytest.mark.first(5)
def test_each_gain_is_what_another_program_finds(rig, own, values, percent):
    told = limits(rig, "--change", str(percent), values=values)
    own = {**own, **{OTHER_NAME[key][0]: value * OTHER_NAME[key][1] for key, value in values.items()}}
    now = other_growth_per_s(own)
    assert told["growth_per_s"] == pytest.approx(now, abs=1e-6)
    assert told["buys"]["change"] == pytest.approx(percent / 100.0)
    rank = told["buys"]["rank"]
    assert {gain["key"] for gain in rank} == set(OTHER_NAME) and len(rank) == len(OTHER_NAME) + 1
    compared = 0
    for gain in rank:
        growths = []
        for side, sign in (("less", -1), ("more", 1)):
            if gain[side] is None:
                continue
            if gain["value"] > 0.0:
                assert gain[side]["value"] == pytest.approx(gain["value"] * (1 + sign * percent / 100.0), rel=1e-6)
            changed = changed_values(own, gain, gain[side]["value"])
            growth = other_growth_per_s(changed)
            assert gain[side]["growth_per_s"] == pytest.approx(growth, abs=1e-6), (gain["key"], side)
            if gain[side]["modulus"] is not None:
                ratio = gain[side]["modulus"] / other_margin(changed)  # a grid may overlook the bottom of a dip
                assert 1 - 1e-3 < ratio < 1 + 1e-5, (gain["key"], side)
            assert (gain[side]["modulus"] is None) is bool(growth >= 0.0)
            growths.append((growth, gain[side]["value"]))
            compared += 1
        best = min(growths)
        assert gain["gain_per_s"] == pytest.approx(now - best[0], abs=2e-6)
        assert gain["to"] in [value for growth, value in growths if growth < best[0] + 1e-6]
    print(f"{rig} {values}, {percent:g} %: {compared} changed loops compared")
    assert compared >= 24
    gains = [gain["gain_per_s"] for gain in rank]
    assert gains == sorted(gains, reverse=True)


def test_margins_rank_by_themselves_and_not_as_growth_does():
    told = limits("ess")["buys"]
    assert told["modulus"] == pytest.approx(other_margin(ESS), rel=1e-4)
    margins = []
    for gain in told["rank_by_modulus"]:
        sides = [gain[side] for side in ("less", "more") if gain[side] is not None]
        best = max(sides, key=lambda side: side["modulus"])
        assert gain["to"] == best["value"]
        margins.append(best["modulus"])
    assert margins == sorted(margins, reverse=True)
    better = {gain["key"]: gain["to"] for gain in told["rank_by_modulus"]}
    assert better["robot.dead_time_ms"] < 17.5 and better["object.mass_kg"] < 100.0


@pytest.mark.long
def test_a_force_that_becomes_a_tick_older_is_said():
    """The sample comes exactly one tick late: at a higher rate, with its delay in ms, it comes two ticks late."""
    told = {(gain["key"], gain.get("delays_stay")): gain for gain in limits("ess")["buys"]["rank"]}
    assert told["loop.rate_Hz", "in ms"]["more"]["force_older_by_ticks"] == 1
    assert told["loop.rate_Hz", "in ms"]["less"]["force_older_by_ticks"] == 0
    assert told["loop.rate_Hz", "in ticks"]["more"]["force_older_by_ticks"] == 0
    assert told["sensor.delay_ms", None]["more"]["force_older_by_ticks"] == 1
    text = command("limits", "ess").stdout.decode()
    assert "the force becomes 1 tick older" in text


@pytest.mark.slow
def test_a_limit_at_an_amplitude_is_where_the_eigenvalues_at_it_leave_the_circle():
    """Also of an effect whose equivalent takes a simulation, and of one-sided contact."""
    limit_of = {"robot.acceleration_limit_m_per_s2": 0.3}
    for rig, key, arguments in (("ess", "manipulator.mass_kg", ["--amplitude", "0.01", *settings(limit_of)]),
                                ("concept-copper", "object.stiffness_N_per_m", ["--amplitude", "0.005"])):
        done = command("limits", rig, "--json", *arguments)
        told = one_json_object(done.stdout)["parameters"][key]
        limit = told["below"] or told["above"]
        assert limit is not None and not limit["jump"]
        stable = [one_json_object(command("eigen", rig, "--json", *arguments,
                                          *settings({key: repr(limit["value"] * (1 + side))})).stdout)
                  ["spectral_radius"] < 1.0 for side in (-1e-5, 1e-5)]
        print(f"{rig}: {limit}")
        assert stable == ([False, True] if limit["stable"] == "above" else [True, False])


def test_damping_of_the_manipulator_buys_what_the_closed_form_says():
    """Without dead time worth naming the pair decays by (D + d)/(2 (M + m)): a tenth of D buys D/(20 (M + m))."""
    values = {"loop.rate_Hz": 10000, "robot.dead_time_ms": 0.1, "sensor.delay_ms": 0.0, "bus.ideal": "true",
              "sensor.low_pass_frequency_Hz": 2000}
    rank = limits("ess", values=values)["buys"]["rank"]
    gain = next(g for g in rank if g["key"] == "manipulator.damping_N_s_per_m")
    expected = 0.1 * 125.66370614359172 / (2 * 300.0)
    print(f"gain {gain['gain_per_s']:.6f} /s, closed form {expected:.6f} /s")
    assert gain["gain_per_s"] == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize("rig, values", [("ess", {}), ("ess", {"object.mass_kg": 210.0}), ("ess-50hz", {})])
def test_the_nearest_limit_is_the_one_of_the_smallest_factor(rig, values):
    told = limits(rig, values=values)
    nearest = told["nearest_limit"]
    factors = {}
    for key, parameter in told["parameters"].items():
        for side in ("below", "above"):
            if parameter[side] is not None:
                factors[key, parameter[side]["value"]] = parameter[side]["value"] / parameter["value"]
    key, value = min(factors, key=lambda at: abs(np.log(factors[at])))
    print(f"{rig} {values}: {nearest}")
    assert (nearest["key"], nearest["value"]) == (key, value)
    assert nearest["factor"] == pytest.approx(factors[key, value])
    beyond = {**values, key: repr(float(value * (1 + 1e-5 * np.sign(nearest["factor"] - 1))))}
    assert one_json_object(command("eigen", rig, "--json", *settings(beyond)).stdout)["stable"] is not told["stable"]


@pytest.mark.long
def test_the_tables_for_a_person_rank_as_the_json_does():
    text = command("limits", "ess").stdout.decode()
    told = limits("ess")["buys"]
    for title, key in (("what helps most:", "rank"), ("what gives the most margin", "rank_by_modulus")):
        lines = text.split(title)[1].splitlines()[2:2 + len(told[key])]
        assert [line.split()[0].strip(",") for line in lines] == [gain["key"] for gain in told[key]]
        for line, gain in zip(lines, told[key]):
            assert f"{gain['gain_per_s']:+.6f}" in line and f"{gain['to']:.6g}" in line


def test_a_change_that_no_rig_may_have_is_left_out_not_guessed():
    """The dead time is one period already: with lines between setpoints it cannot be shorter."""
    rank = limits("ess", values={"robot.dead_time_ms": 2.5})["buys"]["rank"]
    dead_time = next(gain for gain in rank if gain["key"] == "robot.dead_time_ms")
    assert dead_time["less"] is None and dead_time["to"] == pytest.approx(2.75)
