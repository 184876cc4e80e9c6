"""What the doubles of the controllers share: a line on TCP or a pty, a machine of straight motions that can touch a
hemisphere, and faults on demand. Nothing here comes from the code that is tested.

A double prints one line of JSON when it is ready: {"address": …, "control": port}. On the control port (TCP) it takes one
command a line and answers with one line of JSON:
    fault <ok|off|stuck|garbage|wrong|slow [by how many seconds]|intermittent>
    probe <ok|dead|stuck|chatter>       the switch of the probe
    limit <axis> <-1|0|1>               a limit switch
    machine                             where it truly is, whether it moves, when it moved last (s of the monotonic clock), how it
                                        was told to stop and when
    line                                how often something was heard, how much of what is said is still under way
"""
import argparse
import json
import math
import os
import pty
import random
import select
import socket
import time
import tty

FAULTS = ("ok", "off", "stuck", "garbage", "wrong", "slow", "intermittent")
SLOW = 0.4         # s by which a slow device is late
ANSWERING, SILENT = 1.0, 0.7  # s of an intermittent one
WRONG = 5.0        # mm by which a wrong device is wrong
TICK = 0.001       # s
STALL = 0.02       # s of the world at most that pass at once


class Machine:
    """Axes in mm or deg that go in straight lines with one acceleration; a ball that the tip of the probe may touch."""

    def __init__(self, axes, ball, tip, scale, acceleration):
        self.axes, self.acceleration = axes, acceleration
        self.position = [0.0] * axes
        self.ball, self.tip, self.scale = ball, tip, scale  # ball: x y z r; scale: true / shown of the first axes
        self.target, self.speed, self.now = None, 0.0, 0.0
        self.share, self.hold = 1.0, False
        self.probe = "ok"
        self.limits = [0] * axes
        self.random = random.Random(1)

    def move(self, target, feed):
        """@param feed units/s along the vector of all axes."""
        self.target, self.speed = list(target), feed

    def halt(self):
        self.target, self.now, self.hold = None, 0.0, False

    def moving(self):
        return self.target is not None and self.now > 0.0

    def depth(self, position=None):
        if not self.ball:
            return -1.0
        p = position or self.position
        away = math.sqrt(sum((p[i] * self.scale[i] - self.ball[i]) ** 2 for i in range(3)))
        return self.ball[3] + self.tip - away

    def closed(self):
        if self.probe == "dead":
            return False
        if self.probe == "stuck":
            return True
        touching = self.depth() > 0.0
        if self.probe == "chatter" and touching:
            return self.random.random() < 0.5
        return touching

    def step(self, seconds):
        """@return "arrived", "held" or nothing."""
        if self.target is None:
            return None
        way = [t - p for t, p in zip(self.target, self.position)]
        left = math.sqrt(sum(w * w for w in way))
        wanted = 0.0 if self.hold else min(self.speed * self.share, math.sqrt(2 * self.acceleration * left) + 1e-9)
        change = self.acceleration * seconds
        self.now = min(max(wanted, self.now - change), self.now + change)
        if self.hold and self.now <= 0.0:
            return "held"
        reach = max(self.now, self.acceleration * seconds if not self.hold and self.share > 0.0 else 0.0) * seconds
        if left <= reach:
            self.position, self.target, self.now = list(self.target), None, 0.0
            return "arrived"
        self.position = [p + w * reach / left for p, w in zip(self.position, way)]
        return None


