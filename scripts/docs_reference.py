"""The reference pages that are generated from the code: each returns Markdown. Names come from the sources and from
build/berth, so they cannot drift. What the code does not describe in words (causes of a stop, limits, log fields) is
described in scripts/docs/descriptions.toml; a name without a description is an error, and so is the reverse."""

import json
import re
import subprocess
import tomllib
from pathlib import Path

import cantools
import readme

ROOT = readme.ROOT
BERTH = ROOT / "build" / "berth"
DESCRIPTIONS = ROOT / "scripts" / "docs" / "descriptions.toml"


class Undescribed(Exception):
    pass


def berth(*words):
    return subprocess.run([BERTH, *words], cwd=ROOT, capture_output=True, text=True, check=True).stdout


def source(path):
    return (ROOT / path).read_text()


def cell(text):
    return str(text).replace("|", "\\|").replace("\n", " ")


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(map(cell, row)) + " |" for row in rows]) + "\n"


def unit_of(name):
    """The unit in the last part of a name, in the usual notation; empty where there is none."""
    units = {"N_s_per_m": "N s/m", "N_per_m3": "N/m³", "N_per_m2": "N/m²", "N_per_m": "N/m", "rad_per_s2": "rad/s²",
             "rad_per_s": "rad/s", "m_per_s2": "m/s²", "m_per_s": "m/s", "N_m_s": "N m s", "N_m2": "N m²", "N_m": "N m",
             "kg_per_m": "kg/m", "N_per_s": "N/s", "ms_per_s": "ms/s", "per_s": "1/s", "kg_m2": "kg m²", "s2": "s²",
             "ppm": "ppm", "Hz": "Hz", "hz": "Hz", "ms": "ms", "ns": "ns", "us": "µs", "rad": "rad", "deg": "°",
             "kg": "kg", "dB": "dB", "mm": "mm", "um": "µm", "m": "m", "s": "s", "N": "N", "J": "J", "W": "W"}
    return next((unit for ending, unit in units.items() if name.endswith("_" + ending)), "")


def described(section, names):
    """{name: description} in the order of `names`; both sides must agree."""
    have = tomllib.loads(DESCRIPTIONS.read_text())[section]
    lacking, extra = [name for name in names if not have.get(name)], [name for name in have if name not in names]
    if lacking or extra:
        raise Undescribed(f"{DESCRIPTIONS}, [{section}]: no description of {lacking}, nothing is called {extra}")
    return {name: have[name] for name in names}


# --- rig keys --------------------------------------------------------------------------------------------------------

LARGEST = 1e300  # a bound beyond it says no more than that the number is finite


def schema_range(key):
    """The values that a key may have, in words."""
    if "enum" in key:
        return ", ".join(f"`{value}`" for value in key["enum"])
    names = {"minimum": "from", "exclusiveMinimum": "above", "maximum": "to", "maxLength": "characters: at most"}
    words = [f"{word} {key[bound]:g}" for bound, word in names.items()
             if abs(key.get(bound) or 0) < LARGEST and key.get(bound) is not None]
    return " ".join(words + ["or inf"] * bool(key.get("inf")))


def schema_default(key, required):
    if key.get("default") is not None:
        return f"`{json.dumps(key['default'])}`"
    return "`inf`" if key.get("inf") else "required" if required else ""


def schema_rows(section, required=()):
    for name, key in section.items():
        if not key.get("description", "").strip():
            raise Undescribed(f"rig key {name} has no description in the schema")
        yield f"`{name}`", key.get("unit", ""), schema_default(key, name in required), schema_range(key), key["description"]


def schema_sections(properties, above=""):
    """(heading, section) of every section, inner ones after their own."""
    for name, section in properties.items():
        if section.get("type") == "array" and "properties" in section.get("items", {}):
            yield f"[[{above}{name}]]", section["items"] | {"description": section["description"]}
        elif section.get("type") == "object":
            inner = section.get("properties", {})
            plain = {key: value for key, value in inner.items() if value.get("type") != "object"}
            if plain or not inner:
                yield f"[{above}{name}]", section | {"properties": plain}
            yield from schema_sections({key: value for key, value in inner.items() if value.get("type") == "object"},
                                       f"{above}{name}.")


