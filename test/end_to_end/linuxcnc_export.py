"""Drives a headless LinuxCNC with exported tables, as an ordinary user: linuxcnc_export.py folder steps.json
The folder holds machine.ini and what it names. Each step commands a place (mm) and temperatures; printed, one JSON a line, is
where the motors stand when it has come to rest. Ends LinuxCNC whatever happens."""
import json
import os
import signal
import socket
import subprocess
import sys
import time

PORT = 5007


def wait_until(condition, seconds, what):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        answer = condition()
        if answer:
            return answer
        time.sleep(0.02)
    raise SystemExit("timeout: " + what)


def listens():
    with socket.socket() as s:
        return s.connect_ex(("127.0.0.1", PORT)) == 0


def hal(*words):
    done = subprocess.run(["/usr/bin/halcmd", "-s"] + list(words), capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit("halcmd %s: %s" % (" ".join(words), done.stderr))
    return done.stdout.strip()


class Shell:
    """linuxcncrsh: a line, an answer."""

    def __init__(self):
        self.socket = socket.create_connection(("127.0.0.1", PORT), 10)
        self.file = self.socket.makefile("rw", newline="\r\n")
        for line in ("hello EMC mm 1.0", "set echo off", "set enable EMCTOO", "set wait_mode done"):
            self.send(line)

    def send(self, line):
        self.file.write(line + "\n")
        self.file.flush()

    def ask(self, line, key):
        self.send("get " + line)
        while True:
            answer = self.file.readline()
            if not answer:
                raise SystemExit("linuxcncrsh closed the connection")
            if answer.upper().startswith(key.upper()):
                return answer.strip()[len(key):].strip()


def motors():
    return [float(hal("getp", "joint.%d.motor-pos-cmd" % n)) for n in range(3)]


def at_rest():
    """The motors, when nothing changes any more: the trajectory, the run of a table's step, the offsets."""
    last = [None, 0]

    def still():
        now = (motors(), hal("getp", "motion.in-position"))
        last[1] = last[1] + 1 if now == last[0] and now[1] == "TRUE" else 0
        last[0] = now
        return now[0] if last[1] >= 5 else None

    return wait_until(still, 20, "the machine does not come to rest")


def drive(folder, steps):
    shell = Shell()
    shell.send("set estop off")
    shell.send("set machine on")
    wait_until(lambda: hal("getp", "motion.motion-enabled") == "TRUE", 20, "the machine does not turn on")
    shell.send("set mode manual")
    shell.send("set home -1")
    wait_until(lambda: hal("getp", "motion.is-all-homed") == "TRUE", 20, "the joints do not home")
    offsets = os.path.exists(os.path.join(folder, "external_offsets.hal"))
    if offsets:
        wait_until(lambda: hal("getp", "mm-offsets.enable") == "TRUE", 10, "the offsets are not enabled")
    shell.send("set mode mdi")
    for step in steps:
        for sensor, degrees in step.get("degC", {}).items():
            if offsets and sensor in step.get("sensors", []):
                hal("sets", "mm-" + sensor, repr(degrees))
        for x, y, z in step["through"]:
            shell.send("set mdi G1 X%.4f Y%.4f Z%.4f F1500" % (x, y, z))
            target = (x, y, z)
            wait_until(lambda: all(abs(float(hal("getp", "joint.%d.pos-cmd" % n)) - target[n]) < 0.05 for n in range(3)), 30, "the machine does not go to %s" % (target,))
        # An offset follows within some cycles of the component.
        if offsets:
            seen = [0]

            def followed():
                counts = [hal("getp", "mm-offsets.%s-counts" % a) for a in "xyz"]
                seen[0] = seen[0] + 1 if counts == drive.counts else 0
                drive.counts = counts
                return seen[0] >= 10

            wait_until(followed, 10, "the offsets do not settle")
        print(json.dumps({"target": step["through"][-1], "motors": at_rest()}), flush=True)


drive.counts = None


def main():
    folder, steps = sys.argv[1], json.load(open(sys.argv[2]))
    log = open(os.path.join(folder, "log"), "w")
    process = subprocess.Popen(["/usr/bin/linuxcnc", os.path.join(folder, "machine.ini")], cwd=folder, stdout=log, stderr=log,
                               stdin=subprocess.DEVNULL, start_new_session=True)
    try:
        wait_until(lambda: listens() or process.poll() is not None, 40, "LinuxCNC does not start")
        if process.poll() is not None:
            raise SystemExit("LinuxCNC ended: " + open(os.path.join(folder, "log")).read()[-2000:])
        drive(folder, steps)
    finally:
        # Its display ends, and LinuxCNC tidies up.
        found = subprocess.run(["pgrep", "-f", "linuxcncrsh.*-ini " + os.path.join(folder, "machine.ini")], capture_output=True, text=True)
        for pid in found.stdout.split():
            os.kill(int(pid), signal.SIGTERM)
        try:
            process.wait(30)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)


if __name__ == "__main__":
    main()
