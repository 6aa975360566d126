"""Drives as their public object dictionaries describe them: what each lacks, refuses and needs.

`source` names manual and revision, `read` what was read there (or in the public file that is named). All else of a row
is what CiA 301 and CiA 402 say of a drive. Facts are written down; no text is copied.
"""

from dataclasses import dataclass, field

NO_OBJECT, NO_SUBINDEX = 0x06020000, 0x06090011
READ_ONLY, BAD_VALUE = 0x06010002, 0x06090030

CONTROLWORD, TARGET = 0x60400010, 0x607A0020
STATUSWORD, POSITION = 0x60410010, 0x60640020
MODE, MODE_DISPLAY, VELOCITY = 0x60600008, 0x60610008, 0x60FF0020


@dataclass(frozen=True, eq=False)
class Drive:
    name: str
    source: str
    read: str
    rate_Hz: int = 400
    rig: dict = field(default_factory=dict)  # keys of the rig file beside the rate
    lacks: tuple = ()  # objects
    values: dict = field(default_factory=dict)  # (object, subindex): what it holds at first
    refuses: dict = field(default_factory=dict)  # (object, subindex): what may be written, or () for nothing; then the code
    fixed_pdos: dict = field(default_factory=dict)  # mapping object: its entries, which cannot be written
    only_default_cob_ids: bool = False
    late_mode: bool = False  # 0x6061 shows the mode only when enabled
    homing: str = ""  # "attained", or "error"
    refused: tuple = ()  # words of the refusal; (): it is enabled and follows
    holds: dict = field(default_factory=dict)  # (object, subindex): what the set-up has to have left there


MS_ONLY = {(0x60C2, 2): ((-3,), BAD_VALUE)}
STATIC_PDOS = {0x1600: (CONTROLWORD,), 0x1601: (CONTROLWORD, MODE), 0x1602: (CONTROLWORD, TARGET),
               0x1603: (CONTROLWORD, VELOCITY), 0x1A00: (STATUSWORD,), 0x1A01: (STATUSWORD, MODE_DISPLAY),
               0x1A02: (STATUSWORD, POSITION), 0x1A03: (STATUSWORD, 0x606C0020)}
GUARDED = (0x1016, 0x1017)

