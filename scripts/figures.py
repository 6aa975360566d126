#!/usr/bin/env python3
"""Redraws the figures of the paper from computation and judges its claims: figures.html and a PNG of each figure."""
import argparse
import sys
from pathlib import Path

import claims
from berth_log import InputError
from berth_program import ROOT, Berth
from compensated_figures import CompensatedData, compensated_figures
from figures_page import build_page
from figures_picture import build_picture
from paper_case import CASES, FAST, Case
from paper_data import PaperData
from paper_figures import all_figures
from report import EXIT_INPUT, write_whole


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rig", choices=CASES, default=FAST, help="the case (default: ess)")
    parser.add_argument("--plain", action="store_true",
                        help="without the figures with compensation, which take most of the time")
    parser.add_argument("--beside", choices=CASES,
                        help="another case, plain, in a folder of its name; what both share is computed once")
    parser.add_argument("--out", type=Path, default=ROOT / "build" / "figures",
                        help="folder for page and pictures (default: build/figures)")
    parser.add_argument("--berth", type=Path, default=ROOT / "build" / "berth",
                        help="the host command, which computes everything (default: build/berth)")
    return parser.parse_args()


def draw(data, out, is_plain):
    """Page and pictures of one case."""
    found = claims.measure(data)
    figures = all_figures(data) + ([] if is_plain else compensated_figures(CompensatedData(data)))
    for figure in figures:
        write_whole(out / f"{figure.file_stem}.png", build_picture(figure))
    page = out / "figures.html"
    content = build_page(figures, found, data.case.rig, page).encode()
    write_whole(page, content)
    print(claims.text(found), end="")
    print(f"{page} ({len(content) / 1e6:.1f} MB), and {len(figures)} pictures beside it")


def main():
    arguments = parse_arguments()
    try:
        first = PaperData(Berth(arguments.out / "data", arguments.berth), Case(arguments.rig))
        draw(first, arguments.out, arguments.plain)
        if arguments.beside:
            out = arguments.out / arguments.beside
            out.mkdir(exist_ok=True)
            draw(PaperData(first.berth, Case(arguments.beside), concept=first.concept), out, True)
    except InputError as error:
        print(f"figures: {error}", file=sys.stderr)
        return EXIT_INPUT
    return 0


if __name__ == "__main__":
    sys.exit(main())
