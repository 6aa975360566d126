"""The live view: what a loop does now, for a person beside the rig.

`berth live RIG` shows a simulated run at the pace of the clock, `berth live LOG` a log, `berth live --from ADDRESS` what
`berth-target --live` sends. All three give the same datagrams (hal/live_sample.h).

sample    reads a datagram, whoever sent it; sources: where datagrams come from
judge     one pure function from the last seconds to a verdict and its bars
server    the page, and the gate to the Foxglove server; foxglove: its channels
events    what a person marks, on the host beside the log
"""
from .judge import State, judge
from .sample import Sample, Window

__all__ = ["Sample", "State", "Window", "judge"]