class Double:
    """Runs a protocol: `received(bytes)` is called with what comes, `tick(seconds)` every millisecond; `say(text)` answers."""

    def __init__(self, arguments):
        self.fault, self.since, self.late = "ok", time.monotonic(), SLOW
        self.pty = arguments.pty
        self.connections, self.listener, self.port = [], None, arguments.port
        self.outgoing = []  # time, connection, bytes
        self.random = random.Random(2)
        self.told = []      # what is to be looked at later: [what, time]
        if self.pty:
            self.open_pty()
        else:
            self.listen()
        self.control = socket.create_server(("127.0.0.1", arguments.control))
        self.controllers = {}
        print(json.dumps({"address": self.address(), "control": self.control.getsockname()[1]}), flush=True)

    # -- what a protocol adds
    def received(self, connection, data):
        raise NotImplementedError

    def connected(self, connection):
        pass

    def tick(self, seconds):
        raise NotImplementedError

    def power(self, on):
        raise NotImplementedError

    def command(self, words):
        return {"error": "unknown"}

    # -- the line
    def address(self):
        return "serial:%s" % os.ttyname(self.slave) if self.pty else "tcp:127.0.0.1:%d" % self.port

    def listen(self):
        self.listener = socket.create_server(("127.0.0.1", self.port))
        self.port = self.listener.getsockname()[1]

    def open_pty(self):
        master, self.slave = pty.openpty()
        tty.setraw(master)
        tty.setraw(self.slave)
        os.set_blocking(master, False)
        self.connections = [master]

    def drop(self):
        if self.pty:
            return
        for connection in self.connections:
            connection.close()
        self.connections, self.outgoing = [], []

    def say(self, connection, text):
        if self.fault == "stuck":
            return
        data = text.encode("latin-1")
        if self.fault == "garbage":
            data = bytes(self.random.randrange(256) for _ in data[:-2]) + b"\r\n"
        at = time.monotonic() + (self.late if self.fault == "slow" else 0.0)
        if self.outgoing:
            at = max(at, self.outgoing[-1][0])  # nothing overtakes on a line
        self.outgoing.append((at, connection, data))

    def silent(self):
        return self.fault == "intermittent" and (time.monotonic() - self.since) % (ANSWERING + SILENT) > ANSWERING

    def flush(self):
        now = time.monotonic()
        late = []
        for at, connection, data in self.outgoing:
            if at > now:
                late.append((at, connection, data))
            elif not self.silent():
                try:
                    os.write(connection, data) if self.pty else connection.sendall(data)
                except OSError:
                    pass
        self.outgoing = late

    def set_fault(self, fault, late=SLOW):
        if fault not in FAULTS:
            return {"error": "no such fault"}
        before, self.fault, self.since, self.late = self.fault, fault, time.monotonic(), float(late)
        if fault == "off" and before != "off":
            self.drop()
            self.power(False)
            if self.listener:
                self.listener.close()
                self.listener = None
        if before == "off" and fault != "off":
            self.power(True)
            if not self.pty:
                self.listen()
        return {"fault": fault}

    def obey(self, line):
        words = line.split()
        if words[0] == "fault":
            return self.set_fault(*words[1:])
        if words[0] == "probe":
            self.machine.probe = words[1]
            return {"probe": words[1]}
        if words[0] == "limit":
            self.machine.limits[int(words[1])] = int(words[2])
            return {"limits": self.machine.limits}
        if words[0] == "machine":
            return {"position": self.machine.position, "moving": self.machine.moving(), "moved": self.moved, "depth": self.machine.depth(),
                    "told": self.told, "deepest": self.deepest}
        if words[0] == "line":
            return {"heard": self.heard, "waiting": len(self.outgoing)}
        return self.command(words)

    heard = 0
    deepest, moved = -1e9, 0.0

    def run(self):
        last = time.monotonic()
        parent = os.getppid()
        while os.getppid() == parent:
            readers = list(self.connections) + list(self.controllers) + [self.control]
            if self.listener:
                readers.append(self.listener)
            ready, _, _ = select.select(readers, [], [], TICK)
            # The world is brought up to the present before it is asked for: what it answers is of now. Where this process was
            # held up, its world stood still, as no real machine would jump.
            now = time.monotonic()
            last = max(last, now - STALL)
            while last + TICK <= now:
                last += TICK
                if self.fault != "off":
                    before = self.machine.position
                    self.tick(TICK)
                    if self.machine.position != before:
                        self.moved = last
                    self.deepest = max(self.deepest, self.machine.depth())
            for one in ready:
                if one is self.control:
                    connection, _ = one.accept()
                    self.controllers[connection] = b""
                elif one in self.controllers:
                    self.serve(one)
                elif one is self.listener:
                    connection, _ = one.accept()
                    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                    self.connections.append(connection)
                    self.connected(connection)
                elif one in self.connections:
                    self.read(one)
            self.flush()

    def serve(self, one):
        data = one.recv(4096)
        if not data:
            del self.controllers[one]
            one.close()
            return
        self.controllers[one] += data
        while b"\n" in self.controllers[one]:
            line, self.controllers[one] = self.controllers[one].split(b"\n", 1)
            one.sendall((json.dumps(self.obey(line.decode())) + "\n").encode())

    def read(self, one):
        try:
            data = os.read(one, 4096) if self.pty else one.recv(4096)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if not data:
            if not self.pty:
                self.connections.remove(one)
                one.close()
            return
        if self.fault == "off":
            return
        self.heard += 1
        self.received(one, data)


def arguments(axes):
    parser = argparse.ArgumentParser()
    parser.add_argument("--port", type=int, default=0)
    parser.add_argument("--control", type=int, default=0, help="port of the control line; 0: any")
    parser.add_argument("--pty", action="store_true")
    parser.add_argument("--axes", type=int, default=axes)
    parser.add_argument("--ball", type=float, nargs=4, default=None, help="centre and radius, mm")
    parser.add_argument("--tip", type=float, default=1.0, help="radius of the tip, mm")
    parser.add_argument("--scale", type=float, nargs=3, default=[1.0, 1.0, 1.0], help="true / shown of X Y Z")
    parser.add_argument("--acceleration", type=float, default=500.0, help="mm/s^2")
    parser.add_argument("--homing", type=float, default=200.0, help="units/s along the vector of all axes")
    parser.add_argument("--no-hal", action="store_true", help="grbl 1.1, not grblHAL")
    return parser.parse_known_args()[0]  # roslaunch adds arguments of its own
