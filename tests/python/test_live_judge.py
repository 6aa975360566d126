"""The verdict of the live view, from motions in closed form; datagrams that are none; the window that stays small."""

import json
import math
import random

import berth
import numpy as np
import pytest
from berth import _core
from berth.live import sample as samples
from berth.live.judge import judge
from berth.live.sample import BadDatagram, Sample, Window, parse

RUNNING = _core.state_names.index("running")
FAULT = _core.state_names.index("fault")
STOPPED = _core.state_names.index("stopped")
FIRST = {"rig": "ess", "config_hash": "0123", "period_ms": 2.5, "run": 7, "sequence": 0, "unsent": 0, "time_s": 0.0,
         "woke_late_ms": 0.0, "force_frame_age_ms": 2.5, "operator_position_m": 0.0, "operator_force_N": 0.0,
         "manipulator_position_m": 0.0, "command_position_m": 0.0, "robot_position_m": 0.0, "force_N": 0.0,
         "peak_force_N": 0.0, "energy_operator_J": 0.0, "energy_dissipated_J": 0.0, "energy_dead_time_J": 0.0,
         "missed_ticks": 0, "rejected_frames": 0, "lost_frames": 0, "state": RUNNING, "stop_cause": 0, "limits": 0}
RATE_Hz = 100.0


def datagram(**changed):
    return json.dumps({"berth_live": 1, **FIRST, **changed}).encode()


def motion(position_m, seconds=10.0, **changed):
    """Samples of position_m(time_s); what is `changed` may depend on the time, too."""
    made = []
    for i in range(int(seconds * RATE_Hz)):
        time_s = i / RATE_Hz
        more = {name: value(time_s) if callable(value) else value for name, value in changed.items()}
        made.append(Sample(**{**FIRST, "sequence": i, "time_s": time_s, "manipulator_position_m": position_m(time_s), **more}))
    return made


def swing(growth_per_s, frequency_Hz, height_m=1e-3):
    return lambda t: height_m * math.exp(growth_per_s * t) * math.cos(2 * math.pi * frequency_Hz * t) + 0.02


@pytest.mark.parametrize("growth_per_s", [-1.0, -0.3, -0.05, 0.05, 0.3, 1.0])
@pytest.mark.parametrize("frequency_Hz", [1.0, 2.7, 7.8, 12.0])
def test_growth_is_that_of_the_closed_form(growth_per_s, frequency_Hz):
    state = judge(motion(swing(growth_per_s, frequency_Hz)), 0.0)
    assert state.verdict == ("growing" if growth_per_s > 0 else "decaying")
    assert state.look == ("bad" if growth_per_s > 0 else "good")
    assert state.growth_per_s == pytest.approx(growth_per_s, abs=0.02 + 2 * state.growth_ci95_per_s)
    assert state.frequency_Hz == pytest.approx(frequency_Hz, rel=0.01)


def spoilt(position_m, **changed):
    return motion(position_m, manipulator_position_m=lambda t: math.nan if t > 9.9 else position_m(t), **changed)


GROWS, DECAYS, RESTS = swing(0.5, 2.0), swing(-0.5, 2.0), lambda t: 0.02
CASES = {
    "grows": (motion(GROWS), 0.0, "growing", "bad"),
    "decays": (motion(DECAYS), 0.0, "decaying", "good"),
    "rests": (motion(RESTS), 0.0, "at rest", "good"),
    "neither": (motion(swing(0.0, 2.0)), 0.0, "undecided", "unsure"),
    "two swings": (motion(GROWS, seconds=1.0), 0.0, "undecided", "unsure"),
    "one sample": (motion(RESTS, seconds=0.01), 0.0, "at rest", "good"),
    "driven": (motion(GROWS, operator_position_m=lambda t: 0.01 * t), 0.0, "driven", "unsure"),
    "pushed": (motion(DECAYS, operator_force_N=math.sin), 0.0, "driven", "unsure"),
    "limits act": (motion(GROWS, limits=lambda t: 8 if t > 8 else 0), 0.0, "at the limits", "bad"),
    "limits acted": (motion(DECAYS, limits=lambda t: 8 if t < 1 else 0), 0.0, "decaying", "good"),
    "fault": (motion(DECAYS, state=lambda t: FAULT if t > 9 else RUNNING), 0.0, "stopped", "bad"),
    "holding": (motion(DECAYS, state=3, stop_cause=2), 0.0, "holding", "unsure"),
    "asked to end": (motion(DECAYS, state=STOPPED, stop_cause=1), 0.0, "ended", "unsure"),
    "ended by a limit": (motion(DECAYS, state=STOPPED, stop_cause=10), 0.0, "stopped", "bad"),
    "not yet": (motion(RESTS, state=1), 0.0, "not running", "unsure"),
    "no more": (motion(GROWS), 1.5, "no data", "unsure"),
    "fault, and no more": (motion(DECAYS, state=FAULT), 60.0, "stopped", "bad"),
    "never": ([], None, "no data", "unsure"),
    "no number": (spoilt(DECAYS), 0.0, "not finite", "bad"),
}


