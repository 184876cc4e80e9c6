"""Run by linuxcnc_export_test.sh: prints `ok …` and `not ok …` lines."""
import csv
import io
import json
import math
import os
import shutil
import subprocess
import sys
import tempfile

ROOT = os.path.abspath(os.path.join(os.path.dirname(__file__), "..", ".."))
MM = os.environ["MM"]
PLAN = os.path.join(ROOT, "config/plans/nine_ball_plate.yaml")
OWN = (["positioning_polynomial:x=4um", "lead_screw_periodic:y=2um,period=2mm", "backlash:x=3um", "backlash:y=2um", "backlash:z=4um"],
       ["{type: positioning_polynomial, axis: x, degree: %d}" % d for d in (2, 3, 4, 5)]
       + ["{type: lead_screw_periodic, axis: y, period_mm: 2}"] + ["{type: backlash, axis: %s}" % a for a in "xyz"])
CROSS = (["backlash:x=3um", "squareness:x/y=40arcsec", "straightness:x/z=4um", "thermal_growth:z/frame=2um/K"],
         ["{type: backlash, axis: x}", "{type: squareness, axis: x, of: y}", "{type: thermal_growth, direction: z, sensor: frame}"]
         + ["{type: straightness, axis: x, direction: z, degree: %d}" % d for d in (2, 3)])
# um: half of the 0.02 um that a table may leave between two points at worst, 0.1 nm written, and the motors as HAL prints them.
TABLE = 0.25  # um: 0.05 between entries of the table, and LinuxCNC keeps the correction of the last cycle that had a velocity: up to 0.2


def say(good, what, why=""):
    print(("ok " if good else "not ok ") + what + ("" if good or not why else ": " + why), flush=True)
    return good


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


def with_lines(ini, export):
    """The machine's INI file with the lines of the exported one, and room for offsets."""
    section, lines, told = None, {}, []
    for line in open(os.path.join(export, "machine.ini")):
        if line.startswith("["):
            section = line.strip()
        elif line.startswith("COMP_FILE"):
            lines.setdefault(section, []).append(line)
    for line in open(ini):
        told.append(line)
        if line.strip() in lines:
            told += lines[line.strip()]
        if line.strip() in ("[AXIS_X]", "[AXIS_Y]", "[AXIS_Z]"):
            told.append("OFFSET_AV_RATIO = 0.1\n")
        if line.startswith("HALFILE") and os.path.exists(os.path.join(export, "external_offsets.hal")):
            told.append("HALFILE = external_offsets.hal\n")
    return "".join(told)


def machine(work, made):
    """A folder for an ordinary user: the machine of the ROS tests with the export's lines and files."""
    folder, export = os.path.join(work, "machine"), os.path.join(work, "export")
    said = json.loads(run(MM, "export", made, "--to", "linuxcnc", "-o", export, "--json"))
    shutil.copytree(os.path.join(ROOT, "test/ros/linuxcnc"), folder)
    text = with_lines(os.path.join(folder, "machine.ini"), export)
    for name in os.listdir(export):
        if name.endswith(".comp") or name.startswith("external_offsets"):
            shutil.copy(os.path.join(export, name), folder)
    with open(os.path.join(folder, "machine.ini"), "w") as file:
        file.write(text)
    for name in ("machine.var", "machine.tbl"):
        open(os.path.join(folder, name), "w").close()
    bin_folder = os.path.join(folder, "bin")
    os.mkdir(bin_folder)
    shutil.copy(os.path.join(ROOT, "scripts/linuxcnc_offsets"), bin_folder)
    shutil.copy(os.path.join(ROOT, "test/end_to_end/linuxcnc_export.py"), folder)
    return folder, said


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


def spread(errors):
    """um: largest distance of any error from the mean of its axis."""
    worst, total = 0.0, 0.0
    for axis in range(3):
        values = [e[axis] for e in errors]
        mean = sum(values) / len(values)
        worst = max([worst] + [abs(v - mean) for v in values])
        total += sum((v - mean) ** 2 for v in values)
    return 1e3 * worst, 1e3 * math.sqrt(total / 3 / len(errors))


