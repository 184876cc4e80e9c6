"""Run by linuxcnc_offsets_test.sh: prints `ok …` and `not ok …` lines."""
import copy
import importlib.machinery
import importlib.util
import json
import math
import os
import random
import subprocess
import sys
import tempfile

from told import say

PROGRAM = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts", "linuxcnc_offsets")
sys.dont_write_bytecode = True
loader = importlib.machinery.SourceFileLoader("linuxcnc_offsets", PROGRAM)
program = importlib.util.module_from_spec(importlib.util.spec_from_loader("linuxcnc_offsets", loader))
loader.exec_module(program)

# Offsets that can be told in the head: x of 0.001 mm times y/10, z of 0.002 mm a kelvin of the frame.
FILE = {
    "format": "measuring_machine external offsets", "version": 1, "axes": ["x", "y", "z"],
    "positions_mm": {"x": [-10.0, 10.0], "y": [-10.0, 0.0, 10.0], "z": [0.0, 5.0]},
    "sensors": ["frame"], "reference_degC": {"frame": 20.0},
    "offset_mm": {"x": [-0.001, -0.001, 0.0, 0.0, 0.001, 0.001] * 2, "y": [0.0] * 12, "z": [0.0] * 12},
    "offset_mm_per_K": {"frame": {"x": [0.0] * 12, "y": [0.0] * 12, "z": [0.002] * 12}}}


def run(*words, optimised=False):
    command = ["/usr/bin/python3"] + (["-O"] if optimised else []) + [PROGRAM] + list(words)
    return subprocess.run(command, capture_output=True, text=True)


def changed(*path, value=None, drop=False):
    data = copy.deepcopy(FILE)
    inner = data
    for key in path[:-1]:
        inner = inner[key]
    if drop:
        del inner[path[-1]]
    else:
        inner[path[-1]] = value
    return data


def refusals(work):
    nan = math.nan
    cases = [
        (changed("offset_mm", "x", 3, value=nan), "offset_mm of x, value 4: NaN is not a number from -1 to 1 mm"),
        (changed("offset_mm", "z", 0, value=math.inf), "offset_mm of z, value 1: Infinity is not a number from -1 to 1 mm"),
        (changed("offset_mm", "y", 11, value=-1.5), "offset_mm of y, value 12: -1.5 is not a number from -1 to 1 mm"),
        (changed("offset_mm", "y", 1, value="0.1"), "offset_mm of y, value 2: \"0.1\" is not a number"),
        (changed("offset_mm", "y", 1, value=True), "offset_mm of y, value 2: true is not a number"),
        (changed("offset_mm", "y", 1, value=None), "offset_mm of y, value 2: null is not a number"),
        (changed("offset_mm", "x", value=[0.0] * 11), "offset_mm of x has 11 values, the grid 12 points"),
        (changed("offset_mm", "x", drop=True), "'x' is missing in offset_mm"),
        (changed("offset_mm", drop=True), "'offset_mm' is missing"),
        (changed("offset_mm_per_K", "frame", "z", 5, value=nan), "offset_mm_per_K, frame, of z, value 6: NaN is not a number from -1 to 1 mm/K"),
        (changed("offset_mm_per_K", "frame", drop=True), "'frame' is missing in offset_mm_per_K"),
        (changed("positions_mm", "y", 1, value=nan), "positions_mm of y, value 2: NaN is not a number from -100000 to 100000 mm"),
        (changed("positions_mm", "y", 1, value=10.0), "positions_mm of y, value 3: 10 is not above the one before, 10"),
        (changed("positions_mm", "z", value=[1.0]), "positions_mm of z has 1 values, 2 are the least"),
        (changed("reference_degC", "frame", value=nan), "reference_degC of frame: NaN is not a number from -50 to 150 degC"),
        (changed("reference_degC", "frame", value=293.15), "reference_degC of frame: 293.15 is not a number from -50 to 150 degC"),
        (changed("reference_degC", value={}), "'frame' is missing in reference_degC"),
        (changed("axes", value=["x", "x", "z"]), "axes, value 2: \"x\" is no name of its own"),
        (changed("axes", value=["x", "yy", "z"]), "axes, value 2: \"yy\" is no name of its own"),
        (changed("axes", value=[]), "'axes' is empty"),
        (changed("version", value=2), "it is of version 2, this program reads 1"),
        (changed("format", value="other"), "it is no file of external offsets"),
        ([1], "it is no file of external offsets"),
        (None, "it is no JSON"),
    ]
    for n, (data, words) in enumerate(cases):
        path = os.path.join(work, "broken%d.json" % n)
        with open(path, "w") as file:
            file.write(json.dumps(FILE)[:-50] if data is None else json.dumps(data))
        for optimised in (False, True) if n < 3 else (False,):
            done = run(path, optimised=optimised)
            lines = done.stderr.splitlines()
            say(done.returncode == 1 and len(lines) == 1 and not done.stdout and lines[0].startswith("linuxcnc_offsets: %s: %s" % (path, words))
                and lines[0].endswith("; export it again"), "refused%s: %s" % (" with -O" if optimised else "", words), done.stderr)
    done = run(os.path.join(work, "nowhere.json"))
    say(done.returncode == 1 and "nowhere.json: No such file" in done.stderr and len(done.stderr.splitlines()) == 1, "refused: no file", done.stderr)


