"""berth: what becomes of a robot that displays the motion of a simulated manipulator.

>>> import berth
>>> rig = berth.Rig.load("ess")
>>> rig["object.mass_kg"] = 120
>>> rig.run().verdict.stable
True
"""
from ._core import __version__, keys, meaning, shipped_rigs, shipped_robots, unit
from .answers import Compensation, Limit, Map, Method, Spectrum, Verdict
from .diagnosis import Block, Cause, Diagnosis, Parameter, diagnose
from .errors import InputError
from .rig import Rig
from .run import Log, Run, read_log

__all__ = ["Block", "Cause", "Compensation", "Diagnosis", "InputError", "Limit", "Log", "Map", "Method", "Parameter",
           "Rig", "Run", "Spectrum", "Verdict", "__version__", "diagnose", "keys", "meaning", "read_log",
           "shipped_rigs", "shipped_robots", "unit"]
