"""Run by linuxcnc_export_test.sh: prints `ok …` and `not ok …` lines."""
import csv
import io
import json
import math
import os
import random
import shutil
import subprocess
import sys
import tempfile

import linuxcnc_export
from told import THOROUGH, say

ROOT = os.path.abspath(os.path.join(os.path.dirname(__file__), "..", ".."))
MM = os.environ["MM"]
PLAN = os.path.join(ROOT, "config/plans/nine_ball_plate.yaml")
CROSS = (["backlash:x=3um", "positioning_polynomial:y=4um", "squareness:x/y=40arcsec", "straightness:x/z=4um", "thermal_growth:z/frame=2um/K"],
         ["{type: backlash, axis: x}", "{type: squareness, axis: x, of: y}", "{type: thermal_growth, direction: z, sensor: frame}"]
         + ["{type: positioning_polynomial, axis: y, degree: %d}" % d for d in (2, 3, 4, 5)]
         + ["{type: straightness, axis: x, direction: z, degree: %d}" % d for d in (2, 3)])
TABLE = 0.25  # um: 0.05 between entries of the table, and LinuxCNC keeps the correction of the last cycle that had a velocity: up to 0.2
# um: as much, and of the offsets 0.1 between the points of the grid, 0.02 that they may keep at rest, 0.005 of a count.
OFFSETS = 0.3
# In which direction each joint moved last, as its table takes it: the comparator keeps its answer while there is no velocity.
DIRECTIONS = "loadrt comp count=3\n" + "".join(
    "addf comp.%d servo-thread\nnet velocity-%d joint.%d.vel-cmd => comp.%d.in1\n" % (n, n, n, n) for n in range(3))
# Seconds of the servo thread, which stand still where the computer holds it up.
CLOCK = "loadrt integ\naddf integ.0 servo-thread\nsetp integ.0.in 1\n"


def run(*words, accepted=(0,)):
    done = subprocess.run([str(w) for w in words], capture_output=True, text=True)
    if done.returncode not in accepted:
        raise SystemExit("not ok %s: %s" % (" ".join(map(str, words)), done.stderr))
    return done.stdout


def calibration(work, hidden, effects):
    bag, model, made = (os.path.join(work, f) for f in ("s.bag", "m.yaml", "c.yaml"))
    run(MM, "simulate", "--machine", "three_axis", "--plan", PLAN, "--seed", 7, "-o", bag, *[w for h in hidden for w in ("--hide", h)])
    with open(model, "w") as file:
        file.write("machine: three_axis\neffects:\n" + "".join("  - %s\n" % e for e in effects))
    run(MM, "calibrate", bag, "--model", model, "--method", "least_squares", "-o", made, accepted=(0, 1))
    return made


def joint_lines(ini):
    """Of an INI file the lines that compensate, by their section."""
    section, lines = None, {}
    for line in open(ini) if os.path.exists(ini) else []:
        if line.startswith("["):
            section = line.strip()
        elif line.startswith(("COMP_FILE", "BACKLASH")):
            lines.setdefault(section, []).append(line)
    return lines


def with_lines(ini, export):
    """The machine's INI file with the lines of the exported one, those that stay for the other joints, and room for offsets."""
    lines, told = {**joint_lines(os.path.join(export, "kept/machine.ini")), **joint_lines(os.path.join(export, "machine.ini"))}, []
    for line in open(ini):
        told.append(line)
        if line.startswith("DISPLAY"):
            told[-1] = line.rstrip() + " --port %d\n" % linuxcnc_export.PORT
        if line.strip() in lines:
            told += lines[line.strip()]
        if line.strip() in ("[AXIS_X]", "[AXIS_Y]", "[AXIS_Z]"):
            told.append("OFFSET_AV_RATIO = 0.1\n")
        if line.startswith("HALFILE"):
            told.append("HALFILE = directions.hal\n")
        if line.startswith("HALFILE") and os.path.exists(os.path.join(export, "external_offsets.hal")):
            told.append("HALFILE = external_offsets.hal\n")
    return "".join(told)


def machine(work, made):
    """A folder for an ordinary user with what is exported, and what the export says."""
    export = os.path.join(work, "export")
    said = json.loads(run(MM, "export", made, "--to", "linuxcnc", "-o", export, "--json"))
    return machine_with(os.path.join(work, "machine"), export), said


