"""What a person marks while a loop runs: one JSON object a line, on the host. Nothing goes to the target."""
from __future__ import annotations

import json
from collections import deque
from datetime import datetime, timezone
from pathlib import Path

TEXT_MAX = 200
EVENTS_MAX = 10_000
NEWEST_MAX = 200


class Events:
    """A file LOG.events.jsonl, made with the first event."""

    def __init__(self, path: Path):
        self.path = path
        self.count = 0
        self.newest: deque[dict] = deque(maxlen=NEWEST_MAX)  # for a page that comes later

    def mark(self, text: str, rig: str, run: int, time_s: float) -> dict | None:
        """Writes an event at this time of the loop. None: there are too many."""
        if self.count >= EVENTS_MAX:
            return None
        event = {"time_s": time_s, "text": " ".join(text.split())[:TEXT_MAX], "rig": rig, "run": run,
                 "marked": datetime.now(timezone.utc).isoformat(timespec="milliseconds")}
        self.path.parent.mkdir(parents=True, exist_ok=True)
        with self.path.open("a") as file:
            file.write(json.dumps(event) + "\n")
        self.count += 1
        self.newest.append(event)
        return event
