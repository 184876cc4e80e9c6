"""A headless Chromium that tests drive by its DevTools protocol, with nothing but the standard library."""
import base64
import json
import os
import re
import shutil
import socket
import struct
import subprocess
import tempfile
import urllib.parse


class Socket:
    """The client's side of a WebSocket (RFC 6455): whole text messages."""

    def __init__(self, url, seconds=120):
        parts = urllib.parse.urlparse(url)
        self.socket = socket.create_connection((parts.hostname, parts.port), seconds)
        key = base64.b64encode(os.urandom(16)).decode()
        self.socket.sendall(("GET %s HTTP/1.1\r\nHost: %s\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                             "Sec-WebSocket-Key: %s\r\nSec-WebSocket-Version: 13\r\n\r\n" % (parts.path + ("?" + parts.query if parts.query else ""), parts.netloc, key)).encode())
        self.buffer = b""
        while b"\r\n\r\n" not in self.buffer:
            self.buffer += self._some()
        head, self.buffer = self.buffer.split(b"\r\n\r\n", 1)
        if b" 101 " not in head.split(b"\r\n")[0]:
            raise IOError(head.decode())

    def _some(self):
        data = self.socket.recv(1 << 16)
        if not data:
            raise IOError("the other side closed")
        return data

    def _take(self, count):
        while len(self.buffer) < count:
            self.buffer += self._some()
        taken, self.buffer = self.buffer[:count], self.buffer[count:]
        return taken

    def send(self, text):
        self._send(text.encode(), 1)

    def _send(self, data, kind):
        size = struct.pack("!B", 128 | len(data)) if len(data) < 126 else struct.pack("!BH", 128 | 126, len(data)) if len(data) < 65536 \
            else struct.pack("!BQ", 128 | 127, len(data))
        mask = os.urandom(4)
        repeated = mask * (len(data) // 4 + 1)
        masked = (int.from_bytes(data, "big") ^ int.from_bytes(repeated[:len(data)], "big")).to_bytes(len(data), "big") if data else b""
        self.socket.sendall(struct.pack("!B", 128 | kind) + size + mask + masked)

    def receive(self):
        message = b""
        while True:
            first, second = self._take(2)
            length = second & 127
            if length == 126:
                length = struct.unpack("!H", self._take(2))[0]
            elif length == 127:
                length = struct.unpack("!Q", self._take(8))[0]
            data = self._take(length)
            if first & 15 == 8:
                raise IOError("the other side ended the connection")
            if first & 15 == 9:  # asks whether anybody is there
                self._send(data, 10)
            if first & 15 in (0, 1):
                message += data
                if first & 128:
                    return message.decode()

    def close(self):
        self.socket.close()


class Browser:
    """One page of a Chromium of its own, in a profile that goes with it."""

    def __init__(self, width=1280, height=900):
        program = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
        if not program:
            raise FileNotFoundError("chromium is not installed; scripts/setup installs it")
        self.profile = tempfile.mkdtemp(prefix="mm_browser_")
        arguments = [program, "--headless=new", "--remote-debugging-port=0", "--user-data-dir=" + self.profile, "--no-first-run",
                     "--disable-gpu-sandbox", "--enable-unsafe-swiftshader", "--disable-background-networking", "--disable-sync",
                     "--window-size=%d,%d" % (width, height), "--remote-allow-origins=*", "about:blank"]
        if os.geteuid() == 0:
            arguments.insert(1, "--no-sandbox")
        self.process = subprocess.Popen(arguments, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        address = None
        for line in self.process.stderr:
            found = re.search(r"DevTools listening on (ws://\S+)", line)
            if found:
                address = found.group(1)
                break
        if not address:
            raise IOError("chromium did not start")
        self.socket, self.last, self.session = Socket(address), 0, None
        self.errors, self.requests = [], []
        target = self.command("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.command("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.command(domain + ".enable")
        self.resize(width, height)

    def close(self):
        self.socket.close()
        self.process.terminate()
        try:
            self.process.wait(20)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        shutil.rmtree(self.profile, ignore_errors=True)

    def __enter__(self):
        return self

    def __exit__(self, *error):
        self.close()

    def command(self, method, **parameters):
        self.last += 1
        message = {"id": self.last, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        self.socket.send(json.dumps(message))
        while True:
            answer = json.loads(self.socket.receive())
            self._note(answer)
            if answer.get("id") == self.last:
                if "error" in answer:
                    raise RuntimeError("%s: %s" % (method, answer["error"]["message"]))
                return answer["result"]

    def _note(self, event):
        """What went wrong on the page, and what it asked from whom."""
        method, parameters = event.get("method"), event.get("params", {})
        if method == "Runtime.exceptionThrown":
            details = parameters["exceptionDetails"]
            self.errors.append(details.get("exception", {}).get("description", details["text"]))
        elif method == "Log.entryAdded" and parameters["entry"]["level"] == "error":
            self.errors.append(parameters["entry"]["text"] + " " + parameters["entry"].get("url", ""))
        elif method == "Network.requestWillBeSent":
            self.requests.append(parameters["request"]["url"])

    def evaluate(self, expression):
        """Value of a JavaScript expression; a promise is awaited."""
        answer = self.command("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True, userGesture=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(expression + ": " + json.dumps(answer["exceptionDetails"])[:500])
        return answer["result"].get("value")

    def open(self, url):
        self.command("Page.navigate", url=url)
        self.wait("document.readyState === 'complete'")

    def wait(self, condition, seconds=60):
        """Until an expression is true on the page, looked at whenever the page draws. @return its value."""
        return self.evaluate("""new Promise((resolve, reject) => {
          const end = performance.now() + %d;
          const look = () => { let value; try { value = (%s); } catch (error) { value = null; }
            if (value) resolve(value); else if (performance.now() > end) reject(new Error("never true")); else setTimeout(look, 30); };
          look(); })""" % (1000 * seconds, condition))

    def click(self, words, within="document", seconds=60):
        """Clicks the button whose text begins so, once it is there and enabled."""
        self.wait("""(() => { const b = [...(%s).querySelectorAll("button")].find((x) => x.textContent.trim().startsWith(%s) && !x.disabled);
                     if (b) b.click(); return !!b; })()""" % (within, json.dumps(words)), seconds)

    def text(self, selector):
        return self.evaluate("(document.querySelector(%s) || {}).innerText" % json.dumps(selector))

    def resize(self, width, height):
        self.command("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=width < 600)

    def colours(self, scheme):
        self.command("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])

    def screenshot(self, file):
        data = self.command("Page.captureScreenshot", format="png", captureBeyondViewport=True)["data"]
        with open(file, "wb") as f:
            f.write(base64.b64decode(data))
