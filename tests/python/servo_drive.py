"""A CiA 402 drive of python `canopen`: its object dictionary, and what a servo drive does with SYNC and PDOs."""

import canopen
from canopen.profiles.p402 import State402

NODE, MASTER = 1, 127
COUNTS_PER_M = 1e8
SYNC, NMT = 0x080, 0x000


class ServoDrive:
    """A CiA 402 drive of python canopen: its SDO server, NMT slave, heartbeat, emergency producer, PDO mapping and
    table of transitions. What is written here: PDOs by SYNC, and that it is always where it was sent."""

    def __init__(self, bus, start_counts=round(0.01 * COUNTS_PER_M), pdos=1, **changed):
        self.bus = bus
        self.start_counts = start_counts
        self.node = canopen.LocalNode(NODE, servo_dictionary(NODE, pdos))
        bus.network.add_node(self.node)
        self.state = "SWITCH ON DISABLED"
        self.states = [self.state]
        self.controlword = 0
        self.waiting = None
        self.targets = []
        self.heartbeats = []  # ticks at which the master's came
        for name, value in changed.items():
            self.node.object_dictionary[int(name, 16)].default = value
        bus.network.subscribe(NMT, self.on_nmt)
        bus.network.subscribe(SYNC, self.on_sync)
        bus.network.subscribe(0x700 + MASTER, lambda *_: self.heartbeats.append(bus.ticks))
        self.node.add_write_callback(self.on_write)
        self.boot()

    def boot(self):
        self.node.nmt.stop_heartbeat()
        self.node.nmt.state = "INITIALISING"  # sends the boot-up message
        self.node.nmt.state = "PRE-OPERATIONAL"

    def on_nmt(self, _, data, __):
        if data[0] in (0x81, 0x82) and data[1] in (0, NODE):
            assert self.state != "OPERATION ENABLED", "reset while it moves"
            self.boot()
        elif data[0] == 0x01:
            self.node.pdo.read()
            for pdo in (*self.node.rpdo.values(),):
                pdo.callbacks = []
                pdo.add_callback(self.on_rpdo)

    def on_write(self, index, data, **_):
        if index == 0x6060:
            self.node.data_store.setdefault(0x6061, {})[0] = bytes(data)

    def on_rpdo(self, pdo):
        if self.node.nmt.state == "OPERATIONAL":
            self.waiting = {variable.index: variable.raw for variable in pdo}

    def command_of(self, controlword):
        """The command that the bits make, as the table of transitions names it."""
        if not controlword & 0x2:
            return State402.CW_DISABLE_VOLTAGE
        if not controlword & 0x4:
            return State402.CW_QUICK_STOP
        if not controlword & 0x1:
            return State402.CW_SHUTDOWN
        return State402.CW_OPERATION_ENABLED if controlword & 0x8 else State402.CW_SWITCH_ON

    def obey(self, controlword):
        resets = controlword & ~self.controlword & 0x80
        self.controlword = controlword
        command = self.command_of(controlword)
        for (before, after), code in State402.TRANSITIONTABLE.items():
            wanted = resets if before == "FAULT" else code == command
            if before == self.state and wanted:
                self.enter(after)
                return

    def enter(self, state):
        self.state = state
        self.states.append(state)

    def statusword(self):
        return State402.SW_MASK[self.state][1] | 0x210

    def position(self):
        return self.targets[-1][1] if self.targets else self.start_counts

    def on_sync(self, *_):
        if self.node.nmt.state != "OPERATIONAL":
            return
        if self.waiting is not None:
            self.obey(self.waiting[0x6040])
            if self.state == "OPERATION ENABLED":
                self.node.sdo[0x607A].raw = self.waiting[0x607A]
                self.targets.append((self.bus.ticks, self.waiting[0x607A]))
        tpdo = next(pdo for pdo in self.node.tpdo.values() if pdo.enabled and pdo.cob_id == 0x180 + NODE)
        tpdo[0x6041].raw = self.statusword()
        tpdo[0x6064].raw = self.position()
        self.bus.network.send_message(tpdo.cob_id, tpdo.data)


