#!/usr/bin/env python3
"""Runs demo.launch: measure, record, calibrate by service, promote; the error against the simulated truth before and after."""
import json
import logging
import math
import os
import shutil
import signal
import subprocess
import sys
import threading

import actionlib
import rospy
import tf2_ros
from geometry_msgs.msg import PointStamped
from measuring_machine.msg import MeasureAction, MeasureGoal, MoveAction, MoveGoal, ProbeContact
from measuring_machine.srv import Calibrate, Promote
from std_msgs.msg import String
from std_srvs.srv import Trigger

CLEAR = 0.0078  # m, z above every ball and within the calibrated volume
# Fresh points of the touching machine, m: none of them is a point of the plan; the low ones lie between the balls.
CHECKS = [(x, y, CLEAR) for x in (-0.015, 0.002, 0.014) for y in (-0.009, 0.011, 0.027)]
CHECKS += [(x, y, z) for x, y in ((0.0, -0.009), (0.001, 0.027), (-0.013, 0.010), (0.012, 0.009)) for z in (0.0, -0.006)]
LASER_CHECKS = 12  # postures half-way between two of the plan: a laser meets nothing on its way


def without_seconds(text):
    found = json.loads(text or "{}")
    found.get("genetic", {}).pop("seconds", None)
    return found



def microseconds(stamp):
    """Python's tf2 has the nanoseconds of a stamp from a double, which errs by a hundred of them."""
    return (stamp.to_nsec() + 500) // 1000


