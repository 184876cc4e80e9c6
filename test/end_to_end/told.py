"""What the scripts of this folder share: how long they may take, and the lines that scripts/test counts."""
import os

LONG = os.environ.get("MM_LONG_TESTS", "0") not in ("", "0")
THOROUGH = LONG or os.environ.get("MM_THOROUGH_TESTS", "0") not in ("", "0")


def say(good, what, why=""):
    print(("ok " if good else "not ok ") + what + ("" if good or not why else ": " + str(why)[-3000:]), flush=True)


def check(what, good, why=""):
    say(good, what, why)