def variable(dictionary, index, name, kind, default, subindex=None, access="rw", record=None):
    """Adds a variable to an object dictionary, or to one of its records."""
    made = canopen.objectdictionary.ODVariable(name, index, subindex or 0)
    made.data_type = kind
    made.access_type = access
    made.default = default
    made.pdo_mappable = True
    if record is None:
        dictionary.add_object(made)
    else:
        record.add_member(made)
    return made


def servo_dictionary(node_id, pdos=1):
    """The objects of a CiA 402 servo drive that a master in cyclic synchronous position needs, with so many PDOs each
    way."""
    types = canopen.objectdictionary
    od = types.ObjectDictionary()
    od.node_id = node_id

    def record(index, name, members):
        made = types.ODRecord(name, index)
        od.add_object(made)
        for subindex, (member, kind, default) in enumerate(members):
            variable(od, index, member, kind, default, subindex, record=made)

    variable(od, 0x1000, "Device type", types.UNSIGNED32, 0x00020192, access="ro")
    variable(od, 0x1001, "Error register", types.UNSIGNED8, 0, access="ro")
    variable(od, 0x1006, "Communication cycle period", types.UNSIGNED32, 0)
    variable(od, 0x1017, "Producer heartbeat time", types.UNSIGNED16, 0)
    record(0x1016, "Consumer heartbeat time", [("Entries", types.UNSIGNED8, 1), ("Consumer 1", types.UNSIGNED32, 0)])
    for n in range(pdos):
        for index, name, cob_id in ((0x1400 + n, f"RPDO {n + 1}", 0x200), (0x1800 + n, f"TPDO {n + 1}", 0x180)):
            record(index, name, [(f"{name} entries", types.UNSIGNED8, 2),
                                 ("COB-ID", types.UNSIGNED32, (0 if n == 0 else 1 << 31) + cob_id + 0x100 * n + node_id),
                                 ("Transmission type", types.UNSIGNED8, 255)])
        for index, name in ((0x1600 + n, f"RPDO {n + 1} mapping"), (0x1A00 + n, f"TPDO {n + 1} mapping")):
            record(index, name, [(f"{name} entries", types.UNSIGNED8, 0)] +
                   [(f"Object {i}", types.UNSIGNED32, 0) for i in range(1, 9)])
    variable(od, 0x100C, "Guard time", types.UNSIGNED16, 0)
    variable(od, 0x100D, "Life time factor", types.UNSIGNED8, 0)
    variable(od, 0x6040, "Controlword", types.UNSIGNED16, 0)
    variable(od, 0x6041, "Statusword", types.UNSIGNED16, 0, access="ro")
    variable(od, 0x6060, "Modes of operation", types.INTEGER8, 0)
    variable(od, 0x6061, "Modes of operation display", types.INTEGER8, 0, access="ro")
    variable(od, 0x6064, "Position actual value", types.INTEGER32, 0, access="ro")
    variable(od, 0x607A, "Target position", types.INTEGER32, 0)
    variable(od, 0x606C, "Velocity actual value", types.INTEGER32, 0, access="ro")
    variable(od, 0x60FF, "Target velocity", types.INTEGER32, 0)
    variable(od, 0x607E, "Polarity", types.UNSIGNED8, 0)
    variable(od, 0x6098, "Homing method", types.INTEGER8, 0)
    for index, name in ((0x608F, "Position encoder resolution"), (0x6091, "Gear ratio"), (0x6092, "Feed constant")):
        record(index, name, [(f"{name} entries", types.UNSIGNED8, 2), ("Numerator", types.UNSIGNED32, 1),
                             ("Denominator", types.UNSIGNED32, 1)])
    record(0x60C2, "Interpolation time period", [("Entries", types.UNSIGNED8, 2), ("Value", types.UNSIGNED8, 1),
                                                 ("Index", types.INTEGER8, -3)])
    variable(od, 0x6502, "Supported drive modes", types.UNSIGNED32, 1 << 7, access="ro")
    return od
