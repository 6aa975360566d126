"""A page in headless Chromium, by the browser's own debugging protocol: JSON texts that end in a zero byte, over two
pipes. No clock is bent and none is waited for: a question is answered when the page has the answer."""

import base64
import json
import os
import select
import shlex
import shutil
import subprocess
import time

# Software rendering of 3-D; nothing that asks the network on the browser's own account.
OPTIONS = ["--headless", "--no-sandbox", "--enable-unsafe-swiftshader", "--disable-quic", "--no-first-run",
           "--disable-background-networking", "--disable-component-update", "--disable-sync",
           "--window-size=1400,1200", "--remote-debugging-pipe"]
TIMEOUT_s = 300.0

# What the browser says to plotly about reading pixels back; both are about speed only.
HARMLESS = ("GL Driver Message (OpenGL, Performance",
            "Canvas2D: Multiple readback operations using getImageData are faster")


class Browser:
    """One page, a file or an address, opened; `console` collects what it writes and what it throws."""

    def __init__(self, page, profile):
        program = shutil.which("chromium")
        assert program, "chromium is missing; `make setup-test` installs it"
        self.console, self.events, self.received, self.questions = [], [], b"", 0
        command_read, self.commands = os.pipe()
        self.answers, answer_write = os.pipe()
        words = shlex.join([program, *OPTIONS, f"--user-data-dir={profile}", "about:blank"])
        self.process = subprocess.Popen(["bash", "-c", f"exec {words} 3<&{command_read} 4>&{answer_write}"],
                                        pass_fds=(command_read, answer_write), stdout=subprocess.DEVNULL,
                                        stderr=subprocess.DEVNULL)
        os.close(command_read)
        os.close(answer_write)
        self.session = None
        target = next(target for target in self.ask("Target.getTargets")["targetInfos"] if target["type"] == "page")
        self.session = self.ask("Target.attachToTarget", targetId=target["targetId"], flatten=True)["sessionId"]
        for domain in ("Runtime", "Log", "Page"):
            self.ask(f"{domain}.enable")
        self.ask("Page.navigate", url=page if isinstance(page, str) else page.as_uri())
        self.wait_for("Page.loadEventFired")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait(TIMEOUT_s)
        os.close(self.commands)
        os.close(self.answers)

    def ask(self, method, **parameters):
        """The result of one command of the protocol."""
        self.questions += 1
        question = {"id": self.questions, "method": method, "params": parameters}
        if self.session:
            question["sessionId"] = self.session
        os.write(self.commands, json.dumps(question).encode() + b"\0")
        answer = self.next_message(lambda message: message.get("id") == question["id"])
        assert "error" not in answer, (method, answer["error"])
        return answer["result"]

    def look(self, width_px, scheme):
        """Opens the page again on a screen of this width, light or dark. A narrow one is a phone: touched, no mouse."""
        self.ask("Emulation.setDeviceMetricsOverride", width=width_px, height=900, deviceScaleFactor=1,
                 mobile=width_px < 600)
        self.ask("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
        self.events.clear()
        self.ask("Page.reload")
        self.wait_for("Page.loadEventFired")

    def picture(self, path):
        """The whole page as a PNG."""
        width, height = self.evaluate("[innerWidth, document.documentElement.scrollHeight]")
        clip = {"x": 0, "y": 0, "width": width, "height": height, "scale": 1}
        found = self.ask("Page.captureScreenshot", format="png", captureBeyondViewport=True, clip=clip)
        path.write_bytes(base64.b64decode(found["data"]))

    def evaluate(self, script):
        """The value of an expression in the page; a promise is waited for."""
        answer = self.ask("Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in answer, answer["exceptionDetails"]
        return answer["result"].get("value")

    def wait_for(self, method):
        """Until an event has happened."""
        if method not in self.events:
            self.next_message(lambda message: message.get("method") == method)

    def next_message(self, is_wanted):
        deadline_s = time.monotonic() + TIMEOUT_s
        while True:
            while b"\0" in self.received:
                text, _, self.received = self.received.partition(b"\0")
                message = json.loads(text)
                self.note(message)
                if is_wanted(message):
                    return message
            ready, _, _ = select.select([self.answers], [], [], max(0.0, deadline_s - time.monotonic()))
            assert ready, f"the browser has not answered for {TIMEOUT_s:g} s; console: {self.console}"
            content = os.read(self.answers, 1 << 20)
            assert content, f"the browser has ended with exit code {self.process.wait(TIMEOUT_s)}"
            self.received += content

    def note(self, message):
        """Keeps what belongs to the console."""
        method, found = message.get("method"), message.get("params", {})
        self.events.append(method)
        if method == "Runtime.exceptionThrown":
            details = found["exceptionDetails"]
            text = details.get("exception", {}).get("description", details["text"])
        elif method == "Runtime.consoleAPICalled":
            text = " ".join(str(argument.get("value", argument.get("description"))) for argument in found["args"])
        elif method == "Log.entryAdded":
            text = found["entry"]["text"]
        else:
            return
        if not any(words in text for words in HARMLESS):
            self.console.append(text)
