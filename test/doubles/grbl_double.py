#!/usr/bin/env python3
"""A machine that speaks the documented language of grbl 1.1 and grblHAL: real-time bytes, status reports, settings, homing,
jogging, G0 and G1, G4, G38.2 to G38.5 with [PRB:], soft and hard limits, alarms, a receive buffer of 128 characters."""
import re
import time

import device_double

LETTERS = "XYZABC"
BUFFER = 128
TRAVEL = 400.0  # mm or deg: machine coordinates go from -TRAVEL to 0, the reference switches are at the upper end
PULL_OFF = 1.0
INCH = 25.4
SINGLE_AXES, HOMING_REQUIRED = 2, 4  # bits of $22 in grblHAL


class Grbl(device_double.Double):
    def __init__(self, a):
        self.hal, self.homing = not a.no_hal, a.homing
        self.machine = device_double.Machine(a.axes, a.ball, a.tip, a.scale, a.acceleration)
        self.offset = [1.5, -2.25, 3.0, 0.0, 0.0, 0.0][:a.axes]  # G54: work coordinates are not machine coordinates
        self.deepest = -1e9
        self.settings = {1: 255, 10: 1, 13: 0, 20: 1, 21: 1, 22: 3 if self.hal else 1}
        self.door, self.refuses_x, self.homing_fails = None, False, False
        self.fresh(position_lost=True)
        super().__init__(a)

    def fresh(self, position_lost):
        """After power-on or a soft reset."""
        self.state, self.alarm, self.critical = "Idle", 0, False
        self.buffer, self.line, self.lines = 0, b"", []
        self.job = None        # what keeps the interpreter busy: kind and its data
        self.absolute, self.feed, self.reports = True, 0.0, 0
        self.held = False
        self.machine.halt()
        self.machine.share = 1.0
        if position_lost:
            self.machine.position = [-3.0, -2.0, -4.0, -2.0, -2.0, -2.0][:self.machine.axes]
            self.homed, self.homed_axes = False, set()

    def power(self, on):
        self.fresh(position_lost=on)
        if on:
            self.welcome()

    def welcome(self):
        self.buffer = 0
        for connection in self.connections:
            self.say(connection, "\r\n%s ['$' for help]\r\n" % ("GrblHAL 1.1f" if self.hal else "Grbl 1.1h"))

    def out(self, text):
        for connection in self.connections:
            self.say(connection, text + "\r\n")

    # -- real-time bytes, taken out of the stream as they come
    def received(self, connection, data):
        for byte in data:
            if byte == 0x18:
                self.told.append(["reset", time.monotonic()])
                self.soft_reset()
            elif byte == ord("?"):
                self.report()
            elif byte == ord("!"):
                self.told.append(["hold", time.monotonic()])
                if self.state.startswith("Door"):
                    continue
                if self.state in ("Run", "Jog") or (self.state == "Idle"):
                    self.held, self.machine.hold = True, True
                    if self.state == "Idle":
                        self.state = "Hold:0"
                    elif self.state == "Run":
                        self.state = "Hold:1"
            elif byte == ord("~"):
                if self.state.startswith("Hold") or self.state == "Door:0":
                    self.held, self.machine.hold = False, False
                    self.state = "Run" if self.job else "Idle"
            elif byte == 0x85:
                if self.state == "Jog":
                    self.held, self.machine.hold = True, True
            elif 0x90 <= byte <= 0x94:
                share = self.machine.share
                self.machine.share = {0x90: 1.0, 0x91: share + 0.1, 0x92: share - 0.1, 0x93: share + 0.01,
                                      0x94: share - 0.01}[byte]
                self.machine.share = min(2.0, max(0.1, self.machine.share))
            elif byte >= 0x80:
                pass
            else:
                self.buffer += 1
                if self.buffer > BUFFER:
                    self.told.append(["overflow", time.monotonic()])
                    continue
                if byte in b"\r\n":
                    self.lines.append((self.line.decode("latin-1"), len(self.line) + 1))
                    self.line = b""
                else:
                    self.line += bytes([byte])

    def soft_reset(self):
        moving = self.state in ("Run", "Jog", "Hold:1", "Door:2") and self.machine.moving()
        homing = self.state == "Home"
        kept = self.alarm if self.hal and self.state == "Alarm" else 0  # grblHAL stays locked over a reset
        self.fresh(position_lost=False)
        if kept:
            self.state, self.alarm = "Alarm", kept
        if moving or homing:
            self.homed = False
        if homing:
            self.raise_alarm(6)
        elif moving:
            self.raise_alarm(3)
        self.welcome()
        if self.door:
            self.open_door()

    def open_door(self):
        """It comes to rest, and stays there until the door is closed and it is told to go on."""
        self.door = True
        if self.state != "Alarm":
            self.state = "Door:2" if self.job and self.machine.moving() else "Door:1"
            self.held = self.machine.hold = True

    def raise_alarm(self, code):
        self.machine.halt()
        self.job, self.held = None, False
        self.state, self.alarm, self.critical = "Alarm", code, code in (1, 2)
        self.out("ALARM:%d" % code)
        if self.critical:
            self.out("[MSG:Reset to continue]")

    def shown(self):
        position = list(self.machine.position)
        if self.fault == "wrong":
            position[0] += device_double.WRONG
        return self.places(position)

    def places(self, values):
        return ",".join("%.4f" % (v / INCH) for v in values) if self.settings[13] else ",".join("%.3f" % v for v in values)

    def report(self):
        if not self.hal and (self.state == "Home" or self.critical):
            return  # grbl 1.1 does not report while it homes, nor after a limit until it is reset; grblHAL does
        state = "Alarm:%d" % self.alarm if self.state == "Alarm" and self.hal and self.alarm else self.state
        pins = "".join(LETTERS[i] for i in range(self.machine.axes) if self.machine.limits[i])
        if self.machine.closed():
            pins += "P"
        text = "<%s|MPos:%s|FS:%d,0" % (state, self.shown(), round(60 * self.machine.now))
        if pins:
            text += "|Pn:" + pins
        if self.reports % 10 == 0:
            text += "|WCO:" + self.places(self.offset)
        elif self.reports % 10 == 1 or self.share_told != self.machine.share:
            self.share_told = self.machine.share
            text += "|Ov:%d,100,100" % round(100 * self.machine.share)
        self.reports += 1
        self.out(text + ">")

    # -- lines
    def tick(self, seconds):
        if self.fault == "stuck" and not self.job:
            return
        self.advance(seconds)
        while self.lines and not self.blocking() and (self.hal or not self.critical):
            line, length = self.lines.pop(0)
            self.buffer -= length
            self.interpret(line.strip().upper())

    share_told = 1.0

    def blocking(self):
        return self.job is not None and self.job["kind"] in ("probe", "home", "wait")

    def advance(self, seconds):
        for i, switch in enumerate(self.machine.limits):
            if switch and self.machine.moving() and self.machine.target[i] != self.machine.position[i]:
                if (self.machine.target[i] > self.machine.position[i]) == (switch > 0):
                    self.homed = False
                    return self.raise_alarm(1)
        if self.state in ("Door:0", "Door:1"):
            return
        job = self.job
        if job is None:
            return
        if job["kind"] == "wait" and not job.get("motion"):
            self.job = None
            return self.out("ok")
        if job["kind"] == "home" and self.homing_fails:
            self.raise_alarm(9)  # and begins anew, of its own accord
            self.fresh(position_lost=True)
            self.state, self.alarm = "Alarm", 9
            return self.welcome()
        was = self.machine.closed() if job["kind"] == "probe" else False
        how = self.machine.step(seconds)
        if job["kind"] == "probe" and not was and not job.get("tripped") and self.machine.closed():
            job["tripped"] = list(self.machine.position)
            self.machine.hold = True
        if how == "held":
            if job.get("tripped"):
                self.machine.halt()
                return self.probed(job)
            if self.state == "Jog":
                self.machine.halt()
                self.job, self.state, self.held = None, "Idle", False
                return
            self.state = "Door:1" if self.state.startswith("Door") else "Hold:0"
            return
        if how == "arrived":
            if job["kind"] == "probe":
                return self.probed(job)
            self.job = None
            self.state = "Idle"
            if job["kind"] == "home":
                self.homed_axes |= set(job["axes"])
                self.homed = len(self.homed_axes) == self.machine.axes
                if self.hal and self.settings[22] & HOMING_REQUIRED and not self.homed:
                    self.state, self.alarm = "Alarm", 11
                self.out("ok")
            if job["kind"] == "wait":
                self.out("ok")

    def probed(self, job):
        self.job, self.state = None, "Idle"
        at = job.get("tripped") or self.machine.position
        self.out("[PRB:%s:%d]" % (",".join("%.3f" % p for p in at), 1 if job.get("tripped") else 0))
        if not job.get("tripped") and job["strict"]:
            return self.raise_alarm(5)
        self.out("ok")

    def interpret(self, line):
        if self.state == "Home":
            return
        if not line:
            return self.out("ok")
        if self.critical:
            return self.out("error:79")  # of grblHAL; grbl 1.1 does not even answer
        if line[0] == "$":
            return self.system(line)
        if self.state == "Alarm":
            return self.out("error:9")
        self.block(line)

    def system(self, line):
        if line == "$$":
            values = dict(self.settings)
            for i in range(self.machine.axes):
                values.update({100 + i: 1000.0, 110 + i: 3000.0, 120 + i: self.machine.acceleration, 130 + i: TRAVEL})
            for key in sorted(values):
                self.out("$%d=%.3f" % (key, values[key]))
            return self.out("ok")
        if line == "$I":
            self.out("[VER:1.1f.20230101:]")
            self.out("[OPT:VNMSL,35,%d]" % BUFFER)
            if self.hal:
                self.out("[FIRMWARE:grblHAL]")
            return self.out("ok")
        if line == "$X":
            if self.refuses_x:
                return self.out("error:45")
            if self.hal and self.settings[22] & HOMING_REQUIRED and not self.homed:
                return self.out("error:46")
            if self.state == "Alarm":
                self.state, self.alarm = "Idle", 0
                self.out("[MSG:Caution: Unlocked]")
            return self.out("ok")
        if line == "$H" or re.fullmatch(r"\$H[XYZABC]", line):
            if len(line) == 3 and not self.hal:
                return self.out("error:3")
            if len(line) == 3 and not self.settings[22] & SINGLE_AXES:
                return self.out("error:5")
            if self.state not in ("Idle", "Alarm"):
                return self.out("error:8")
            axes = range(self.machine.axes) if len(line) == 2 else [LETTERS.index(line[2])]
            target = list(self.machine.position)
            for i in axes:
                target[i] = -PULL_OFF
            self.state, self.alarm = "Home", 0
            self.machine.move(target, self.homing)
            self.job = {"kind": "home", "axes": list(axes)}
            return None
        if line.startswith("$J="):
            if self.state not in ("Idle", "Jog"):
                return self.out("error:9" if self.state == "Alarm" else "error:8")
            return self.motion(line[3:], jog=True)
        return self.out("error:3")

    def words(self, line):
        return re.findall(r"([A-Z])\s*(-?\d*\.?\d+)", line)

    def block(self, line):
        words = self.words(line)
        codes = [value for letter, value in words if letter == "G"]
        if "4" in codes:
            if self.job and self.job["kind"] == "move":
                self.job["kind"], self.job["motion"] = "wait", True
            else:
                self.job = {"kind": "wait", "motion": False}
            return None
        if any(code.startswith("38.") for code in codes):
            return self.motion(line, probe=next(code for code in codes if code.startswith("38.")))
        return self.motion(line)

    def motion(self, line, jog=False, probe=None):
        if self.job is not None:
            return self.out("error:8")
        absolute, machine_coordinates = True, False
        target = list(self.machine.position)
        feed = self.feed
        words = self.words(line)
        for letter, value in words:
            if letter == "G":
                absolute = {"90": True, "91": False}.get(value, absolute)
                machine_coordinates = machine_coordinates or value == "53"
            if letter == "F":
                feed = float(value) / 60.0
        moves = False
        for letter, value in words:
            if letter not in LETTERS[:self.machine.axes]:
                continue
            i = LETTERS.index(letter)
            moves = True
            if not absolute:
                target[i] += float(value)
            else:
                target[i] = float(value) + (0.0 if machine_coordinates else self.offset[i])
        if feed <= 0.0:
            return self.out("error:22")
        if not jog:
            self.feed = feed
        if not moves:
            return self.out("ok")
        if any(not -TRAVEL <= t <= 0.0 for t in target):
            if jog:
                return self.out("error:15")
            return self.raise_alarm(2)
        if probe:
            if self.machine.closed():
                return self.raise_alarm(4)
            self.job = {"kind": "probe", "strict": probe == "38.2"}
        else:
            self.job = {"kind": "move"}
            self.out("ok")
        if not self.held:  # in feed hold it is planned, and waits for ~
            self.state = "Jog" if jog else "Run"
        self.machine.hold = self.held
        self.machine.move(target, min(feed, 50.0))
        return None

    def obey(self, line):
        before = list(self.machine.limits)
        answer = super().obey(line)
        if self.machine.limits != before and not self.hal and self.state not in ("Alarm", "Home") and self.settings[21]:
            self.homed = False
            self.raise_alarm(1)  # grbl 1.1: any change of the pin, also a switch that opens
        return answer

    def command(self, words):
        if words[0] == "alarm":
            self.raise_alarm(int(words[1]))
            return {"alarm": int(words[1])}
        if words[0] == "set":
            self.settings[int(words[1])] = int(words[2])
            return {"set": self.settings}
        if words[0] == "door":
            if words[1] == "open":
                self.open_door()
            else:
                self.door = False
                if self.state == "Door:1":
                    self.state = "Door:0"
            return {"state": self.state}
        if words[0] == "refuse_x":
            self.refuses_x = words[1] == "on"
            return {"refuse_x": self.refuses_x}
        if words[0] == "homing_fails":
            self.homing_fails = words[1] == "on"
            return {"homing_fails": self.homing_fails}
        if words[0] == "share":
            return {"share": self.machine.share}
        if words[0] == "override":  # at its panel
            self.machine.share = float(words[1])
            return {"override": self.machine.share}
        if words[0] == "jog":  # of another sender
            self.motion("G91 G21 X%s F600" % words[1], jog=True)
            return {"state": self.state}
        if words[0] == "hold":  # at its panel
            self.received(None, b"!")
            return {"state": self.state}
        return {"error": "unknown"}


if __name__ == "__main__":
    Grbl(device_double.arguments(6)).run()