def compare(work, made, steps, answers, what):
    """Prints the figure, um. @return largest and RMS without and with the tables."""
    rows = [(a["motors"], s["directions"], s["degC"]) for a, s in zip(answers, steps)]
    uncorrected = [(a["target"], s["directions"], s["degC"]) for a, s in zip(answers, steps)]
    places = [a["target"] for a in answers]
    less = lambda found: [[p - q for p, q in zip(f, place)] for f, place in zip(found, places)]
    before = spread(less(corrected(work, made, uncorrected)))
    after = spread(less(corrected(work, made, rows)))
    print("%s: without tables %.2f um at most, RMS %.3f; with them %.3f um at most, RMS %.4f" % ((what,) + before + after), flush=True)
    return before, after


def judge(work, made, steps, answers, most, what):
    before, after = compare(work, made, steps, answers, what)
    say(after[0] <= most and before[0] > 10 * most and after[1] <= 0.05 * before[1], what, "more than %g um, or than a twentieth of the RMS" % most)


def both_ways(degrees):
    """Each axis alone over its travel, eleven places upwards and eleven downwards."""
    steps = []
    travel = [(-11.0, 11.0), (-6.0, 26.0), (-8.0, 6.0)]
    for axis, (low, high) in enumerate(travel):
        for way in (1, -1):
            for n in range(11):
                share = n / 10.0 if way > 0 else 1 - n / 10.0
                place = [0.3, 5.2, -1.1]
                place[axis] = round(low + share * (high - low), 3)
                begin = [p - 0.4 for p in place]  # the other axes arrive upwards
                begin[axis] = place[axis] - 0.4 * way
                steps.append({"through": ([begin] if n == 0 else []) + [place], "directions": [1 if k != axis else way for k in range(3)], "degC": degrees})
    return steps


def places_in_space(degrees_of, sensors):
    """Twenty-seven places, each arrived at upwards, at temperatures that change."""
    steps = []
    for n in range(27):
        place = [(-10.0, 1.3, 9.0)[n % 3], (-5.0, 9.7, 25.0)[n // 3 % 3], (-7.0, -1.7, 5.0)[n // 9]]
        steps.append({"through": [[p - 0.5 for p in place], place], "directions": [1, 1, 1], "degC": degrees_of(n), "sensors": sensors})
    return steps


def main():
    middle = {"air": 20.5, "bed": 22.0, "frame": 22.0, "motor": 24.0}
    with tempfile.TemporaryDirectory() as work:
        os.chmod(work, 0o755)
        made = calibration(work, *OWN)
        folder, _ = machine(work, made)
        steps = both_ways(middle)
        answers = driven(folder, steps)
        if len(answers) == len(steps):
            judge(work, made, steps, answers, TABLE, "COMP_FILE, both directions over the travel of each axis")
    with tempfile.TemporaryDirectory() as work:
        os.chmod(work, 0o755)
        made = calibration(work, *CROSS)
        folder, said = machine(work, made)
        sensors = json.load(open(os.path.join(folder, "external_offsets.json")))["sensors"]
        say("frame" in sensors, "the external offsets know the sensor")
        say(said["rms_with_offsets_um"] < 0.1 * said["rms_um"]["exported"], "the report tells what the offsets add")
        steps = places_in_space(lambda n: dict(middle, frame=20.8 + 0.1 * n), sensors)
        answers = driven(folder, steps)
        if len(answers) == len(steps):
            compare(work, made, steps, answers, "external offsets, temperatures changing")
        broken = os.path.join(work, "broken.json")
        with open(os.path.join(folder, "external_offsets.json")) as file, open(broken, "w") as out:
            out.write(file.read()[:-200])
        done = subprocess.run([os.path.join(ROOT, "scripts/linuxcnc_offsets"), broken], capture_output=True, text=True)
        say(done.returncode != 0 and broken in done.stderr, "a damaged file of offsets is refused by name", done.stderr)


if __name__ == "__main__":
    main()
    sys.stdout.flush()
