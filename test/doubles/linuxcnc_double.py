#!/usr/bin/env python3
"""A machine as LinuxCNC's Python module shows and moves it: MDI with G1, G38.3, G10 L2 P1, parameters in expressions; work coordinates
that are shifted and turned; homing, abort, emergency stop, feed override, soft limits, limit switches that switch it off.
test/doubles/linuxcnc_module is that module: it asks here, one line of JSON a call. How often the status was written stands in
shared memory, as LinuxCNC keeps it. Faults: off ends LinuxCNC; stuck and intermittent: its status is not written."""
import ctypes
import json
import math
import random
import re
import signal
import sys
import tempfile
import time

import device_double

LETTERS = "XYZABC"
LIMIT = 200.0  # mm or deg
TOP = 50.0     # units/s
RECEPTION = 0.01  # s between two looks at whether a command was taken
SWITCHING = 0.1  # s that it is busy with switching on, on a busy computer
HOMING_BEGINS = 0.25  # s after which homing begins on a busy computer
NAMES = ("state", "mode", "abort", "teleop_enable", "unhome", "home", "feedrate", "mdi")  # of commands
ESTOP, ESTOP_RESET, ON, MANUAL, MDI = 1, 2, 4, 1, 3


class Memory:
    """The head of LinuxCNC's status, of which its clients count the writes."""
    CREATE, REMOVE, WRITES_AT = 0o1000, 0, 56

    def __init__(self):
        self.libc = ctypes.CDLL(None)
        self.libc.shmat.restype = ctypes.c_void_p
        self.key = random.SystemRandom().randrange(1, 2**31)
        self.file = tempfile.NamedTemporaryFile("w", suffix=".nml")
        self.file.write("B emcStatus SHMEM localhost 20480 0 0 2 16 %d TCP=5005 xdr\n" % self.key)
        self.file.flush()

    def create(self):
        self.id = self.libc.shmget(self.key, 128, self.CREATE | 0o600)
        self.writes = ctypes.c_long.from_address(self.libc.shmat(self.id, None, 0) + self.WRITES_AT)

    def remove(self):
        self.libc.shmctl(self.id, self.REMOVE, None)


