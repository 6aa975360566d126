"""berth-target --check: what it says of a machine, to whoever asks."""

import re

import pytest


@pytest.fixture
def preflight(guest):
    step = guest("preflight")
    step.check_done()
    return step


def findings(text):
    """{subject: (verdict, text)}"""
    rows = (line for line in text.splitlines() if line[:8].strip() in ("ok", "WARNING", "MISSING"))
    return {row[9:25].strip(): (row[:8].strip(), row[26:]) for row in rows}


def test_a_machine_that_is_fit(preflight):
    found = findings(preflight.text("check"))
    assert preflight.number("check.exit_code") == 0
    assert "PREEMPT_RT" in found["kernel"][1]
    for subject in ("kernel", "throttling", "scheduling", "can0", "can1"):
        assert found[subject][0] == "ok", found[subject]
    assert "1000000 bit/s" in found["can0"][1]
    for bus in ("can0", "can1"):  # these controllers have no clock of their own
        assert found[f"{bus} stamps"][0] == "ok" and found[f"{bus} stamps"][1].startswith("software")
        assert found[f"{bus} restart"] == ("ok", "100 ms after bus-off")
        assert found[f"{bus} interrupt"] == ("ok", "served by CPU 0")
        assert found[f"{bus} queue"] == ("ok", "10 frames")
    lines = found["GPIO"][1].split()
    assert int(lines[0]) >= 1 and int(lines[3]) >= 5
    for key, name in (("emergency_stop", "EMERGENCY_STOP"), ("enable", "ENABLE"), ("heartbeat", "HEARTBEAT"),
                      ("tick", "TICK"), ("fault", "FAULT")):
        assert re.search(rf"^ok +target.{key}_line +{name} on gpiochip\d$", preflight.text("check"), re.MULTILINE)
    assert not [subject for subject, (verdict, _) in found.items() if verdict == "MISSING"]


def test_who_may_not_have_real_time_is_told_what_to_do(preflight):
    found = findings(preflight.text("check_user"))
    assert preflight.number("check_user.exit_code") == 3
    verdict, text = found["scheduling"]
    assert verdict == "MISSING"
    assert "LimitRTPRIO" in text or "LimitMEMLOCK" in text
    assert "chips with 0 lines" in found["GPIO"][1] and "may not be opened" in found["GPIO"][1]
    assert "-> run as root, or let a udev rule give /dev/gpiochip*" in preflight.text("check_user")


def test_a_chip_goes_by_its_label_as_well_and_the_watchdog_is_looked_at(preflight):
    assert preflight.number("check_chip.exit_code") == 0, preflight.text("check_chip")
    assert findings(preflight.text("check_chip"))["watchdog"] == ("ok", "/dev/watchdog0")
    assert preflight.number("check_no_chip.exit_code") == 3
    assert "no line is called TICK" in preflight.text("check_no_chip")
    assert findings(preflight.text("check_no_chip"))["watchdog"][0] == "MISSING"


def test_a_bus_that_is_down_is_told_and_waited_for_but_not_for_ever(preflight):
    told = preflight.text("check_down")
    assert preflight.number("check_down.exit_code") == 3
    assert findings(told)["can0"][0] == "MISSING" and findings(told)["can0"][1].startswith("down")
    assert "-> ip link set can0 type can bitrate 1000000 restart-ms 100 && ip link set can0 up" in told
    assert preflight.number("down.exit_code") == 3
    assert preflight.lines("down.stderr") == [
        "can0 is down: waiting 10 s for it",
        "can0: the interface is down (Network is down); berth-target --check says what to do"]
    assert "stopped because: requested" in preflight.text("down_stopped.stdout")  # who waits may be stopped


def test_what_is_not_there_is_named_with_its_key(preflight):
    text = preflight.text("check_wrong")
    assert preflight.number("check_wrong.exit_code") == 3
    assert findings(text)["can9"][0] == "MISSING"
    assert "target.robot_interface" in text
    assert "no line is called NOWHERE" in text
