"""Clients of the workbench for the load test: honest ones, and every kind of hostile one. Each hostile kind is a function that runs until
`end` and returns how often it was answered with which status; 0: closed without an answer."""
import json
import os
import re
import select
import socket
import sys
import threading
import time
import urllib.parse

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from browser import Socket  # noqa: E402

RATE = 10000      # requests a second that are sent with the token
PATIENCE = 10.0   # s that an honest client waits at most: these tests share their computer


class Address:
    def __init__(self, url):
        parts = urllib.parse.urlparse(url)
        self.url, self.host, self.port = url, parts.netloc, parts.port
        self.token = urllib.parse.parse_qs(parts.query)["token"][0]

    def connect(self, seconds=PATIENCE):
        s = socket.create_connection(("127.0.0.1", self.port), seconds)
        s.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        return s

    def request(self, line, more="", body="", host=None):
        return ("%s HTTP/1.1\r\nHost: %s\r\n%s\r\n%s" % (line, self.host if host is None else host, more, body)).encode()

    def post(self, path, body, token=True):
        return self.request("POST %s%s" % (path, "?token=" + self.token if token else ""), "Content-Length: %d\r\n" % len(body.encode()), body)

    def ask(self, request):
        """Status and body of one request in a connection of its own; 0: none came."""
        try:
            with self.connect() as s:
                s.sendall(request)
                return answer_of(s)
        except OSError:
            return 0, b""


def answer_of(s):
    """Status and body of the next answer of a connection; 0: it was closed before."""
    got = b""
    while b"\r\n\r\n" not in got:
        more = s.recv(65536)
        if not more:
            return 0, b""
        got += more
    head, body = got.split(b"\r\n\r\n", 1)
    size = int(re.search(rb"(?i)content-length: *(\d+)", head).group(1))
    while len(body) < size:
        more = s.recv(65536)
        if not more:
            return 0, b""
        body += more
    return int(head[9:12]), body


