"""The package on a Debian with systemd as init: steps/package.sh does what the tutorial says, and this is what came of it."""

import re

import pytest
from target_log import TargetLog

OTHER, FIFO = 0, 1
CONFIGURATION = ["/etc/berth", "/etc/berth/rig.toml", "/etc/security/limits.d/berth.conf"]


@pytest.fixture
def package(board):
    step = board("package")
    step.check_done()
    return step


def properties(step, name):
    """What systemd says of the service."""
    return dict(line.split("=", 1) for line in step.lines(f"{name}.unit") if "=" in line)


def check_stopped_in_order(step, name):
    log = TargetLog(step.path(f"{name}.ulg"))
    assert log.states()[:3] == ["start", "ready", "running"]
    assert log.last_state() == "stopped"
    log.check_no_tick_is_missing()


# --- installed ---------------------------------------------------------------------------------------------------
def test_dpkg_installs_and_removes_it_without_a_complaint(package):
    for name in ("install", "reinstall", "remove", "purge"):
        said = re.sub(r".* not empty so not removed\n", "", package.text(name))  # a folder that is not ours alone
        assert not re.search("warning|error|fail|usage", said, re.IGNORECASE), said
    assert package.text("verify") == ""
    assert package.text("unit_verify") == ""


def test_its_user_has_the_lines_and_the_watchdog(package):
    assert re.match(r"uid=\d+\(berth\) gid=\d+\(berth\)", package.text("user"))
    rows = [line.split() for line in package.lines("access")]
    assert len(rows) >= 4
    for device, group, mode in rows:
        assert (device, group, mode) == (device, "berth", "660")


def test_the_service_can_do_little_that_the_loop_does_not_need(package):
    """Of 10, by systemd's own scale."""
    exposure = re.search(r"Overall exposure level for berth.service: ([\d.]+)", package.text("exposure"))
    assert float(exposure[1]) <= 2.0, package.text("exposure")


def test_its_watchdog_is_the_machines(package):
    assert re.search(r"^ok +watchdog +/dev/watchdog$", package.text("check"), re.MULTILINE), package.text("check")


def test_a_log_is_for_its_owner_and_group_alone(package):
    assert package.text("log_mode").split() == ["berth", "berth", "640"]


def test_queue_and_throttling_are_set_without_a_reboot(package):
    assert package.number("queue") == 10
    assert package.number("throttling") == -1


def test_networkd_brings_the_buses_up(package):
    for name in ("can0", "can1"):
        [link] = [one for one in package.json("links.json") if one["ifname"] == name]
        assert "UP" in link["flags"]
        assert link["linkinfo"]["info_data"]["bittiming"]["bitrate"] == 1_000_000
        assert link["linkinfo"]["info_data"]["restart_ms"] == 100
        assert link["txqlen"] == 10


def test_a_boot_does_not_wait_for_addresses_of_the_buses(package):
    assert package.number("online.exit_code") == 0, package.text("online")


def test_its_user_may_move_the_robot(package):
    """sudo -u berth berth-target --check: by the limits snippet, not by being root."""
    assert package.number("check.exit_code") == 0, package.text("check")
    for finding in (r"limits +rtprio 98, memlock unlimited bytes",
                    r"scheduling +SCHED_FIFO 80, memory locked, CPU latency 0 us"):
        assert re.search(f"^ok +{finding}$", package.text("check"), re.MULTILINE), package.text("check")


# --- running -----------------------------------------------------------------------------------------------------
def test_start_returns_when_the_loop_runs(package):
    unit = properties(package, "running")
    assert unit["Type"] == "notify"
    assert (unit["ActiveState"], unit["SubState"]) == ("active", "running")
    assert unit["WatchdogUSec"] == "2s"
    assert unit["NRestarts"] == "0"


def test_the_process_is_real_time_locked_and_not_root(package):
    scheduling = {}
    for line in package.lines("threads"):
        name, fields = re.match(r"\d+ \((.*)\) (.*)", line).groups()
        fields = fields.split()
        scheduling[name] = int(fields[38]), int(fields[37])  # policy and rt_priority of proc(5): 41 and 40, of 52
    assert scheduling == {"berth-target": (FIFO, 80), "log": (OTHER, 0), "watchdog": (OTHER, 0)}
    status = dict(line.split(":", 1) for line in package.lines("status"))
    locked_kB, whole_kB = (int(status[key].split()[0]) for key in ("VmLck", "VmSize"))
    assert locked_kB > 0.9 * whole_kB
    uid = re.match(r"uid=(\d+)", package.text("user"))[1]
    assert status["Uid"].split() == [uid] * 4
    assert status["NoNewPrivs"].strip() == "1"
    assert re.search(r"Max locked memory +unlimited +unlimited", package.text("limits"))
    assert re.search(r"Max realtime priority +98 +98", package.text("limits"))


def test_stop_leads_the_robot_to_rest_and_closes_the_log(package):
    unit = properties(package, "stopped")
    assert (unit["ActiveState"], unit["Result"], unit["ExecMainStatus"]) == ("inactive", "success", "0")
    assert "stopped because: requested" in package.text("stopped.journal")
    assert "0 not recorded" in package.text("stopped.journal")
    assert package.number("fault_level") == 0
    check_stopped_in_order(package, "stopped")


def test_a_loop_that_is_started_before_its_bus_is_up_waits_for_it(package):
    """As at boot."""
    check_stopped_in_order(package, "early")


def test_systemd_ends_a_loop_that_hangs(package):
    unit = properties(package, "hung")
    assert (unit["ActiveState"], unit["Result"]) == ("failed", "watchdog")


# --- replaced and removed, while it runs -------------------------------------------------------------------------
def test_a_new_package_stops_the_loop_in_order_and_keeps_the_rig(package):
    unit = properties(package, "reinstalled")
    assert (unit["ActiveState"], unit["Result"]) == ("inactive", "success")
    check_stopped_in_order(package, "reinstalled")
    assert package.text("reinstalled.rig") == "# my own rig\n"


def test_removal_stops_the_loop_in_order_and_leaves_configuration_and_logs(package):
    unit = properties(package, "removed")
    assert (unit["LoadState"], unit["ActiveState"]) == ("not-found", "inactive")
    check_stopped_in_order(package, "removed")
    assert package.lines("removed.files") == CONFIGURATION
    assert package.lines("purged.files") == []
    assert {"run.ulg", "run.1.ulg", "run.2.ulg"} <= set(package.lines("logs"))
