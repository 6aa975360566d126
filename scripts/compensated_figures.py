"""The figures of the paper that are about stability, with compensation of the dead time: what the paper asks for at
its end. Figs 5 and 6 are about the robot alone, which compensation leaves as it is."""
from functools import cached_property

import numpy as np

from paper_case import FAST, HALF, SLOW
from paper_figures import CASES, Contour, Curve, Figure, Plot, thinned, z_plane
from report_signals import COMMAND, MANIPULATOR, OBJECT, OPERATOR, REPORTED, ROBOT

PREDICTION = {"prediction.enabled": "true"}
IDENTIFICATION = PREDICTION | {"identification.enabled": "true"}
PASSIVITY = {"passivity.action": "damping"}
TANK = {"passivity.action": "tank"}
# Settings, grid, options of `berth map`. A point in the time domain costs up to a thousand times one of eigenvalues; the
# shares are within 4.1 points of those on grids of twice as many points a side.
METHODS = {
    "extrapolation of order 1": ({"extrapolation.order": 1}, "40x30", ()),
    "prediction": (PREDICTION, "48x36", ()),
    "prediction, model wrong": (PREDICTION, "24x18", ("--model", "tolerances")),
    "identification, model wrong": (IDENTIFICATION, "11x9", ("--model", "tolerances")),
    "passivity": (PASSIVITY, "24x18", ()),
    "energy tank": (TANK, "18x14", ()),
}
STYLES = {"without": (OPERATOR, "points"), "extrapolation of order 1": (REPORTED, "points"),
          "prediction": (MANIPULATOR, "points"), "prediction, model wrong": (MANIPULATOR, "ring"),
          "identification, model wrong": (OBJECT, "ring"), "passivity": (ROBOT, "points"),
          "energy tank": (COMMAND, "points")}
DRAWN = ("prediction", "identification, model wrong", "passivity")  # the others are in the overview
MAPS = {12: (SLOW, "elasticity"), 13: (SLOW, "mass"), 14: (FAST, "elasticity"), 15: (FAST, "mass"),
        16: (HALF, "elasticity"), 17: (HALF, "mass")}
WRONG = "a dead time, stiffness or mass of the object that is wrong by 30, 50 or 20 %"


class CompensatedData:
    """Measured when first asked for, and once; `plain` is the data of the figures without."""

    def __init__(self, plain):
        self.plain = plain
        self.berth = plain.berth

    @cached_property
    def copper(self):
        """The log of the concept test on copper, by method."""
        return {name: self.berth.run(f"copper-{name}", "concept-copper", values)[1]
                for name, values in (("prediction", PREDICTION), ("passivity", PASSIVITY), ("tank", TANK))}

    @cached_property
    def spectra(self):
        """What `berth eigen` says with prediction, by rig."""
        return {rig: self.plain.ask("eigen", rig, PREDICTION) for rig in (SLOW, FAST)}

    @cached_property
    def maps(self):
        """By figure and method."""
        return {(number, name): self.plain.map(f"{number}-{name.replace(' ', '-')}", rig, vary, values, grid, options)
                for number, (rig, vary) in MAPS.items() for name, (values, grid, options) in METHODS.items()}

    def share(self, number, name):
        """Of the objects left of the wall, in percent, for which the loop is stable."""
        found = self.plain.maps[MAPS[number]] if name == "without" else self.maps[number, name]
        return 100 * found.told["stable_share_below_wall"]


def concept_test(data):
    panels = []
    for name, log in data.copper.items():
        time_s, position_mm = thinned(log)
        ends_s = np.array([time_s[0], time_s[-1]])
        panels.append(Plot(f"Copper sheet, {name}", "time (s)", "position (mm)", [
            Curve("surface of the material", OPERATOR, ends_s, np.zeros(2), "dash"),
            Curve("robot", ROBOT, time_s, position_mm)]))
    peaks = ", ".join(f"{name} {np.abs(log.rig['measured_force_N']).max():.0f} N" for name, log in data.copper.items())
    return Figure("Fig. 4 compensated", "Concept test on copper, which is unstable without compensation",
                  f"20 ms of dead time, as in Fig. 4. Largest force: {peaks}.", panels)


def eigenvalues(data, number, rig, rate):
    told, plain = data.spectra[rig], data.plain.spectra[rig]
    return Figure(f"Fig. {number} compensated", f"Eigenvalues with prediction, {rate} sampling rate",
                  f"{CASES[rig]}. The slow mode lies where it would without dead time: growth "
                  f"{told['growth_per_s']:+.5f} /s, coupled without dead time {slowest(told['coupled']):+.5f} /s, without "
                  f"compensation {plain['growth_per_s']:+.5f} /s. Prediction adds the modes of its twin of the hardware.",
                  [z_plane(told, False, "loop with prediction"), z_plane(told, True, "loop with prediction")])


def slowest(spectrum):
    return spectrum["growth_per_s"]


def stable_area(data, number):
    rig, vary = MAPS[number]
    plain = data.plain.maps[rig, vary]
    panels = [Contour(data.maps[number, name], f"{name}: {data.share(number, name):.1f} % stable", plain)
              for name in DRAWN]
    without = data.share(number, "without")
    faithful = 100 * data.maps[number, "identification, model wrong"].told["time_domain"]["faithful_share_below_wall"]
    gains = "; ".join(f"{name} {data.share(number, name):.1f} % ({data.share(number, name) - without:+.1f})"
                      for name in METHODS)
    return Figure(f"Fig. {number} compensated", f"Area of stable simulations ({vary} variation)",
                  f"{CASES[rig]}. Dotted: limit without compensation. Stable of what lies left of the wall: {without:.1f} % without; {gains} points. "
                  "The prediction's model is each object as it is. Identification starts with "
                  f"{WRONG}. Each is tried alone, and the worst counts: the motion is within 5 % of that without dead time in "
                  f"{faithful:.1f} % of the area. Identification, "
                  "passivity and tank have no eigenvalues: each point was run for 20 s. Hatched: a fault ended the run before "
                  "it had a growth.",
                  panels)


def overview(data):
    numbers = np.array(list(MAPS), float)
    curves = [Curve(name, *STYLES[name][:1], numbers, np.array([data.share(number, name) for number in MAPS]),
                    STYLES[name][1]) for name in ("without", *METHODS)]
    gain_60, gain_20 = (data.share(n, "prediction") - data.share(n, "without") for n in (12, 14))
    return Figure("Compensated", "How much more of the area left of the 5 Hz wall is stable",
                  f"Elasticity varied, with prediction: {gain_20:.1f} points more of the area at 20 ms of dead time (Fig. 14), "
                  f"{gain_60:.1f} more at 60 ms (Fig. 12). Model wrong: {WRONG}. Each is tried alone, and the worst counts.",
                  [Plot("", "figure of the paper (number)", "stable of what lies left of the wall (%)", curves,
                        y_range=(-3.0, 105.0))])


def compensated_figures(data):
    """In the order of the paper, the overview first."""
    return [overview(data), concept_test(data), eigenvalues(data, 10, SLOW, "50 Hz"),
            eigenvalues(data, 11, FAST, "400 Hz"), *[stable_area(data, number) for number in MAPS]]
