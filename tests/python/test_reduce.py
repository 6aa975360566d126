"""What `berth reduce` says beside its numbers: what it left out, what it passed over, how far it looked."""

import pytest
from conftest import EXIT_INPUT, command, one_json_object


def reduce(*words):
    return one_json_object(command("reduce", *words, "--json").stdout)


@pytest.mark.parametrize("key,value,says", [
    ("robot.jitter_ms", "1", "up to 1 ms early or late"),
    ("robot.clock", "free", "by a clock of its own"),
    ("sensor.loss_probability", "0.01", "frames are lost"),
])
def test_what_changes_from_period_to_period_is_named_and_left_out(key, value, says):
    steady, varying = reduce("ess"), reduce("ess", "--set", f"{key}={value}")
    assert steady["left_out"] == []
    assert len(varying["left_out"]) == 1 and says in varying["left_out"][0]
    assert varying["poses"] == steady["poses"]
    assert says in command("reduce", "ess", "--set", f"{key}={value}").stderr.decode()


def test_with_further_axes_it_says_which_of_them_move():
    assert reduce("ess-berthing")["compared"] == []
    compared = reduce("ess-pose")["compared"]
    assert len(compared) == 2 and "along x alone" in compared[0] and "all axes" in compared[1]
    shown = command("reduce", "ess-pose").stdout.decode()
    assert all(line in shown for line in compared)


def test_a_mode_of_the_attitude_control_is_marked_and_passed_over():
    """At this pose the tool has more of it than of any other that is held."""
    words = ("ess", "--unguided", "--pose", "1.35,-0.5")
    [pose] = reduce(*words)["poses"]
    held = [mode for mode in pose["modes"] if mode["frequency_Hz"] > 0.0]
    slow = max(held, key=lambda mode: mode["share"])
    assert slow["frequency_Hz"] < 0.05 and slow["attitude_share"] > 0.99
    assert pose["reduced"]["attitude_share"] < 0.01
    assert pose["reduced"]["share"] == max(mode["share"] for mode in held if mode is not slow)
    shown = command("reduce", *words).stdout.decode()
    assert shown.count("held by the attitude control") == sum(mode["attitude_share"] > 0.5 for mode in held)


def test_below_the_shortest_dead_time_nothing_is_said():
    limit = reduce("ess")["poses"][0]["dead_time_limit_ms"]
    assert limit["looked_from"] == 2.5 and limit["full"] == 0.0
    [shortest] = reduce("ess", "--set", "robot.dead_time_ms=2.5")["poses"]
    assert shortest["loop"]["full"]["growth_per_s"] > 0.0 > shortest["loop"]["reduced"]["growth_per_s"]
    assert "< 2.5" in command("reduce", "ess").stdout.decode()
    ideal = reduce("ess", "--set", "robot.interpolation=hold", "--set", "robot.dead_time_ms=0", "--set",
                   "bus.ideal=true")["poses"][0]["dead_time_limit_ms"]
    assert ideal["looked_from"] == pytest.approx(0.025) and ideal["looked_to"] == 25.0


@pytest.mark.parametrize("words", [
    ("reduce", "ess", "--pose", ""), ("reduce", "ess", "--direction", ""), ("reduce", "ess", "--sweep", ""),
    ("reduce", "ess", "--arm", ""), ("run", "ess", "--out", ""), ("map", "ess", "--x", ""), ("eigen", "ess", "--set", ""),
])
def test_an_empty_value_is_no_choice(words):
    done = command(*words)
    assert done.returncode == EXIT_INPUT
    assert f"{words[2]}: needs a value" in done.stderr.decode()


@pytest.mark.parametrize("words", [("--pose", "1e7,0"), ("--sweep", "1=-1e7:0:3")])
def test_angles_of_many_turns_are_refused(words):
    done = command("reduce", "ess", *words)
    assert done.returncode == EXIT_INPUT and "within" in done.stderr.decode()
