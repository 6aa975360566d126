"""The guest itself, by other people's tools: what the other tests rely on."""

import re

import pytest

MACHINE = {"arm64": "aarch64", "amd64": "x86_64"}


@pytest.fixture
def machine(guest):
    step = guest("machine")
    step.check_done()
    return step


def test_the_kernel_is_real_time(guest, machine):
    assert machine.number("realtime") == 1
    assert re.search(rf"PREEMPT_RT .*{MACHINE[guest.arch]}", machine.text("kernel"))


@pytest.mark.parametrize("name", ["can0", "can1", "can2", "can3"])
def test_the_buses_are_up(machine, name):
    [link] = [one for one in machine.json("links.json") if one["ifname"] == name]
    assert "UP" in link["flags"]
    assert link["linkinfo"]["info_kind"] == "can"
    assert link["linkinfo"]["info_data"]["bittiming"]["bitrate"] == 1_000_000
    assert link["txqlen"] == 10


@pytest.mark.parametrize("pair", ["can0:can2", "can2:can0", "can1:can3", "can3:can1"])
def test_frames_cross_the_bus_in_order(machine, pair):
    numbers = [int(line.split("#")[1][:2], 16) for line in machine.lines(f"{pair}.candump")]
    assert numbers == list(range(20))


def test_an_input_is_seen_through_the_kernel(machine):
    edges = [line.split(" EDGE")[0].replace("event: ", "").strip() for line in machine.lines("edges")]
    assert edges == ["FALLING", "RISING", "FALLING", "RISING"]


def test_an_output_is_seen_outside(machine):
    assert machine.lines("fault_levels") == ["1", "0", "1"]


def test_time_is_virtual(machine):
    """Independent of the host's load, or no timing test below means anything: an idle guest wakes within 100 us."""
    thread = machine.json("cyclictest.json")["thread"]["0"]
    assert thread["cycles"] == 1200
    assert thread["max"] < 100