class Demo:
    def __init__(self, folder, plan, model):
        self.folder, self.plan, self.model = folder, plan, model
        self.lock = threading.Lock()
        self.truth, self.contacts = {}, []
        rospy.Subscriber("probe/contact", ProbeContact, self.contacts.append, queue_size=1000)
        self.axes = actionlib.SimpleActionClient("axis_driver/move", MoveAction)
        self.measure = actionlib.SimpleActionClient("measure/run", MeasureAction)

    def take_truth(self, message):
        with self.lock:
            self.truth[microseconds(message.header.stamp)] = (message.point.x, message.point.y, message.point.z)

    def ways(self):
        """The fresh points as moves: lists of (joints, positions)."""
        if all(math.isnan(c.laser_reading) for c in self.contacts):
            return [[(["z"], [CLEAR]), (["x", "y"], p[:2]), (["z"], p[2:])] for p in CHECKS]
        step = max(1, len(self.contacts) // LASER_CHECKS)
        pairs = [(self.contacts[i], self.contacts[(i + 2 * step + 7) % len(self.contacts)])
                 for i in range(0, len(self.contacts), step)]
        return [[(list(a.name), [0.5 * (p + q) for p, q in zip(a.position, b.position)])] for a, b in pairs]

    def errors_at_checks(self, frame):
        """RMS and largest distance between a frame and the true tip, um, over the fresh points."""
        errors = []
        # Heard only here: over a whole measurement they would be a hundred thousand messages.
        truth = rospy.Subscriber("axis_driver/truth", PointStamped, self.take_truth, queue_size=1000)
        frames = tf2_ros.Buffer()
        listener = tf2_ros.TransformListener(frames)
        for way in self.ways():
            for names, position in way:
                self.go(names, position)
            with self.lock:
                self.truth.clear()
            errors.append(self.error_now(frames, frame))
        truth.unregister()
        listener.unregister()
        self.checks = len(errors)
        return math.sqrt(sum(e * e for e in errors) / len(errors)), max(errors)

    def go(self, names, position):
        goal = MoveGoal(kind=MoveGoal.GO, name=names, position=list(position), linear_speed=0.02, rotary_speed=0.35)
        self.axes.send_goal(goal)
        self.end_of(self.axes)
        rospy.rostime.wallsleep(0.02)  # its last status may still be on the way
        if self.axes.get_state() != actionlib.GoalStatus.SUCCEEDED:
            raise RuntimeError("a check position was not reached: " + self.axes.get_goal_status_text())

    def error_now(self, frames, frame):
        """At the third stamp, from now on, for which both the truth and the frame have come, um."""
        places = {}  # by stamp; the truth of a stamp may come later than its frame
        for _ in range(500):
            self.go_on()
            try:
                latest = frames.lookup_transform("workpiece", frame, rospy.Time(0))
                at = latest.transform.translation
                places[microseconds(latest.header.stamp)] = (at.x, at.y, at.z)
            except tf2_ros.TransformException:
                pass  # none yet
            with self.lock:
                known = [stamp for stamp in places if stamp in self.truth]
                if len(known) >= 3:
                    return 1e6 * math.dist(self.truth[max(known)], places[max(known)])
            rospy.rostime.wallsleep(0.02)
        raise RuntimeError("no frame '%s' arrives with the stamps of the joint states" % frame)

    def end_of(self, client):
        """The client's own wait_for_result never returns where the end came before send_goal did."""
        while client.gh.get_comm_state() != actionlib.CommState.DONE:
            rospy.rostime.wallsleep(0.02)
            self.go_on()

    @staticmethod
    def go_on():
        """After each wait: what ends the node ends its waits, too."""
        if rospy.is_shutdown():
            raise rospy.ROSInterruptException("stopped")

    def record(self, bag):
        """Begins; what is measured after this is in the bag."""
        recorder = subprocess.Popen([os.path.join(os.path.dirname(os.path.realpath(__file__)), "session_recorder.py"), bag, "__name:=record"])
        begun = []
        heard = rospy.Subscriber("record/recording", String, begun.append)
        while not begun:
            self.go_on()
            if recorder.poll() is not None:
                raise RuntimeError("the session is not recorded: session_recorder.py ended with status %d" % recorder.returncode)
            rospy.rostime.wallsleep(0.02)
        heard.unregister()
        return recorder

    def run(self):
        shutil.rmtree(os.path.join(self.folder, "calibrations"), ignore_errors=True)
        os.makedirs(self.folder, exist_ok=True)
        bag = os.path.join(self.folder, "session.bag")
        rospy.wait_for_service("axis_driver/home", 30)
        home = rospy.ServiceProxy("axis_driver/home", Trigger)()
        if not home.success:
            raise RuntimeError("homing: " + home.message)
        recorder = self.record(bag)
        try:
            self.measure.wait_for_server()
            self.measure.send_goal(MeasureGoal(plan=self.plan), feedback_cb=self.tell)
            self.end_of(self.measure)
            result = self.measure.get_result()
            if self.measure.get_state() != actionlib.GoalStatus.SUCCEEDED:
                raise RuntimeError("measurement: " + result.message)
        finally:
            if recorder.poll() is None:
                recorder.send_signal(signal.SIGINT)
            recorder.wait(30)
        print("measured: %d contacts, %d missed; recorded as %s" % (result.contacts, result.missed, bag), flush=True)
        before = self.errors_at_checks("probe_tip")
        rospy.wait_for_service("calibration_server/calibrate", 30)
        calibrate = rospy.ServiceProxy("calibration_server/calibrate", Calibrate)
        live = calibrate(bag="", model=self.model, seed=1)
        answer = calibrate(bag=bag, model=self.model, seed=1)
        same = without_seconds(live.json) == without_seconds(answer.json)
        print("live session and bag give %s" % ("the same to the bit" if same else "different results"), flush=True)
        print("calibrate: %s" % answer.message, flush=True)
        if not answer.success:
            raise RuntimeError("calibration failed")
        if not same:
            raise RuntimeError("the bag is not the session that was measured: " + (live.message if not live.success else answer.message))
        with open(os.path.join(self.folder, "calibration.json"), "w") as out:
            out.write(answer.json + "\n")
        promoted = rospy.ServiceProxy("calibration_server/promote", Promote)()
        print("promote: %s" % promoted.message, flush=True)
        after = self.errors_at_checks("probe_tip_corrected")
        print("error of the frame against the simulated truth at %d fresh points:" % self.checks)
        print("  before (probe_tip)            RMS %7.2f um, largest %7.2f um" % before)
        print("  after  (probe_tip_corrected)  RMS %7.2f um, largest %7.2f um" % after, flush=True)
        if not after[0] < before[0]:
            raise RuntimeError("the corrected frame is no better than the nominal one")

    @staticmethod
    def tell(feedback):
        if feedback.move % 100 == 0:
            print("move %d of %d, %d contacts" % (feedback.move, feedback.moves, feedback.contacts), flush=True)


def main():
    """roslaunch itself always ends with 0, so the last line and the file `result` in the folder say how it went."""
    rospy.init_node("demo")
    # actionlib says so of the last status of each goal that has ended; nothing is lost
    logging.getLogger("rosout").addFilter(lambda said: "not tracking" not in said.getMessage())
    arguments = rospy.myargv()[1:]
    result = os.path.join(arguments[0], "result")
    try:
        if os.path.exists(result):
            os.remove(result)
        Demo(*arguments).run()
        said, status = "passed", 0
    except (KeyboardInterrupt, rospy.ROSInterruptException):
        said, status = "stopped", 130
    except (RuntimeError, rospy.ROSException, rospy.ServiceException, OSError) as error:
        said, status = "FAILED: %s" % " ".join(str(error).split()), 1
        if rospy.is_shutdown():  # Ctrl-C, in the middle of a call
            said, status = "stopped", 130
    print("demo: " + said, file=sys.stderr if status else sys.stdout, flush=True)
    os.makedirs(arguments[0], exist_ok=True)
    with open(result, "w") as out:
        out.write(said + "\n")
    return status


if __name__ == "__main__":
    sys.exit(main())