@pytest.mark.parametrize("name", CASES)
def test_a_verdict(name):
    made, age_s, verdict, look = CASES[name]
    before = list(made)
    state = judge(made, age_s)
    assert (state.verdict, state.look) == (verdict, look), state
    assert state.because and state == judge(made, age_s) and made == before
    json.dumps(state.as_json(), allow_nan=False)


@pytest.mark.parametrize("growth_per_s, verdict", [(0.5, "growing"), (-0.5, "decaying")])
def test_lost_datagrams_change_no_verdict(growth_per_s, verdict):
    """One in ten is lost at random."""
    drawn = random.Random(5)
    made = [one for one in motion(swing(growth_per_s, 2.0)) if drawn.random() > 0.1]
    state = judge(made, 0.0)
    assert state.verdict == verdict and state.growth_per_s == pytest.approx(growth_per_s, abs=0.05)


def test_behind_a_gap_growth_is_sought_anew():
    made = [one for one in motion(GROWS) if not 9.0 < one.time_s < 9.5]
    assert judge(made, 0.0).growth_per_s is None


def test_a_change_is_seen_before_the_window_is_full_of_it():
    """Decays for 7 s, then grows: the shortest part alarms."""
    before, after = swing(-0.3, 4.0), swing(1.0, 4.0, 1e-4)
    state = judge(motion(lambda t: before(t) if t < 7 else after(t - 7) + before(7) - after(0)), 0.0)
    assert state.verdict == "growing" and state.growth_span_s == pytest.approx(2.5, abs=0.02)


def test_energies_and_counts_are_of_the_window():
    made = motion(DECAYS, energy_dead_time_J=lambda t: 3 * t, energy_dissipated_J=lambda t: t, missed_ticks=lambda t: int(t),
                  peak_force_N=lambda t: -40.0 if 5 < t < 5.02 else 1.0, unsent=4)
    state = judge(made, 0.25, lost=9, bad=2)
    span_s = made[-1].time_s
    assert state.dead_time_J == pytest.approx(3 * span_s) and state.damping_J == pytest.approx(span_s)
    assert (state.missed_ticks, state.peak_force_N, state.unsent_datagrams) == (9, -40.0, 4)
    assert (state.lost_datagrams, state.bad_datagrams, state.age_s) == (9, 2, 0.25)


def test_a_datagram_is_read():
    made = parse(datagram(force_N=1.5, force_frame_age_ms=None))
    assert made.force_N == 1.5 and math.isnan(made.force_frame_age_ms) and made.rig == "ess"
    assert made.as_json()["force_frame_age_ms"] is None
    json.dumps(made.as_json(), allow_nan=False)


@pytest.mark.parametrize("bytes_", [
    b"", b"{", b"[]", b"null", b"1", b'"text"', b"\xff\xfe", b"{}", b"[" * 1400, datagram()[:-1], datagram() + b"}",
    datagram(berth_live=2), datagram(more=1), datagram(force_N="1"), datagram(force_N=True), datagram(force_N=[1]),
    datagram(force_N=float("nan")), datagram(force_N=float("inf")), datagram(sequence=-1), datagram(sequence=1.5),
    datagram(sequence=None), datagram(sequence=10**30), datagram(state=6), datagram(stop_cause=99), datagram(limits=16),
    datagram(rig=7), datagram(rig="a" * 65), datagram(rig="\x00"), datagram(period_ms=0), datagram(period_ms=None),
    datagram(time_s=-1), datagram(time_s=None), datagram(rig="a" * 2000),
    datagram().replace(b'"force_N": 0.0, ', b""), datagram().replace(b'"force_N": 0.0', b'"force_N": 1e999')])
def test_what_is_no_sample_is_refused(bytes_):
    with pytest.raises(BadDatagram):
        parse(bytes_)


def test_whatever_comes_is_a_sample_or_refused():
    drawn = random.Random(11)
    whole, passed = datagram(), 0
    for _ in range(20_000):
        bytes_ = bytearray(whole)
        for _ in range(drawn.randint(1, 3)):
            bytes_[drawn.randrange(len(bytes_))] = drawn.randrange(256)
        try:
            made = parse(bytes(bytes_))
        except BadDatagram:
            continue
        passed += 1
        judge([made], 0.0)
    assert 10 < passed < 15_000


