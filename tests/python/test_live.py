"""`berth live` from outside: what clients of Foxglove and PlotJuggler get, what it takes from a target, and what it does
with clients that mean it no good."""

import asyncio
import json
import os
import pathlib
import re
import signal
import socket
import struct
import subprocess
import time

import numpy as np
import pytest
from conftest import BERTH, EXIT_INPUT, ROOT, command, run_json
from live_view import FoxgloveClient, LiveView, next_message, open_stream
from pyulog import ULog
from test_live_judge import datagram
from tornado.httpclient import AsyncHTTPClient, HTTPRequest
from tornado.websocket import websocket_connect

SHORT = ["ess", "--set", "run.duration_s=6"]


def run_of(coroutine):
    return asyncio.run(coroutine)


def free_udp_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@pytest.fixture(scope="module")
def view(tmp_path_factory):
    """A simulated run in real time, which goes on for longer than these tests."""
    with LiveView("ess", "--set", "run.duration_s=900", "--out", tmp_path_factory.mktemp("view")) as made:
        yield made


@pytest.mark.parametrize("protocol", ["foxglove.sdk.v1", "foxglove.websocket.v1"])
def test_a_foxglove_client_reads_what_the_log_has(protocol, tmp_path):
    async def watch(view):
        client = await FoxgloveClient.connect(view, protocol)
        assert client.info["capabilities"] == [] and set(client.channels) == {"/loop", "/verdict", "/event"}
        await client.subscribe("/loop", "/verdict")
        got = {"/loop": [], "/verdict": []}
        while len(got["/loop"]) < 150 or len(got["/verdict"]) < 10:
            topic, payload, time_ns = await client.next()
            got[topic].append(payload)
            assert abs(time_ns * 1e-9 - time.time()) < 60
        return client.channels, got

    with LiveView(*SHORT, "--out", tmp_path) as view:
        channels, got = run_of(watch(view))
    ticks = ULog(str(tmp_path / "ess.ulg")).get_dataset("tick").data
    at = np.searchsorted(ticks["scheduled_ns"] * 1e-9, [one["time_s"] - 1e-5 for one in got["/loop"]])
    for name in ("manipulator_position_m", "robot_position_m", "force_N", "energy_dead_time_J", "state"):
        np.testing.assert_allclose([one[name] for one in got["/loop"]], ticks[name][at], rtol=1e-7, err_msg=name)
    assert len(set(np.diff(at))) == 1  # evenly thinned, none lost
    for topic, messages in got.items():
        assert channels[topic]["encoding"] == "json" and channels[topic]["schemaEncoding"] == "jsonschema"
        schema = json.loads(channels[topic]["schema"])
        for message in messages:
            assert set(message) == set(schema["properties"])
            for name, value in message.items():
                assert is_of(value, schema["properties"][name]["type"]), (topic, name, value)


def is_of(value, kinds):
    known = {"string": str, "integer": int, "number": (int, float), "null": type(None), "array": list}
    return any(isinstance(value, known[kind]) for kind in ([kinds] if isinstance(kinds, str) else kinds))


def test_plotjuggler_gets_json(tmp_path):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as juggler:
        juggler.bind(("127.0.0.1", 0))
        juggler.settimeout(60)
        with LiveView(*SHORT, "--out", tmp_path, "--plotjuggler", f"127.0.0.1:{juggler.getsockname()[1]}"):
            got = [json.loads(juggler.recv(4096)) for _ in range(100)]
    assert [one["timestamp"] for one in got] == sorted(one["timestamp"] for one in got)
    assert all(one["timestamp"] == one["berth"]["time_s"] and "force_N" in one["berth"] for one in got)


def test_a_run_a_log_and_its_folder_show_the_same(tmp_path):
    """The log at fifty times real time."""
    log = run_json("ess", tmp_path, *SHORT[1:])["log"]
    shown = []
    for what in (log, tmp_path):
        with LiveView(what, "--end", "--speed", "50") as view:
            view.process.wait(60)
            view.end()
            shown.append(view.last_line)
            assert view.events == str(tmp_path / "ess.events.jsonl")
    with LiveView(*SHORT, "--out", tmp_path / "again", "--end", "--speed", "20") as view:
        begin_s = time.monotonic()
        view.process.wait(60)
        assert time.monotonic() - begin_s < 6
        view.end()
        shown.append(view.last_line)
    assert shown[0] == shown[1] == shown[2] and shown[0].startswith("600 samples shown, 0 lost, 0 malformed")


def test_real_time_is_that_of_the_clock(tmp_path):
    async def watch(view):
        client = await FoxgloveClient.connect(view)
        await client.subscribe("/loop")
        seen = []
        while not seen or seen[-1][1] - seen[0][1] < 3.0:
            seen.append((time.monotonic(), (await client.next())[1]["time_s"]))
        return seen

    with LiveView(*SHORT, "--out", tmp_path) as view:
        seen = run_of(watch(view))
    assert seen[-1][0] - seen[0][0] == pytest.approx(3.0, abs=0.5)


