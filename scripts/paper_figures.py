"""What each figure shows: panels of curves and maps, free of how they are drawn. Page and pictures take it from
here, so that they show the same."""
from dataclasses import dataclass

import numpy as np

from berth_map import Map
from paper_case import FAST, HALF, SLOW
from paper_data import (ADDED_SAMPLES, FILTER_BANDWIDTH_HZ, INTEGRATORS, RATES_HZ, ROBOT, STIFF_TIMES, SUBSTEPS,
                        filtered_amplitude, robot_amplitude)
from report_signals import COMMAND, MANIPULATOR, OBJECT, OPERATOR, REPORTED, ROBOT as ROBOT_COLOUR

POINTS_MAX = 3000  # of a curve over time
CASES = {SLOW: "50 Hz, 60 ms of dead time", FAST: "400 Hz, 20 ms of dead time",
         HALF: "400 Hz, half the dead time: 10 ms"}


@dataclass(frozen=True)
class Curve:
    """One curve; `style` is line, dash, dot (a line of dots), or a marker: points, star, ring."""
    label: str
    colour: str
    x: np.ndarray
    y: np.ndarray
    style: str = "line"


@dataclass(frozen=True)
class Plot:
    """Curves on two axes."""
    title: str
    x_title: str
    y_title: str
    curves: list
    x_range: tuple = None
    y_range: tuple = None
    is_equal: bool = False  # one unit is as long on both axes
    is_log_x: bool = False


@dataclass(frozen=True)
class Surface:
    """A map as a surface over its axes, with the plane of no growth and the wall."""
    map: Map

    def every_second(self):
        """x, y and height at every second point of the map, which is fine enough for a surface."""
        return [grid[::2, ::2] for grid in (self.map.x, self.map.y, self.map.measured_growth_per_s())]

    def wall(self):
        """x and y of the wall along the map; nothing where it lies outside."""
        y = np.linspace(self.map.y.min(), self.map.y.max(), 31)
        x = self.map.told["wall_Hz"] / self.map.told["manipulator_Hz"] / np.sqrt(1.0 - y**2)
        inside = (self.map.x.min() <= x) & (x <= self.map.x.max())
        return x[inside], y[inside]


@dataclass(frozen=True)
class Contour:
    """A map from above, with the limit of stability, the wall and the rig itself; `before`: a map whose limit is
    drawn beside it."""
    map: Map
    title: str = ""
    before: Map = None


@dataclass(frozen=True)
class Figure:
    """A figure of the paper. `name` is that of its claims."""
    name: str
    title: str
    caption: str
    panels: list

    @property
    def file_stem(self):
        """Fig. 5 -> fig-05"""
        words = self.name.lower().replace(".", "").split()
        return "-".join(word.zfill(2) if word.isdigit() else word for word in words)


