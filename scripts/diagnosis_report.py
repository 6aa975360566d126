#!/usr/bin/env python3
"""Makes the report of a diagnosis in its folder: report.html with zoomable plots, report.png for a README."""
import argparse
import sys
import tempfile
from pathlib import Path

import progress
from berth_log import InputError
from berth_program import ROOT, Berth
from diagnosis_data import read_diagnosis
from diagnosis_page import build_page
from diagnosis_picture import build_picture
from diagnosis_stability import measure
from report import EXIT_INPUT, write_whole


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", metavar="DIR", type=Path, help="the folder that `berth diagnose --out` wrote")
    parser.add_argument("--berth", type=Path, default=ROOT / "build" / "berth",
                        help="the host command, which tells the limits of stability (default: build/berth)")
    return parser.parse_args()


def main():
    arguments = parse_arguments()
    try:
        progress.show(f"diagnosis_report: {arguments.folder}")
        diagnosis = read_diagnosis(arguments.folder)
        with tempfile.TemporaryDirectory() as folder:
            found = measure(diagnosis, Berth(folder, arguments.berth))
        page = build_page(diagnosis, found, arguments.folder / "report.html")
        reports = {"report.html": page.encode(), "report.png": build_picture(diagnosis)}
        progress.show()
        for name, content in reports.items():
            path = arguments.folder / name
            write_whole(path, content)
            print(f"{path} ({len(content) / 1e6:.1f} MB)")
    except InputError as error:
        progress.show()
        print(f"diagnosis_report: {error}", file=sys.stderr)
        return EXIT_INPUT
    return 0


if __name__ == "__main__":
    sys.exit(main())