class LinuxCnc(device_double.Double):
    def __init__(self, a):
        self.machine = device_double.Machine(a.axes, a.ball, a.tip, a.scale, a.acceleration)
        self.offset = [2.0, -1.0, 0.5, 0.0, 0.0, 0.0][:a.axes]  # of the work coordinates
        self.turn = 0.0  # deg, of the work coordinates about Z
        self.units = 1.0
        self.memory = Memory()
        self.begin()
        self.memory.create()
        signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
        super().__init__(a)

    def begin(self):
        self.task, self.mode, self.serial = ESTOP, MANUAL, 0
        self.homed = [False] * self.machine.axes
        self.machine.halt()
        self.machine.share = 1.0
        self.queue, self.job, self.errors = [], None, []
        self.named = {}  # parameters #<…>
        self.refusals = 0
        self.said_late, self.unsaid = False, []
        self.homing = None  # when the joints begin to home, and which
        self.switching = 0.0  # until when it is busy with switching on
        self.frozen = 0.0   # until when the status is not written
        self.lines, self.shown = {}, {}
        self.waiting = []   # when a command's sender hears that it was taken, who that is, and its number
        self.mover, self.slow = None, 0.0  # who gave the last motion, and s by which he hears that later than others
        self.probed, self.tripped = [0.0] * self.machine.axes, False

    def power(self, on):
        self.begin()
        (self.memory.create if on else self.memory.remove)()

    # -- the module
    def say(self, connection, value):
        try:
            connection.sendall((json.dumps(value) + "\n").encode())
        except OSError:
            pass  # it has gone

    def received(self, connection, data):
        self.lines[connection] = self.lines.get(connection, b"") + data
        while b"\n" in self.lines[connection]:
            line, self.lines[connection] = self.lines[connection].split(b"\n", 1)
            self.interpret(connection, *json.loads(line))

    def interpret(self, connection, what, *values):
        if what == "nmlfile":
            return self.say(connection, self.memory.file.name)
        if what == "status":
            return self.say(connection, self.shown)
        if what == "error":
            return self.say(connection, self.errors.pop(0) if self.errors else None)
        assert what in NAMES, what
        self.serial += 1
        self.mover = connection if what == "mdi" else self.mover
        self.waiting.append((time.monotonic() + RECEPTION + (self.slow if connection is self.mover else 0.0), connection, self.serial))
        stops = what == "abort" or (what, *values) == ("state", ESTOP)
        if stops and self.refusals > 0:
            self.refusals -= 1
        else:
            getattr(self, "set_" + what)(*values)

    def write(self):
        """What LinuxCNC's task does in each of its cycles."""
        position = list(self.machine.position)
        if self.fault == "wrong":
            position[0] += device_double.WRONG
        full = lambda values: list(values) + [0.0] * (9 - len(values))
        axes = self.machine.axes
        busy = self.job or self.queue or time.monotonic() < self.switching
        self.shown = {
            "echo_serial_number": self.serial, "state": 2 if busy else 1, "task_state": self.task, "joints": axes,
            "homed": self.homed, "limit": [{-1: 1, 0: 0, 1: 2}[l] for l in self.machine.limits],
            "actual_position": full(position), "position": full(position), "axis_mask": 2**axes - 1,
            "linear_units": self.units, "angular_units": 1.0, "probe_val": int(self.machine.closed()), "probe_tripped": self.tripped,
            "probed_position": full(self.probed), "feedrate": self.machine.share}
        self.memory.writes.value += 1

    # -- commands
    def set_state(self, value):
        if value == ESTOP:
            self.told.append(["reset", time.monotonic()])
            self.task = ESTOP
            self.halt()
        elif value == ESTOP_RESET and self.task == ESTOP:
            self.task = ESTOP_RESET
        elif value == ON and self.task != ESTOP:
            self.task = ON
            self.switching = time.monotonic() + SWITCHING

    def set_mode(self, value):
        self.mode = value

    def set_teleop_enable(self, value):
        pass

    def set_abort(self):
        self.told.append(["hold", time.monotonic()])
        self.queue = []
        if self.job:
            self.job["aborted"], self.machine.hold = True, True

    def set_feedrate(self, value):
        self.machine.share = value
        self.told.append(["override", 100.0 * value])

    def joints_of(self, joint):
        return list(range(self.machine.axes)) if joint < 0 else [joint]

    def set_unhome(self, joint):
        for j in self.joints_of(joint):
            self.homed[j] = False

    def set_home(self, joint):
        if self.task != ON or self.mode != MANUAL:
            return self.errors.append("must be in joint mode to home")
        joints = self.joints_of(joint) + (self.homing[1] if self.homing else [])
        self.homing = (time.monotonic() + HOMING_BEGINS, joints)

    def set_mdi(self, text):
        if self.mode != MDI or self.task != ON:
            return self.errors.append("Must be in MDI mode to issue MDI command")
        self.queue.append(text)

    # -- what a test does
    def command(self, words):
        """refuse N: the next N aborts and emergency stops have no effect.
        late: what the motion says of a trip arrives when the next motion has begun, as on a busy computer.
        slow S: who moves the axes hears S seconds later that a command was taken, as on a busy computer.
        freeze S: for S seconds the status is not written, and the axes go on, as where the task is held up.
        mdi …: another client's. override PERCENT: of the feed, by another client. fault_joint N: its following error.
        units N: of the machine, per mm. say …: an error of LinuxCNC's. state: what a client cannot see otherwise."""
        if words[0] == "mdi":
            self.mode = MDI
            self.queue.append(" ".join(words[1:]))
            return {"mdi": self.queue}
        if words[0] == "override":
            self.machine.share = float(words[1]) / 100.0
            return {"override": self.machine.share}
        if words[0] == "fault_joint":
            return self.switch_off("joint %s following error" % words[1])
        if words[0] == "say":
            self.errors.append(" ".join(words[1:]))
            return {"said": self.errors[-1]}
        if words[0] == "units":
            self.units = float(words[1])
            return {"units": self.units}
        if words[0] == "state":
            return {"override": self.machine.share, "on": self.task == ON, "queue": len(self.queue), "job": bool(self.job)}
        if words[0] == "freeze":
            self.frozen = time.monotonic() + float(words[1])
            return {"frozen": float(words[1])}
        if words[0] == "slow":
            self.slow = float(words[1])
            return {"slow": self.slow}
        if words[0] == "late":
            self.said_late = True
            return {"late": True}
        if words[0] == "refuse":
            self.refusals = int(words[1])
            return {"refusals": self.refusals}
        return {"error": "unknown"}

    def switch_off(self, why):
        """As motion does by itself: the axes rest, and the flags of homing stand."""
        self.task = ESTOP_RESET
        self.errors.append(why)
        self.halt()
        return {"off": why}

    def begin_homing(self):
        (_, joints), self.homing = self.homing, None
        target = list(self.machine.position)
        for j in joints:
            target[j] = 0.0
        self.machine.move(target, TOP)
        self.job = {"kind": "home", "joints": joints}

    def halt(self):
        self.machine.halt()
        self.queue, self.job, self.homing = [], None, None

    # -- the world
    def tick(self, seconds):
        now = time.monotonic()
        self.go_on(seconds)
        if self.fault != "stuck" and not self.silent() and now >= self.frozen:
            self.write()
        heard, self.waiting = [w for w in self.waiting if w[0] <= now], [w for w in self.waiting if w[0] > now]
        for _, connection, serial in heard:
            if connection in self.connections:
                self.say(connection, serial)

    def go_on(self, seconds):
        for joint, switch in enumerate(self.machine.limits):
            if switch and self.task == ON:
                self.switch_off("joint %d on limit switch error" % joint)
        if self.job is None and self.homing and time.monotonic() >= self.homing[0]:
            self.begin_homing()
        if self.job is None and self.queue:
            self.begin_block(self.queue.pop(0))
        job = self.job
        if job is None:
            return
        was = self.machine.closed()
        how = self.machine.step(seconds)
        if not was and self.machine.closed() and not job.get("tripped"):
            if job["kind"] == "probe":
                job["tripped"], self.tripped, self.probed = True, True, list(self.machine.position)
            elif not job.get("aborted"):
                (self.unsaid if self.said_late else self.errors).append("Probe tripped during non-probe move.")
                job["aborted"] = True
                self.queue = []
            self.machine.hold = True
        if how not in ("arrived", "held"):
            return
        if how == "held":
            self.machine.halt()
        if job["kind"] == "home" and not job.get("aborted"):
            for j in job["joints"]:
                self.homed[j] = True
        self.job = None

    def turned(self, at, by):
        """@return the first two of `at` turned about Z by `by` deg, the others as they are."""
        c, s = math.cos(math.radians(by)), math.sin(math.radians(by))
        return [at[0] * c - at[1] * s, at[0] * s + at[1] * c] + list(at[2:])

    def to_work(self, position):
        return self.turned([p - o for p, o in zip(position, self.offset)], -self.turn)

    def to_machine(self, work):
        return [w + o for w, o in zip(self.turned(work, self.turn), self.offset)]

    def parameter(self, number):
        work, number = self.to_work(self.machine.position), int(number)
        if 5420 <= number < 5420 + len(work):
            return work[number - 5420]
        return {5220: 1.0, 5230: self.turn}[number]

    def value(self, text):
        """Of a number or an expression: [#5420+1.5*COS[#<_a>]]."""
        text = re.sub(r"#<(\w+)>", lambda m: "(%r)" % self.named[m.group(1).upper()], text)
        text = re.sub(r"#(\d+)", lambda m: "(%r)" % self.parameter(m.group(1)), text)
        text = text.replace("#[", "PARAMETER[").replace("[", "(").replace("]", ")")
        names = {"PARAMETER": self.parameter, "COS": lambda a: math.cos(math.radians(a)), "SIN": lambda a: math.sin(math.radians(a))}
        return float(eval(text, {"__builtins__": {}}, names))

    def begin_block(self, text):
        text = text.upper()
        self.named.update({m.group(1): self.value(m.group(2)) for m in re.finditer(r"#<(\w+)>=(\S+)", text)})
        words = [(w[0], self.value(w[1:])) for w in re.sub(r"#<\w+>=\S+", "", text).split()]
        codes = [v for l, v in words if l == "G"]
        if 10.0 in codes:
            return self.set_work(dict(words))
        probes = 38.3 in codes
        work, named, feed = self.to_work(self.machine.position), {}, 0.0
        for letter, value in words:
            if letter == "F":
                feed = value / 60.0
            if letter in LETTERS[:self.machine.axes]:
                named[LETTERS.index(letter)] = value
        if 53.0 in codes:
            target = [named.get(i, p) for i, p in enumerate(self.machine.position)]
        else:
            target = self.to_machine([named.get(i, w) for i, w in enumerate(work)]) if named else list(self.machine.position)
        for i, t in enumerate(target):
            if abs(t) > LIMIT:
                self.errors.append("Linear move on line 0 would exceed %s's %s limit" % (LETTERS[i], "positive" if t > 0 else "negative"))
                self.queue = []
                return
        if probes:
            self.tripped = False
        if probes and self.machine.closed():
            self.errors.append("Probe is already tripped when starting G38.2 or G38.3 move")
            self.queue = []
            return
        way = [t - p for t, p in zip(target, self.machine.position)]
        linear = sum(w * w for w in way[:3]) ** 0.5
        whole = sum(w * w for w in way) ** 0.5
        if whole == 0.0 or feed <= 0.0:
            return
        # The feed is that of the linear axes; the others arrive with them.
        self.machine.move(target, min(feed * (whole / linear if linear > 0.0 else 1.0), 2 * TOP))
        self.errors, self.unsaid = self.errors + self.unsaid, []
        self.job = {"kind": "probe" if probes else "move"}

    def set_work(self, words):
        """G10 L2 P1: of the work coordinates that are active."""
        for i, letter in enumerate(LETTERS[:self.machine.axes]):
            self.offset[i] = words.get(letter, self.offset[i])
        self.turn = words.get("R", self.turn)


if __name__ == "__main__":
    double = LinuxCnc(device_double.arguments(5))
    try:
        double.run()
    finally:
        double.memory.remove()
