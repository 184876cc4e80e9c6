#!/usr/bin/env python3
"""LASER's figure 3: the niching algorithm against the traditional one, over many seeds, as a table and as convergence
curves side by side.

    convergence.py CENTRES.csv ARTIFACT.yaml [--mm PATH] [--seeds 50] [--folder FOLDER]

CENTRES.csv: the fitted centres of one ball in each posture, in the import format (LASER's Table 2).
"""
import argparse
import csv
import json
import os
import statistics
import subprocess
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
REACHED = 50.0  # um


def mm(program, *arguments):
    done = subprocess.run([program, *arguments], capture_output=True, text=True, check=False)
    if done.returncode not in (0, 1):
        raise SystemExit("mm " + " ".join(arguments) + "\n" + done.stderr)
    return done.stdout


def median(values):
    return statistics.median(values) if values else float("nan")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("centres")
    parser.add_argument("artifact")
    parser.add_argument("--mm", default="mm")
    parser.add_argument("--seeds", type=int, default=50)
    parser.add_argument("--folder", default=None)
    options = parser.parse_args()
    folder = options.folder or tempfile.mkdtemp(prefix="convergence_")
    os.makedirs(folder, exist_ok=True)
    bag, mount = os.path.join(folder, "centres.bag"), os.path.join(folder, "mount.yaml")
    model = os.path.join(HERE, "model.yaml")
    mm(options.mm, "import", options.centres, "--artifact", options.artifact, "--machine", "five_axis", "-o", bag)
    algorithms = {"niching": [], "traditional": ["--traditional"]}
    curves = []
    print("algorithm     reached 0.05 mm   evaluations to it (median)   RMS at the end, um (median)   polished, um")
    for name, flags in algorithms.items():
        ends, needed, polished, shown = [], [], [], []
        for seed in range(1, options.seeds + 1):
            curve = os.path.join(folder, "%s_%d.csv" % (name, seed))
            result = json.loads(mm(options.mm, "calibrate", bag, "--model", model, "--method", "niching", *flags,
                                   "--seed", str(seed), "--curve", curve, "--json", "-o", mount))
            genetic = result["genetic"]
            with open(curve, encoding="utf-8") as file:
                rms = [float(row["rms_um"]) for row in csv.DictReader(file)]
            ends.append(genetic["rms_um"])
            polished.append(result["polish"]["rms_um"])
            first = next((g for g, value in enumerate(rms) if value <= REACHED), None)
            if first is not None:
                needed.append((first + 1) * genetic["evaluations"] / (genetic["generations"] + 1))
            shown.append((genetic["rms_um"], curve))
        print("%-12s  %7d of %d      %10.0f                   %10.1f                  %.2f … %.2f" %
              (name, len(needed), options.seeds, median(needed), median(ends), min(polished), max(polished)))
        shown.sort()
        middle = os.path.join(folder, name + ".csv")
        os.replace(shown[len(shown) // 2][1], middle)
        curves.append(middle)
    page = os.path.join(folder, "convergence.html")
    mm(options.mm, "report", bag, "--calibration", mount, "-o", page, *sum((["--curve", c] for c in curves), []))
    print("the two runs that end in the middle, side by side: " + page)


if __name__ == "__main__":
    main()