# --- what a target sends --------------------------------------------------------------------------------------------

def test_a_target_is_shown_and_others_are_not(tmp_path):
    """Datagrams of 127.0.0.1, with some missing, doubled and malformed; of 127.0.0.2; too many."""
    port = free_udp_port()
    with LiveView("--from", f"127.0.0.1:{port}", "--rig", "ess", "--out", tmp_path) as view:
        target = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        stranger = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        stranger.bind(("127.0.0.2", 0))
        for i in range(100):
            if i not in (10, 11, 12):
                target.sendto(datagram(sequence=i, time_s=i / 100), ("127.0.0.1", port))
            stranger.sendto(datagram(sequence=i, time_s=i / 100, force_N=1e6), ("127.0.0.1", port))
            time.sleep(0.005)
        for bad in (b"", b"{", b"\xff" * 100, datagram(force_N="1"), datagram(sequence=50, time_s=0.5)):
            target.sendto(bad, ("127.0.0.1", port))
        target.sendto(b"x" * 5000, ("127.0.0.1", port))
        state = run_of(first_state(view, lambda state: state["bad_datagrams"] == 4))
        view.end()
    assert state["lost_datagrams"] == 3 and state["peak_force_N"] == 0.0
    assert (view.count("shown"), view.count("lost"), view.count("malformed")) == (97, 3, 4)
    assert view.count("refused") == 101  # of the stranger, and the one that is too long


async def first_state(view, is_wanted):
    """The page's first state that is so."""
    page = await open_stream(view)
    while True:
        told = json.loads(await next_message(page))
        if "state" in told and is_wanted(told["state"]):
            return told["state"]


def test_a_flood_of_datagrams_is_cut_off(tmp_path):
    port = free_udp_port()
    with LiveView("--from", f"127.0.0.1:{port}", "--out", tmp_path) as view:
        target = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        begin_s = time.monotonic()
        before_bytes = view.resident_bytes()
        sent = 0
        while time.monotonic() - begin_s < 5.0:
            for _ in range(200):
                target.sendto(datagram(sequence=sent, time_s=sent / 1e4), ("127.0.0.1", port))
                sent += 1
            time.sleep(0.01)
        state = run_of(first_state(view, lambda state: True))  # it still answers
        assert view.resident_bytes() - before_bytes < 60e6
        seconds = time.monotonic() - begin_s
        view.end()
    assert state["verdict"] and sent > 20_000
    assert view.count("shown") <= 2000 * (seconds + 1) and view.count("refused") > 0