def rig_keys():
    schema = json.loads(berth("schema"))
    head = ["key", "unit", "default", "values", "meaning"]
    top = {name: key for name, key in schema["properties"].items() if key["type"] not in ("object", "array") or
           name == "assumed"}
    text = ["# Rig keys", "Every key of a rig file, from `berth schema`. A section may be left out, and so may a key: berth then "
            "assumes the default, and lists it before the verdict. The object, the manipulator's mass and the robot's dead "
            "time must be stated all the same. A value may also be `{ value = 100.0, tolerance = 0.03 }`.\n",
            "## At the top", table(head, schema_rows(top))]
    for heading, section in schema_sections({name: key for name, key in schema["properties"].items() if name not in top}):
        text += [f"## {heading}", section["description"].capitalize() + ".\n"]
        # [tolerances] and [signals] have members by the names of keys and signals: the description says so.
        if section["properties"] and heading not in ("[tolerances]", "[signals]"):
            text.append(table(head, schema_rows(section["properties"], section.get("required", ()))))
    return "\n\n".join(text)


# --- commands --------------------------------------------------------------------------------------------------------

def subcommands():
    """{name: one line} from `berth --help`."""
    listed = berth("--help").split("Subcommands:")[1]
    return dict(re.findall(r"^  (\S+) *(.*)$", listed, re.M))


def cli():
    text = ["# Commands", "From `berth --help` and `berth COMMAND --help`.\n",
            table(["command", "what it does"], [(f"[`{name}`](#{name})", line) for name, line in subcommands().items()])]
    for name, line in subcommands().items():
        if not line.strip():
            raise Undescribed(f"berth {name} has no line in --help")
        text += [f"## {name}", f"```text\n{berth(name, '--help').strip()}\n```"]
    return "\n\n".join(text)


def shipped():
    text = ["# Shipped rigs and robots", "## Rigs", "From `berth rigs`. `base = \"NAME\"` in a rig file starts from one.\n",
            table(["rig", "what it is"], re.findall(r"^(\S+) +(\S.*)$", berth("rigs"), re.M)),
            "## Robots", "From `sim_hal/robots`. Dead times are reports of single users: a range, not a promise.\n"]
    rows = []
    for file in sorted((ROOT / "sim_hal" / "robots").glob("*.toml")):
        robot = tomllib.loads(file.read_text())
        loop, arm = robot.get("loop", {}), robot.get("robot", {})
        period = loop.get("period_ms") or (1000 / loop["rate_Hz"] if "rate_Hz" in loop else "")
        dead = arm.get("dead_time_ms", f"{arm.get('dead_time_periods')} periods")
        rows.append((f"`{robot['name']}`", robot["description"], period, dead, robot["source"]))
    text.append(table(["robot", "what it is", "period in ms", "dead time in ms", "who reports it"], rows))
    return "\n\n".join(text)


# --- effects, faults, log --------------------------------------------------------------------------------------------

def effects():
    text = ["# Effects", "From `berth effects`. An effect is in the rig when one of its keys is set. `berth diagnose` looks "
            "for all of them.\n"]
    for effect in json.loads(berth("effects", "--json")):
        if not (effect["physics"] and effect["source"] and all(p["meaning"] for p in effect["parameters"])):
            raise Undescribed(f"effect {effect['effect']} lacks physics, source or a meaning")
        rows = [(f"`{p['key']}`", unit_of(p["key"]), f"{p['low']:g} to {p['high']:g}", p["meaning"])
                for p in effect["parameters"]]
        text += [f"## {effect['effect']}", effect["physics"], f"Source: {effect['source']}.\n",
                 table(["key", "unit", "range of the search", "meaning"], rows)]
    return "\n\n".join(text)