def answers(path):
    done = run(path, "--at", "x=0,y=5,z=1,frame=21.5")
    found = json.loads(done.stdout)
    say(abs(found["x"] - 0.0005) < 1e-12 and found["y"] == 0.0 and abs(found["z"] - 0.003) < 1e-12, "--at answers", done.stdout)
    for at, words in (("x=0,y=5", "z is missing"),
                      ("x=0,y=nan,z=1", "y: NaN is not a number from -100000 to 100000 mm"),
                      ("x=0,y=5,z=k", "z: 'k' is no number"),
                      ("x=0,y=5,z=1,bed=20", "'bed' is none of x, y, z, frame"),
                      ("x=0,y=5,z=1,frame=293", "frame: 293.0 is not a number from -50 to 150 degC")):
        done = run(path, "--at", at)
        say(done.returncode == 1 and words in done.stderr and len(done.stderr.splitlines()) == 1, "--at refuses: " + words, done.stderr)


class Motion:
    """What LinuxCNC 2.9 makes of counts (External Axis Offsets): seen in a headless one by linuxcnc_export_test.sh. The pins of both."""

    def __init__(self, ratio=0.1):
        self.ratio, self.old, self.was_on = ratio, dict.fromkeys("xyz", 0), False
        self.pins = {"motion-enabled": False, "all-homed": False, "frame-degC": 20.0}
        for a in "xyz":
            self.pins.update({a + "-position": 0.0, a + "-request": 0.0, a + "-offset": 0.0, a + "-counts": 0, a + "-scale": 0.0,
                              a + "-enable": False, a + "-clear": False})

    def cycle(self):
        pins, on = self.pins, self.pins["motion-enabled"]
        for a in "xyz":
            if on and not self.was_on:  # the sum begins at zero where the axis stands
                pins[a + "-position"] += pins[a + "-offset"]
                pins[a + "-request"] = pins[a + "-offset"] = 0.0
            change, self.old[a] = pins[a + "-counts"] - self.old[a], pins[a + "-counts"]
            if not pins[a + "-enable"]:
                pins[a + "-request"] = pins[a + "-offset"]  # held
            elif pins[a + "-clear"]:
                pins[a + "-request"] = 0.0
            elif on and pins["all-homed"]:
                pins[a + "-request"] += change * pins[a + "-scale"]
            if on and pins["all-homed"] and self.ratio > 0.0:
                step = pins[a + "-request"] - pins[a + "-offset"]
                pins[a + "-offset"] += max(-0.0005, min(0.0005, step))
        self.was_on = on


