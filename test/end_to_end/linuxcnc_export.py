"""Drives a headless LinuxCNC with exported tables, as an ordinary user: linuxcnc_export.py folder steps.json
The folder holds machine.ini and what it names. A step may do something to the machine (`first`), sets signals of temperatures (`sets`)
and goes `through` places (mm); printed, one JSON a line, is where the motors stand when it has come to rest, where the axes are
commanded, in which direction each joint moved last, and what is told of the offsets. Ends LinuxCNC whatever happens."""
import json
import os
import signal
import socket
import subprocess
import sys
import time

LONG = 120.0  # s: nothing here is about how soon
PORT = 5008  # not that to which the driver of a rostest that waits for its turn connects


def wait_until(condition, what):
    end = time.monotonic() + LONG
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


def pin(name):
    """Its value, to the last digit (halcmd prints seven)."""
    import hal as hal_library
    if pin.watch is None:
        pin.watch = hal_library.component("mm-watch")
        pin.watch.ready()
    return hal_library.get_value(name)


pin.watch = None


class Shell:
    """linuxcncrsh: a line, an answer."""

    def __init__(self):
        self.socket = socket.create_connection(("127.0.0.1", PORT), LONG)
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
    return [pin("joint.%d.motor-pos-cmd" % n) for n in range(3)]


def at_rest():
    """The motors, when nothing has changed for 0.1 s of the servo thread: the trajectory, the run of a table's step, the offsets."""
    last, since = [None], [0.0]

    def still():
        now = (motors(), pin("motion.in-position"))
        if now != last[0] or not now[1]:
            last[0], since[0] = now, pin("integ.0.out")
        return now[0] if pin("integ.0.out") - since[0] >= 0.1 else None

    return wait_until(still, "the machine does not come to rest")


def offsets_arrive():
    """Three periods of the component after now, all offsets are there."""
    begin = pin("mm-offsets.cycles")
    wait_until(lambda: pin("mm-offsets.cycles") >= begin + 3 and pin("mm-offsets.arrived"), "the offsets do not arrive")


class Machine:
    def __init__(self, folder):
        import linuxcnc
        # linuxcncrsh cannot unhome, and looks every tenth of a second whether a block has ended
        self.shell, self.commands, self.manual, self.mdi = Shell(), linuxcnc.command(), linuxcnc.MODE_MANUAL, linuxcnc.MODE_MDI
        self.offsets = os.path.exists(os.path.join(folder, "external_offsets.hal"))

    def on(self):
        self.shell.send("set machine on")
        wait_until(lambda: pin("motion.motion-enabled"), "the machine does not turn on")

    def off(self):
        self.shell.send("set machine off")
        wait_until(lambda: not pin("motion.motion-enabled"), "the machine does not turn off")

    def home(self):
        self.shell.send("set mode manual")
        self.shell.send("set home -1")
        wait_until(lambda: pin("motion.is-all-homed"), "the joints do not home")

    def cleared(self):
        if self.offsets:
            wait_until(lambda: pin("mm-offsets.x-clear"), "offsets that are off are not cleared")

    def do(self, what):
        if what == "off and on":
            self.off()
            self.cleared()
            self.on()
        elif what == "off and on unseen":  # by the component, which is stopped meanwhile
            pid = int(subprocess.run(["pgrep", "-f", "linuxcnc_offsets external_offsets.json"], capture_output=True, text=True).stdout.split()[0])
            os.kill(pid, signal.SIGSTOP)
            self.off()
            self.on()
            os.kill(pid, signal.SIGCONT)
        elif what == "unhome and home":
            for command in (lambda: self.commands.mode(self.manual), lambda: self.commands.teleop_enable(0), lambda: self.commands.unhome(-1)):
                command()
                self.commands.wait_complete()
            wait_until(lambda: not pin("motion.is-all-homed"), "the joints stay homed")
            self.cleared()
            self.home()
        else:
            raise SystemExit("what is '%s'?" % what)
        self.takes_blocks()

    def takes_blocks(self):
        self.commands.mode(self.mdi)
        self.commands.wait_complete()

    def go(self, places):
        for place in places:
            self.commands.mdi("G1 X%.4f Y%.4f Z%.4f F3000" % tuple(place))
            wait_until(lambda: all(abs(pin("axis.%s.pos-cmd" % a) - p) < 1e-6 for a, p in zip("xyz", place)),
                       "the machine does not go to %s" % (place,))

    def told(self):
        if self.offsets:
            offsets_arrive()
        stands = at_rest()
        answer = {"motors": stands, "commanded": [pin("axis.%s.pos-cmd" % a) for a in "xyz"],
                  "directions": [1 if pin("comp.%d.out" % n) else -1 for n in range(3)]}
        if self.offsets:
            answer["offsets"] = [pin("axis.%s.eoffset" % a) for a in "xyz"]
            answer["held"] = pin("mm-offsets.held")
        return answer


def drive(folder, steps):
    machine = Machine(folder)
    machine.shell.send("set estop off")
    machine.on()
    machine.home()
    machine.takes_blocks()
    for step in steps:
        if "first" in step:
            machine.do(step["first"])
        for signal_name, value in step.get("sets", {}).items():
            hal("sets", signal_name, value)
        machine.go(step.get("through", []))
        print(json.dumps(machine.told()), flush=True)


def main():
    folder, steps = sys.argv[1], json.load(open(sys.argv[2]))
    log = open(os.path.join(folder, "log"), "w")
    process = subprocess.Popen(["/usr/bin/linuxcnc", "-r", os.path.join(folder, "machine.ini")], cwd=folder, stdout=log, stderr=log,
                               stdin=subprocess.DEVNULL, start_new_session=True)
    try:
        wait_until(lambda: listens() or process.poll() is not None, "LinuxCNC does not start")
        if process.poll() is not None:
            raise SystemExit("LinuxCNC ended: " + open(os.path.join(folder, "log")).read()[-2000:])
        drive(folder, steps)
    finally:
        if pin.watch is not None:
            pin.watch.exit()
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
