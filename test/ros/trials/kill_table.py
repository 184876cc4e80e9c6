#!/usr/bin/env python3
"""Who moves dies, in every way and at every moment: kill_table.py <hardware> <trials> [filter]. One row a cell: how long the axes
truly moved on, frames that were wrong, measurements that were lost. See scripts/kill_table."""
import collections
import os
import re
import signal
import statistics
import subprocess
import sys
import threading
import time

import actionlib
import rospy
from measuring_machine.msg import MeasureAction, MeasureGoal, MoveAction, MoveGoal
from std_srvs.srv import SetBool, Trigger

import processes
from stage import HARDWARE, Stage, rng, support

sys.path.insert(0, os.path.join(support.PACKAGE, "test", "support"))
from workbench_test import Page  # noqa: E402

REST = 1.0            # s after which nothing may move any more
QUIET = 0.6           # s without motion: it stays so
LONGEST = 2.5         # s that a motion is looked at
STANDS_STILL = 1.5    # s from SIGSTOP to SIGCONT
SLOW = 4e-3           # m/s
MOMENT = 120.0        # s for a moment to come: a computer that is busy starts a client of Python in half a minute
MOMENTS = ("move", "probe", "home", "wait")
SIGNALS = {"KILL": signal.SIGKILL, "STOP": signal.SIGSTOP, "TERM": signal.SIGTERM, "HUP": signal.SIGHUP, "INT": signal.SIGINT}
ALL = tuple(SIGNALS) + ("cut", "dead")  # cut: its connection with the driver (of the driver: with the control); dead: SIGKILL under a dead master

Cell = collections.namedtuple("Cell", "process signal moment mover judged")


def cells(hardware):
    """What can be tried. `judged`: the axes must rest; of the others frames and measurements alone count."""
    def of(process, signals, moments, mover, judged=True):
        return [Cell(process, s, m, mover(m) if callable(mover) else mover, judged) for s in signals for m in moments]

    driver = [s for s in ALL if s != "cut" or hardware == "grbl"]  # the others have no line to their control
    table = of("axis_driver", driver, MOMENTS, lambda m: "measure" if m == "wait" else "plain")
    table += of("measure", ALL, ("move", "probe", "wait"), "measure")
    table += of("workbench", ALL, MOMENTS, "page")
    table += of("page", ("cut", "STOP"), MOMENTS, "page")
    table += of("client", [s for s in ALL if s != "STOP"], ("move", "probe", "home"), "plain")  # without a ticket nobody promises to see it stand still
    table += of("client with a ticket", ALL, ("move", "probe"), "ticket")
    table += of("master", ("KILL",), ("move", "probe", "home"), "plain") + of("master", ("KILL",), ("probe", "wait"), "measure")
    table += of("master", ("KILL",), ("move",), "page")
    for bystander in ("probe", "compensation", "calibration_server"):
        table += of(bystander, ("KILL", "STOP", "TERM", "cut"), ("move", "probe", "wait"), "measure", judged=False)
    return [c for c in table if c.moment != "home" or HARDWARE[hardware].homes]


class Result:
    def __init__(self, cell):
        self.cell, self.rest, self.wrong, self.error, self.compared, self.contacts, self.uncounted = cell, [], 0, 0.0, 0, set(), 0
        self.failed = collections.Counter()