DRIVES = (
    Drive("maxon EPOS4", "EPOS4 Firmware Specification rel8234, November 2018; its EDS, file version 2, for Module 50/5",
          "no 0x1006, no 0x608F, 0x6091, 0x6092, 0x607E; 0x60C2:01 from 0 to 100; 12 objects a PDO; COB-ID of TPDO 1 "
          "with bit 30; 0x6098 is 7", rate_Hz=500, lacks=(0x1006,),
          refuses={**MS_ONLY, (0x60C2, 1): (range(101), BAD_VALUE)}, values={(0x1800, 1): 0x40000181, (0x60C2, 1): 0},
          holds={(0x60C2, 1): 2, (0x60C2, 2): -3}),
    Drive("Elmo", "MAN-CAN301IG 2.1 and MAN-CAN402IG 1.2; mode 8 is of later lines (Gold, Platinum), not read",
          "COB-IDs other than the default are aborted; transmission types 1, 254, 255; 0x60C2:02 is read only, -3; "
          "0x60C2:01 from 1 to 255", rate_Hz=250, only_default_cob_ids=True,
          refuses={(0x60C2, 2): ((), READ_ONLY), (0x60C2, 1): (range(1, 256), BAD_VALUE),
                   (0x1400, 2): ((1, 254, 255), BAD_VALUE), (0x1800, 2): ((1, 254, 255), BAD_VALUE)},
          holds={(0x60C2, 1): 4, (0x60C2, 2): -3}),
    Drive("Nanotec", "C5-E Technical Manual 1.3.1 (FIR-v1626); PD4-E Technical Manual 1.0.1 (FIR-v1748), pages 255, 256",
          "0x60C2:02 has to be -3; 0x608F holds 2000 and 1, and can be written", rate_Hz=500, refuses=MS_ONLY,
          rig={"cia402.encoder_counts": 4096, "cia402.encoder_revolutions": 1, "cia402.gear_motor_revolutions": 5,
               "cia402.gear_shaft_revolutions": 2, "cia402.feed_counts": 500000, "cia402.feed_shaft_revolutions": 1,
               "cia402.polarity": "reversed"},
          values={(0x608F, 1): 2000, (0x608F, 2): 1},
          holds={(0x608F, 1): 4096, (0x608F, 2): 1, (0x6091, 1): 5, (0x6091, 2): 2, (0x6092, 1): 500000,
                 (0x6092, 2): 1, (0x607E, 0): 0x80}),
    Drive("Copley", "CANopen Programmer's Manual 16-01195, revision 00, June 2017", "the title alone could be read",
          holds={(0x60C2, 1): 25, (0x60C2, 2): -4, (0x1006, 0): 2500}),
    Drive("Trinamic", "TMCM-6212 CANopen Firmware Manual V3.22, revision 1.05, page 27",
          "0x1016 is one number of 16 bits, without subindex 1: it cannot name the node that it watches",
          rate_Hz=500, rig={"cia402.must_watch_loop": "false"},
          refuses={(0x1016, 1): ((), NO_SUBINDEX), (0x60C2, 2): ((-3,), BAD_VALUE)}),
    Drive("Trinamic, to be watched", "the same", "the same", rate_Hz=500, refuses={(0x1016, 1): ((), NO_SUBINDEX)},
          refused=("would not stop when the loop dies", "object 0x1016:01", "cia402.must_watch_loop = false")),
    Drive("Technosoft iPOS", "iPOS CANopen Programming User Manual P091.063.iPOS.STO.UM.0117, section 10; public driver "
          "roboticslab-uc3m/yarp-devices", "0x60C2 in ms, index -3; the driver enables first and then waits for the mode",
          rate_Hz=100, refuses=MS_ONLY, late_mode=True,
          rig={"robot.dead_time_ms": 300, "sensor.delay_ms": 100, "cia402.state_timeout_ms": 500},
          holds={(0x60C2, 1): 10}),
    Drive("Kollmorgen AKD", "AKD CANopen, November 2012, page 145; pages 80 and 52 (S300): default mapping of RPDO 1",
          "homing by SDO: mode 6, controlwords 6, 7, 0x0F, 0x1F, then statusword 0x1637", homing="attained",
          rig={"cia402.homing_method": 35}, holds={(0x6098, 0): 35, (0x6060, 0): 8}),
    Drive("Kollmorgen AKD, homing fails", "the same; bit 13 of the statusword: CiA 402", "the same", homing="error",
          rig={"cia402.homing_method": 7}, refused=("homing has failed", "object 0x6041:00")),
    Drive("ERL PCS", "erl-elektronik.de, support, FAQ 117, PDO mapping; mode 8 not read",
          "static mapping of CiA 402: PDO 3 carries controlword and target, statusword and position",
          fixed_pdos=STATIC_PDOS, holds={(0x1402, 1): 0x201, (0x1802, 1): 0x40000181, (0x1400, 1): 0x80000201}),
    Drive("fixed mapping without a target", "CiA 402, pre-defined PDOs 1 and 2 alone", "",
          fixed_pdos={index: STATIC_PDOS[index] for index in (0x1600, 0x1601, 0x1A00, 0x1A01)},
          refused=("PDO mapping is fixed", "object 0x1600:00")),
    Drive("minimal", "CiA 301, node guarding; ros_canopen issue 106: drives without heartbeat; guarding as in INVEOR "
          "DOC01738251-0001 2.00, page 40", "100C, 100D; answers carry a bit that toggles; silence stops the motor",
          lacks=(*GUARDED, 0x1006, 0x6502, 0x6061), holds={(0x100C, 0): 100, (0x100D, 0): 3}),
    Drive("nobody sees it go", "CiA 301: one of both is mandatory", "", lacks=(*GUARDED, 0x100C, 0x100D),
          refused=("object 0x100C:00", "the object does not exist", "neither heartbeat (0x1017) nor node guarding")),
    Drive("Nanotec at 400 Hz", "the same as Nanotec", "the same", refuses=MS_ONLY,
          refused=("object 0x60C2:02", "1000 divided by such a whole number")),
    Drive("without 0x60C2", "CiA 402: the object is optional", "", lacks=(0x60C2,),
          refused=("object 0x60C2:02", "the object does not exist")),
    Drive("wrong: an I/O module", "CiA 401", "device profile 401", values={(0x1000, 0): 0x00020191},
          refused=("object 0x1000:00", "it holds 0x20191", "0x192")),
    Drive("wrong: no mode 8", "Elmo MAN-CAN402IG 1.2: modes of the SimplIQ line", "profile and interpolated modes alone",
          values={(0x6502, 0): 0x6D}, refused=("object 0x6502:00", "it holds 0x6D", "0x80")),
    Drive("wrong: sign cannot be set", "maxon EPOS4, the same EDS", "no 0x607E", lacks=(0x607E,), rate_Hz=500,
          rig={"cia402.polarity": "reversed"}, refused=("object 0x607E:00", "the object does not exist", "maker's tool")),
)
