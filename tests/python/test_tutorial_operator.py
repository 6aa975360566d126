"""The operator station that the tutorial for a board types as one line of shell, read with berth.dbc."""

import os
import re
import subprocess

import cantools
from conftest import ROOT

PAGE = ROOT / "scripts" / "docs" / "tutorials" / "empty-board.md"
FRAMES = 230
STUB = f"""#!/bin/sh
echo "$@" >> frames
[ $(wc -l < frames) -lt {FRAMES} ] || kill $PPID
"""


def frames_of(line, folder):
    """What the line gives to cansend, which here ends the shell after FRAMES of them; sleep takes no time."""
    for name, text in (("cansend", STUB), ("sleep", "#!/bin/sh\n")):
        (folder / name).write_text(text)
        (folder / name).chmod(0o755)
    subprocess.run(["sh", "-c", line], cwd=folder, env={"PATH": f"{folder}:{os.environ['PATH']}"}, timeout=60)
    return [text.split() for text in (folder / "frames").read_text().splitlines()]


def test_the_line_requests_nothing_and_then_to_run(tmp_path):
    (line,) = re.findall(r"^i=0; while .*cansend.*$", PAGE.read_text(), re.M)
    message = cantools.database.load_file(ROOT / "firmware" / "can" / "berth.dbc").get_message_by_name("operator_motion")
    frames = frames_of(line, tmp_path)
    assert len(frames) == FRAMES
    for index, (channel, frame) in enumerate(frames):
        identifier, data = frame.split("#")
        values = message.decode(bytes.fromhex(data))
        assert channel == "can0" and int(identifier, 16) == message.frame_id and len(data) == 2 * message.length
        assert values["position_m"] == 0 and values["velocity_m_per_s"] == 0
        assert values["counter"] == index % 16
        assert values["request"] == ("none" if index < 200 else "run")