class KillTable:
    def __init__(self, hardware):
        self.stage = Stage(hardware)
        self.watch, self.hardware = self.stage.watch, self.stage.hardware
        self.axes = actionlib.SimpleActionClient("axis_driver/move", MoveAction)
        self.measure = actionlib.SimpleActionClient("measure/run", MeasureAction)
        assert support.served(self.axes, self.measure, seconds=60)
        self.workbench = self.page = self.client = None
        self.others = {}  # joints that no trial moves, as homing leaves them
        self.place(self.hardware.start)
        self.others = dict(list(zip(self.watch.joints.name, self.watch.joints.position))[3:])
        self.stage.calibrate()
        self.watch.wait(lambda: self.watch.compensation.publishing, 30, "a corrected frame")

    # -- before a trial: all nodes are there, the axes homed and at their start
    def call(self, name, kind, *values):
        rospy.wait_for_service(name, 20)
        return rospy.ServiceProxy(name, kind)(*values)

    def service(self, name, kind, *values, seconds=30):
        """A service of a driver that may just be beginning. @return its answer, when it is a success."""
        said = []

        def called():
            try:
                said.append(self.call(name, kind, *values))
                return said[-1].success
            except (rospy.ServiceException, rospy.ROSException) as e:
                said.append(e)
                return False

        assert support.wait_until(called, seconds), "%s: %s" % (name, said[-1])

    def place(self, position):
        """Homed and there, whatever it was before."""
        self.service("axis_driver/stop", Trigger)
        for _ in range(10):
            if self.watch.status.homed and self.go(position):
                return
            self.service("axis_driver/emergency_stop", SetBool, False)  # a reset, which also forgets the homing
            self.service("axis_driver/home", Trigger, seconds=60)
            self.watch.wait(lambda: self.watch.status.homed, 10, "the homing in the status")
        raise AssertionError("the axes do not get to their start: " + self.watch.says())

    def go(self, position):
        self.axes.send_goal(MoveGoal(name=["x", "y", "z"] + list(self.others), position=[1e-3 * v for v in position] + list(self.others.values()),
                                     linear_speed=0.02))
        if not support.ended(self.axes, 20):
            self.axes.cancel_goal()
        return self.axes.get_state() == actionlib.GoalStatus.SUCCEEDED

    def start_workbench(self):
        if self.workbench is None or self.workbench.poll() is not None:
            rospy.delete_param("/workbench/url") if rospy.has_param("/workbench/url") else None
            self.workbench = self.stage.begin([support.REAPER, support.node("workbench"), "_open:=false", "_store:=" + self.stage.store,
                                               "__name:=workbench"])
            self.page = None
        assert support.wait_until(lambda: rospy.has_param("/workbench/url") and processes.pid_of("/workbench"), 30), "no workbench"
        if self.page is None or not self.page.open or not self.page.beats:
            self.page = Page(rospy.get_param("/workbench/url"))
        stops = self.watch.motion.stops
        self.page.post("stop")  # is answered before it has been sent
        self.watch.wait(lambda: self.watch.motion.stops != stops and self.watch.motion.stopped_by.startswith("/workbench"), 30, "the page's stop")
        assert self.page.wait(lambda s: s["task"] is None and s["armed"] is None, 30), self.page.state()
        self.service("axis_driver/stop", Trigger)  # is answered when the page's stop is over, too

    def ready(self, cell):
        self.place(self.hardware.far if cell.moment == "home" else self.hardware.start)
        if cell.mover == "page":
            self.start_workbench()
        assert support.served(self.axes, self.measure, seconds=30)
        self.watch.wait(lambda: self.watch.compensation.publishing, 30, "a corrected frame")

    # -- the motion
    def begin(self, cell):
        h = self.hardware
        if cell.mover == "measure":
            self.counted = 0
            self.measure.send_goal(MeasureGoal(plan=self.stage.plan(cell.moment)), feedback_cb=self.count)
        elif cell.mover == "page":
            said = []  # a driver that has just come back is connected to its stop within a second

            def armed():
                said.append(self.page.act("arm", client=self.page.client))
                return said[-1][0]

            assert support.wait_until(armed, 5), said[-1][1]
            if cell.moment == "home":
                status, answer = self.page.post("home", client=self.page.client)
            else:
                status, answer = self.page.post("run", client=self.page.client, plan=self.stage.plan(cell.moment))
            assert status in (200, 202), answer
        else:
            kind, speed, target = {"move": (MoveGoal.GO, SLOW, h.far), "probe": (MoveGoal.PROBE, 0.6e-3, h.deep), "home": (0, 0, ())}[cell.moment]
            order = ["home"] if cell.moment == "home" else [str(kind), str(speed)] + [str(1e-3 * v) for v in target]
            client = os.path.join(os.path.dirname(os.path.realpath(__file__)), "client.py")
            self.client = subprocess.Popen([sys.executable, client, cell.mover] + order, stdout=self.stage.log, stderr=self.stage.log)

    def count(self, feedback):
        self.counted = max(self.counted, feedback.contacts)

    def moment(self, cell, random):
        """Waits until the moment is there, and a little longer."""
        w, planned = self.watch, cell.mover in ("measure", "page")

        def there():
            if cell.mover == "measure" and support.ended(self.measure, 0):
                raise AssertionError("the plan ended before the moment %s: %s" % (cell.moment, self.measure.get_result().message))
            if planned and cell.moment != "home" and not w.contacts:
                return False
            x, far = w.joints.position[0], 1e-3 * self.hardware.far[0]
            if cell.moment == "move":
                return w.speed() > 0.8 * SLOW and not w.status.probing and abs(x - far) > 0.5 * SLOW * LONGEST + 1e-3 and (
                    abs(x - 1e-3 * self.hardware.start[0]) > 5e-4)
            if cell.moment == "probe":
                return w.speed() > 3e-4 and w.status.probing
            if cell.moment == "home":
                return w.motion.homing and w.speed() > 1e-3
            return not w.status.moving and max(abs(p - 1e-3 * s) for p, s in zip(w.joints.position, self.hardware.start)) < 3e-5 and w.speed() == 0.0

        w.wait(there, MOMENT, "the moment " + cell.moment)
        threading.Event().wait(random.uniform(0.0, 0.3))

    # -- the deed
    def pid(self, cell):
        if cell.process.startswith("client"):
            return self.client.pid
        return processes.pid_of("/" + cell.process)

    def strike(self, cell):
        """@return when it was, s of time.time()."""
        if cell.process == "master":
            self.stage.line.cut()
            threading.Event().wait(0.2)
            began = time.time()
            if cell.mover == "plain":
                self.client.send_signal(signal.SIGUSR1)
            elif cell.mover == "measure":
                self.measure.cancel_goal()
            else:
                threading.Thread(target=self.page.post, args=("stop",), daemon=True).start()
            return began
        if cell.process == "page":
            began = time.time()
            if cell.signal == "cut":
                self.page.close()
            else:
                self.page.beats = False
            return began
        pid, driver = self.pid(cell), processes.pid_of("/axis_driver")
        self.stopped = pid if cell.signal == "STOP" else None
        if cell.signal == "dead":
            self.stage.line.cut()
            threading.Event().wait(0.2)
        began = time.time()
        if cell.signal == "cut":
            number = processes.cut(pid, port=self.stage.control_port) if cell.process == "axis_driver" else processes.cut(pid, driver)
            assert number or not cell.judged, "no connection to cut"
        else:
            os.kill(pid, SIGNALS.get(cell.signal, signal.SIGKILL))
        return began

    def look(self, cell, began):
        """@return s from `began` to the last motion of what must rest."""
        threading.Event().wait(0.05)
        while time.time() < began + LONGEST:
            moved = max(self.watch.last_moved(), began)
            if time.time() > max(moved, began + 0.1) + QUIET:
                break
            threading.Event().wait(0.02)
        if cell.signal == "STOP" and cell.process != "page":
            threading.Event().wait(max(0.0, began + STANDS_STILL - time.time()))
            if cell.process == "axis_driver" and not self.stage.double:
                began = time.time()  # the simulated axes stood still with it
            os.kill(self.stopped, signal.SIGCONT)
            threading.Event().wait(QUIET + 0.4)
        return max(0.0, self.watch.last_moved() - began)

    def recovered(self, cell):
        """Every node is there again, and what the first of them say was heard. A workbench that was ended has ended: the next trial begins another."""
        if cell.process == "workbench" and cell.signal not in ("STOP", "cut"):
            assert support.wait_until(lambda: self.workbench.poll() is not None, 30), "the workbench does not end"
        for node in ("/axis_driver", "/measure", "/probe", "/compensation", "/calibration_server"):
            assert support.wait_until(lambda: processes.pid_of(node), 30), node + " does not come back"
        began = time.time_ns()
        self.watch.wait(lambda: self.watch.joints.header.stamp.to_nsec() > began, 30, "a joint state")
        threading.Event().wait(0.2)  # unhomed states, of which there must be no frame
        self.watch.wait(lambda: not self.watch.status.homed or max(self.watch.frames, default=0) > began, 30, "a corrected frame")

    def trial(self, cell, number, result):
        self.ready(cell)
        self.watch.forget()
        self.begin(cell)
        try:
            self.moment(cell, rng(cell, number))
            self.struck = self.strike(cell)
            rest = self.look(cell, self.struck)
        finally:
            self.stage.line.mend()
            if self.client is not None:
                self.client.kill()
                self.client.wait()
                self.client = None
        result.rest.append(rest)
        self.recovered(cell)
        compared, wrong, most = self.watch.wrong_frames()
        for stamp, error in wrong[:5]:
            print("    wrong by %.3f um, %.3f s after the deed: %s" % (1e6 * error, 1e-9 * stamp - self.struck, self.watch.around(stamp)), file=sys.stderr)
        result.compared, result.wrong, result.error = result.compared + compared, result.wrong + len(wrong), max(result.error, most)
        with self.watch.changed:
            heard = list(self.watch.contacts)
        result.contacts.update(heard)
        if cell.mover == "measure" and cell.process != "measure":
            result.uncounted += max(0, self.counted - len(heard))

    def run(self, result, number):
        try:
            self.trial(result.cell, number, result)
        except (AssertionError, rospy.ROSException, OSError) as e:
            result.failed[str(e)[:300]] += 1

    def end(self):
        if self.page:
            self.page.close()
        self.stage.end()


