"""What the figures and claims of the paper need, measured with the host command. Each is measured when first asked
for, and once."""
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from paper_case import FAST, HALF, RIGS, SLOW, Case

# A robot whose amplitude rises by a few percent up to 5 Hz, as the paper's does: an assumption.
ROBOT = {"robot.transfer_frequency_Hz": 15, "robot.transfer_damping_ratio": 0.6}
FILTER_BANDWIDTH_HZ = 40

# The operator swings a well damped manipulator with 16 sines at once; the last period is evaluated.
SINES_PERIOD_S = 20
SINES = {"object.mass_kg": 1, "object.stiffness_N_per_m": 0, "object.damping_N_s_per_m": 0,
         "manipulator.damping_N_s_per_m": 2000, "manipulator.initial_position_m": 0,
         "profile.kind": "multisine", "profile.amplitude_m": 0.01, "profile.duration_s": SINES_PERIOD_S,
         "profile.frequency_start_Hz": 0.25, "profile.frequency_end_Hz": 5, "run.duration_s": 2.25 * SINES_PERIOD_S}

# As little dead time as a loop can have: 0.2 ms in all, no low-pass.
NO_DEAD_TIME = {"loop.rate_Hz": 10000, "bus.ideal": "true", "robot.dead_time_ms": 0.1, "sensor.delay_ms": 0.1,
                "sensor.low_pass_order": 0}

STIFF_TIMES = 10  # an object so many times as stiff is unstable at 400 Hz
INTEGRATORS = ("semi_implicit_euler", "rk4")
SUBSTEPS = (1, 3, 10, 30, 100, 300, 1000)
RATES_HZ = (400, 500, 800, 1000, 1600, 2000, 4000)

ADDED_SAMPLES = (0, 1, 2, 3, 5, 8, 13, 20)  # of dead time; many cost much at 50 Hz
GRID = "241x241"
WALL_GRID, HIGHEST_HZ = "300x200", 8.0  # a map that reaches well beyond the wall
WIDE_LOW_PASS_HZ = 50  # in place of 20 Hz


@dataclass(frozen=True)
class Amplitude:
    """Amplitude ratio of robot to manipulator, measured and in closed form, with and without inverse filter."""
    frequency_Hz: np.ndarray
    without: np.ndarray
    with_filter: np.ndarray

    def line(self):
        """The straight line that fits best, at the frequencies measured."""
        return np.polyval(np.polyfit(self.frequency_Hz, self.without, 1), self.frequency_Hz)


def robot_amplitude(frequency_Hz):
    """|G_R| from its definition."""
    r = frequency_Hz / ROBOT["robot.transfer_frequency_Hz"]
    return 1.0 / np.abs(1.0 - r**2 + 2j * ROBOT["robot.transfer_damping_ratio"] * r)


def filtered_amplitude(frequency_Hz):
    """Robot and inverse filter together: a Butterworth filter of second order."""
    return 1.0 / np.sqrt(1.0 + (frequency_Hz / FILTER_BANDWIDTH_HZ) ** 4)


def amplitude_ratio(log):
    """Frequencies of the sines in Hz, and robot to manipulator at each, over the last whole period in the log."""
    ticks = round(SINES_PERIOD_S / log.period_s)
    last_period_s = log.tick_s[-ticks:]
    spectra = [np.fft.rfft(np.interp(last_period_s, times_s, values)) for times_s, values in
               ((log.tick_s, log.tick["manipulator_position_m"]), (log.rig_s, log.rig["robot_position_m"]))]
    heights = np.abs(spectra[0])
    sines = np.flatnonzero(heights > 1e-3 * heights[1:].max())
    sines = sines[sines > 0]
    return np.fft.rfftfreq(ticks, log.period_s)[sines], np.abs(spectra[1] / spectra[0])[sines]