def test_the_window_stays_small_and_in_order():
    window = Window(span_s=10.0, count_max=500)
    for i in range(5000):
        assert window.add(Sample(**{**FIRST, "sequence": i, "time_s": i / 100}))
    assert len(window.samples) == 500
    last = window.samples[-1]
    assert not window.add(last) and not window.add(Sample(**{**FIRST, "sequence": 3, "time_s": 99.0}))
    assert window.lost == 0
    assert window.add(Sample(**{**FIRST, "sequence": 5009, "time_s": 60.0})) and window.lost == 9
    assert len(window.samples) == 1  # the others are older than 10 s
    assert window.add(Sample(**{**FIRST, "run": 8})) and window.lost == 0 and len(window.samples) == 1


def by_numpy(ticks, stride):
    """What a sample is, once more: of each `stride` ticks the last, with what must not be thinned away."""
    whole = ticks[:len(ticks) // stride * stride].reshape(-1, stride)
    force_N = whole["force_N"]
    peak = np.take_along_axis(force_N, np.abs(force_N).argmax(axis=1)[:, None], axis=1)[:, 0]
    return whole[:, -1], peak, np.bitwise_or.reduce(whole["limits"], axis=1), whole["missed_ticks"].sum(axis=1).cumsum()


@pytest.mark.parametrize("rate_Hz, stride", [(100, 4), (1000, 1), (7, 57)])
def test_samples_are_the_ticks_of_the_log_thinned(rate_Hz, stride):
    rig = berth.Rig.load("ess", {"object.mass_kg": 205, "run.duration_s": 8, "sensor.noise_N": 2})
    run = rig.run(advice=False)
    thinner = _core.LiveThinner(rig._core, 3, rate_Hz)
    made = [parse(one) for part in np.array_split(run.ticks, 7) for one in thinner.samples(
        np.frombuffer(part.tobytes(), np.uint8))]
    last, peak, limits, missed = by_numpy(run.ticks, stride)
    assert len(made) == len(last) and [one.sequence for one in made] == list(range(len(made)))
    for name in set(samples.NAMES) & set(run.fields) - {"limits", "missed_ticks"}:
        np.testing.assert_allclose([getattr(one, name) for one in made], last[name], rtol=1e-8, err_msg=name)
    np.testing.assert_allclose([one.peak_force_N for one in made], peak, rtol=1e-8)
    np.testing.assert_allclose([one.time_s for one in made], 1e-9 * last["scheduled_ns"], rtol=1e-8)
    assert [one.limits for one in made] == list(limits) and limits.any()
    assert [one.missed_ticks for one in made] == list(missed)
    assert {(one.rig, one.config_hash, one.run) for one in made} == {("ess", rig.config_hash, 3)}


def watched(name, values, robot=""):
    """(run, [(time in s, state) ten times a second]) of a run without a clock."""
    rig = berth.Rig.load(name, values, robot)
    run = rig.run(advice=False)
    thinner, window, told = _core.LiveThinner(rig._core, 0, _core.live_rate_Hz), Window(), []
    for one in thinner.samples(np.frombuffer(run.ticks.tobytes(), np.uint8)):
        window.add(parse(one))
        if window.samples[-1].sequence % 10 == 9:
            told.append(judge(window.samples, 0.0))
    return run, told


# Growth is that of the eigenvalues: of another method than the fit of the motion.
DIVERGING = [("ess", {"object.stiffness_N_per_m": 9000}, "abb-egm"), ("ess", {"object.stiffness_N_per_m": 12000}, "abb-egm"),
             ("ess", {"object.stiffness_N_per_m": 20000}, "abb-egm"), ("concept-copper", {}, ""),
             ("ess", {"object.mass_kg": 205, "reflex.growth_J": 20.0}, "")]


@pytest.mark.parametrize("name, values, robot", DIVERGING)
def test_a_loop_that_diverges_is_red_before_the_supervisor_stops_it(name, values, robot):
    run, told = watched(name, values, robot)
    assert run.verdict.stop_cause not in (None, "requested")
    first = next(state for state in told if state.look == "bad")
    assert first.state == "running" and first.time_s < run.verdict.stop_after_s
    assert told[-1].verdict == "stopped" and told[-1].look == "bad"
    growth = run.rig.eigenvalues().growth_per_s
    assert growth > 0 and not any(state.look == "good" for state in told)
    for state in told:
        if state.verdict == "growing":
            assert state.growth_per_s == pytest.approx(growth, abs=0.01 + state.growth_ci95_per_s)


@pytest.mark.long
@pytest.mark.parametrize("values", [{}, {"sensor.noise_N": 3}, {"sensor.noise_N": 30, "run.seed": 5},
                                    {"object.mass_kg": 150, "robot.feedback_noise_m": 1e-5}, {"robot.jitter_ms": 0.3},
                                    {"object.mass_kg": 190}])
def test_a_loop_that_decays_is_never_red(values):
    run, told = watched("ess", values)
    assert run.rig.verdict(advice=False).stable
    assert not [state for state in told if state.look == "bad"]
    assert any(state.look == "good" for state in told)
