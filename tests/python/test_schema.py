"""`berth schema`: the JSON schema of rig files, against the rigs that the program reads and those that it refuses."""

import json
import math
import pathlib
import tomllib

import jsonschema
import pytest
from conftest import EXIT_INPUT, RIG_FOLDER, RIGS, command

VALUE_KEYS = {"value", "tolerance"}  # of { value = 100, tolerance = 0.05 }


@pytest.fixture(scope="module")
def schema():
    done = command("schema")
    assert done.returncode == 0 and done.stderr == b""
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def validator(schema):
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


def read(rig):
    return tomllib.loads((RIG_FOLDER / f"{rig}.toml").read_text())


def described(schema, path=""):
    """(path, schema) of every key and section that a rig file can hold."""
    for name, key in schema.get("properties", {}).items():
        if name not in VALUE_KEYS:
            yield f"{path}{name}", key
            yield from described(key, f"{path}{name}.")
    if schema.get("type") == "array":
        yield from described(schema["items"], path)


@pytest.mark.parametrize("rig", RIGS)
def test_a_shipped_rig_validates_as_it_stands_and_as_it_is_printed(rig, validator):
    validator.validate(read(rig))
    printed = command("run", rig, "--print-config").stdout.decode()
    validator.validate(tomllib.loads(printed))


@pytest.mark.parametrize("change, words", [
    ({"robot": {"dead_tme_ms": 17.5}}, "dead_tme_ms"),             # a key
    ({"robott": {"dead_time_ms": 17.5}}, "robott"),                # a section
    ({"robot": {"dead_time_s": 0.0175}}, "dead_time_s"),           # a unit
    ({"object": {"stiffness_N_per_mm": 2.0}}, "stiffness_N_per_mm"),
    ({"object": {"mass_kg": 0.0}}, "minimum of 1e-06"),                # a range
    ({"object": {"mass_kg": {"value": -1.0}}}, "minimum of 1e-06"),
    ({"object": {"mass_kg": {"value": 1.0, "tolerance": 1.0}}}, "maximum of 1"),
    ({"sensor": {"loss_probability": 1.5}}, "maximum of 1"),
    ({"wrench": {"roll_rad": 11.0}}, "maximum of 10"),
    ({"object": {"kind": "griped"}}, "griped"),                    # a word
    ({"manipulator": {"arm": {"kind": "plane"}}}, "is not valid"),
    ({"robot": {"dead_time_ms": "17.5 ms"}}, "is not of type"),    # a type
    ({"sensor": {"low_pass_order": 1.5}}, "is not of type 'integer'"),
    ({"sensor": {"low_pass_order": 3}}, "maximum of 2"),
    ({"bus": {"ideal": 1}}, "is not of type 'boolean'"),
    ({"sensor": {"delay_ms": 2e5}}, "maximum of 100000"),
    ({"axis": {"y": {"inertia_kg_m2": 1.0}}}, "inertia_kg_m2"),    # of an axis that turns
    ({"orders": [{"line_m": [0.1, 0.0]}]}, "at_s"),
    ({"tolerances": {"robot.clock": 0.1}}, "robot.clock"),
    ({"signals": {"force_kN": "F"}}, "force_kN"),
    ({"base": "esss"}, "'esss' is not valid"),                     # a base
    ({"base": ""}, "'' is not valid"),
    ({"base": "none/such"}, "'none/such' is not valid"),
    ({"robot": {"dead_time_ms": math.inf}}, "maximum of"),         # what is not finite
    ({"limits": {"position_min_m": -math.inf}}, "minimum of"),
    ({"object": {"mass_kg": {"value": math.inf}}}, "maximum of"),
    ({"orders": [{"at_s": math.inf}]}, "maximum of"),
    ({"axis": {"y": {"mass_kg": math.inf}}}, "maximum of"),
])
def test_the_schema_refuses_what_the_program_refuses(change, words, validator, tmp_path):
    rig = read("ess")
    for section, keys in change.items():
        if isinstance(keys, dict):
            rig.setdefault(section, {}).update(keys)
        else:
            rig[section] = keys
    errors = list(validator.iter_errors(rig))
    assert len(errors) == 1 and words in errors[0].message, errors
    file = tmp_path / "wrong.toml"
    file.write_text(toml_text(rig))
    assert command("run", file, "--print-config").returncode == EXIT_INPUT


def toml_text(rig):
    """Of nested mappings; JSON's words for values are TOML's, but for inline tables."""
    def value(thing):
        if isinstance(thing, dict):
            return "{ " + ", ".join(f"{json.dumps(key)} = {value(inner)}" for key, inner in thing.items()) + " }"
        if isinstance(thing, list):
            return "[" + ", ".join(map(value, thing)) + "]"
        return json.dumps(thing)
    return "".join(f"{name} = {value(thing)}\n" for name, thing in rig.items())


def test_every_key_and_section_says_what_it_is(schema):
    keys = dict(described(schema))
    keys |= {f"arm.{path}": key for path, key in described(schema["$defs"]["arm"])}
    assert len(keys) > 300
    undescribed = [path for path, key in keys.items()
                   if len(key.get("description", "").split()) < 2 and "$ref" not in key]
    assert undescribed == []
    assert [path for path, key in keys.items() if key.get("description", "").startswith("of the same")
            and not path.startswith("arm.")] == []