def machine_with(folder, export):
    """A folder for an ordinary user: the machine of the ROS tests with the lines and files of a folder of tables."""
    shutil.copytree(os.path.join(ROOT, "test/ros/linuxcnc"), folder)
    text = with_lines(os.path.join(folder, "machine.ini"), export)
    for name in os.listdir(export):
        if name.endswith(".comp") or name.startswith("external_offsets"):
            shutil.copy(os.path.join(export, name), folder)
    with open(os.path.join(folder, "machine.ini"), "w") as file:
        file.write(text)
    with open(os.path.join(folder, "directions.hal"), "w") as file:
        file.write(DIRECTIONS + CLOCK)
    for name in ("machine.var", "machine.tbl"):
        open(os.path.join(folder, name), "w").close()
    bin_folder = os.path.join(folder, "bin")
    os.mkdir(bin_folder)
    shutil.copy(os.path.join(ROOT, "scripts/linuxcnc_offsets"), bin_folder)
    shutil.copy(os.path.join(ROOT, "test/end_to_end/linuxcnc_export.py"), folder)
    return folder


def driven(folder, steps):
    with open(os.path.join(folder, "steps.json"), "w") as file:
        json.dump(steps, file)
    command = ["/usr/bin/env", "HOME=" + folder, "DISPLAY=", "PATH=" + os.path.join(folder, "bin") + ":/usr/bin:/bin", "/usr/bin/python3",
               os.path.join(folder, "linuxcnc_export.py"), folder, os.path.join(folder, "steps.json")]
    if os.getuid() == 0:  # LinuxCNC refuses to run as root
        subprocess.check_call(["chown", "-R", "nobody", folder])
        command = ["/usr/sbin/runuser", "-u", "nobody", "--"] + command
    done = subprocess.run(command, capture_output=True, text=True, cwd=folder)
    answers = [json.loads(line) for line in done.stdout.splitlines()]
    say(done.returncode == 0 and len(answers) == len(steps), "LinuxCNC starts, goes to %d places and ends" % len(steps),
        done.stderr[-1500:] + open(os.path.join(folder, "log")).read()[-1500:])
    return answers


def corrected(work, made, rows):
    """Where the full model says that the probe is: rows of (motors mm, directions, temperatures)."""
    sensors = sorted(rows[0][2])
    text = "time_s,x_mm,y_mm,z_mm,x_velocity_mm_s,y_velocity_mm_s,z_velocity_mm_s," + ",".join(s + "_degC" for s in sensors) + "\n"
    for n, (motors, directions, degrees) in enumerate(rows):
        # Any speed but standstill tells a direction; no effect of these models asks for more.
        text += ",".join([str(n)] + ["%.9f" % m for m in motors] + ["%g" % (0.5 * d) for d in directions] + ["%g" % degrees[s] for s in sensors]) + "\n"
    states = os.path.join(work, "states.csv")
    with open(states, "w") as file:
        file.write(text)
    answer = run(MM, "apply", states, "--calibration", made, "-o", "-")
    table = list(csv.DictReader(io.StringIO(answer)))
    return [[float(row["corrected_%s_mm" % a]) for a in "xyz"] for row in table]


def from_mean(errors):
    """um: what is the same for all of an axis is taken out."""
    means = [sum(e[axis] for e in errors) / len(errors) for axis in range(3)]
    return [[1e3 * (v - m) for v, m in zip(e, means)] for e in errors]


def largest(errors):
    return max(abs(v) for e in errors for v in e)


def rms(errors):
    return math.sqrt(sum(v * v for e in errors for v in e) / 3 / len(errors))


def judge(work, made, steps, answers, most, what):
    """The full model at where the motors stand against where the axes are commanded, and the same without tables and offsets."""
    places = [a["commanded"] for a in answers]
    say(all(abs(p - q) < 1e-6 for s, place in zip(steps, places) if s["through"] for p, q in zip(s["through"][-1], place)),
        what + ": the axes are where they were sent")

    def errors(rows):
        return from_mean([[p - q for p, q in zip(f, place)] for f, place in zip(corrected(work, made, rows), places)])

    before = errors([(p, s["directions"] or a["directions"], s["degC"]) for p, a, s in zip(places, answers, steps)])
    after = errors([(a["motors"], a["directions"], s["degC"]) for a, s in zip(answers, steps)])
    print("%s, %d places: without tables %.2f um at most, RMS %.3f; with them %.3f um at most, RMS %.4f" % (
        what, len(steps), largest(before), rms(before), largest(after), rms(after)), flush=True)
    for phase in dict.fromkeys(s.get("phase") for s in steps):
        rows = [e for e, s in zip(after, steps) if s.get("phase") == phase]
        if phase is not None:
            say(largest(rows) <= most, "%s: %s, %d places: %.3f um at most" % (what, phase, len(rows), largest(rows)), "more than %g um" % most)
    say(largest(after) <= most and largest(before) > 10 * most and rms(after) <= 0.05 * rms(before), what,
        "more than %g um, or than a twentieth of the RMS" % most)


