#!/usr/bin/env python3
"""Starts rviz with a view whose frames have the prefix of a machine: view_in_rviz.py VIEW.rviz [PREFIX]."""
import os
import sys
import tempfile

import yaml

FRAMES = ("Fixed Frame", "Target Frame", "Reference Frame")


def prefixed(part, prefix):
    if isinstance(part, list):
        return [prefixed(one, prefix) for one in part]
    if not isinstance(part, dict):
        return part
    done = {}
    for key, value in part.items():
        if key in FRAMES:
            value = prefix + value
        elif key == "Frames":
            value = {name if name == "All Enabled" else prefix + name: shown for name, shown in value.items()}
        done[key] = prefixed(value, prefix)
    if part.get("Class") == "rviz/RobotModel":
        done["TF Prefix"] = prefix.rstrip("/")
    return done


def main():
    view, own = sys.argv[1], [a for a in sys.argv[2:] if not a.startswith("__") and ":=" not in a]
    remapped = [a for a in sys.argv[2:] if ":=" in a]
    prefix = own[0] if own else ""
    if prefix:
        with open(view) as source, tempfile.NamedTemporaryFile("w", suffix=".rviz", delete=False) as target:
            yaml.safe_dump(prefixed(yaml.safe_load(source), prefix), target, sort_keys=False)
        view = target.name
    os.execvp("rosrun", ["rosrun", "rviz", "rviz", "-d", view] + remapped)


if __name__ == "__main__":
    main()
