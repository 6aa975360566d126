"""Writes a record with a hidden effect, and apart from it the truth.

    python tests/hidden_effects/generate.py --seed 7 --out DIR --truth DIR [--effect robot.backlash --size large]

DIR of --out: rig.toml, record.csv and for some seeds validate.csv, repeat.csv, standstill.csv. DIR of --truth:
truth.json. The same arguments give the same bytes.
"""

import argparse
import json
import pathlib
import shlex
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import detectability  # noqa: E402
from effects import ASKED_FOR, LIBRARY, SIZES  # noqa: E402
from noise import LEVELS  # noqa: E402
from outside import OUTSIDE  # noqa: E402
from scenario import KINDS, PAIRS, draw  # noqa: E402

HEADER = "t_s,operator_force_N,command_position_m,robot_position_m,force_N"


def csv_text(run, p):
    """A run as CSV: every value with the digits that it has."""
    settle = int(p["settle_ticks"])
    result = run.result
    t_s = np.arange(len(result["force_N"])) * p["period_s"]
    columns = zip(t_s, run.operator_N[settle:], result["command_m"], result["robot_m"], result["force_N"])
    return HEADER + "\n" + "".join("%.6f,%.4f,%.11f,%.9f,%.7f\n" % row for row in columns)


def truth_of(scenario):
    """What only the scorer reads."""
    return {
        "seed": scenario.seed,
        "kind": scenario.kind,
        "effects": [
            {"effect": name, "size": size, "parameters": change.parameters, "detectability": found}
            for (name, size, change), found in zip(scenario.effects, detectability.assess(scenario))
        ],
        "size": scenario.effects[0][1] if scenario.effects else None,
        "noise": scenario.noise_level,
        "richer": scenario.richer,
        "excitation": scenario.excitation,
        "object": scenario.rig.values["object.kind"],
        "floor_rms": {channel: noise.rms for channel, noise in scenario.noise.items()},
        "floor": {channel: vars(noise) for channel, noise in scenario.noise.items()},
        "true_fields": scenario.true,
        "scale": vars(scenario.scale),
    }


def write(scenario, out, truth_folder):
    """Writes record and truth into their folders; the truth."""
    out, truth_folder = pathlib.Path(out), pathlib.Path(truth_folder)
    assert out.resolve() != truth_folder.resolve(), "the truth is not for those who diagnose the record"
    out.mkdir(parents=True, exist_ok=True)
    truth_folder.mkdir(parents=True, exist_ok=True)
    (out / "rig.toml").write_text(scenario.rig.toml())
    for name, run in scenario.runs.items():
        (out / f"{name}.csv").write_text(csv_text(run, scenario.true))
    text = json.dumps(truth_of(scenario), indent=1) + "\n"
    (truth_folder / "truth.json").write_text(text)
    return json.loads(text)


def arguments(words=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--out", required=True, help="folder of the record")
    parser.add_argument("--truth", required=True, help="folder of truth.json")
    parser.add_argument("--effect", help="'none', a name, or two with a comma: " + ", ".join([*LIBRARY, *ASKED_FOR, *OUTSIDE]))
    parser.add_argument("--size", choices=SIZES)
    parser.add_argument("--noise", choices=LEVELS)
    parser.add_argument("--kind", choices=sorted({*KINDS, *PAIRS}))
    return parser.parse_args(words)


def main():
    given = arguments()
    scenario = draw(given.seed, given.effect, given.size, given.kind, given.noise)
    write(scenario, given.out, given.truth)
    print(f"seed {given.seed}; again: {shlex.join(['python', *sys.argv])}")


if __name__ == "__main__":
    main()