class Honest:
    """A page, by its live connection, and a program that asks for the session twenty times a second: in a connection that it
    keeps, and each time in a new one."""

    def __init__(self, address):
        self.address, self.going, self.live, self.lost = address, True, [], None
        self.kept, self.new, self.refused, self.failed, self.state = [], [], 0, [], {}
        self.socket = Socket("ws://%s/live?token=%s" % (address.host, address.token))
        self.threads = [threading.Thread(target=t, daemon=True) for t in (self.read, self.ask_kept, self.ask_new)]
        for t in self.threads:
            t.start()

    def read(self):
        try:
            while self.going:
                state = json.loads(self.socket.receive())
                if "sequence" in state:
                    self.state = state
                    self.live.append((time.time(), state["sequence"]))
        except (OSError, ValueError) as e:
            self.lost = e

    def one(self, s, times):
        began = time.time()
        s.sendall(self.address.request("GET /data/session?token=" + self.address.token))
        status, body = answer_of(s)
        if status == 200 and json.loads(body)["observations"] > 0:
            times.append(time.time() - began)
        elif status == 429:
            self.refused += 1  # "wait a second": another has the token too, and asks too much
        else:
            raise OSError("status %d" % status)

    def ask_kept(self):
        s = None
        while self.going:
            try:
                s = s or self.address.connect()
                self.one(s, self.kept)
            except OSError as e:
                self.failed.append("kept: %s" % e)
                s = None
            time.sleep(0.05)

    def ask_new(self):
        while self.going:
            began = time.time()
            try:
                with self.address.connect() as s:
                    before = len(self.new)
                    self.one(s, self.new)
                    if len(self.new) > before:
                        self.new[-1] = time.time() - began  # the connection counts
            except OSError as e:
                self.failed.append("new: %s" % e)
            time.sleep(0.05)

    def at_rest(self, seconds):
        """Until no task runs or waits."""
        end = time.time() + seconds
        while time.time() < end and not (self.state and self.state["task"] is None and not self.state["pending"]):
            time.sleep(0.05)
        return bool(self.state) and self.state["task"] is None and not self.state["pending"]

    def forget(self):
        self.kept, self.new, self.refused, self.failed, self.live = [], [], 0, [], []

    def tell(self):
        def times(t):
            t = sorted(t)
            return "%d, median %.1f, 99 %% %.1f, most %.1f ms" % (len(t), 1e3 * t[len(t) // 2], 1e3 * t[int(0.99 * len(t))], 1e3 * t[-1]) if t else "none"
        gaps = [b[0] - a[0] for a, b in zip(self.live, self.live[1:])]
        return "honest answers: kept connection %s; new connection %s; asked to wait %d; failed %d%s; %d live states, at most %.2f s apart" % (
            times(self.kept), times(self.new), self.refused, len(self.failed), " (%s)" % self.failed[0] if self.failed else "",
            len(self.live), max(gaps, default=0.0))


def flood_without_token(address, end, at_once):
    """A connection a request, so many at a time: each is refused and closed, or gives way."""
    counts, request = {}, address.request("GET /data/session")
    while time.time() < end:
        open_ = []
        for _ in range(at_once):
            s = socket.socket()
            s.setblocking(False)
            s.connect_ex(("127.0.0.1", address.port))
            open_.append(s)
        for s in open_:
            status = 0
            try:
                s.settimeout(PATIENCE)
                s.sendall(request)
                head = s.recv(64)
                status = int(head[9:12]) if head else 0
            except OSError:
                pass
            s.close()
            counts[status] = counts.get(status, 0) + 1
    return counts


def flood_with_token(address, end, share):
    """RATE requests a second, sent without waiting for the answers, by a client that has the token."""
    counts, each, began = {}, 25, time.time()
    s = address.connect()
    batch = address.request("GET /none?token=" + address.token) * each
    sent, tail = 0, b""
    poll = select.poll()
    poll.register(s, select.POLLIN)

    def take(wait):
        nonlocal tail
        while poll.poll(wait):
            more = s.recv(1 << 18)
            if not more:
                raise OSError("closed")
            data = tail + more
            for status in re.findall(rb"HTTP/1\.1 (\d{3})", data):
                counts[int(status)] = counts.get(int(status), 0) + 1
            tail = data[-11:] if b"HTTP/1.1" not in data[-11:] else data[-7:]
            wait = 0
    try:
        while time.time() < end:
            if sent < (time.time() - began) * RATE * share:
                s.sendall(batch)
                sent += each
                take(0)
            else:
                take(1)
        while sum(counts.values()) < sent and time.time() < end + PATIENCE:
            take(100)
    except OSError:
        pass
    counts["sent"] = sent
    return counts


def slow_loris(address, end, _):
    """Two hundred connections that each send a letter of a header now and then; who is closed comes again."""
    counts, open_, header = {"connections": 0}, [], b"GET /data/session HTTP/1.1\r\nHost: " + address.host.encode() + b"\r\nX-Slow: " + b"a" * 4000
    while time.time() < end:
        while len(open_) < 200:
            try:
                s = address.connect(1)
            except OSError:
                break
            s.setblocking(False)
            open_.append([s, 0])
            counts["connections"] += 1
        still = []
        for one in open_:
            try:
                one[0].send(header[one[1]:one[1] + 1])
                one[1] += 1
                if one[0].recv(64) == b"":
                    raise OSError
            except BlockingIOError:
                still.append(one)
            except OSError:
                one[0].close()
                counts[0] = counts.get(0, 0) + 1
                continue
        open_ = still
        time.sleep(0.02)
    for s, _ in open_:
        s.close()
    return counts


def endless(address, end, kind):
    """Bodies without an end, in chunks: JSON that only opens; a file."""
    counts = {"MB sent": 0.0}
    path, token, piece = {"json": ("/action/add", True, b'{"effect":' + b"[" * 16384), "json_foreign": ("/action/add", False, b"[" * 16384),
                          "file": ("/upload", True, b"x" * (1 << 20))}[kind]
    more = "&name=endless.bag" if kind == "file" else ""
    head = address.request("POST %s?token=%s%s" % (path, address.token if token else "", more), "Transfer-Encoding: chunked\r\n")
    while time.time() < end:
        status = 0
        try:
            with address.connect() as s:
                s.sendall(head)
                poll = select.poll()
                poll.register(s, select.POLLIN)
                chunk = b"%x\r\n" % len(piece) + piece + b"\r\n"
                while time.time() < end and not poll.poll(0):
                    s.sendall(chunk)
                    counts["MB sent"] += len(piece) / 1048576.0
                if poll.poll(0):
                    status = int(s.recv(64)[9:12] or 0)
                else:
                    status = "stopped by us"
        except OSError:
            pass  # it was closed while it was sent: the answer is lost with it
        counts[status] = counts.get(status, 0) + 1
    return counts


def announced(address, end, how):
    """A file with its length, of 1 GB, sent until the other side has enough; or one as large as is allowed, which is no bag."""
    megabytes, token = {"1 GB": (1024, True), "1 GB, no token": (1024, False), "250 MB": (250, True)}[how]
    counts, block = {"MB sent": 0.0}, b"x" * (1 << 20)
    head = address.request("POST /upload?name=big.bag" + ("&token=" + address.token if token else ""), "Content-Length: %d\r\n" % (megabytes << 20))
    while time.time() < end:
        status = 0
        try:
            with address.connect(60) as s:
                s.sendall(head)
                poll = select.poll()
                poll.register(s, select.POLLIN)
                for _ in range(megabytes):
                    if poll.poll(0):
                        break
                    s.sendall(block)
                    counts["MB sent"] += 1
                status = int(s.recv(64)[9:12] or 0)
        except OSError:
            pass
        counts[status] = counts.get(status, 0) + 1
    return counts


def refusals(address):
    """What must be refused whoever asks: (request, statuses that it may have). 409: another sends a file just now."""
    mine, t = "?token=" + address.token, address.token
    yield address.request("GET /data/session" + mine, host="evil.example"), {421}
    yield address.request("GET /data/session" + mine, host="127.0.0.1:1"), {421}
    for origin in ("http://evil.example", "null", "https://" + address.host):
        yield address.request("POST /action/add_all" + mine, "Origin: %s\r\nContent-Length: 2\r\n" % origin, "{}"), {403}
        yield address.request("GET /live" + mine, "Origin: %s\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                              "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n" % origin), {403}
    for path in ("/data/session", "/?token=", "/?token=" + "0" * 32, "/t/%s/data/session" % ("f" * 32), "/upload"):
        yield address.request("GET " + path), {403}
        yield address.request("POST " + path, "Content-Length: 2\r\n", "{}"), {403}
    for path in ("/../../etc/passwd", "/t/%s/../../../etc/passwd" % t, "/app/%2e%2e/%2e%2e/etc/passwd", "/app/..%5c..%5cx", "/a%00.js", "/%"):
        yield address.request("GET " + path + ("" if "/t/" in path else mine)), {400}
    for path in ("/etc/passwd", "//etc/passwd", "/app/etc/passwd", "/data//etc/passwd", "/download/....//passwd", "/lib/%252e%252e/passwd", "/data/.bashrc"):
        yield address.request("GET " + path + mine), {400, 404}
    for method in ("PUT", "DELETE", "OPTIONS", "TRACE", "CONNECT"):
        yield address.request(method + " /data/session" + mine), {405, 400}
    yield address.request("GET /" + "a" * 9000 + mine), {431, 400}
    yield b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + b"\0" * 600 + b"\r\n\r\n", {400, 431, 0}
    yield address.post("/action/nothing_of_the_kind", "{}"), {404}
    for motion in ("arm", "home", "run", "stop"):
        yield address.post("/action/" + motion, "{}"), {409}
    for body in ("", "[", "[]", "null", '{"effect": [1]}', '{"seed": -1}', '{"a": 1, "a": 2}', '{"effect": "\\ud800"}', '{"foreign": "x"}'):
        yield address.post("/action/add", body), {400}
    yield address.request("POST /upload?token=%s&name=../../../etc/cron.d/x" % t, "Content-Length: 4\r\n", "data"), {415, 409}
    yield address.request("POST /upload?token=%s&name=empty.bag" % t, "Content-Length: 0\r\n"), {400, 409}


def foreigners(address, end, _):
    counts, wrong = {}, []
    list_ = list(refusals(address))
    while time.time() < end:
        for request, allowed in list_:
            status, _ = address.ask(request)
            counts[status] = counts.get(status, 0) + 1
            if status not in allowed and status != 429:
                wrong.append((status, request[:100].decode("latin-1")))
    counts["wrong"] = wrong[:3]
    return counts


FORMULAS = ["(" * 490 + "k1*x", "k1*" + "(" * 248 + "x" + ")" * 248, "-" * 490 + "x", "k1*x" + "^2" * 240, "k1*2^9^9^9^9^9^9^9*x", "k1*x" + "*x" * 240,
            "k1*" + "sin(" * 120 + "x" + ")" * 120, "k1*x+" * 99 + "x", "(x>0?" * 80 + "k1*x" + ":0)" * 80, "k1*x," * 100 + "x", "k1=k1=k1*x", "x" * 500,
            "+".join("k%d*x" % i for i in range(1, 80)), "k1*(" + "x," * 200 + "x)", "max(" + "x," * 230 + "k1*x)", "k1*x\0*y", "k1*\"" + "a" * 480, "1e" + "9" * 400]


def formulas(address, end, _):
    """Formulas that nest, repeat and never end: each is judged on the server's own thread. @return counts, and the longest time (s)."""
    counts, longest, at = {}, 0.0, 0
    s = address.connect()
    while time.time() < end or at < len(FORMULAS):
        formula, at = FORMULAS[at % len(FORMULAS)], at + 1
        began = time.time()
        s.sendall(address.post("/formula", json.dumps({"direction": "x", "formula": formula, "start": "1"})))
        status, body = answer_of(s)
        longest = max(longest, time.time() - began)
        said = status if status != 200 else "ok" if json.loads(body)["ok"] else "refused"
        counts[said] = counts.get(said, 0) + 1
        time.sleep(0.003)  # below the limit of requests a second: each is read
    counts["longest ms"] = round(1e3 * longest, 1)
    return counts


def bombs(address, end, _):
    """Texts in YAML that grow when they are read, within a body of 64 KB."""
    counts = {}
    aliases = "a0: &a0 [x, x, x, x, x, x, x, x, x]\n" + "".join("a%d: &a%d [%s]\n" % (i, i, ", ".join(["*a%d" % (i - 1)] * 9)) for i in range(1, 12))
    nested, flow = "effects: " + "[" * 30000, "{a: " * 15000
    merged = "x: &x {a: 1}\n" + "".join("y%d: &y%d {<<: [%s]}\n" % (i, i, ", ".join(["*x"] * 8)) for i in range(300))
    while time.time() < end:
        for name, body in (("calibrate", {"model": aliases + "effects: *a11\n"}), ("add", {"effect": nested}), ("remove", {"effect": flow}),
                           ("calibrate", {"model": merged}), ("add", {"effect": "{type: formula, direction: x, formula: \"" + "(" * 50000 + "\"}"})):
            status, _ = address.ask(address.post("/action/" + name, json.dumps(body)))
            counts[status] = counts.get(status, 0) + 1
    return counts