class PaperData:
    """All measurements of one case, by the host command `berth`. Interfaces are SLOW, FAST and HALF. `concept`: that
    of another case, which is the same for all."""

    def __init__(self, berth, case=Case(), grid=GRID, wall_grid=WALL_GRID, concept=None):
        self.berth = berth
        self.case = case
        self.grid = grid
        self.wall_grid = wall_grid
        if concept is not None:
            self.concept = concept

    def ask(self, subcommand, interface, values=None):
        """What a subcommand says of the case at an interface, with more overrides."""
        rig, own = self.case.at(interface)
        return self.berth.ask(subcommand, rig, own | (values or {}))

    def run(self, name, interface, values):
        rig, own = self.case.at(interface)
        return self.berth.run(f"{self.case.name(interface)}-{name}", rig, own | values)

    def map(self, name, interface, vary, values=None, grid=None, options=()):
        rig, own = self.case.at(interface)
        return self.berth.map(f"{self.case.name(interface)}-{name}", rig, vary, grid or self.grid,
                              own | (values or {}), *options)

    @cached_property
    def concept(self):
        """(result, log) of each concept test: foam, copper, and copper without dead time. They are rigs of their
        own, the same for every case."""
        return {"foam": self.berth.run("foam", "concept-foam"),
                "copper": self.berth.run("copper", "concept-copper"),
                "no_dead_time": self.berth.run("no-dead-time", "concept-copper", NO_DEAD_TIME)}

    @cached_property
    def amplitude(self):
        """Fig. 5."""
        ratios = []
        for is_on in ("false", "true"):
            _, log = self.run(f"amplitude-{is_on}", FAST, {**SINES, **ROBOT, "inverse_filter.enabled": is_on,
                                                           "inverse_filter.bandwidth_Hz": FILTER_BANDWIDTH_HZ})
            frequency_Hz, ratio = amplitude_ratio(log)
            ratios.append(ratio)
        return Amplitude(frequency_Hz, *ratios)

    @cached_property
    def steps(self):
        """Fig. 6: what `berth deadtime` measures, by interface."""
        return {interface: self.ask("deadtime", interface) for interface in RIGS}

    @cached_property
    def spectra(self):
        """Figs 10 and 11: what `berth eigen` says, by interface."""
        return {interface: self.ask("eigen", interface) for interface in RIGS}

    @cached_property
    def eigenvalue_counts(self):
        """Number of eigenvalues with ADDED_SAMPLES of dead time added, by interface."""
        counts = {}
        for interface in (SLOW, FAST):
            step = self.steps[interface]
            counts[interface] = [len(self.ask("eigen", interface, {
                "robot.dead_time_ms": step["configured_ms"] + added * step["period_ms"]})["eigenvalues"])
                for added in ADDED_SAMPLES]
        return counts

    @cached_property
    def maps(self):
        """Figs 12 to 17, by interface and what is varied."""
        return {(interface, vary): self.map("figures", interface, vary)
                for interface in RIGS for vary in ("elasticity", "mass")}

    def mass_map_with_hold(self, interface):
        """The map of mass if the robot jumps to its setpoints instead of moving there on a line."""
        return self.map("hold", interface, "mass", {"robot.interpolation": "hold"})

    def highest_stable_Hz(self, values=None):
        """Highest damped eigenfrequency of the coupled system, and its damping ratio, at which the loop is stable
        at 400 Hz, over all elasticities and dampings of the object up to HIGHEST_HZ and a damping ratio of 0.99."""
        name = "-".join(["wall", *(f"{key}={value}" for key, value in (values or {}).items())])
        highest = HIGHEST_HZ / self.case.assumptions.manipulator_Hz
        found = self.map(name, FAST, "elasticity", values, self.wall_grid,
                         ("--x-range", f"0.85:{highest:.6g}", "--y-range", "0.01:0.99"))
        stable_Hz = np.where(found.radius < 1.0, found.damped_frequency_Hz(), 0.0)
        highest = stable_Hz.argmax()
        return stable_Hz.flat[highest], found.y.flat[highest]

    def limits(self, interface):
        """What `berth limits` says of each parameter."""
        return self.ask("limits", interface)["parameters"]

    def times_to_limit(self, key):
        """How many times its value at 400 Hz a parameter may grow to; inf without a limit."""
        limit = self.limits(FAST)[key]
        return limit["above"]["value"] / limit["value"] if limit["above"] else np.inf

    @cached_property
    def stiff_object(self):
        """The object that diverges at 400 Hz."""
        stiffness_N_per_m = self.case.assumptions.values()["object.stiffness_N_per_m"]
        return {"object.stiffness_N_per_m": round(STIFF_TIMES * stiffness_N_per_m)}

    @cached_property
    def growth_by_substeps(self):
        """Growth in 1/s of a diverging loop, by integrator of the manipulator and its steps per tick."""
        return {integrator: [self.ask("eigen", FAST, {
            **self.stiff_object, "manipulator.integrator": integrator, "manipulator.substeps": substeps})[
                "growth_per_s"] for substeps in SUBSTEPS] for integrator in INTEGRATORS}

    @cached_property
    def growth_exact_per_s(self):
        """Growth of the same loop with the exact step."""
        return self.ask("eigen", FAST, self.stiff_object)["growth_per_s"]

    @cached_property
    def growth_by_rate(self):
        """Growth of the same loop in 1/s at finer and finer ticks, dead times as they are."""
        return [self.ask("eigen", FAST, {**self.stiff_object, "loop.rate_Hz": rate_Hz, "bus.ideal": "true"})[
            "growth_per_s"] for rate_Hz in RATES_HZ]
