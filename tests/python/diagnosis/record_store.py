"""Makes each test record once and shares it between the rows of the tables and the processes of pytest-xdist.

A record is a folder in build/test_records. Its name is the hash of all that decides its content: the recipe with its
values, the sources that make it, and build/berth where that program takes part.
"""

import contextlib
import fcntl
import hashlib
import json
import os
import shutil
import time

from conftest import ROOT

FOLDER = ROOT / "build" / "test_records"
UNUSED_s = 86400.0  # a day: older ones belong to an earlier program or an earlier recipe


def digest(*paths):
    """Of the content of these files."""
    made = hashlib.sha256()
    for path in sorted(paths):
        made.update(path.name.encode() + b"\0" + path.read_bytes())
    return made.hexdigest()


@contextlib.contextmanager
def locked(path):
    """One process at a time."""
    with path.open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


def made_once(key, make):
    """The folder of the record with this key (a JSON value); `make(folder)` fills it if it is not there."""
    name = hashlib.sha256(json.dumps(key, sort_keys=True).encode()).hexdigest()[:20]
    folder, part = FOLDER / name, FOLDER / f"{name}.part"
    FOLDER.mkdir(parents=True, exist_ok=True)
    with locked(FOLDER / f"{name}.lock"):
        if not folder.exists():
            shutil.rmtree(part, ignore_errors=True)
            part.mkdir()
            make(part)
            part.rename(folder)
        os.utime(folder)
    return folder


def remove_unused():
    """Removes the records that no run has used for a day."""
    for path in FOLDER.glob("*") if FOLDER.exists() else ():
        with contextlib.suppress(FileNotFoundError):
            if time.time() - path.stat().st_mtime > UNUSED_s:
                shutil.rmtree(path) if path.is_dir() else path.unlink()
