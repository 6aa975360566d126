#!/usr/bin/env python3
"""Makes a report of a run beside its log: LOG.html with zoomable plots, LOG.png for a README."""
import argparse
import os
import sys
from pathlib import Path

import progress
from berth_log import InputError, behind_latest, read_log, read_summary, write_whole
from report_accuracy import accuracy_of
from report_figure import build_figure
from report_page import build_page
from report_reduction import sweeps_of

ROOT = Path(__file__).resolve().parents[1]
EXIT_INPUT = 2


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("log", metavar="LOG", type=Path, help="a .ulg file written by `berth run`")
    parser.add_argument("--berth", type=lambda path: Path(path).resolve(), default=ROOT / "build" / "berth",
                        help="the host command, which tells the run's result from the log (default: build/berth)")
    parser.add_argument("--accuracy", metavar="JSON", type=Path,
                        help="what `berth accuracy RIG --json` printed, for a run with an arm (default: LOG with "
                             ".accuracy.json instead of .ulg, if there is one)")
    parser.add_argument("--no-poses", action="store_true",
                        help="of a rig with an arm: leave out the arm's swing over its poses, which may take a minute")
    parser.add_argument("--out", metavar="FILE.html", type=Path,
                        help="the page to write, and a picture beside it (default: beside the log)")
    return parser.parse_args()


def refuse_unwritable(page, log):
    """Before seconds are spent on it: a log may lie in the folder of another user. Raises InputError."""
    folder = page.absolute().parent
    if not folder.is_dir():
        raise InputError(f"{folder}: there is no such folder; make it first (mkdir -p), or choose another with --out")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise InputError(f"{folder}: you may not write there, so the page cannot stand beside the log; choose another "
                         f"place: berth report {log} --out ~/{page.name}")


def main():
    progress.end_with_the_pipe()
    arguments = parse_arguments()
    arguments.log = behind_latest(arguments.log)
    try:
        progress.show(f"report: reads {arguments.log}")
        summary = read_summary(arguments.log, arguments.berth)
        log = read_log(arguments.log)
        page = arguments.out or arguments.log.with_suffix(".html")
        refuse_unwritable(page, arguments.log)
        sweeps = None if arguments.no_poses else sweeps_of(log, arguments.berth)
        progress.show(f"report: draws {page}")
        text = build_page(log, summary, page, accuracy_of(log, arguments.accuracy), sweeps)
        picture = page.with_suffix(".png")
        progress.show(f"report: draws {picture}")
        contents = {page: text.encode(), picture: build_figure(log, summary)}
        progress.show()
        for path, content in contents.items():
            write_whole(path, content)
            print(f"{path} ({len(content) / 1e6:.1f} MB)")
    except InputError as error:
        progress.show()
        print(f"report: {error}", file=sys.stderr)
        return EXIT_INPUT
    return 0


if __name__ == "__main__":
    sys.exit(main())
