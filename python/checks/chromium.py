"""A headless Chromium, spoken to over a pipe in its DevTools protocol: pages, what they say and ask for, fingers on them."""

import base64
import fcntl
import json
import os
import select
import shutil
import subprocess
import time

BINARY = next(filter(None, map(shutil.which, ["chromium", "chromium-browser", "google-chrome"])), None)
FLAGS = [
    "--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-first-run",
    "--host-resolver-rules=MAP * ~NOTFOUND", "--disable-background-networking", "--hide-scrollbars", "--remote-debugging-pipe",
]
PATIENCE_SECONDS = 120


class Chromium:
    """One process; close it when done."""

    def __init__(self, profile):
        here, there = os.pipe(), os.pipe()
        # The browser reads from descriptor 3 and writes to 4, which the ends must not be already.
        ends = [fcntl.fcntl(end, fcntl.F_DUPFD_CLOEXEC, 10) for end in (here[0], there[1])]
        hand_over = lambda: (os.dup2(ends[0], 3), os.dup2(ends[1], 4))
        command = [BINARY, *FLAGS, f"--user-data-dir={profile}"]
        # Nothing else is inherited: Python opens its files that way.
        self.process = subprocess.Popen(command, close_fds=False, preexec_fn=hand_over, stderr=subprocess.DEVNULL)
        for end in [here[0], there[1], *ends]:
            os.close(end)
        self._to, self._from = here[1], there[0]
        self._received, self._number = b"", 0
        self.events = []

    def close(self):
        os.close(self._to)
        try:
            self.process.wait(timeout=20)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        os.close(self._from)

    def call(self, method, session=None, **parameters):
        """Asks for something and waits for the answer; what happens meanwhile is kept in `events`."""
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters} | ({"sessionId": session} if session else {})
        os.write(self._to, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._next()
            if answer.get("id") == self._number:
                assert "error" not in answer, f"{method}: {answer['error']}"
                return answer["result"]
            self.events.append(answer)

    def _next(self):
        until = time.monotonic() + PATIENCE_SECONDS
        while b"\0" not in self._received:
            ready, _, _ = select.select([self._from], [], [], max(0, until - time.monotonic()))
            assert ready, "the browser does not answer"
            part = os.read(self._from, 1 << 20)
            assert part, "the browser is gone"
            self._received += part
        text, self._received = self._received.split(b"\0", 1)
        return json.loads(text)

    def open(self, file, width, height=900, phone=False):
        """A page in a tab of this size, loaded and drawn."""
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        page = Page(self, target, session, file.as_uri())
        for domain in ["Page", "Runtime", "Log", "Network"]:
            page.call(f"{domain}.enable")
        page.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=phone)
        if phone:
            page.call("Emulation.setTouchEmulationEnabled", enabled=True, maxTouchPoints=2)
        page.call("Page.navigate", url=file.as_uri())
        page.wait("document.readyState === 'complete' && location.protocol === 'file:'")
        page.pause()
        return page


class Page:
    """A tab."""

    def __init__(self, browser, target, session, address):
        self.browser, self.target, self.session, self.address = browser, target, session, address

    def call(self, method, **parameters):
        return self.browser.call(method, self.session, **parameters)

    def close(self):
        self.browser.call("Target.closeTarget", targetId=self.target)

    def evaluate(self, expression):
        """The value of a piece of JavaScript, awaited if need be."""
        answer = self.call("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in answer, answer["exceptionDetails"]
        return answer["result"].get("value")

    def wait(self, condition):
        until = time.monotonic() + PATIENCE_SECONDS
        while not self.evaluate(condition):
            assert time.monotonic() < until, condition
            time.sleep(0.05)

    def pause(self):
        """Until what is due has been drawn."""
        self.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done, 50))))")

    def _events(self, *methods):
        for event in self.browser.events:
            if event.get("sessionId") == self.session and event["method"] in methods:
                yield event["params"]

    def complaints(self):
        """All that the page, its scripts and its policy have said on the console."""
        said = [json.dumps(event["args"]) for event in self._events("Runtime.consoleAPICalled")]
        said += [json.dumps(event["exceptionDetails"]) for event in self._events("Runtime.exceptionThrown")]
        return said + [event["entry"]["text"] for event in self._events("Log.entryAdded")]

    def requests(self):
        """Addresses that were requested, besides the page and what is written in it."""
        asked = [event["request"]["url"] for event in self._events("Network.requestWillBeSent")]
        return [url for url in asked if url != self.address and not url.startswith("data:")]

    def touch(self, *paths):
        """Moves fingers over the screen at the same time, each along its places (x, y)."""
        points = lambda step: [{"x": path[step][0], "y": path[step][1], "id": n} for n, path in enumerate(paths)]
        self.call("Input.dispatchTouchEvent", type="touchStart", touchPoints=points(0))
        for step in range(1, len(paths[0])):
            self.call("Input.dispatchTouchEvent", type="touchMove", touchPoints=points(step))
        self.call("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])
        self.pause()

    def picture(self):
        """The whole page as PNG."""
        size = self.call("Page.getLayoutMetrics")["cssContentSize"]
        clip = {"x": 0, "y": 0, "width": size["width"], "height": size["height"], "scale": 1}
        return base64.b64decode(self.call("Page.captureScreenshot", captureBeyondViewport=True, clip=clip)["data"])
