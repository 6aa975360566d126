"""One port for everybody: a browser gets the page and its stream, Foxglove gets the Foxglove server behind a gate.

The gate is there because foxglove-sdk takes messages of 16 MB, answers malformed ones, and has no limit on clients. It
lets `subscribe` and `unsubscribe` through and drops a client that says anything else."""
from __future__ import annotations

import asyncio
import json
from pathlib import Path

from tornado.httpclient import HTTPRequest
from tornado.iostream import StreamBufferFullError, StreamClosedError
from tornado.web import Application, RequestHandler
from tornado.websocket import WebSocketClosedError, WebSocketHandler, websocket_connect

from .guard import (CLIENTS_MAX, CLOSE_BUSY, CLOSE_MALFORMED, CLOSE_POLICY, MESSAGE_BYTES_MAX, WAITING_BYTES_MAX, Pace)

PAGE = Path(__file__).with_name("page.html")
# Nothing from elsewhere, and no other site shows the page in a frame.
POLICY = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; connect-src 'self'; frame-ancestors 'none'"
FOXGLOVE_PROTOCOLS = ("foxglove.sdk.v1", "foxglove.websocket.v1")  # the same on the wire for what is allowed here
FOXGLOVE_OPERATIONS = ("subscribe", "unsubscribe")


class _Client(WebSocketHandler):
    """A WebSocket of the outside world."""

    def initialize(self, hub):
        self.hub = hub
        self.pace = Pace()
        self.is_counted = False

    def prepare(self):
        """Before the connection is a WebSocket: too many get no answer but this."""
        if self.request.headers.get("Upgrade", "").lower() == "websocket" and self.hub.clients >= CLIENTS_MAX:
            self.set_status(503)
            self.finish("too many clients\n")

    def get_compression_options(self):
        return None  # a small message that becomes a large one is not wanted

    def open(self, *_):
        self.hub.clients += 1
        self.is_counted = True
        self.ws_connection.stream.max_write_buffer_size = WAITING_BYTES_MAX

    def on_close(self):
        if self.is_counted:
            self.hub.clients -= 1
            self.is_counted = False

    def drop(self, code: int, why: str) -> None:
        self.hub.dropped += 1
        self.close(code, why)

    def say(self, message, binary: bool = False) -> bool:
        """False: the client is gone, or reads too slowly and is dropped."""
        try:
            self.write_message(message, binary).add_done_callback(lambda told: told.cancelled() or told.exception())
            return True
        except StreamBufferFullError:
            self.hub.dropped += 1
            self.ws_connection.stream.close()
        except (WebSocketClosedError, StreamClosedError):
            pass
        return False


class PageStream(_Client):
    """Samples and verdicts to the page; marks from it."""

    def open(self, *_):
        super().open()
        self.say(self.hub.greeting())
        self.hub.pages.add(self)

    def on_close(self):
        super().on_close()
        self.hub.pages.discard(self)

    def on_message(self, message):
        if not self.pace.allows_one():
            return self.drop(CLOSE_POLICY, "too many messages")
        try:
            asked = json.loads(message)
            text = asked.pop("mark")
            if asked or not isinstance(text, str):
                raise ValueError
        except (ValueError, AttributeError, KeyError, RecursionError, TypeError):
            return self.drop(CLOSE_MALFORMED, "no mark")
        self.hub.mark(text)
        return None


class Gate(_Client):
    """The page for a browser, and the Foxglove server for who asks for its protocol."""

    behind = None

    async def get(self, *arguments):
        if self.request.headers.get("Upgrade", "").lower() == "websocket":
            await super().get(*arguments)
            return
        self.set_header("Content-Type", "text/html; charset=utf-8")
        self.set_header("Content-Security-Policy", POLICY)
        self.set_header("Cache-Control", "no-store")
        self.finish(PAGE.read_bytes())

    def check_origin(self, origin):
        return True  # Foxglove's page comes from elsewhere; it can read, and nothing else

    def select_subprotocol(self, subprotocols):
        return next((one for one in subprotocols if one in FOXGLOVE_PROTOCOLS), None)

    async def open(self, *_):
        super().open()
        if not self.selected_subprotocol:
            return self.drop(CLOSE_POLICY, "speaks no Foxglove protocol")
        try:
            self.behind = await websocket_connect(HTTPRequest(f"ws://127.0.0.1:{self.hub.foxglove.port}/"),
                                                  subprotocols=[FOXGLOVE_PROTOCOLS[0]],
                                                  max_message_size=WAITING_BYTES_MAX)
        except Exception:  # whatever stops it, this client gets no answer
            return self.drop(CLOSE_BUSY, "the Foxglove server does not answer")
        self.relaying = asyncio.create_task(self.relay())
        return None

    async def relay(self) -> None:
        """From the Foxglove server to the client, until one of them ends."""
        while (message := await self.behind.read_message()) is not None:
            if not self.say(message, isinstance(message, bytes)):
                break
        self.close()

    async def on_message(self, message):
        if not self.pace.allows_one():
            return self.drop(CLOSE_POLICY, "too many messages")
        try:
            is_allowed = isinstance(message, str) and json.loads(message)["op"] in FOXGLOVE_OPERATIONS
        except (ValueError, KeyError, TypeError, RecursionError):
            is_allowed = False
        if not is_allowed:
            return self.drop(CLOSE_MALFORMED, "only subscribe and unsubscribe")
        if self.behind is not None:
            await self.behind.write_message(message)
        return None

    def on_close(self):
        super().on_close()
        if self.behind is not None:
            self.behind.close()


class _Absent(RequestHandler):
    def prepare(self):
        self.set_status(404)
        self.finish("not here\n")


def application(hub) -> Application:
    return Application([("/", Gate, {"hub": hub}), ("/stream", PageStream, {"hub": hub}), (".*", _Absent)],
                       websocket_max_message_size=MESSAGE_BYTES_MAX, websocket_ping_interval=20,
                       log_function=lambda handler: None)
