"""What keeps a client of the live view in bounds, whichever protocol it speaks."""
from __future__ import annotations

import time

MESSAGE_BYTES_MAX = 16 << 10   # what a client may say at once
MESSAGES_PER_S_MAX = 50        # a person clicks; Foxglove subscribes to a few channels at once
WAITING_BYTES_MAX = 4 << 20    # for a client that does not read
CLIENTS_MAX = 16
# Of WebSocket (RFC 6455).
CLOSE_POLICY, CLOSE_MALFORMED, CLOSE_BUSY = 1008, 1007, 1013


class Pace:
    """Counts messages: a bucket that holds a second's worth."""

    def __init__(self, per_s: float = MESSAGES_PER_S_MAX, clock=time.monotonic):
        self._per_s, self._clock = per_s, clock
        self._left, self._at_s = float(per_s), clock()

    def allows_one(self) -> bool:
        now_s = self._clock()
        self._left = min(self._per_s, self._left + self._per_s * (now_s - self._at_s)) - 1.0
        self._at_s = now_s
        return self._left >= 0.0