class Rig:
    def __init__(self, ratio=0.1):
        self.said = []
        self.motion = Motion(ratio)
        self.pins = self.motion.pins
        self.component = program.Component(program.Offsets(FILE), self.said.append)

    def periods(self, count, cycles=20):
        for _ in range(count):
            self.component.tick(self.pins)
            for _ in range(cycles):
                self.motion.cycle()

    def begin(self):
        self.pins.update({"motion-enabled": True, "all-homed": True})
        self.periods(4)
        return self

    def go(self, x, y, z):
        self.pins.update({"x-position": x, "y-position": y, "z-position": z})
        self.periods(4)

    def wanted(self):
        return {"x": 1e-4 * max(-10.0, min(10.0, self.pins["y-position"])), "y": 0.0, "z": 0.002 * (self.pins["frame-degC"] - 20.0)}

    def error(self):
        return max(abs(self.pins[a + "-offset"] - w) for a, w in self.wanted().items())


def follows():
    rig = Rig().begin()
    rig.go(0.0, 7.0, 1.0)
    rig.pins["frame-degC"] = 22.0
    rig.periods(6)
    say(rig.error() < 0.6e-5 and rig.pins["arrived"] and not rig.said, "offsets follow position and temperature", rig.pins)
    for event in ("off and on", "unhome and home", "off and on unseen"):
        names = {"off and on": "motion-enabled", "unhome and home": "all-homed", "off and on unseen": "motion-enabled"}
        rig.pins[names[event]] = False
        if event.endswith("unseen"):
            rig.motion.cycle()
        else:
            rig.periods(3)
            say(all(rig.pins[a + "-counts"] == 0 and rig.pins[a + "-clear"] and rig.pins[a + "-enable"] for a in "xyz") and not rig.pins["arrived"],
                event + ": counts are 0 meanwhile, and cleared", rig.pins)
        rig.pins[names[event]] = True
        rig.motion.cycle()
        rig.periods(program.PATIENCE + 10)
        say(rig.error() < 0.6e-5 and rig.pins["arrived"], "after %s the offsets are whole, once" % event, rig.pins)
    say(len(rig.said) == 1 and "given anew" in rig.said[0], "what LinuxCNC took otherwise is said", rig.said)


def flickers():
    rig = Rig().begin()
    rig.go(0.0, 5.0, 1.0)
    counts = set()
    for n in range(50):
        rig.pins["frame-degC"] = 20.0 + (0.008 if n % 2 else -0.008)  # 0.016 um
        rig.periods(1)
        counts.add(rig.pins["z-counts"])
    say(counts == {0}, "a flicker of a thermometer below 0.02 um moves nothing", counts)
    rig.go(0.0, 5.1, 1.0)
    say(rig.pins["z-counts"] == 2, "where an axis moves, the offset is exact", rig.pins["z-counts"])
    rig.pins["frame-degC"] += 0.012
    rig.periods(2)
    say(rig.pins["z-counts"] == 4, "more than 0.02 um is given at rest", rig.pins["z-counts"])


