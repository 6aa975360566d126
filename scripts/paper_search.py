#!/usr/bin/env python3
"""Searches the values that the paper does not tell for those under which all of its claims hold, and which lie
farthest from the bound of each: the rig ess-paper.

The search goes over a lattice of plausible values, each a round number: from a coarse choice of starts it walks to the
neighbour with the largest of the smallest margins, until none is better. There is no chance in it. Claims 1, 2 and 8
do not depend on these values and 7 hardly does; the result is judged by all.
"""
import argparse
import sys
import tempfile
from dataclasses import dataclass
from itertools import combinations, product
from math import inf
from pathlib import Path

import claims
from berth_log import InputError
from berth_program import ROOT, Berth
from paper_case import FAST, SLOW, Assumptions, Case
from paper_data import PaperData


@dataclass(frozen=True)
class Range:
    """Plausible values of an assumption, and the lattice on them."""
    name: str
    least: float
    most: float
    step: float
    starts: tuple
    reason: str

    def value(self, index):
        return round(self.least + index * self.step, 9)

    def holds(self, index):
        return 0 <= index <= round((self.most - self.least) / self.step)

    def index(self, value):
        return round((value - self.least) / self.step)


RANGES = (
    Range("manipulator_Hz", 0.5, 2.5, 0.05, (1.0, 1.5, 2.0),
          "first mode of a servicer's arm of a few metres; the wall of 5 Hz is to lie on the paper's maps"),
    Range("manipulator_damping_ratio", 0.01, 0.10, 0.005, (0.05,),
          "elastic joints with gears: a few percent"),
    Range("object_mass_share", 0.05, 0.60, 0.01, (0.1, 0.15, 0.25),
          "first mode of a solar generator, lighter than arm and servicer behind the end effector"),
    Range("object_stiffness_share", 0.10, 1.00, 0.05, (0.3,),
          "a generator that bends more easily than the arm, or as easily"),
    Range("object_damping_ratio", 0.005, 0.03, 0.005, (0.02,),
          "a light structure in vacuum: 0.5 to 3 %"),
    Range("low_pass_Hz", 20.0, 190.0, 5.0, (100.0, 150.0),
          "of a force sensor; below half the sampling rate of 400 Hz"),
)
GRID, WALL_GRID = "121x81", "200x100"  # of the search; the result is judged on those of the figures


def smallest_margin(data, more_than=-inf):
    """Of the claims that depend on the assumptions. Once one is no more than `more_than` the others are not asked:
    the cheap and telling ones come first."""
    smallest = inf
    for margins in (
            lambda: [claims.above(data.highest_stable_Hz()[0], claims.WALL_HZ)],
            lambda: [claims.below(claims.stable_share(data, SLOW, "elasticity"), claims.SMALL_AREA)],
            lambda: [claim.margin for claim in claims.maps_at_half_dead_time(data)],
            lambda: [claims.below(claims.stable_share(data, SLOW, "mass"), claims.SMALL_AREA)],
            lambda: [claim.margin for claim in claims.stability(data)],
            lambda: [claim.margin for claim in claims.maps_at_400_Hz(data)]):
        smallest = min(smallest, *margins())
        if smallest <= more_than:
            break
    return smallest


class Search:
    """Walks over the lattice. A point is a tuple of indices, one a range."""

    def __init__(self, program):
        self.program = program
        self.margins = {}  # by point; an upper bound where the walk needed no more
        self.asked = 0

    def assumptions(self, point):
        return Assumptions(**{each.name: each.value(index) for each, index in zip(RANGES, point)})

    def margin(self, point, more_than):
        known, is_exact = self.margins.get(point, (inf, False))
        if not is_exact and known > more_than:
            with tempfile.TemporaryDirectory() as folder:  # maps are large: they do not stay
                berth = Berth(folder, self.program)
                case = Case(FAST, self.assumptions(point))
                known = smallest_margin(PaperData(berth, case, GRID, WALL_GRID), more_than)
            self.margins[point] = known, known > more_than
            self.asked += 1
        return known

    def neighbours(self, point, stride):
        """One coordinate changed, or two."""
        for count in (1, 2):
            for axes in combinations(range(len(RANGES)), count):
                for signs in product((-stride, stride), repeat=count):
                    moved = list(point)
                    for axis, sign in zip(axes, signs):
                        moved[axis] += sign
                    if all(each.holds(index) for each, index in zip(RANGES, moved)):
                        yield tuple(moved)

    def climb(self, point, at_least):
        """The best point that steps of 4, 2 and 1 lead to from here, and its margin."""
        best = self.margin(point, at_least)
        for stride in (4, 2, 1):
            is_better = True
            while is_better:
                is_better = False
                for moved in self.neighbours(point, stride):
                    margin = self.margin(moved, best)
                    if margin > best:
                        point, best, is_better = moved, margin, True
                        break
        return point, best

    def run(self, starts_count, tell):
        starts = list(product(*[[each.index(value) for value in each.starts] for each in RANGES]))
        ranked = sorted(starts, key=lambda point: (-self.margin(point, -inf), point))
        best_point, best = None, -inf
        for start in ranked[:starts_count]:
            point, margin = self.climb(start, -inf)
            tell(f"{self.margin(start, -inf):+.4f} at {self.assumptions(start)}\n  leads to {margin:+.4f} at "
                 f"{self.assumptions(point)}")
            if margin > best:
                best_point, best = point, margin
        return self.assumptions(best_point), best


def report(search, found, margin, program):
    """Ranges, the result, and the margins of all claims with it, on the grids of the figures."""
    lines = [f"{'assumption':<28}{'found':>8}   {'range':<14}{'step':>6}  reason"]
    for each in RANGES:
        span = f"{each.least:g} to {each.most:g}"
        lines.append(f"{each.name:<28}{getattr(found, each.name):8g}   {span:<14}{each.step:>6g}  {each.reason}")
    lines.append(f"smallest margin {100 * margin:.1f} % on a grid of {GRID}, of {search.asked} cases computed")
    with tempfile.TemporaryDirectory() as folder:
        judged = claims.measure(PaperData(Berth(folder, program), Case(FAST, found)))
    lines.append("margins of all claims, on the grids of the figures")
    for claim in judged:
        margin = "yes or no" if abs(claim.margin) == inf else f"{100 * claim.margin:+.1f} %"
        lines.append(f"{claim.number}  {claim.verdict:<8}{margin:>10}  {claim.figure:<11} {claim.sentence}")
    return "\n".join([*lines, f"{sum(claim.met for claim in judged)} of {len(judged)} met"])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--starts", type=int, default=3, help="from how many of the best starts to walk (default: 3)")
    parser.add_argument("--berth", type=Path, default=ROOT / "build" / "berth", help="the host command")
    arguments = parser.parse_args()
    search = Search(arguments.berth)
    try:
        found, margin = search.run(arguments.starts, lambda line: print(line, flush=True))
        print(report(search, found, margin, arguments.berth))
    except InputError as error:
        print(f"paper_search: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
