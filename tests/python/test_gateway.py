"""The guide's gateway between the loop's firmware and a robot: the loop runs it, and it stops when it has to."""

import struct

import can
import pytest
from conftest import ROOT
from page_program import page_program
from peer_bus import PeerBus

STATES = ["start", "ready", "running", "holding", "fault", "stopped"]
RUN = 2


@pytest.fixture(scope="module")
def gateway_module():
    return page_program("build-a-gateway.md", "gateway")


class Cell:
    """The loop's firmware and the gateway, tick by tick; frames of the loop arrive while `is_connected`."""

    def __init__(self, module):
        self.bus = PeerBus("loop", "ess")
        self.robot = module.StandIn()
        self.robot.position_m = 0.01
        self.gateway = module.Gateway(self.robot, ROOT / "firmware" / "can" / "berth.dbc")
        self.is_connected = True

    def state(self):
        return STATES[self.bus.state[0]]

    def command_m(self):
        return 1e-9 * struct.unpack("<i", self.bus.state[4:])[0]

    def run(self, ticks):
        for _ in range(ticks):
            begin = len(self.bus.heard)
            self.bus.tick()
            for _, identifier, data in self.bus.heard[begin:]:
                if self.is_connected:
                    self.gateway.take(can.Message(arbitration_id=identifier, data=data), self.bus.now_s)
            self.bus.send(self.gateway.cycle(self.bus.now_s))

    def run_until_running(self):
        self.run(10)
        assert self.state() == "ready"
        self.bus.request = RUN
        self.run(20)
        assert self.state() == "running"


@pytest.fixture
def cell(gateway_module):
    made = Cell(gateway_module)
    yield made
    made.bus.close()


def test_the_loop_runs_a_robot_behind_the_gateway(cell):
    cell.run_until_running()
    positions_m = []
    for _ in range(400):
        cell.run(1)
        positions_m.append(cell.robot.position_m)
        assert cell.robot.position_m == pytest.approx(cell.command_m(), abs=1e-9)
    assert cell.state() == "running" and max(positions_m) - min(positions_m) > 0.005


def test_it_holds_the_robot_before_motion_is_allowed(cell):
    cell.run(50)
    assert cell.robot.is_stopped and cell.robot.position_m == 0.01 and cell.state() == "ready"


def test_it_stops_a_robot_that_gets_no_setpoints_and_the_loop_notices(cell):
    cell.run_until_running()
    cell.is_connected = False
    cell.run(10)
    assert cell.robot.is_stopped
    cell.run(60)
    assert cell.state() == "fault"


def test_a_fault_of_the_robot_stops_the_loop(cell):
    cell.run_until_running()
    cell.robot.is_faulted = True
    cell.run(3)
    assert cell.state() == "fault"
    cell.run(3)
    assert cell.robot.is_stopped