def test_a_key_with_a_unit_in_its_name_states_it(schema):
    """By the last word of the name, not by the program's own table."""
    ends = {"_m", "_s", "_ms", "_us", "_kg", "_N", "_Hz", "_rad", "_J", "_W", "_ppm", "_m2", "_s2", "_m3", "_frames",
            "_ticks"}
    for path, key in [*described(schema), *described(schema["$defs"]["arm"])]:
        name = path.rpartition(".")[2]
        has_unit = any(name.endswith(end) for end in ends) or "_per_" in name
        if "$ref" not in key and "properties" not in key or key.get("type") == ["number", "object"]:
            assert ("unit" in key) == has_unit, path
    keys = dict(described(schema))
    assert keys["object.damping_N_s_per_m"]["unit"] == "N s/m"
    assert keys["axis.rz.stiffness_N_m_per_rad"]["unit"] == "N m/rad"
    assert keys["object.stiffness_drift_per_s"]["unit"] == "1/s"


def test_defaults_are_those_of_a_rig_that_states_nothing_else(schema, tmp_path):
    file = tmp_path / "least.toml"
    file.write_text("[manipulator]\nmass_kg = 200\n[robot]\ndead_time_ms = 17.5\n[object]\nmass_kg = 100\n")
    printed = tomllib.loads(command("run", file, "--print-config").stdout.decode())
    compared = 0
    for path, key in described(schema):
        section, _, name = path.partition(".")
        if name and name in printed.get(section, {}) and path not in ("manipulator.mass_kg", "object.mass_kg"):
            expected = key.get("default", float("inf"))
            assert printed[section][name] == expected, path
            compared += 1
    assert compared > 120


@pytest.mark.parametrize("base", ["ess", "concept-arm-foam", "mine.toml", "../rigs/my rig.toml"])
def test_a_base_is_a_shipped_rig_or_a_file(base, validator):
    validator.validate({"base": base})


@pytest.mark.parametrize("key", ["run.emergency_stop_s", "prediction.mass_kg", "sensor.saturation_N"])
def test_inf_stays_where_it_means_never(key, validator):
    section, _, name = key.partition(".")
    validator.validate({section: {name: math.inf}})


@pytest.mark.parametrize("line, other, told", [
    ("dead_time_ms = 17.5", "dead_time_ms = nan", "robot.dead_time_ms: must be a finite number (is nan); write a number"),
    ("mass_kg = 100.0", "mass_kg = { value = nan }", "object.mass_kg"),
    ("position_min_m = -1.0", "position_min_m = 2.0",
     "limits.position_min_m: must be smaller than limits.position_max_m; are the two exchanged?"),
    ('name = "ess"', 'name = "ess"\nbase = "esss"', "base: must be a shipped rig (ess, "),
    ('name = "ess"', 'name = "ess"\nbase = "esss"', "did you mean ess?"),
    ('name = "ess"', 'name = "ess"\nbase = "/"', "base: must be a shipped rig (ess, "),
])
def test_check_refuses_what_no_schema_can(line, other, told, schema, tmp_path):
    """With file, line, key and remedy. The schema's description says so."""
    text = (RIG_FOLDER / "ess.toml").read_text()
    assert text.count(line) == 1
    file = tmp_path / "wrong.toml"
    file.write_text(text.replace(line, other))
    done = command("check", file)
    number = text[:text.index(line)].count("\n") + 1 + other.count("\n")
    assert done.returncode == EXIT_INPUT
    shown = done.stderr.decode()
    assert f"{file}:{number}: " in shown and told in shown
    assert "nan" in schema["description"] and "berth check" in schema["description"]


def test_the_schema_is_the_same_each_time_and_stands_in_one_file(schema):
    assert command("schema").stdout == command("schema").stdout
    assert schema["$schema"] == "https://json-schema.org/draft/2020-12/schema"
    assert pathlib.PurePath(schema["$id"]).name == schema["$id"]


VALUES = (-1.0, 0.0, 1e-9, 0.5, 7.0, 1e3, 1e6, 1e12, 1e300)
# What a range of one key cannot say: it hangs on another key, on the kind of the rig, or has a gap.
RULES_BETWEEN_KEYS = {
    "sensor.rate_Hz",            # 0, or from 1 on; not faster than the bus
    "robot.transfer_frequency_Hz",  # up to 1e6 Hz, or infinite
    "robot.dead_time_ms", "robot.jitter_ms", "robot.deadband_m", "dissipation.damping_N_s_per_m", "run.duration_s",
    "sensor.sample_phase_ms",
}


@pytest.mark.long
def test_a_value_out_of_one_keys_range_does_not_validate(schema, validator):
    """Of each number of the rig file; what berth says with a range of that key, the schema refuses as well."""
    wrong = []
    for section, properties in schema["properties"].items():
        for name, key in properties.get("properties", {}).items():
            path = f"{section}.{name}"
            if path in RULES_BETWEEN_KEYS or path.startswith("axis.") or "minimum" not in json.dumps(key):
                continue
            for value in VALUES:
                rig = read("ess")
                rig.setdefault(section, {})[name] = value
                said = command("run", "ess", "--print-config", "--set", f"{path}={value}").stderr.decode()
                has_range = f"{path}: must be " in said or f"{path}: must not be" in said
                if has_range and validator.is_valid(rig) and "whole number" not in said:
                    wrong.append((path, value, said.strip()))
    assert not wrong, "\n".join(map(str, wrong))