def both_ways(places=11 if THOROUGH else 5):
    """Each axis alone over its travel, so many places upwards and as many downwards."""
    steps = []
    for axis, (low, high) in enumerate([(-11.0, 11.0), (-6.0, 26.0), (-8.0, 6.0)]):
        for way in (1, -1):
            for n in range(places):
                share = n / (places - 1.0) if way > 0 else 1 - n / (places - 1.0)
                place = [0.3, 5.2, -1.1]
                place[axis] = round(low + share * (high - low), 3)
                begin = [p - 0.4 for p in place]  # the other axes arrive upwards
                begin[axis] = place[axis] - 0.4 * way
                steps.append({"through": ([begin] if n == 0 else []) + [place], "directions": [1 if k != axis else way for k in range(3)]})
    return steps


def at_places(phase, numbers, degrees_of, sensors, **more):
    """Places of a grid of twenty-seven in space, every second one arrived at downwards, at temperatures that change."""
    steps = []
    for n in numbers:
        place = [(-10.0, 1.3, 9.0)[n % 3], (-5.0, 9.7, 25.0)[n // 3 % 3], (-7.0, -1.7, 5.0)[n // 9]]
        way, degrees = 1 - 2 * (n % 2), degrees_of(n)
        steps.append({"phase": phase, "through": [[p - 0.5 * way for p in place], place], "directions": [way] * 3, "degC": degrees,
                      "sets": {"mm-" + s: repr(degrees[s]) for s in sensors}, **more})
    return steps


def through_everything(middle, sensors):
    """Places at changing temperatures; as the machine stands after it was off and on, seen by the component or not, and after it was homed
    anew, and where it goes then; thermometers that fail, while their last good value is the true one."""
    warming = lambda n: dict(middle, frame=20.8 + 0.1 * n)
    steps = at_places("temperatures change", range(0, 27, 1 if THOROUGH else 5), warming, sensors)
    for n, event in enumerate(("unhome and home", "off and on", "off and on unseen", "unhome and home")):
        phase = "after %s%s" % (event, ", again" if n == 3 else "")
        steps.append({"phase": phase, "first": event, "through": [], "directions": None, "degC": steps[-1]["degC"]})
        steps += at_places(phase, (4, 11, 24, 3) if THOROUGH else (4, 11), warming, sensors)
    good = dict(middle, frame=steps[-1]["degC"]["frame"])
    for value in ("nan", "inf", "400", "-80"):
        steps += at_places("a thermometer tells " + value, (8, 18), lambda _: good, [], held=True)
        steps[-2]["sets"] = {"mm-frame": value}
    return steps + at_places("the thermometer is good again", (2, 21), warming, sensors)


def tables_and_offsets(middle):
    with tempfile.TemporaryDirectory() as work:
        os.chmod(work, 0o755)
        made = calibration(work, *CROSS)
        folder, said = machine(work, made)
        sensors = json.load(open(os.path.join(folder, "external_offsets.json")))["sensors"]
        say("frame" in sensors, "the external offsets know the sensor")
        say(said["rms_with_offsets_um"] < 0.1 * said["rms_um"]["exported"], "the report tells what the offsets add")
        steps = through_everything(middle, sensors)
        answers = driven(folder, steps)
        if len(answers) != len(steps):
            return
        turned = sum(a["directions"][k] != s["directions"][k] for a, s in zip(answers, steps) if s["directions"] for k in range(3))
        print("an offset moved %d of %d joints last, against the direction of the move" % (turned, 3 * len(steps)), flush=True)
        judge(work, made, steps, answers, OFFSETS, "COMP_FILE and external offsets")
        say(all(a["held"] == s.get("held", False) for a, s in zip(answers, steps)), "pin held tells that a thermometer has no good value")
        with open(os.path.join(folder, "log")) as file:
            told = [line.strip() for line in file if line.startswith("linuxcnc_offsets:")]
        said_of = lambda *words: len([line for line in told if all(w in line for w in words)])
        say(said_of("frame-degC is nan, not from -50 to 150 degC") == 1 and said_of("frame-degC is good again") == 1,
            "what does not count is said once", str(told))
        say(said_of("given anew") >= 1, "an off and on between two periods is noticed", str(told))  # and a pause of this computer, perhaps


def probe(motors, directions):
    """The machine of the next test, as plain arithmetic: where its probe is, mm. A bent screw and play of x, play of y, a periodic screw
    of 2 mm and play of z."""
    x, y, z = motors
    return [x + 1e-3 * (0.9 * (x / 10) + 1.5 * (x / 10) ** 2) - 0.0025 * directions[0], y - 0.003 * directions[1],
            z + 0.002 * math.sin(math.pi * z) - 0.002 * directions[2]]


def table_active():
    """Tables that a builder made are active while it is measured: they hold two thirds of the screw and of the play of x, all of that of y,
    and nothing of z."""
    with tempfile.TemporaryDirectory() as work:
        os.chmod(work, 0o755)
        active = os.path.join(work, "active")
        os.mkdir(active)
        with open(os.path.join(active, "machine.ini"), "w") as file:
            file.write("[TRAJ]\nCOORDINATES = X Y Z\nLINEAR_UNITS = mm\n[JOINT_0]\nTYPE = LINEAR\nCOMP_FILE = builder.comp\n"
                       "COMP_FILE_TYPE = 1\n[JOINT_1]\nTYPE = LINEAR\nBACKLASH = 0.006\n[JOINT_2]\nTYPE = LINEAR\n")
        with open(os.path.join(active, "builder.comp"), "w") as file:
            for x in range(-14, 15, 2):
                error = 1e-3 * (0.6 * (x / 10) + 1.0 * (x / 10) ** 2)
                file.write("%d %.7f %.7f\n" % (x, 0.0017 - error, -0.0017 - error))
        steps = both_ways()
        measured = driven(machine_with(os.path.join(work, "measured"), active), steps)
        if len(measured) != len(steps):
            return

        def errors(answers, motors="motors"):
            return from_mean([[p - q for p, q in zip(probe(a[motors], a["directions"]), a["commanded"])] for a in answers])

        noise = random.Random(5)
        log, model, bag, made = (os.path.join(work, f) for f in ("log.csv", "m.yaml", "s.bag", "c.yaml"))
        with open(log, "w") as file:
            file.write("time_s,x_mm,y_mm,z_mm,x_velocity_mm_s,y_velocity_mm_s,z_velocity_mm_s,deviation_x_um,deviation_y_um,"
                       "deviation_z_um\n")
            for n, (answer, error) in enumerate(zip(measured, errors(measured))):
                file.write(",".join([str(n)] + ["%.4f" % p for p in answer["commanded"]] + ["%g" % (0.5 * d) for d in answer["directions"]]
                                    + ["%.4f" % (error[k] + noise.gauss(0, 0.03)) for k in range(3)]) + "\n")
        with open(model, "w") as file:
            file.write("machine: three_axis\neffects:\n  - {type: scale, axis: x}\n  - {type: positioning_polynomial, axis: x, degree: 2}\n"
                       "  - {type: backlash, axis: x}\n  - {type: lead_screw_periodic, axis: z, period_mm: 2}\n  - {type: backlash, axis: z}\n")
        run(MM, "import", log, "--machine", "three_axis", "--compensation", active, "-o", bag)
        run(MM, "calibrate", bag, "--model", model, "--method", "least_squares", "-o", made, accepted=(0, 1))
        folder, said = machine(work, made)
        say(said["touched"] == ["x", "z"], "the export is for x and z", str(said["touched"]))
        answers = driven(folder, steps)
        if len(answers) != len(steps):
            return
        say(all(a["directions"] == s["directions"] for a, s in zip(answers, steps)), "without offsets, joints move last as they are sent")
        none, before, after = errors(answers, "commanded"), errors(measured), errors(answers)
        print("COMP_FILE, both directions over the travel of each axis, %d places: without tables %.2f um at most, RMS %.3f; with those that "
              "were active while measuring %.2f um; with the exported ones %.3f um, RMS %.4f" % (
                  len(steps), largest(none), rms(none), largest(before), largest(after), rms(after)), flush=True)
        say(largest(after) <= TABLE and largest(none) > 10 * TABLE and rms(after) <= 0.05 * rms(none), "COMP_FILE corrects each axis both ways",
            "more than %g um, or than a twentieth of the RMS" % TABLE)
        say(largest([e[:1] for e in before]) > 1.0, "the exported table corrects what the machine is, not what was left of it")


def main():
    middle = {"air": 20.5, "bed": 22.0, "frame": 22.0, "motor": 24.0}
    tables_and_offsets(middle)
    table_active()


if __name__ == "__main__":
    main()
    sys.stdout.flush()
