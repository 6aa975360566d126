"""`berth live`: python -m berth.live RIG | LOG | --from ADDRESS[:PORT]."""
from __future__ import annotations

import argparse
import asyncio
import math
import os
import signal
import sys
from datetime import datetime
from importlib.util import find_spec
from pathlib import Path

from ..errors import InputError
from ..rig import Rig
from ..run import read_log

FOLDER = Path("build/live")
EXIT_INPUT = 2
WEB_PORT = 8765   # as Foxglove looks for one
TARGET_PORT = 8767


def main(words: list[str] | None = None) -> int:
    arguments = _parser().parse_args(words)
    try:
        for package in ("tornado", "foxglove"):
            if find_spec(package) is None:
                raise InputError(f"a live view needs the Python package {package}: install berth[live]", "", "")
        return asyncio.run(_serve(arguments))
    except InputError as error:
        print(f"berth: {error}", file=sys.stderr)
        return EXIT_INPUT


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="berth live", description="A running loop, in a browser and in Foxglove.")
    parser.add_argument("what", metavar="RIG|LOG", nargs="?", default="")
    parser.add_argument("--from", dest="source", default="")
    parser.add_argument("--rig", default="")
    parser.add_argument("--robot", default="")
    parser.add_argument("--set", dest="settings", action="append", default=[])
    parser.add_argument("--speed", type=float, default=1.0)
    parser.add_argument("--bind", default="127.0.0.1")
    parser.add_argument("--port", type=int, default=WEB_PORT)
    parser.add_argument("--plotjuggler", default="")
    parser.add_argument("--out", default="")
    parser.add_argument("--end", action="store_true")
    return parser


def address_and_port(option: str, text: str, port: int | None) -> tuple[str, int]:
    """Of "HOST:PORT", "[IPv6]:PORT", or, with a port to fall back on, "HOST"."""
    host, colon, digits = text.rpartition(":")
    if not colon or text.endswith("]"):
        host, digits = text, ""
    host = host.removeprefix("[").removesuffix("]")
    is_port = digits.isascii() and digits.isdigit() and 0 < int(digits) < 65536 if digits else port is not None
    if not host or not is_port or (":" in host and not text.startswith("[")):
        raise InputError(f"{option} {text}: must be HOST:PORT, as 192.168.1.20:{port or 9870}", option, "")
    return host, int(digits) if digits else port


def _settings(words: list[str]) -> dict[str, str]:
    for word in words:
        if "=" not in word:
            raise InputError(f"--set {word}: must be section.key=value", f"--set {word}", "")
    return dict(word.split("=", 1) for word in words)


def _source(arguments):
    """(where datagrams come from, the rig or None, the file of the events)."""
    from .sources import Replay, Target
    if not math.isfinite(arguments.speed) or not 0.01 <= arguments.speed <= 1000:
        raise InputError(f"--speed {arguments.speed:g}: must be from 0.01 to 1000", "--speed", "")
    stamp = datetime.now().strftime("%Y-%m-%dT%H-%M-%S")
    if bool(arguments.what) == bool(arguments.source):
        raise InputError("name a rig, a log or --from ADDRESS; one of them", "", "")
    if arguments.source:
        host, port = address_and_port("--from", arguments.source, TARGET_PORT)
        target = Target(host, port)
        rig = Rig.load(arguments.rig, _settings(arguments.settings), arguments.robot) if arguments.rig else None
        folder = Path(arguments.out or FOLDER / f"{host.replace(':', '-')}-{stamp}")
        return target, rig, folder / "events.jsonl"
    if arguments.rig:
        raise InputError("--rig goes with --from alone: a rig or a log says what it is", "--rig", "")
    path = Path(arguments.what)
    if path.is_dir():
        found = sorted(path.glob("*.ulg"))
        if len(found) != 1:
            raise InputError(f"{path}: has {len(found)} logs, and one is wanted; name the .ulg file", str(path), "")
        path = found[0]
    if path.suffix == ".ulg":
        if arguments.settings or arguments.robot:
            raise InputError(f"{path}: a log cannot be changed; leave out --set and --robot", str(path), "")
        log = read_log(path)
        events = Path(arguments.out) / f"{path.stem}.events.jsonl" if arguments.out else path.with_suffix(".events.jsonl")
        return Replay(log.rig, log.ticks, arguments.speed), log.rig, events
    rig = Rig.load(arguments.what, _settings(arguments.settings), arguments.robot)
    folder = Path(arguments.out or FOLDER / f"{rig.name}-{stamp}")
    folder.mkdir(parents=True, exist_ok=True)
    run = rig.run(log=folder / f"{rig.name}.ulg", advice=False)
    return Replay(rig, run.ticks, arguments.speed), rig, folder / f"{rig.name}.events.jsonl"


def _facts(rig, source: str) -> dict:
    """What the page says of the rig; little where only the target knows it."""
    if rig is None:
        return {"source": source, "rig": "", "description": "", "config_hash": "", "delay_budget": None}
    return {"source": source, "rig": rig.name, "description": rig.description, "config_hash": rig.config_hash,
            "delay_budget": rig.delay_budget}


async def _serve(arguments) -> int:
    from tornado.httpserver import HTTPServer
    from tornado.netutil import bind_sockets

    from .events import Events
    from .foxglove import FoxgloveServer
    from .guard import MESSAGE_BYTES_MAX
    from .hub import JUDGED_EVERY_s, Hub
    from .server import application
    plotjuggler = address_and_port("--plotjuggler", arguments.plotjuggler, None) if arguments.plotjuggler else None
    source, rig, events = _source(arguments)
    if not 0 <= arguments.port < 65536:
        raise InputError(f"--port {arguments.port}: must be from 0 to 65535; 0 takes a free one", "--port", "")
    try:
        sockets = bind_sockets(arguments.port, arguments.bind)
    except OSError as error:
        raise InputError(f"--port {arguments.port}: {arguments.bind} has no such port free ({error}); take another one, or "
                         "--port 0 for any", "--port", "") from None
    foxglove = FoxgloveServer()
    hub = Hub(_facts(rig, arguments.source or arguments.what), Events(events), foxglove, plotjuggler)
    server = HTTPServer(application(hub), max_buffer_size=1 << 20, max_header_size=MESSAGE_BYTES_MAX,
                        max_body_size=MESSAGE_BYTES_MAX, idle_connection_timeout=30)
    server.add_sockets(sockets)
    host, port = sockets[0].getsockname()[:2]
    shown = f"[{host}]" if ":" in host else host
    print(f"page       http://{shown}:{port}\nFoxglove   ws://{shown}:{port}\nevents     {events}\n"
          "Ctrl-C ends it; the loop goes on.", flush=True)
    ended = asyncio.Event()
    loop = asyncio.get_running_loop()
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        loop.add_signal_handler(number, ended.set)
    feeding = asyncio.create_task(source.feed(hub.take))
    while not ended.is_set():
        if feeding.done():
            feeding.result()
            if arguments.end:
                break
        hub.tell()
        try:
            await asyncio.wait_for(ended.wait(), JUDGED_EVERY_s)
        except TimeoutError:
            pass
    hub.tell()
    feeding.cancel()
    hub.close()
    server.stop()
    foxglove.stop()
    refused = getattr(source, "refused", 0)
    print(f"{hub.taken} samples shown, {hub.window.lost} lost, {hub.bad} malformed, {refused} refused; {hub.dropped} clients "
          "dropped")
    return 0


def end() -> None:
    """Without waiting for what threads of a library may still do."""
    code = main()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


if __name__ == "__main__":  # SIGPIPE stays ignored: a client that leaves must not end the view of the others
    end()
