#!/usr/bin/env python3
"""LASER's Table 3 on the simulated five-axis machine: the radius of a ball measured five times, and length
errors by ISO 10360 style runs, before and after the probe's mount is calibrated on one ball of unknown centre.

    run.py [--mm PATH] [--folder FOLDER]
"""
import argparse
import itertools
import json
import math
import os
import re
import subprocess
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
CALIBRATION_PLAN = os.path.join(HERE, "..", "..", "config", "plans", "five_axis_ball.yaml")
# What the mechanics did to the probe: deviations of the chain's axes, known to nobody but the simulation.
HIDDEN = ["rotary_axis_offset:b/x=170um", "rotary_axis_offset:b/y=-130um", "rotary_axis_offset:a/y=-240um",
          "rotary_axis_offset:a/z=190um", "rotary_zero:b=-240arcsec", "rotary_zero:a=290arcsec"]
K = 1000.0  # mm/um: slope of LASER's accuracy, (A + L / 1000) um


def mm(program, *arguments, status=(0,)):
    done = subprocess.run([program, *arguments], capture_output=True, text=True, check=False)
    if done.returncode not in status:
        raise SystemExit("mm " + " ".join(arguments) + "\n" + done.stderr)
    return done.stdout


def balls(text):
    return {b["name"]: b for b in json.loads(text)["artifact"]["balls"]}


def true_centres(plan):
    with open(plan, encoding="utf-8") as file:
        return {m[0]: [float(v) for v in m[1].split(",")]
                for m in re.findall(r"name: (\w+), .*?centre_mm: \[([^\]]*)\]", file.read())}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--mm", default="mm")
    parser.add_argument("--folder", default=None, help="where the sessions go; a temporary one if left out")
    options = parser.parse_args()
    folder = options.folder or tempfile.mkdtemp(prefix="laser_probe_")
    os.makedirs(folder, exist_ok=True)
    model, nothing = os.path.join(HERE, "model.yaml"), os.path.join(HERE, "nothing.yaml")
    mount = os.path.join(folder, "mount.yaml")

    def simulate(plan, seed):
        bag = os.path.join(folder, "%s_%d.bag" % (os.path.splitext(os.path.basename(plan))[0], seed))
        mm(options.mm, "simulate", "--machine", "five_axis", "--plan", plan, "--seed", str(seed), "-o", bag,
           *itertools.chain.from_iterable(("--hide", h) for h in HIDDEN))
        return bag

    def before(bag):
        return balls(mm(options.mm, "calibrate", bag, "--model", nothing, "--method", "least_squares", "--json",
                        "--keep-outliers"))

    def after(bag):
        return balls(mm(options.mm, "compare", bag, "--calibration", mount, "--json", "--keep-outliers"))

    mm(options.mm, "calibrate", simulate(CALIBRATION_PLAN, 1), "--model", model, "--method", "least_squares",
       "-o", mount, status=(0, 1))

    radii = {"before": [], "after": []}
    for seed in range(11, 16):
        bag = simulate(os.path.join(HERE, "ball.yaml"), seed)
        radii["before"].append(before(bag)["c0"]["radius_mm"])
        radii["after"].append(after(bag)["c0"]["radius_mm"])
    print("radius of a ball of 6 mm, five times (LASER: 6.0122 before, 6.0000 after)")
    for when, values in radii.items():
        print("  %-6s %s mm, largest error %.2f um" % (when, " ".join("%.4f" % r for r in values),
                                                       1e3 * max(abs(r - 6.0) for r in values)))

    plan = os.path.join(HERE, "lengths.yaml")
    truth = true_centres(plan)
    errors = {"before": [], "after": []}
    for seed in range(21, 24):
        bag = simulate(plan, seed)
        for when, found in (("before", before(bag)), ("after", after(bag))):
            for p, q in itertools.combinations(sorted(truth), 2):
                length = math.dist(truth[p], truth[q])
                errors[when].append((length, 1e3 * (math.dist(found[p]["centre_mm"], found[q]["centre_mm"]) - length)))
    print("length errors of %d lengths, three times each (LASER: 11.82 + L/1000 before, 1.96 + L/1000 after)"
          % (len(errors["after"]) // 3))
    result = {"radius_mm": radii}
    for when, pairs in errors.items():
        a = max(0.0, max(abs(e) - length / K for length, e in pairs))
        result["A_um_" + when] = a
        print("  %-6s within (%.2f + L/%.0f) um, L in mm; RMS %.2f um" %
              (when, a, K, math.sqrt(sum(e * e for _, e in pairs) / len(pairs))))
    with open(os.path.join(folder, "table3.json"), "w", encoding="utf-8") as file:
        json.dump(result, file, indent=1)
    print("written to " + folder)


if __name__ == "__main__":
    main()
