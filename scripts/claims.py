#!/usr/bin/env python3
"""The claims of the paper, each decided by what the host command computes or measures, and its figure.

`make figures` shows each under its figure.
"""
import argparse
import sys
import tempfile
import textwrap
from dataclasses import dataclass, field
from math import inf
from string import ascii_lowercase

import numpy as np

from berth_log import InputError
from berth_program import Berth
from paper_case import CASES, FAST, HALF, SLOW, Case, assumptions_of
from paper_data import ADDED_SAMPLES, RATES_HZ, SUBSTEPS, WIDE_LOW_PASS_HZ, PaperData

WALL_HZ = 5.0  # up to where the paper's robot is an ideal transmitter

# What words of the paper are taken to mean.
SMALL_AREA = 0.25           # "only a very small area": less than this share of what the robot could display
WIDE_AREA_TIMES = 2.0       # "a wide area": so many times the small one
NEAR_LIMIT_TIMES = 2.0      # "not far away from the limit": less than so many times the value of ess
SMALL_RISE = 0.05           # "a small increase" of the amplitude ratio
LINEAR_WITHIN = 0.005       # "linear": a straight line is met within this
IDEAL_WITHIN = 0.001        # "an ideal transmitter": amplitude ratio 1 within this
NOT_CURED_SHARE = 0.5       # refining "is not valid": more than this share of the growth stays


@dataclass(frozen=True)
class Claim:
    """One claim. `figure` is a name as in paper_figures; `values` are the numbers that decide. `margin`: how far
    they are from the bound, as a share of it, negative where the claim is missed; infinite where it is yes or no."""
    number: str
    sentence: str
    figure: str
    margin: float
    measured: str
    values: dict = field(default_factory=dict)
    remark: str = ""  # where it is missed, what would make it true

    @property
    def met(self):
        return self.margin > 0.0

    @property
    def verdict(self):
        return "met" if self.met else "NOT MET"


def yes_or_no(met):
    return inf if met else -inf


def below(value, bound):
    """Margin of a value that has to be below a bound."""
    return 1.0 - value / bound


def above(value, bound):
    return value / bound - 1.0 if bound > 0.0 else inf


def concept_test(data):
    growth_per_s = {name: result["growth_per_s"] for name, (result, _) in data.concept.items()}
    verdicts = {name: result["stable"] for name, (result, _) in data.concept.items()}
    return [Claim(
        "1", "Two passive systems closed through dead time go unstable, dependent only on the object", "Fig. 4",
        yes_or_no(verdicts == {"foam": True, "copper": False, "no_dead_time": True}),
        f"growth with foam {growth_per_s['foam']:+.3f} /s, with copper {growth_per_s['copper']:+.2f} /s, with "
        f"copper but without dead time {growth_per_s['no_dead_time']:+.3f} /s", {"growth_per_s": growth_per_s})]


def eigenvalues(data):
    claims = []
    for rig, figure in ((SLOW, "Fig. 10"), (FAST, "Fig. 11")):
        counts = data.eigenvalue_counts[rig]
        step = data.steps[rig]
        claims.append(Claim(
            "2", "Every further sample of dead time adds one eigenvalue", figure,
            yes_or_no(counts == [counts[0] + added for added in ADDED_SAMPLES]),
            f"{counts[0]} eigenvalues, with 1, 2 ... {ADDED_SAMPLES[-1]} samples of {step['period_ms']:g} ms more: "
            f"{counts[1]}, {counts[2]} ... {counts[-1]}", {"counts": counts}))
    return claims


def stability(data):
    claims = []
    for rig, figure, case in ((SLOW, "Fig. 10", "50 Hz with 60 ms"), (FAST, "Fig. 11", "400 Hz with 20 ms")):
        told = data.spectra[rig]
        claims.append(Claim(
            "3", f"{data.case.spoken} is stable at {case} of dead time", figure,
            told["growth_per_s"] / told["coupled"]["growth_per_s"],  # decay as a share of that without dead time
            f"largest |z| {told['spectral_radius']:.9f}, growth {told['growth_per_s']:+.6f} /s",
            {"spectral_radius": told["spectral_radius"]}))
    return claims


def stable_share(data, rig, vary):
    """Of the objects that the robot could display."""
    return data.maps[rig, vary].told["stable_share_below_wall"]