def thinned(log):
    """Time in s and position of the displayed end effector in mm."""
    step = max(1, len(log.rig_s) // POINTS_MAX)
    return log.rig_s[::step], 1e3 * log.rig["robot_position_m"][::step]


def concept_test(data):
    titles = {"foam": "Rubber foam, 20 ms of dead time", "copper": "Copper sheet, 20 ms of dead time",
              "no_dead_time": "Copper sheet, 0.2 ms of dead time"}
    panels = []
    for name, title in titles.items():
        _, log = data.concept[name]
        time_s, position_mm = thinned(log)
        ends_s = np.array([time_s[0], time_s[-1]])
        panels.append(Plot(title, "time (s)", "position (mm)", [
            Curve("surface of the material", OPERATOR, ends_s, np.zeros(2), "dash"),
            Curve("robot", ROBOT_COLOUR, time_s, position_mm)]))
    return Figure("Fig. 4", "Concept test: touching and pushing elastic material",
                  "The paper shows a photograph; this is the test itself. The manipulator moves up to the material "
                  "and 20 mm into it. The rigs differ in the material alone, and both materials are passive; copper "
                  "throws the robot back harder each time until its position limit ends the run.", panels)


def amplitude(data):
    found = data.amplitude
    f = np.linspace(0.0, 6.0, 121)
    return Figure("Fig. 5", "Transfer function of the industrial robot",
                  "Amplitude of the robot against that of the simulated manipulator, measured on the simulated rig "
                  "with 16 sines at once. The paper gives no numbers: the robot is assumed to be of second order, "
                  f"{ROBOT['robot.transfer_frequency_Hz']} Hz and damping ratio "
                  f"{ROBOT['robot.transfer_damping_ratio']}. Measured points lie up to 0.05 % below the closed "
                  "form: the robot moves on straight lines between setpoints, 400 times a second.", [
                      Plot("", "frequency (Hz)", "amplitude ratio (1)", [
                          Curve("closed form: |G_R|", ROBOT_COLOUR, f, robot_amplitude(f)),
                          Curve("straight line that fits best", OPERATOR, found.frequency_Hz, found.line(), "dot"),
                          Curve("closed form with inverse filter", MANIPULATOR, f, filtered_amplitude(f)),
                          Curve("measured", ROBOT_COLOUR, found.frequency_Hz, found.without, "points"),
                          Curve(f"measured with inverse filter of {FILTER_BANDWIDTH_HZ} Hz", MANIPULATOR,
                                found.frequency_Hz, found.with_filter, "points")],
                          x_range=(0.0, 6.0), y_range=(0.99, 1.05))])


def command_to_motion(data):
    curves = [Curve("command", COMMAND, np.array([-20.0, 0.0, 0.0, 90.0]), np.array([0.0, 0.0, 1.0, 1.0]), "dash")]
    for rig, colour, rate in ((FAST, MANIPULATOR, "400 Hz"), (SLOW, ROBOT_COLOUR, "50 Hz")):
        step = data.steps[rig]
        position = np.array(step["step"])
        time_ms = step["period_ms"] * np.arange(len(position))
        curves.append(Curve(f"robot at {rate}: {step['command_to_motion_ms']:.1f} ms", colour,
                            np.insert(time_ms, 0, -20.0), np.insert(position, 0, 0.0)))
    return Figure("Fig. 6", "Time delay from command to motion",
                  "A step of the setpoint by 1 mm, and the robot's own report of its position. Between setpoints "
                  "the robot moves on a straight line: it arrives one dead time after the command.",
                  [Plot("", "time after the command (ms)", "position (mm)", curves, x_range=(-20.0, 90.0),
                        y_range=(-0.1, 1.15))])


def as_complex(pairs):
    return np.array([complex(*pair) for pair in pairs])


def z_plane(told, zoomed, loop_label="loop with dead time"):
    """Eigenvalues that `berth eigen` told: all, or those near the slow mode."""
    loop = as_complex(told["eigenvalues"])
    alone = as_complex(told["manipulator"]["eigenvalues"])
    coupled = as_complex(told["coupled"]["eigenvalues"])
    ranges = {}
    angle = np.linspace(0.0, 2.0 * np.pi, 361)
    title = "z-plane"
    if zoomed:
        slow = np.array([found[found.imag > 0][0] for found in (loop, alone, coupled)])
        centre = slow.mean()
        reach = 2.5 * np.abs(slow - centre).max()
        ranges = {"x_range": (centre.real - reach, centre.real + reach),
                  "y_range": (centre.imag - reach, centre.imag + reach)}
        angle = np.angle(centre) + 3.0 * reach * np.linspace(-1.0, 1.0, 61)
        title = "near the slow mode"
    else:
        ranges = {"x_range": (-1.15, 1.15), "y_range": (-1.15, 1.15)}

    def curve(label, colour, z, style):
        inside = np.ones(len(z), bool) if not zoomed else np.abs(z - centre) < 1.5 * reach
        return Curve(label, colour, z.real[inside], z.imag[inside], style)

    return Plot(title, "Re z (1)", "Im z (1)", [
        Curve("unit circle", OPERATOR, np.cos(angle), np.sin(angle)),
        curve(loop_label, ROBOT_COLOUR, loop, "points"),
        curve("manipulator alone", MANIPULATOR, alone, "star"),
        curve("coupled, no dead time", OBJECT, coupled, "ring")], is_equal=True, **ranges)


def eigenvalues(data, name, rig, rate):
    step = data.steps[rig]
    counts = data.eigenvalue_counts[rig]
    added_ms = step["period_ms"] * np.array(ADDED_SAMPLES)
    return Figure(name, f"Eigenvalues using {rate} sampling rate",
                  f"{CASES[rig]}. Beside the slow mode there are eigenvalues of the object on the sensor spring, of "
                  "the low-pass, and of the setpoints and samples on their way.",
                  [z_plane(data.spectra[rig], False), z_plane(data.spectra[rig], True),
                   Plot("claim 2", "dead time added (ms)", "number of eigenvalues (1)",
                        [Curve("eigenvalues", ROBOT_COLOUR, added_ms, np.array(counts), "points"),
                         Curve("one a sample", OPERATOR, added_ms, counts[0] + np.array(ADDED_SAMPLES), "dot")])])


def stable_area(data, name, rig, vary):
    found = data.maps[rig, vary]
    told = found.told
    caption = (f"{CASES[rig]}. Height: growth of the loop's motion; the paper has |z|, its factor a period. Black: limit "
               "of stability. "
               + (f"Green: the robot's wall at {told['wall_Hz']:g} Hz, damped. " if vary == "elasticity" else
                  f"The wall of {told['wall_Hz']:g} Hz is far beyond an object without mass. ")
               + f"Gold: {told['rig']}. Grey: objects that would take a negative stiffness, damping or mass.")
    return Figure(name, f"Area of stable simulations ({vary} variation)", caption,
                  [Surface(found), Contour(found)])


def refinement(data):
    exact = data.growth_exact_per_s
    names = {"semi_implicit_euler": ("semi-implicit Euler", ROBOT_COLOUR, "points"), "rk4": ("RK4", OBJECT, "ring")}
    ends = np.array([SUBSTEPS[0], SUBSTEPS[-1]], float)
    steps = [Curve("exact step", OPERATOR, ends, np.array([exact, exact]), "dash")]
    for integrator in INTEGRATORS:
        label, colour, marker = names[integrator]
        steps.append(Curve(label, colour, np.array(SUBSTEPS, float),
                           np.array(data.growth_by_substeps[integrator]), marker))
    rates = [Curve("exact step", REPORTED, np.array(RATES_HZ, float), np.array(data.growth_by_rate), "points")]
    highest = 1.25 * max(data.growth_by_rate)
    return Figure("Refinement", "Claim 7: finer simulation steps do not cure it",
                  f"{data.case.rig} with an object {STIFF_TIMES} times as stiff, which grows. Left: the manipulator takes "
                  "more and more steps a tick, and the growth converges to that of the exact step. Right: the whole loop ticks faster and "
                  "faster with dead times as they are. Below 0 the loop would be stable.",
                  [Plot("steps of the manipulator", "steps a tick (1)", "growth (1/s)", steps, is_log_x=True,
                        y_range=(0.0, highest)),
                   Plot("ticks of the loop", "rate (Hz)", "growth (1/s)", rates, is_log_x=True,
                        y_range=(0.0, highest))])


def all_figures(data):
    """In the order of the paper."""
    maps = [(12, SLOW, "elasticity"), (13, SLOW, "mass"), (14, FAST, "elasticity"), (15, FAST, "mass"),
            (16, HALF, "elasticity"), (17, HALF, "mass")]
    return [concept_test(data), amplitude(data), command_to_motion(data),
            eigenvalues(data, "Fig. 10", SLOW, "50 Hz"), eigenvalues(data, "Fig. 11", FAST, "400 Hz"),
            *[stable_area(data, f"Fig. {number}", rig, vary) for number, rig, vary in maps], refinement(data)]
