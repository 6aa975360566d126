"""The channels of the Foxglove server: /loop has the samples, /verdict what they mean, /event what a person marks."""
from __future__ import annotations

import foxglove

from .. import _core
from .sample import KINDS

BACKLOG = 256  # messages that wait for one client; then the oldest goes

_TYPES = {"str": {"type": "string"}, "int": {"type": "integer"}, "float": {"type": ["number", "null"]}}
_NAMES = {"state": _core.state_names, "stop_cause": _core.stop_cause_names}


def _described(name: str, kind: str) -> dict:
    """A property of a schema; numbers that stand for names say for which."""
    told = dict(_TYPES[kind])
    if name in _NAMES:
        told["description"] = ", ".join(f"{i} {one}" for i, one in enumerate(_NAMES[name]))
    if name == "limits":
        told["description"] = "bits that acted: " + ", ".join(f"{1 << i} {one}" for i, one in enumerate(_core.limit_names))
    return told


LOOP_SCHEMA = {"type": "object", "title": "berth.loop", "required": list(KINDS),
               "properties": {name: _described(name, kind) for name, kind in KINDS.items()}}
_NUMBERS = ("growth_per_s", "growth_ci95_per_s", "frequency_Hz", "growth_span_s", "window_s", "dead_time_J", "operator_J",
            "damping_J", "peak_force_N", "age_s", "time_s")
_COUNTS = ("missed_ticks", "lost_datagrams", "unsent_datagrams", "bad_datagrams")
_TEXTS = ("verdict", "look", "because", "state", "stop_cause", "rig")
VERDICT_SCHEMA = {"type": "object", "title": "berth.verdict", "properties": {
    **{name: {"type": "string"} for name in _TEXTS}, **{name: {"type": ["number", "null"]} for name in _NUMBERS},
    **{name: {"type": "integer"} for name in _COUNTS}, "limits": {"type": "array", "items": {"type": "string"}}}}
EVENT_SCHEMA = {"type": "object", "title": "berth.event", "properties": {
    "time_s": {"type": "number"}, "run": {"type": "integer"},
    **{name: {"type": "string"} for name in ("text", "rig", "marked")}}}


class FoxgloveServer:
    """foxglove-sdk's server on loopback, at a port of its own choice: clients come through the gate of server.py. It
    offers no capability, so that no client can publish, call or set anything."""

    def __init__(self):
        foxglove.set_log_level("ERROR")
        self._context = context = foxglove.Context()  # kept: the server forgets its channels with it
        self._server = foxglove.start_server(name="berth live", host="127.0.0.1", port=0, capabilities=[], context=context,
                                             message_backlog_size=BACKLOG)
        self.port = self._server.port
        self._channels = {
            topic: foxglove.Channel(topic, message_encoding="json", context=context, schema=schema)
            for topic, schema in (("/loop", LOOP_SCHEMA), ("/verdict", VERDICT_SCHEMA), ("/event", EVENT_SCHEMA))}

    def log(self, topic: str, message: dict) -> None:
        """Times are those of the host; message["time_s"] is the loop's."""
        self._channels[topic].log(message)

    def stop(self) -> None:
        self._server.stop()