def enum_names(path, enum, prefix):
    """Names of an enumeration's members, in words: STOP_BUS_OFF is "bus off"."""
    body = re.search(rf"enum {enum} \{{(.*?)\}};", source(path), re.S)[1]
    body = re.sub(r"/\*.*?\*/", "", body, flags=re.S)
    names = re.findall(rf"\b{prefix}_(\w+)", body)
    return [name.lower().replace("_", " ") for name in names if name not in ("NONE", "COUNT", "STATE_COUNT", "CAUSE_COUNT")]


def faults():
    states = described("states", enum_names("firmware/supervisor.h", "supervisor_state", "SUPERVISOR"))
    causes = described("causes", enum_names("firmware/supervisor.h", "stop_cause", "STOP"))
    limits = described("limits", enum_names("firmware/limits.h", "limit", "LIMIT"))
    goes_to = dict(re.findall(r"SUPERVISOR_(\w+), STOP_(\w+)\}", source("firmware/supervisor.c"))[::-1] and
                   [(cause.lower().replace("_", " "), state.lower()) for state, cause in
                    re.findall(r"SUPERVISOR_(\w+), STOP_(\w+)\}", source("firmware/supervisor.c"))[::-1]])
    return "\n\n".join([
        "# States, faults and limits",
        "Names come from `firmware/supervisor.h` and `firmware/limits.h`. The state and the cause are in the log, in "
        "`berth run`, in `berth summary` and in the frame `loop_status`.\n",
        "## States", table(["state", "meaning"], states.items()),
        "## Causes of a stop", "A cause that leads to `holding` may pass by itself. A cause that leads to `fault` needs a "
        "person: a reset request.\n",
        table(["cause", "leads to", "meaning, and what to do"],
              [(name, goes_to.get(name, ""), what) for name, what in causes.items()]),
        "## Limits", "A limit changes one setpoint and is recorded. It is no fault.\n",
        table(["limit", "meaning"], limits.items())])


LOG_TOPICS = {
    "tick": ("firmware/recorder.h", "TICK_RECORD_FIELDS", "One message a tick: what went in, what came out."),
    "can_frame": ("firmware/recorder.h", "FRAME_RECORD_FIELDS", "One message for each CAN frame received or sent."),
    "arm": ("firmware/arm/arm_record.h", "ARM_RECORD_FIELDS", "One message a tick, for a rig with an arm."),
    "side": ("firmware/side_record.h", "SIDE_RECORD_FIELDS", "One message a tick, for a rig with more than one axis."),
    "rig": ("sim_hal/hil/rig_record.h", "RIG_RECORD_FIELDS", "One message a tick, from the simulated rig alone: the truth."),
}


def log_fields(path, macro):
    """(type, name) of the fields of one record."""
    body = re.search(rf"#define {macro}\(X\)(.*?[^\\])\n", source(path), re.S)[1]
    return re.findall(r"X\((\w+), (\w+)\)", body)


def log():
    text = ["# Log fields", "`berth run` and `berth-target` write ULog, version 1. PlotJuggler, Foxglove and pyulog read it. "
            "`berth export LOG --csv` converts it.\n"]
    for topic, (path, macro, what) in LOG_TOPICS.items():
        fields = log_fields(path, macro)
        meaning = described(f"log.{topic}", [name for _, name in fields]) if topic not in ("arm", "side") else \
            log_patterns(topic, [name for _, name in fields])
        rows = [(f"`{name}`", unit_of(name), kind.removesuffix("_t"), meaning[name]) for kind, name in fields]
        text += [f"## {topic}", what + "\n", table(["field", "unit", "type", "meaning"], rows)]
    return "\n\n".join(text)


def log_patterns(topic, names):
    """As described(), with patterns in place of names, for fields that come once for each joint or axis."""
    patterns = tomllib.loads(DESCRIPTIONS.read_text())[f"log.{topic}"]
    found = {name: next((what for pattern, what in patterns.items() if re.fullmatch(pattern, name)), None) for name in names}
    if lacking := [name for name, what in found.items() if not what]:
        raise Undescribed(f"{DESCRIPTIONS}, [\"log.{topic}\"]: no description of {lacking}")
    return found


