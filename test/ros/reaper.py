#!/usr/bin/env python3
"""Runs a command and leaves nothing of it behind: `reaper.py command …`. What the command starts, in whatever session or
process group, ends with it, and with whoever started the reaper, even when that one is killed."""
import ctypes
import os
import signal
import subprocess
import sys
import time

PR_SET_PDEATHSIG, PR_SET_CHILD_SUBREAPER = 1, 36
GRACE = 25.0  # s from the wish to end to the kill: roslaunch takes up to 17 to end its nodes


def descendants():
    children = {}
    for pid in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open("/proc/%s/stat" % pid) as f:
                parent = int(f.read().rsplit(")", 1)[1].split()[1])
        except (OSError, IndexError):
            continue  # it has just ended
        children.setdefault(parent, []).append(int(pid))
    found, look = [], [os.getpid()]
    while look:
        look = [child for pid in look for child in children.get(pid, [])]
        found += look
    return found


def signal_all(pids, number):
    for pid in pids:
        try:
            os.kill(pid, number)
        except ProcessLookupError:
            pass


def main():
    libc = ctypes.CDLL(None, use_errno=True)
    libc.prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)  # orphans of the command become children of this process
    libc.prctl(PR_SET_PDEATHSIG, signal.SIGTERM, 0, 0, 0)
    wish = []
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda *_: wish.append(time.monotonic()))
    command = subprocess.Popen(sys.argv[1:], start_new_session=True)
    told = False
    while command.poll() is None:
        if (wish or os.getppid() == 1) and not told:
            command.send_signal(signal.SIGINT)
            told = time.monotonic()
        if told and time.monotonic() - told > GRACE:
            break
        time.sleep(0.05)
    signal_all(descendants(), signal.SIGTERM)
    end = time.monotonic() + 3.0
    while descendants() and time.monotonic() < end:
        command.poll()
        try:
            os.waitpid(-1, os.WNOHANG)
        except ChildProcessError:
            break
        time.sleep(0.05)
    signal_all(descendants(), signal.SIGKILL)
    return command.returncode if command.returncode is not None else 1


if __name__ == "__main__":
    sys.exit(main())