def test_the_target_sends_what_it_logs(tmp_path):
    """berth-target without buses; the samples that arrive are those of its log, thinned."""
    async def watch(view, target):
        client = await FoxgloveClient.connect(view)
        await client.subscribe("/loop")
        process = subprocess.Popen(target, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        got = [(await client.next())[1] for _ in range(150)]
        return got, process.communicate(timeout=60)[1], process.returncode

    port = free_udp_port()
    words = [ROOT / "build" / "berth-target", "ess", tmp_path / "log.ulg", "--without-buses", "--live", f"127.0.0.1:{port}",
             "--set", "run.duration_s=2"]
    with LiveView("--from", f"127.0.0.1:{port}", "--out", tmp_path) as view:
        got, errors, code = run_of(watch(view, [str(word) for word in words]))
    assert code == 0 and "samples sent, 0 not taken by the network" in errors
    ticks = ULog(str(tmp_path / "log.ulg")).get_dataset("tick").data
    at = np.searchsorted(ticks["scheduled_ns"], [round(one["time_s"] * 1e9) - 1000 for one in got])
    assert list(np.diff(at)) == [4] * 149
    np.testing.assert_allclose([one["woke_late_ms"] for one in got],
                               1e-6 * (ticks["woke_ns"] - ticks["scheduled_ns"])[at], rtol=1e-6, atol=1e-9)
    assert [one["missed_ticks"] for one in got] == list(ticks["missed_ticks"].cumsum()[at])


@pytest.mark.parametrize("address", ["", "8767", "host:8767", "127.0.0.1:0", "127.0.0.1:99999", "::1:8767"])
def test_an_address_for_the_target_that_is_none(address):
    done = command("ess", "--without-buses", "--live", address, program=(ROOT / "build" / "berth-target",))
    assert done.returncode == EXIT_INPUT and done.stderr.count(b"\n") == 1 and b"--live" in done.stderr


# --- clients that mean it no good ------------------------------------------------------------------------------------

SUBSCRIBE = json.dumps({"op": "subscribe", "subscriptions": [{"id": 1, "channelId": 1}]})
MALFORMED = ["", "{", "[]", "null", "1", '"mark"', "[" * 5000, b"\x01\x00\x00\x00\x00", b"\xff", '{"op":1}', '{"op":null}',
             '{"op":"nope"}', '{"op":"advertise","channels":[{"id":1,"topic":"/x","encoding":"json","schemaName":""}]}',
             '{"op":"setParameters","parameters":[{"name":"position_m","value":1}]}', '{"op":"getParameters"}',
             '{"op":"fetchAsset","uri":"file:///etc/passwd","requestId":1}', '{"mark":1}', '{"mark":null}',
             '{"mark":"a","run":true}', '{"setpoint_m":1}']


def test_a_malformed_message_ends_the_connection(view):
    async def drop_all():
        good = await FoxgloveClient.connect(view)
        await good.subscribe("/loop")
        for path, protocols in (("/", ["foxglove.sdk.v1"]), ("/stream", None)):
            for message in MALFORMED:
                client = await open_stream(view, path, protocols)
                await client.write_message(message, binary=isinstance(message, bytes))
                while await next_message(client) is not None:
                    pass
                assert client.close_code == 1007, (path, message)
        await good.next()  # the others go on

    run_of(drop_all())


@pytest.mark.parametrize("path, protocols", [("/", ["foxglove.sdk.v1"]), ("/stream", None)])
def test_too_large_and_too_many_messages_end_the_connection(view, path, protocols):
    async def drop_all():
        before_bytes = view.resident_bytes()
        for size_bytes in (20 << 10, 1 << 20, 64 << 20):
            client = await open_stream(view, path, protocols)
            try:
                await client.write_message("x" * size_bytes)
            except Exception:  # it is closed while it still speaks
                pass
            while await next_message(client) is not None:
                pass
        flood = await open_stream(view, path, protocols)
        message = SUBSCRIBE if path == "/" else '{"mark":"flood"}'
        try:
            for _ in range(500):
                await flood.write_message(message)
        except Exception:
            pass
        while await next_message(flood) is not None:
            pass
        assert flood.close_code in (1008, None)  # None: reset, as it still spoke
        assert view.resident_bytes() - before_bytes < 40e6
        await FoxgloveClient.connect(view)

    run_of(drop_all())


def test_a_client_that_does_not_read_is_dropped(tmp_path):
    """At a thousand times real time, so that much is written soon."""
    with LiveView("ess", "--set", "run.duration_s=3000", "--speed", "200", "--out", tmp_path) as view:
        deaf = socket.create_connection(("127.0.0.1", view.port))
        deaf.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        deaf.sendall(f"GET /stream HTTP/1.1\r\nHost: 127.0.0.1:{view.port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                     f"Sec-WebSocket-Key: {'A' * 22}==\r\nSec-WebSocket-Version: 13\r\n\r\n".encode())
        before_bytes = view.resident_bytes()
        view.process.poll()
        end_s = time.monotonic() + 10
        while time.monotonic() < end_s:
            time.sleep(0.5)
            assert view.resident_bytes() - before_bytes < 60e6
        view.end()
        assert view.count("dropped") == 1
        deaf.close()


def test_clients_that_leave_in_the_middle_end_nothing(tmp_path):
    """Each with a reset, as a browser's that reloads. A write to a socket that is gone would be SIGPIPE, in the moment
    before the view has noticed: that signal has to be ignored."""
    with LiveView("ess", "--set", "run.duration_s=3000", "--speed", "200", "--out", tmp_path) as view:
        for _ in range(40):
            client = socket.create_connection(("127.0.0.1", view.port))
            client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            client.sendall(f"GET /stream HTTP/1.1\r\nHost: 127.0.0.1:{view.port}\r\nUpgrade: websocket\r\n"
                           f"Connection: Upgrade\r\nSec-WebSocket-Key: {'A' * 22}==\r\n"
                           "Sec-WebSocket-Version: 13\r\n\r\n".encode())
            assert client.recv(1)
            client.close()
        status = pathlib.Path(f"/proc/{view.process.pid}/status").read_text()
        ignored = int(re.search(r"^SigIgn:\s*(\w+)", status, re.M)[1], 16)
        assert ignored >> (signal.SIGPIPE - 1) & 1
        time.sleep(1.0)
        view.end()


def test_seventeen_clients_are_too_many(tmp_path):
    async def crowd(view):
        clients = [await open_stream(view) for _ in range(16)]
        with pytest.raises(Exception, match="503"):
            await open_stream(view)
        clients[0].close()
        while await clients[0].read_message() is not None:
            pass
        await asyncio.sleep(0.3)
        await open_stream(view)

    with LiveView(*SHORT, "--out", tmp_path) as view:
        run_of(crowd(view))


def test_it_is_for_this_computer_alone(view):
    """Sockets that listen are on loopback, and the UDP of a target on loopback is, too."""
    found = subprocess.run(["ss", "-lntup"], capture_output=True, text=True)
    lines = [line for line in found.stdout.split("\n") if f"pid={view.process.pid}," in line]
    assert len(lines) >= 2 and all("127.0.0.1:" in line for line in lines), found.stdout


def test_other_sites_get_no_stream_and_cannot_mark(view):
    async def ask():
        for origin in ("http://evil.example", f"http://127.0.0.1:{view.port + 1}"):
            with pytest.raises(Exception, match="403"):
                await websocket_connect(HTTPRequest(f"ws://127.0.0.1:{view.port}/stream", headers={"Origin": origin}))
        http = AsyncHTTPClient()
        page = await http.fetch(view.url)
        assert "default-src 'none'" in page.headers["Content-Security-Policy"]
        assert b"http://" not in page.body.replace(b"ws://", b"") and b"https://" not in page.body
        for path in ("/nope", "/../etc/passwd", "/page.html"):
            assert (await http.fetch(view.url + path, raise_error=False)).code == 404
        assert (await http.fetch(view.url, method="POST", body="x", raise_error=False)).code == 405

    run_of(ask())


def test_marks_are_kept_beside_the_log(tmp_path):
    async def mark(view):
        page = await open_stream(view)
        client = await FoxgloveClient.connect(view)
        await client.subscribe("/event")
        while not json.loads(await next_message(page)).get("samples"):
            pass
        for text in ("gripped", "a\nb\x00" + "c" * 400, '"); DROP'):
            await page.write_message(json.dumps({"mark": text}))
        return [(await client.next())[1] for _ in range(3)]

    with LiveView(*SHORT, "--out", tmp_path) as view:
        told = run_of(mark(view))
    kept = [json.loads(line) for line in open(view.events)]
    assert view.events == str(tmp_path / "ess.events.jsonl") and kept == told
    assert kept[0]["text"] == "gripped" and kept[1]["text"].startswith("a b") and len(kept[1]["text"]) == 200
    assert all(0 <= one["time_s"] < 6 and one["rig"] == "ess" for one in kept)


# --- what is wrong with the command line ------------------------------------------------------------------------------

@pytest.mark.parametrize("words, said", [
    ([], "a rig, a log, or --from"), (["ess", "--from", "127.0.0.1"], "one of them"), (["no-such-rig"], "no shipped rig"),
    (["ess", "--set", "object.mass_kg=-1"], "object.mass_kg"), (["ess", "--set", "object.mass=1"], "object.mass_kg"),
    (["ess", "--set", "object.mass_kg"], "object.mass_kg"), (["ess", "--speed", "0"], "0.01"),
    (["ess", "--speed", "nan"], "0.01"), (["ess", "--speed", "inf"], "0.01"), (["ess", "--speed", "fast"], "fast"),
    (["ess", "--port", "-1"], "65535"), (["ess", "--port", "70000"], "65535"), (["ess", "--bind", "1.2.3.4"], "1.2.3.4"),
    (["ess", "--plotjuggler", "nowhere"], "HOST:PORT"), (["ess", "--plotjuggler", "127.0.0.1:x"], "HOST:PORT"),
    (["ess", "--rig", "ess"], "--rig goes with --from"), (["--from", "256.1.1.1"], "--from"), (["--from", ""], "--from"),
    (["--from", "127.0.0.1:0"], "HOST:PORT"), (["--from", "127.0.0.1:99999"], "HOST:PORT"),
    (["--from", "127.0.0.1", "--rig", "nope"], "no shipped rig"), (["/nowhere/x.ulg"], "/nowhere/x.ulg"),
    (["Makefile"], "Makefile"), (["README.md", "--from", "x"], "one of them"), (["ess", "--nope"], "--nope"),
])
def test_bad_input(words, said, tmp_path):
    """One line, with what to do, and exit code 2."""
    done = subprocess.run([BERTH, "live", *words], capture_output=True, text=True, cwd=ROOT, timeout=60)
    assert done.returncode == EXIT_INPUT, (done.stdout, done.stderr)
    assert said in done.stderr and done.stderr.count("\n") == 1 and "Traceback" not in done.stderr, done.stderr


def test_bad_logs(tmp_path):
    log = tmp_path / "cut.ulg"
    log.write_bytes(os.urandom(5000))
    (tmp_path / "empty").mkdir()
    for what in (log, tmp_path / "empty", "/dev/null"):
        done = command("live", what)
        assert done.returncode == EXIT_INPUT and done.stderr.count(b"\n") == 1, done.stderr


def test_a_port_that_is_taken(view):
    done = command("live", "ess", "--port", str(view.port), "--set", "run.duration_s=1", "--out", "build/live/taken")
    assert done.returncode == EXIT_INPUT and b"--port 0" in done.stderr and done.stderr.count(b"\n") == 1