def holds():
    rig = Rig().begin()
    rig.pins["frame-degC"] = 23.0
    rig.go(0.0, 5.0, 1.0)
    for value in (math.nan, math.inf, -math.inf, 200.0, -273.15):
        rig.pins["frame-degC"] = value
        rig.go(0.0, rig.pins["y-position"] + 0.5, 1.0)
        say(rig.pins["z-counts"] == 600 and rig.pins["held"] and abs(rig.pins["x-counts"] - 10 * rig.pins["y-position"]) <= 1,
            "at %g degC the last good value counts" % value, rig.pins)
    say(rig.said == ["frame-degC is nan, not from -50 to 150 degC; 23 stays"], "it is said once", rig.said)
    rig.pins["frame-degC"] = 24.0
    rig.periods(4)
    say(rig.pins["z-counts"] == 800 and not rig.pins["held"] and rig.said[1:] == ["frame-degC is good again"], "and when it is good again",
        rig.said)
    before = {a: rig.pins[a + "-counts"] for a in "xyz"}
    rig.pins["y-position"] = math.nan
    rig.periods(2)
    say({a: rig.pins[a + "-counts"] for a in "xyz"} == before and rig.pins["held"] and rig.said[2].startswith("y-position is nan"),
        "without a position the last offsets stay", rig.said)
    rig = Rig()
    rig.component.file.per_kelvin["frame"]["z"] = [0.5] * 12
    rig.begin()
    rig.pins["frame-degC"] = 22.5
    rig.periods(3)
    say(rig.pins["z-counts"] == 0 and rig.said == ["z-offset would be 1.25, more than 1 mm; the last stays"],
        "more than a millimetre is not given", rig.said)
    rig = Rig()
    rig.pins.update({"frame-degC": math.nan, "z-position": math.nan})
    rig.begin()
    say(rig.component.feed.stage == "clear" and rig.pins["held"], "nothing is given before there was a position", rig.pins)


def stands_still():
    rig = Rig(ratio=0.0).begin()
    rig.go(0.0, 5.0, 1.0)
    rig.periods(300, cycles=2)
    rig.go(0.0, 0.0, 1.0)
    rig.go(0.0, -5.0, 1.0)
    rig.pins["motion-enabled"] = False
    rig.periods(3)
    words = "eoffset of x stays at 0.00000 mm where 0.00050 is asked for: OFFSET_AV_RATIO in [AXIS_X]"
    say(len(rig.said) == 1 and rig.said[0].startswith(words) and not rig.pins["arrived"],
        "an offset that does not move is said, once", rig.said)
    rig.pins["motion-enabled"], rig.motion.ratio = True, 0.1
    rig.periods(20)
    say(rig.said[1:] == ["eoffset of x is good again"], "and when it moves", rig.said)


def anything_happens():
    """Switching, homing, restarts of the component and pauses of either at random: the sum is never more than is wanted, and whole in the end."""
    worst_error, worst_sum, seed = 0.0, 0.0, 0
    for seed in range(60):
        chance = random.Random(seed)
        rig = Rig().begin()
        for _ in range(60):
            deed = chance.randrange(7)
            if deed == 0:
                rig.pins["motion-enabled"] = not rig.pins["motion-enabled"]
            elif deed == 1:
                rig.pins["all-homed"] = not rig.pins["all-homed"]
            elif deed == 2:
                rig.pins["y-position"] = chance.uniform(-10, 10)
            elif deed == 3:
                rig.pins["frame-degC"] = 20.0 + chance.uniform(-2, 2)
            elif deed == 4:
                rig.component = program.Component(program.Offsets(FILE), rig.said.append)
            for _ in range(chance.randrange(4)):
                rig.motion.cycle()
            rig.periods(chance.randrange(3), cycles=chance.choice((0, 1, 20)))
            worst_sum = max([worst_sum] + [abs(rig.pins[a + "-request"]) - most for a, most in (("x", 0.001), ("z", 0.004))])
        rig.pins.update({"motion-enabled": True, "all-homed": True})
        rig.periods(program.PATIENCE + 30)
        worst_error = max(worst_error, rig.error())
    say(worst_error <= 2.6e-5, "after anything the offsets are whole (%.4f um at most, %d runs)" % (1e3 * worst_error, seed + 1))
    say(worst_sum <= 1e-5, "and never more than the most that is wanted (by %.4f um at most)" % (1e3 * worst_sum))


def main():
    with tempfile.TemporaryDirectory() as work:
        refusals(work)
        path = os.path.join(work, "offsets.json")
        with open(path, "w") as file:
            json.dump(FILE, file)
        answers(path)
    follows()
    flickers()
    holds()
    stands_still()
    anything_happens()


main()
