#!/usr/bin/env python3
"""A machine that speaks the documented language of LinuxCNC's server linuxcncrsh: hello, enable, get and set on as many
connections as come; MDI with G1, G38.3, G10 L2 P1 and (DEBUG, …), named parameters and expressions; work coordinates that
are shifted and turned; homing, abort, emergency stop, feed override, soft limits, limit switches that switch it off.

As in the server, a command keeps its connection busy for RECEPTION, in which nothing else that came on it is read; and a
command that another connection gave meanwhile has changed the number that the first waits for: it then waits until the
time limit (`set timeout`), or for ever."""
import math
import re
import time

import device_double

LETTERS = "XYZABC"
LIMIT = 200.0  # mm or deg
TOP = 50.0     # units/s
RECEPTION = 0.1  # s between two looks at whether a command was received
HOMING_BEGINS = 0.25  # s after which homing begins on a busy computer


class LinuxCnc(device_double.Double):
    def __init__(self, a):
        self.machine = device_double.Machine(a.axes, a.ball, a.tip, a.scale, a.acceleration)
        self.offset = [2.0, -1.0, 0.5, 0.0, 0.0, 0.0][:a.axes]  # of the work coordinates
        self.turn = 0.0  # deg, of the work coordinates about Z
        self.units = "MM"
        self.begin()
        super().__init__(a)

    def begin(self):
        self.estop, self.on, self.mode, self.teleop = True, False, "MANUAL", False
        self.homed = [False] * self.machine.axes
        self.machine.halt()
        self.machine.share = 1.0
        self.queue, self.job, self.errors, self.display = [], None, [], []
        self.named = {}  # parameters #<…>
        self.refusals = 0
        self.said_late, self.unsaid = False, []
        self.homing = None  # when the joints begin to home, and which
        self.frozen = None  # until when what is shown stays, and what that is
        self.lines, self.greeted, self.enabled = {}, set(), None
        self.verbose, self.waiting, self.number, self.timeout = set(), {}, 0, 0.0
        self.probed = [0.0] * self.machine.axes
        self.success = 0

    def power(self, on):
        self.begin()

    def received(self, connection, data):
        self.lines[connection] = self.lines.get(connection, b"") + data
        self.read_on(connection)

    def read_on(self, connection):
        while connection not in self.waiting and b"\n" in self.lines.get(connection, b""):
            line, self.lines[connection] = self.lines[connection].split(b"\n", 1)
            self.interpret(connection, line.decode("latin-1").strip())

    def look(self):
        now = time.monotonic()
        for connection, (word, number, began) in list(self.waiting.items()):
            late = 0.0 < self.timeout < now - began
            if now - began < RECEPTION or (number != self.number and not late):
                continue
            del self.waiting[connection]
            if late or connection in self.verbose:
                self.answer(connection, "SET %s %s" % (word.upper(), "NAK" if late else "ACK"))
            self.read_on(connection)

    def answer(self, connection, text):
        self.say(connection, text + "\r\n")

    def interpret(self, connection, line):
        words = line.split()
        if not words:
            return
        verb = words[0].lower()
        if verb == "hello":
            good = len(words) == 4 and words[1] == "EMC"
            if good:
                self.greeted.add(connection)
            return self.answer(connection, "HELLO ACK EMCNETSVR 1.1" if good else "HELLO NAK")
        if connection not in self.greeted or len(words) < 2:
            return self.answer(connection, "%s NAK" % verb.upper())
        if verb == "get":
            return self.get(connection, words[1].lower())
        if verb == "set":
            return self.set(connection, words[1].lower(), line.split(None, 2)[2] if len(words) > 2 else "")

    def status(self):
        """@return what is shown: position, and whether nothing is under way."""
        if self.frozen and time.monotonic() < self.frozen[0]:
            return self.frozen[1]
        position = list(self.machine.position)
        if self.fault == "wrong":
            position[0] += device_double.WRONG
        return position, not (self.job or self.queue)

    def shown(self):
        return self.status()[0]

    def numbers(self, values):
        return " ".join("%.6f" % v for v in values + [0.0] * (6 - len(values)))

    def get(self, connection, what):
        on = lambda flag: "ON" if flag else "OFF"
        axes = self.machine.axes
        answers = {
            "estop": lambda: on(self.estop), "machine": lambda: on(self.on), "mode": lambda: self.mode, "teleop_enable": lambda: "YES" if self.teleop else "NO",
            "joint_homed": lambda: " ".join("YES" if h else "NO" for h in self.homed),
            "joint_limit": lambda: " ".join({-1: "MINHARD", 0: "OK", 1: "MAXHARD"}[l] for l in self.machine.limits),
            "abs_act_pos": lambda: self.numbers(self.shown()),
            "abs_cmd_pos": lambda: self.numbers(self.shown()),
            "rel_act_pos": lambda: self.numbers([p - o for p, o in zip(self.shown(), self.offset)]),  # without the turn
            "user_linear_units": lambda: self.units, "user_angular_units": lambda: "DEG",
            "probe_value": lambda: "1" if self.machine.closed() else "0",
            "feed_override": lambda: "%d" % round(100 * self.machine.share),
            "error": lambda: self.errors.pop(0) if self.errors else "OK",
            "operator_display": lambda: self.display.pop(0) if self.display else "OK",
            "program_status": lambda: "IDLE" if self.status()[1] else "RUNNING"}
        if what not in answers:
            return self.answer(connection, "GET %s NAK" % what.upper())
        self.answer(connection, "%s %s" % (what.upper(), answers[what]()))

    def set(self, connection, what, value):
        said = self.setting(connection, what, value)
        if said == "NAK" or (said == "ACK" and connection in self.verbose):
            self.answer(connection, "SET %s %s" % (what.upper(), said))
        if said == "waits":
            self.number += 1
            self.waiting[connection] = (what, self.number, time.monotonic())

    def setting(self, connection, what, value):
        """@return ACK, NAK, or that the connection waits for the reception."""
        if what == "echo":
            return "ACK"
        if what == "verbose":
            self.verbose.add(connection)
            return "ACK"
        if what == "enable":
            if value != "EMCTOO":
                return "NAK"
            self.enabled = connection
            return "ACK"
        if self.enabled is not connection:
            return "NAK"
        if what == "timeout":
            self.timeout = float(value)
            return "ACK"
        return self.obeyed(what, value)

    def command(self, words):
        """refuse N: the next N aborts and emergency stops are refused, as when another client takes control between.
        late: what the motion says of a trip arrives when the next motion has begun, as on a busy computer.
        freeze S: for S seconds what is shown stays as it is, and the axes go on, as where the task is held up.
        mdi …: another client's. override PERCENT: of the feed, by another client. fault_joint N: its following error.
        units INCH: of the machine. say …: an error of LinuxCNC's. state: what a client cannot see otherwise."""
        if words[0] == "mdi":
            self.mode = "MDI"
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
            self.units = words[1]
            return {"units": self.units}
        if words[0] == "state":
            return {"override": self.machine.share, "on": self.on, "queue": len(self.queue), "job": bool(self.job)}
        if words[0] == "freeze":
            self.frozen = (time.monotonic() + float(words[1]), self.status())
            return {"frozen": float(words[1])}
        if words[0] == "late":
            self.said_late = True
            return {"late": True}
        if words[0] == "refuse":
            self.refusals = int(words[1])
            return {"refusals": self.refusals}
        return {"error": "unknown"}

    def switch_off(self, why):
        """As motion does by itself: the axes rest, and the flags of homing stand."""
        self.on = False
        self.errors.append(why)
        self.halt()
        return {"off": why}

    def obeyed(self, what, value):
        if not self.on and what not in ("estop", "machine"):
            self.told.append(["refused", what])
            return "NAK"  # also an abort, and the override of limits
        if self.refusals > 0 and (what == "abort" or (what == "estop" and value.lower() == "on")):
            self.refusals -= 1
            return "NAK"
        if what == "estop":
            if value.lower() == "on":
                self.told.append(["reset", time.monotonic()])
                self.estop, self.on = True, False
                self.halt()
            else:
                self.estop = False
        elif what == "machine":
            self.on = value.lower() == "on" and not self.estop
        elif what == "mode":
            self.mode = value.upper()
        elif what == "teleop_enable":
            self.teleop = value.lower() == "on"
        elif what == "abort":
            self.told.append(["hold", time.monotonic()])
            self.queue = []
            if self.job:
                self.job["aborted"], self.machine.hold = True, True
        elif what == "feed_override":
            self.machine.share = float(value) / 100.0
            self.told.append(["override", float(value)])
        elif what == "home":
            self.home(int(value))
        elif what == "mdi":
            if self.mode != "MDI" or not self.on:
                return "NAK"
            self.queue.append(value)
        else:
            return "NAK"
        return "waits"

    def home(self, joint):
        if not self.on or self.mode != "MANUAL" or self.teleop:
            self.errors.append("must be in joint mode to home")
            return
        self.homing = (time.monotonic() + HOMING_BEGINS, list(range(self.machine.axes)) if joint < 0 else [joint])

    def begin_homing(self):
        """The flags of joints that were homed before stand until now."""
        (_, joints), self.homing = self.homing, None
        target = list(self.machine.position)
        for j in joints:
            self.homed[j], target[j] = False, 0.0
        self.machine.move(target, TOP)
        self.job = {"kind": "home", "joints": joints, "from": time.monotonic()}

    def halt(self):
        self.machine.halt()
        self.queue, self.job, self.homing = [], None, None

    def tick(self, seconds):
        self.look()
        for joint, switch in enumerate(self.machine.limits):
            if switch and self.on:
                self.switch_off("joint %d on limit switch error" % joint)
        if self.job is None and self.homing and time.monotonic() >= self.homing[0]:
            self.begin_homing()
        if self.job is None and self.queue and self.fault != "stuck":
            self.begin_block(self.queue.pop(0))
        job = self.job
        if job is None:
            return
        was = self.machine.closed()
        how = self.machine.step(seconds)
        if not was and self.machine.closed() and not job.get("tripped"):
            if job["kind"] == "probe":
                job["tripped"] = list(self.machine.position)
            elif not job.get("aborted"):
                (self.unsaid if self.said_late else self.errors).append("Probe tripped during non-probe MDI command.")
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
            self.teleop = True
        if job["kind"] == "probe":
            self.success = 1 if job.get("tripped") else 0
            self.probed = job.get("tripped") or list(self.machine.position)
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
        number = int(number)
        for first, values in ((5061, self.to_work(self.probed)), (5420, self.to_work(self.machine.position))):
            if first <= number < first + 6:
                return values[number - first] if number - first < self.machine.axes else 0.0
        return {5070: float(self.success), 5220: 1.0, 5230: self.turn}.get(number, 0.0)

    def value(self, text):
        """Of a number or an expression: [1+#5420*COS[#<_a>]]."""
        text = re.sub(r"#<(\w+)>", lambda m: "(%r)" % self.named.get(m.group(1).upper(), 0.0), text)
        text = re.sub(r"#(\d+)", lambda m: "(%r)" % self.parameter(m.group(1)), text)
        text = text.replace("#[", "PARAMETER[").replace("[", "(").replace("]", ")")
        names = {"PARAMETER": self.parameter, "COS": lambda a: math.cos(math.radians(a)), "SIN": lambda a: math.sin(math.radians(a))}
        return float(eval(text, {"__builtins__": {}}, names))

    def begin_block(self, text):
        message = re.fullmatch(r"\(DEBUG,(.*)\)", text.strip())
        if message:
            said = re.sub(r"#(?:<\w+>|\d+)", lambda m: "%f" % self.value(m.group(0)), message.group(1))
            return self.display.append(said)
        text = text.upper()
        words = [(w[0], self.value(w[1:])) for w in re.sub(r"#<\w+>=\S+", "", text).split()]
        self.named.update({m.group(1): self.value(m.group(2)) for m in re.finditer(r"#<(\w+)>=(\S+)", text)})
        codes = [v for l, v in words if l == "G"]
        if 10.0 in codes:
            return self.set_work(dict(words))
        probes = any(38.0 < c < 39.0 for c in codes)
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
    LinuxCnc(device_double.arguments(5)).run()
