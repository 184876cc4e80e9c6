#!/usr/bin/env python3
"""Emergency stops from the call to the answer, which comes when the control was told: stop_latency.py <calls>. One row a load and a
kind of connection. See scripts/stop_latency."""
import os
import socket
import struct
import subprocess
import sys
import time

import rosgraph
from std_srvs.srv import SetBool, Trigger

from stage import Stage, support

BOUND = 50.0  # ms at 99 %
GOALS = """
import rospy
from measuring_machine.msg import MoveActionGoal, MoveGoal
rospy.init_node("large_goals")
out = rospy.Publisher("axis_driver/move/goal", MoveActionGoal, queue_size=1)
goal = MoveActionGoal(goal=MoveGoal(name=["x"], position=[0.001], feature="x" * 20000000))
number = 0
while not rospy.is_shutdown():
    goal.goal_id.id, number = "/large_goals-%d" % number, number + 1
    out.publish(goal)
    rospy.sleep(0.05)
"""
BUSY = "while True: pass"


class Service:
    """One call of a service over a connection of its own, or a kept one: nothing of rospy lies between the clock and the driver."""

    def __init__(self, name, kind, address, persistent):
        self.socket = socket.create_connection(address)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        fields = {"callerid": "/stop_latency", "service": name, "md5sum": kind._md5sum, "type": kind._type}
        if persistent:
            fields["persistent"] = "1"
        header = b"".join(struct.pack("<I", len(f)) + f for f in ("%s=%s" % item for item in fields.items()) for f in [f.encode()])
        self.socket.sendall(struct.pack("<I", len(header)) + header)
        self.take(struct.unpack("<I", self.take(4))[0])

    def take(self, number):
        data = b""
        while len(data) < number:
            more = self.socket.recv(number - len(data))
            if not more:
                raise OSError("the driver closed the connection")
            data += more
        return data

    def call(self, on):
        """@return whether it succeeded."""
        self.socket.sendall(struct.pack("<IB", 1, on))
        ok = self.take(1)[0]
        answer = self.take(struct.unpack("<I", self.take(4))[0])
        return bool(ok and answer[0])


class Latency:
    def __init__(self):
        self.stage = Stage("simulated")
        self.name = "/axis_driver/emergency_stop"
        assert support.wait_until(lambda: self.address(), 60)
        self.known = self.address()
        self.kept, self.reset = self.service(True), self.service(True)
        self.out = open(os.devnull, "w")

    def address(self):
        try:
            host, port = rosgraph.network.parse_http_host_and_port(rosgraph.Master("/trials").lookupService(self.name).replace("rosrpc", "http"))
            return host, port
        except (rosgraph.MasterError, OSError):
            return None

    def service(self, persistent, known=True):
        return Service(self.name, SetBool, self.known if known else self.address(), persistent)

    def once(self, connection, known):
        """@return ms."""
        assert support.wait_until(lambda: self.reset.call(False), 20), "the emergency stop is not reset"
        began = time.monotonic()
        one = self.kept if connection == "kept" else self.service(False, known)
        done = one.call(True)
        took = 1e3 * (time.monotonic() - began)
        assert done, "the emergency stop did not reach the control"
        if one is not self.kept:
            one.socket.close()
        return took

    def row(self, load, connection, calls, dead=False):
        took = sorted(self.once(connection, dead) for _ in range(calls))
        at99 = took[min(calls - 1, int(0.99 * calls))]
        print("%-16s %-10s %6d %9.2f %9.2f %9.2f  %s" % (load, connection, calls, took[calls // 2], at99, took[-1], "" if at99 <= BOUND else "beyond %g ms" % BOUND))
        return at99 > BOUND

    def beside(self, load, commands, calls):
        processes = [subprocess.Popen([sys.executable, "-c", text], stdout=self.out, stderr=self.out) for text in commands]
        try:
            if commands and commands[0] is GOALS:
                assert support.wait_until(lambda: "/large_goals" in str(rosgraph.Master("/trials").getSystemState()), 30)
                time.sleep(1.0)  # the first of them is on its way
            return sum(self.row(load, connection, calls) for connection in ("kept", "new"))
        finally:
            for one in processes:
                one.kill()
                one.wait()

    def run(self, calls):
        print("%-16s %-10s %6s %9s %9s %9s" % ("load", "connection", "calls", "median ms", "99 %", "most"))
        bad = self.beside("quiet", [], calls)
        bad += self.beside("busy", [BUSY] * 2 * (os.cpu_count() or 1), calls)
        bad += self.beside("20 MB goals", [GOALS], calls)
        self.stage.line.cut()
        bad += self.row("dead master", "kept", calls, True)
        bad += self.row("dead master", "new, known", calls, True)
        return bad


def main(calls):
    latency = Latency()
    try:
        bad = latency.run(calls)
    finally:
        latency.stage.end()
    print("emergency stop: %d rows of %d calls, %d of them beyond %g ms at 99 %%" % (8, calls, bad, BOUND), flush=True)
    support.remove(latency.stage.folder)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.stdout.reconfigure(line_buffering=True)
    sys.exit(main(int(sys.argv[1])))