# --- CAN, HAL --------------------------------------------------------------------------------------------------------

def can():
    bus = cantools.database.load_file(ROOT / "firmware" / "can" / "berth.dbc")
    text = ["# CAN messages", "From `firmware/can/berth.dbc`. Classic CAN, 11-bit identifiers, 1 Mbit/s.\n",
            table(["identifier", "message", "sender", "meaning"],
                  [(f"0x{m.frame_id:03X}", f"[`{m.name}`](#{m.name})", ", ".join(m.senders), m.comment) for m in bus.messages])]
    for message in bus.messages:
        if not message.comment:
            raise Undescribed(f"message {message.name} has no comment in berth.dbc")
        rows = [(f"`{s.name}`", s.start, s.length, "Motorola" if s.byte_order == "big_endian" else "Intel",
                 f"{s.scale:g}", f"{s.minimum:g} to {s.maximum:g}", s.unit or "",
                 ", ".join(f"{value} {name}" for value, name in (s.choices or {}).items())) for s in message.signals]
        text += [f"## {message.name}", f"0x{message.frame_id:03X}. {message.comment}\n",
                 table(["signal", "start bit", "bits", "byte order", "step", "range", "unit", "values"], rows)]
    return "\n\n".join(text)


def words_of(comment):
    return " ".join(line.strip().lstrip("*").strip() for line in comment.splitlines()).strip()


def hal():
    header = source("hal/hal.h")
    text = ["# HAL contract", "From the comments of `hal/hal.h`. `tests/contract` holds both implementations to it: the "
            "simulated rig, and Linux with real buses.\n", words_of(re.match(r"/\*(.*?)\*/", header, re.S)[1]), "## Functions"]
    functions = re.findall(r"/\*((?:(?!\*/).)*?)\*/\n(enum hal_status (hal_\w+)\([^;]*\);)", header, re.S)
    if len(functions) != header.count("\nenum hal_status hal_"):
        raise Undescribed("hal/hal.h: a function has no comment")
    for comment, declaration, name in functions:
        text += [f"### {name}", f"```c\n{declaration}\n```", words_of(comment)]
    text += ["## Types"]
    for kind_name, body in re.findall(r"^((?:struct|enum) \w+) \{\n(.*?)^\};", header, re.S | re.M):
        text += [f"### {kind_name}", f"```c\n{kind_name} {{\n{body}}};\n```"]
    return "\n\n".join(text)


def first_comment(text):
    """What a source file says of itself: its first comment that is more than a name."""
    found = re.search(r"^/\*(.*?)\*/", text, re.S | re.M)
    return words_of(found[1]) if found else ""


def oracles():
    """The cases of tests/theory, by file."""
    text = ["# Oracles in the tests", "Every file of `tests/theory`: what it compares, its cases, and the command. A closed "
            "form, another solver or a published table stands against berth's number in each.\n"]
    for file in sorted((ROOT / "tests" / "theory").glob("*_test.cpp")):
        content = file.read_text()
        cases = re.findall(r'^TEST_CASE\("((?:[^"\\]|\\.)*)"', content, re.M)
        text += [f"## {file.stem.removesuffix('_test')}", first_comment(content), "\n".join(f"- {case}" for case in cases),
                 f"`build/cpp_tests -sf='*theory/{file.stem}*'`"]
    return "\n\n".join(part for part in text if part)


def pages():
    """{file name: Markdown} of every generated page."""
    make = {"rig-keys": rig_keys, "cli": cli, "rigs-and-robots": shipped, "effects": effects,
            "faults": faults, "log": log, "can": can, "hal": hal, "oracles": oracles}
    return {f"{name}.md": function() for name, function in make.items()}


if __name__ == "__main__":
    for page, content in pages().items():
        Path(page).write_text(content)
