"""Public robot descriptions: each file below $BERTH_URDF_DIR is read and agrees with Pinocchio, or is refused in words.

None of them is part of this repository. One folder below it is one collection."""

import os
import pathlib
import re
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from urdf_oracle import disagreement

SEED = int(os.environ.get("BERTH_SEED", "20261129"))
STATES = 10
AGREE = 1e-12  # of the largest entry
FOLDER = os.environ.get("BERTH_URDF_DIR", "")
# Of each collection named, how many of its files must be read: what is refused of it is no arm.
READ_AT_LEAST = {"example-robot-data": (60, 69)}
# Arms that must be among what is read, by its own moments of inertia or by those that berth states.
WANTED = ("SSRMS_Canadarm2", "SRMS_Canadarm", "ETSVII", "panda", "kuka_iiwa", "ur5_robot", "ur10_robot", "kinova", "tiago",
          "tiago_dual", "2_iiwa_base")
ADVICE = re.compile(r'<inertia> of link "(.*)": no body has it: .* The nearest that a body has: ([-a-z0-9., +]*[0-9])')
ADVICE_MAX = 50  # links of a file


def collections():
    if not FOLDER or not list(pathlib.Path(FOLDER).rglob("*.urdf")):
        pytest.skip("PUBLIC ROBOT DESCRIPTIONS WERE NOT TRIED: no *.urdf below $BERTH_URDF_DIR")
    return {path.name: sorted(path.rglob("*.urdf")) for path in sorted(pathlib.Path(FOLDER).iterdir()) if path.is_dir()}


def with_advice(text, message):
    """The file with the moments of inertia that the message states in the place of its own; None: it states none."""
    advice = ADVICE.search(message)
    if advice is None:
        return None
    robot = ElementTree.fromstring(text)
    link = next(link for link in robot.findall("link") if link.get("name") == advice[1])
    for pair in advice[2].split(", "):
        link.find("inertial/inertia").set(*pair.split())
    return ElementTree.tostring(robot, encoding="unicode")


def compared_with_advice(text, message, file, random):
    """What is refused for its inertia, read with what berth states to be the nearest that a body has."""
    for _ in range(ADVICE_MAX):
        text = with_advice(text, message)
        if text is None:
            return None, message
        file.write_text(text)
        worst, arm = disagreement(file, (), text, random, STATES)
        if worst is not None:
            return worst, arm
        message = arm
    return None, message


def outcome(file, random, tmp_path):
    """"read", "mended", "refused" or "alone", a line on it, and whether all is as it should be."""
    text = file.read_text(encoding="utf-8", errors="replace")
    message = ""
    try:
        worst, arm = disagreement(file, (), text, random, STATES)
        kind = "read"
        if worst is None:
            message = arm
            worst, arm = compared_with_advice(text, message, tmp_path / file.name, random)
            kind = "mended"
    except (ValueError, ElementTree.ParseError) as error:  # what Pinocchio and Python raise
        return "alone", f"{message}; read, but not by Pinocchio or Python: {error}", True
    if message and not message.splitlines()[-1].startswith(f"berth: {file}:"):
        return "refused", message, False
    if worst is None:
        return "refused", message, True
    base = "free" if arm["base"]["is_free"] else "held"
    line = f"{len(arm['joint'])} joints, {base} base; inertia {worst[0]:.0e}, bias {worst[1]:.0e}"
    return kind, (f"{message}; with the moments that it states: " if message else "") + line, worst.max() <= AGREE


def test_public_descriptions_are_read_or_refused_in_words(tmp_path):
    print(f"seed {SEED}; again: BERTH_SEED={SEED} pytest -s tests/python/test_urdf_public.py")
    random = np.random.default_rng(SEED)
    wrong, there, read = [], set(), {}
    for collection, files in collections().items():
        counts = dict.fromkeys(("read", "mended", "refused", "alone"), 0)
        for file in files:
            kind, line, is_right = outcome(file, random, tmp_path)
            print(f"{collection}/{file.name}: {kind}: {line.replace(str(file), file.name)}")
            counts[kind] += 1
            if kind in ("read", "mended"):
                there.add(file.stem)
            if not is_right:
                wrong.append((str(file), line))
        read[collection] = (counts["read"], len(files))
        print(f"{collection}: {counts['read']} of {len(files)} read and as Pinocchio has them to {AGREE:g}, "
              f"{counts['mended']} refused and so with the moments of inertia that the refusal states, "
              f"{counts['refused']} refused, {counts['alone']} not read by Pinocchio or Python")
    print("of those wanted not there: " + (", ".join(name for name in WANTED if name not in there) or "none"))
    assert not wrong, wrong
    for collection, (least, of) in READ_AT_LEAST.items():
        if collection in read:
            assert read[collection][0] * of >= least * read[collection][1], (collection, read[collection])