def maps_at_50_Hz(data):
    claims = []
    for figure, vary in (("Fig. 12", "elasticity"), ("Fig. 13", "mass")):
        share = stable_share(data, SLOW, vary)
        remark, values = "", {"share": share}
        if vary == "mass" and share >= SMALL_AREA:
            values["share_hold"] = data.mass_map_with_hold(SLOW).told["stable_share_below_wall"]
            fast = data.mass_map_with_hold(FAST).told["stable_share_below_wall"]
            bands = data.limits(SLOW)["object.mass_kg"]["stable_intervals"]
            remark = (f"With a robot that jumps to its setpoints and holds: {100 * values['share_hold']:.1f} %, and "
                      f"{100 * fast:.1f} % at 400 Hz. With the damper of {data.case.spoken} the mass may lie in "
                      f"{len(bands)} bands, of " + ", ".join(f"{low:.1f} to {high:.1f}" for low, high in bands) + " kg.")
        claims.append(Claim(
            "4", f"50 Hz: only a very small area is stable when the {vary} of the object varies", figure,
            below(share, SMALL_AREA), f"{100 * share:.1f} % of what the robot could display is stable", values, remark))
    return claims


def maps_at_400_Hz(data):
    share, slow = (stable_share(data, rig, "elasticity") for rig in (FAST, SLOW))
    share_times = share / slow if slow > 0.0 else inf
    highest_Hz, damping_ratio = data.highest_stable_Hz()
    times = {key: data.times_to_limit(key) for key in ("object.mass_kg", "object.stiffness_N_per_m")}
    mass_kg = times["object.mass_kg"] * data.case.assumptions.values()["object.mass_kg"]
    remark, values = "", {"highest_Hz": highest_Hz}
    if highest_Hz <= WALL_HZ:
        wider_Hz, wider_ratio = data.highest_stable_Hz({"sensor.low_pass_frequency_Hz": WIDE_LOW_PASS_HZ})
        values["wider_Hz"] = wider_Hz
        remark = (f"With a force low-pass of {WIDE_LOW_PASS_HZ} Hz in place of "
                  f"{data.case.assumptions.low_pass_Hz:g} Hz: up to {wider_Hz:.2f} Hz, at {wider_ratio:.2f}. "
                  "The paper states neither low-pass nor masses.")
    return [
        Claim("5", "400 Hz: a wide area is stable", "Fig. 14", above(share, WIDE_AREA_TIMES * slow),
              f"{100 * share:.1f} % of what the robot could display is stable, {share_times:.1f} times that "
              "at 50 Hz",
              {"share": share, "times": share_times}),
        Claim("5", f"400 Hz: the stable area lies partly beyond the {WALL_HZ:g} Hz wall of the robot", "Fig. 14",
              above(highest_Hz, WALL_HZ),
              f"stable up to {highest_Hz:.2f} Hz, at a damping ratio of {damping_ratio:.2f}", values, remark),
        Claim("5", f"400 Hz: {data.case.spoken} is not far from the limit, above all when the object mass varies",
              "Fig. 15", min(below(times["object.mass_kg"], NEAR_LIMIT_TIMES),
                             above(times["object.stiffness_N_per_m"], NEAR_LIMIT_TIMES))
              if data.spectra[FAST]["stable"] else -inf,
              f"limit at {mass_kg:.3f} kg, {times['object.mass_kg']:.2f} times that of "
              f"{data.case.spoken}; of the elasticity at {times['object.stiffness_N_per_m']:.2f} times",
              {"mass_kg": mass_kg, "times": times}),
    ]


def maps_at_half_dead_time(data):
    claims = []
    for figure, vary in (("Fig. 16", "elasticity"), ("Fig. 17", "mass")):
        share, whole = (stable_share(data, rig, vary) for rig in (HALF, FAST))
        claims.append(Claim(
            "6", f"Half the dead time extends the stable area ({vary})", figure, above(share, whole),
            f"from {100 * whole:.1f} % to {100 * share:.1f} % of what the robot could display",
            {"share": share, "whole": whole}))
    share = stable_share(data, HALF, "elasticity")
    claims.insert(1, Claim(
        "6", "Half the dead time: not the whole range left of the 5 Hz wall is stable", "Fig. 16", below(share, 1.0),
        f"{100 * (1.0 - share):.1f} % of it is unstable", {"share": share}))
    return claims


def refinement(data):
    exact = data.growth_exact_per_s
    fine = data.growth_by_substeps["semi_implicit_euler"][-1]
    least = min([growth for found in data.growth_by_substeps.values() for growth in found] + data.growth_by_rate)
    return [Claim(
        "7", "Refining the simulation step does not cure an unstable loop", "Refinement",
        above(least, NOT_CURED_SHARE * exact) if exact > 0.0 else -inf,
        f"growth {exact:+.4f} /s; with {SUBSTEPS[-1]} steps a tick {fine:+.4f} /s, with {RATES_HZ[-1]} ticks a "
        f"second {data.growth_by_rate[-1]:+.4f} /s",
        {"exact_per_s": exact, "fine_per_s": fine, "fast_per_s": data.growth_by_rate[-1]})]


