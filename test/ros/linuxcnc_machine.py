"""LinuxCNC without a screen, as test/ros/linuxcnc describes its machine: started, looked at through linuxcncrsh, which the driver does
not use, and ended. There can be one on a computer."""
import fcntl
import os
import shutil
import signal
import socket
import subprocess
import threading
import time

import support

FOLDER = os.path.join(support.PACKAGE, "test/ros/linuxcnc")
PORT = 5007


def listens():
    with socket.socket() as s:
        return s.connect_ex(("127.0.0.1", PORT)) == 0


def as_user(command):
    """LinuxCNC and its tools refuse to run as root."""
    return ["/usr/sbin/runuser", "-u", "nobody", "--"] + command if os.getuid() == 0 else command


def hal(pin, value):
    subprocess.check_call(as_user(["/usr/bin/halcmd", "setp", pin, value]))


class Client:
    """Another client of linuxcncrsh: it may do what a panel does."""

    def __init__(self):
        self.socket = socket.create_connection(("127.0.0.1", PORT))
        self.lines = self.socket.makefile("r", newline="\n")
        for line in ("hello EMC panel 1.0", "set echo off", "set verbose on", "set enable EMCTOO", "set timeout 2.0"):
            self.say(line)

    def say(self, line):
        """@return its answer."""
        self.socket.sendall((line + "\r\n").encode())
        return next(text.strip() for text in iter(self.lines.readline, "") if text.strip())

    def get(self, what):
        return self.say("get " + what).split(None, 1)[1]

    def do(self, *commands):
        for command in commands:
            self.say("set enable EMCTOO")
            assert self.say("set " + command).endswith("ACK"), command

    def mdi(self, *blocks):
        self.do("mode mdi", *("mdi " + block for block in blocks))

    def close(self):
        self.lines.close()
        self.socket.close()


class LinuxCnc:
    """@param work a folder for its files. Waits until no other one runs, and until it listens."""

    def __init__(self, work):
        self.only = open("/tmp/mm_linuxcnc.lock", "a")
        if os.stat(self.only.name).st_uid == os.getuid():
            os.chmod(self.only.name, 0o666)  # for another user's test
        fcntl.flock(self.only, fcntl.LOCK_EX)
        os.chmod(work, 0o755)
        self.folder = os.path.join(work, "machine")
        shutil.copytree(FOLDER, self.folder)
        for name in ("machine.var", "machine.tbl"):
            open(os.path.join(self.folder, name), "w").close()
        assert not listens(), "a LinuxCNC is running already"
        if os.path.exists("/tmp/linuxcnc.lock"):
            os.remove("/tmp/linuxcnc.lock")  # of one that was killed: the next would ask on a terminal whether to go on
        self.process = self.start()
        assert support.wait_until(listens, 40), self.said()
        self.moved, self.watching = None, None

    def start(self):
        command = ["/usr/bin/linuxcnc", os.path.join(self.folder, "machine.ini")]
        environment = dict(os.environ, HOME=self.folder, DISPLAY="", PATH="/usr/bin:/bin")
        if os.getuid() == 0:
            subprocess.check_call(["chown", "-R", "nobody", self.folder])
            command = as_user(["/usr/bin/env"] + ["%s=%s" % (k, environment[k]) for k in ("HOME", "DISPLAY", "PATH")] + command)
        log = open(os.path.join(self.folder, "log"), "w")
        return subprocess.Popen(command, env=environment, stdout=log, stderr=log, cwd=self.folder, start_new_session=True)

    def said(self):
        return "".join(open(os.path.join(self.folder, f)).read() for f in os.listdir(self.folder) if f == "log" or f.startswith("linuxcnc_"))

    def tell(self, what):
        """As the doubles tell it: {"moved": s of the monotonic clock when what is commanded last changed}, looked at all the time."""
        assert what == "machine", what
        if self.watching is None:
            self.moved = time.monotonic()
            self.watching = threading.Thread(target=self.watch, daemon=True)
            self.watching.start()
        return {"moved": self.moved}

    def watch(self):
        client, last = Client(), None
        try:
            while True:
                where = client.get("abs_cmd_pos")
                if where != last:
                    self.moved = time.monotonic()
                last = where
                time.sleep(0.002)
        except (OSError, StopIteration):
            pass  # it has ended

    def end(self):
        # Its display ends, and LinuxCNC tidies up.
        subprocess.call(["pkill", "-TERM", "-f", "linuxcncrsh.*-ini " + os.path.join(self.folder, "machine.ini")])
        try:
            self.process.wait(30)
        except subprocess.TimeoutExpired:
            os.killpg(self.process.pid, signal.SIGKILL)
        assert support.wait_until(lambda: not listens(), 20), "LinuxCNC did not end"
