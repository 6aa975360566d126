"""`berth live` as a person starts it, and clients of it that share no code with it."""

import asyncio
import json
import re
import signal
import struct
import subprocess

from conftest import BERTH
from tornado.httpclient import HTTPRequest
from tornado.websocket import websocket_connect

ANSWER_s = 60


class LiveView:
    """A `berth live` at a free port."""

    def __init__(self, *arguments, cwd=None):
        words = [BERTH, "live", *arguments, "--port", "0"]
        self.process = subprocess.Popen([str(word) for word in words], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                        text=True, cwd=cwd)
        self.url = self.events = self.last_line = ""
        while not (self.url and self.events):
            line = self.process.stdout.readline()
            assert line, self.process.stderr.read()
            words = line.split()
            self.url = words[1] if words[0] == "page" else self.url
            self.events = words[1] if words[0] == "events" else self.events
        self.port = int(self.url.rpartition(":")[2])

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.end()

    def end(self):
        """As Ctrl-C; its last line says what was shown."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        rest, errors = self.process.communicate(timeout=ANSWER_s)
        self.last_line = rest.strip().split("\n")[-1] if rest.strip() else self.last_line
        assert self.process.returncode == 0 and errors == "", (self.process.returncode, errors)
        return self.last_line

    def count(self, what):
        """How many samples were "shown", "lost", "malformed", "refused", or clients "dropped"; after end()."""
        pattern = r"(\d+) clients dropped" if what == "dropped" else rf"(\d+) (?:samples )?{what}"
        return int(re.search(pattern, self.last_line)[1])

    def resident_bytes(self):
        with open(f"/proc/{self.process.pid}/statm") as file:
            return int(file.read().split()[1]) * 4096


async def open_stream(view, path="/stream", protocols=None, **options):
    """What the page opens, from its own origin."""
    request = HTTPRequest(f"ws://127.0.0.1:{view.port}{path}", headers={"Origin": view.url} if path == "/stream" else {})
    return await websocket_connect(request, subprotocols=protocols, **options)


async def next_message(client):
    """None: the server has closed the connection."""
    return await asyncio.wait_for(client.read_message(), ANSWER_s)


class FoxgloveClient:
    """The protocol as https://github.com/foxglove/ws-protocol (docs/spec.md) publishes it: texts are JSON objects with "op";
    binary messages begin with an opcode, 1 for message data: subscription u32, time u64 in ns, payload; little-endian."""

    def __init__(self, connection):
        self.connection, self.channels, self.subscribed = connection, {}, {}
        self.info = None

    @classmethod
    async def connect(cls, view, protocol="foxglove.sdk.v1"):
        client = cls(await open_stream(view, "/", [protocol]))
        while not (client.info and client.channels):
            text = await next_message(client.connection)
            assert text is not None, (client.connection.close_code, client.connection.close_reason)
            told = json.loads(text)
            if told["op"] == "serverInfo":
                client.info = told
            elif told["op"] == "advertise":
                client.channels.update({one["topic"]: one for one in told["channels"]})
        return client

    async def subscribe(self, *topics):
        asked = [{"id": 100 + i, "channelId": self.channels[topic]["id"]} for i, topic in enumerate(topics)]
        self.subscribed = {100 + i: topic for i, topic in enumerate(topics)}
        await self.connection.write_message(json.dumps({"op": "subscribe", "subscriptions": asked}))

    async def next(self):
        """(topic, payload, time in ns) of the next message data."""
        while True:
            found = await next_message(self.connection)
            assert found is not None, "the server has closed the connection"
            if isinstance(found, bytes):
                opcode, subscription, time_ns = struct.unpack_from("<BIQ", found)
                assert opcode == 1
                return self.subscribed[subscription], json.loads(found[13:]), time_ns
            told = json.loads(found)
            assert told["op"] in ("advertise", "unadvertise"), told