def robot(data):
    found = data.amplitude
    off_line = np.abs(found.without - found.line()).max()
    is_rising = bool((np.diff(found.without) > 0.0).all())
    rise = found.without[-1] - 1.0
    left = np.abs(found.with_filter - 1.0).max()
    steps = {rig: data.steps[rig]["command_to_motion_ms"] for rig in (SLOW, FAST)}
    return [
        Claim("8", "The robot's amplitude ratio rises slightly and linearly up to 5 Hz", "Fig. 5",
              min(below(rise, SMALL_RISE), below(off_line, LINEAR_WITHIN)) if is_rising else -inf,
              f"by {100 * rise:.2f} % at 5 Hz, at most {100 * off_line:.2f} % off a straight line",
              {"rise": rise, "off_line": off_line},
              "A robot of second order, as assumed here, starts with the square of the frequency."),
        Claim("8", "The rise can be filtered away", "Fig. 5", below(left, IDEAL_WITHIN),
              f"with the inverse filter {100 * left:.3f} % are left", {"left": left}),
        Claim("8", "The dead times show in the command-motion step: 40 ms at 50 Hz, 17.5 ms at 400 Hz", "Fig. 6",
              yes_or_no(np.allclose([steps[SLOW], steps[FAST]], [40.0, 17.5], rtol=0.0, atol=1e-3)),
              f"{steps[SLOW]:.3f} ms and {steps[FAST]:.3f} ms", {"dead_time_ms": steps}),
    ]


# Claim 1 has rigs of its own, 2 counts states, and 8 is about the robot alone: what is assumed of manipulator and
# object does not count there.
OF_ASSUMPTIONS = (stability, maps_at_50_Hz, maps_at_400_Hz, maps_at_half_dead_time, refinement)


def measure(data, parts=(concept_test, eigenvalues, *OF_ASSUMPTIONS, robot)):
    """All claims, in the order of their numbers."""
    return [claim for part in parts for claim in part(data)]


def text(claims):
    """A table for a terminal and for the README."""
    lines = []
    for claim in claims:
        lines.append(f"{claim.number}  {claim.verdict:<8} {claim.figure:<11} {claim.sentence}")
        lines += textwrap.wrap(f"{claim.measured}. {claim.remark}", 112, initial_indent=" " * 12,
                               subsequent_indent=" " * 12)
    met = sum(claim.met for claim in claims)
    return "\n".join(lines) + f"\n{met} of {len(claims)} met\n"


def assumption_table(berth, rig):
    """Which assumption each claim of a case hangs on: whether it holds with one of them put back to that of ess."""
    own, usual = assumptions_of(rig), assumptions_of(FAST)
    cases = {"-": (f"{rig} as it is", Case(rig))}
    for letter, (name, changed) in zip(ascii_lowercase, own.with_one_of(usual).items()):
        put_back = f"{name:<26}{getattr(own, name):>7g} -> {getattr(usual, name):g}"
        cases[letter] = put_back, Case(FAST, changed)
    cases["*"] = "all of them: ess", Case(FAST)
    found = {letter: measure(PaperData(berth, case), OF_ASSUMPTIONS) for letter, (_, case) in cases.items()}
    lines = [f"each claim that depends on what is assumed, with one assumption of {rig} put back to that of ess:",
             "+ met, . NOT MET; claims 1, 2 and 8 do not depend on any"]
    lines += [f"  {letter}  {words}" for letter, (words, _) in cases.items()]
    lines.append(f"{'':<16}{'  '.join(cases)}")
    for of_one in zip(*found.values()):
        marks = "  ".join("+" if claim.met else "." for claim in of_one)
        lines.append(f"{of_one[0].number}  {of_one[0].figure:<11}  {marks}  {of_one[0].sentence}")
    met = "  ".join(f"{letter} {sum(claim.met for claim in claims)}" for letter, claims in found.items())
    return "\n".join([*lines, f"met, of {len(found['-'])}: {met}"]) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rig", choices=CASES, default=FAST, help="the case (default: ess)")
    parser.add_argument("--assumptions", action="store_true",
                        help="instead, which assumption of this case each claim hangs on")
    arguments = parser.parse_args()
    try:
        with tempfile.TemporaryDirectory() as folder:
            berth = Berth(folder)
            print(assumption_table(berth, arguments.rig) if arguments.assumptions
                  else text(measure(PaperData(berth, Case(arguments.rig)))), end="")
    except InputError as error:
        print(f"claims: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
