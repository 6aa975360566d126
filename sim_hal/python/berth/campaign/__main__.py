"""`berth campaign`: python -m berth.campaign FILE.toml, or report [FOLDER]."""
from __future__ import annotations

import argparse
import os
import signal
import sys
from pathlib import Path

from ..errors import InputError
from .cluster import needed

FOLDER = Path("build/campaigns")
EXIT_INTERRUPTED, EXIT_INPUT = 1, 2


def main(words: list[str] | None = None) -> int:
    arguments = _parser().parse_args(words)
    try:
        needed("pyarrow", "a campaign")
        needed("scipy", "a campaign")
        return _report(arguments) if arguments.file == "report" else _run(arguments)
    except InputError as error:
        print(f"berth: {error}", file=sys.stderr)
        return EXIT_INPUT


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="berth campaign", description="Campaigns of many rigs.")
    parser.add_argument("file", metavar="FILE", help="a campaign file, or the word report")
    parser.add_argument("folder", metavar="FOLDER", nargs="?", default="")
    parser.add_argument("--out", default="")
    parser.add_argument("--scheduler", default="")
    parser.add_argument("--workers", type=int, default=0)
    for name in ("--resume", "--anew", "--yes", "--slurm"):
        parser.add_argument(name, action="store_true")
    return parser


def _run(arguments) -> int:
    from .engine import Interrupted, run
    from .report import lines, summarise
    from .spec import Spec
    if arguments.folder:
        raise InputError(f"{arguments.folder}: goes with `report` alone; name the folder of a new campaign with --out")
    spec = Spec.load(arguments.file)
    folder = Path(arguments.out or FOLDER / spec.name)
    try:
        run(spec, folder, scheduler=arguments.scheduler, slurm=arguments.slurm, workers=arguments.workers,
            resume=arguments.resume, anew=arguments.anew, yes=arguments.yes,
            tell=lambda line: print(f"{spec.name}: {line}", file=sys.stderr, flush=True))
    except Interrupted as error:
        print(f"berth: {error}", file=sys.stderr)
        return EXIT_INTERRUPTED
    print("\n".join([*lines(summarise(folder), short=True), f"  more           berth campaign report {folder}"]))
    return 0


def _newest() -> Path:
    found = sorted(FOLDER.glob("*/campaign.json"), key=lambda path: path.stat().st_mtime)
    if not found:
        raise InputError(f"{FOLDER}: has no campaign; run one with `berth campaign FILE.toml`, or name its folder")
    return found[-1].parent


def _report(arguments) -> int:
    from .page import write_page
    from .report import lines, summarise
    found = summarise(Path(arguments.folder) if arguments.folder else _newest())
    print("\n".join(lines(found)))
    print(f"  page           {write_page(found)}")
    return 0


def end() -> None:
    """Without waiting for what Dask's threads may still do."""
    code = main()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


if __name__ == "__main__":
    signal.signal(signal.SIGPIPE, signal.SIG_DFL)
    end()