HEADER = "%-11s %-20s %-6s %-6s %6s %9s %8s %8s %8s %8s %7s %6s" % (
    "hardware", "process", "signal", "moment", "trials", "rest: s", "most", "beyond", "frames", "largest", "wrong", "lost")
UNITS = "%-11s %-20s %-6s %-6s %6s %9s %8s %8s %8s %8s" % ("", "", "", "", "", "median", "", "%g s" % REST, "compared", "um")


def row(hardware, result, lost):
    cell, rest = result.cell, sorted(result.rest)
    beyond = sum(r > REST for r in rest) if cell.judged else 0
    figures = ("%9.2f %8.2f %8d" % (statistics.median(rest), rest[-1], beyond) if cell.judged else "%9s %8s %8s" % ("goes on", "", "")) if rest else " " * 27
    text = "%-11s %-20s %-6s %-6s %6d %s %8d %8.3f %7d %6s" % (
        hardware, cell.process, cell.signal, cell.moment, len(rest), figures, result.compared, 1e6 * result.error, result.wrong, lost)
    for why, times in result.failed.items():
        text += "\n    not tried, %d times: %s" % (times, why)
    return text, beyond + result.wrong + (lost or 0) + sum(result.failed.values()) + (not rest)


def main(hardware, trials, pattern="."):
    chosen = [c for c in cells(hardware) if re.search(pattern, " ".join((hardware,) + c[:3]))]
    if not chosen:
        sys.exit("kill_table: no cell of %s is called '%s'; one is '%s %s'" % (hardware, pattern, hardware, " ".join(cells(hardware)[0][:3])))
    table, results, bad = KillTable(hardware), [Result(cell) for cell in chosen], 0
    try:
        for number in range(trials):
            for result in results:
                table.run(result, number)
                if number == 0 or row(hardware, result, 0)[1]:
                    print(row(hardware, result, 0)[0], file=sys.stderr, flush=True)
            print("round %d of %d" % (number + 1, trials), file=sys.stderr, flush=True)
    except KeyboardInterrupt:
        pass  # the table is of what was tried
    finally:
        table.end()
    recorded = table.stage.recorded()
    print(HEADER + "\n" + UNITS)
    tried = [r for r in results if r.rest or r.failed]
    for result in tried:
        text, wrong = row(hardware, result, len(result.contacts - recorded) + result.uncounted)
        print(text)
        bad += wrong > 0
    print("%s: %d of %d cells tried, %d trials, %d cells not as they must be" % (hardware, len(tried), len(results), sum(len(r.rest) for r in results), bad),
          flush=True)
    support.remove(table.stage.folder)
    return 1 if bad or len(tried) < len(results) else 0


if __name__ == "__main__":
    sys.stdout.reconfigure(line_buffering=True)
    sys.exit(main(sys.argv[1], int(sys.argv[2]), *sys.argv[3:4]))
