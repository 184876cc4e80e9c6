#!/usr/bin/env python3
"""Runs demo.launch: measure, record, calibrate by service, promote; the error against the simulated truth before and after."""
import json
import math
import os
import shutil
import signal
import subprocess
import sys
import threading

import actionlib
import rospy
from geometry_msgs.msg import PointStamped
from measuring_machine.msg import MeasureAction, MeasureGoal, MoveAction, MoveGoal, ReferenceMeasurement
from measuring_machine.srv import Calibrate, Promote
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage

TOPICS = (
    "/(joint_states|reference|artifact|robot_description|axis_driver/status|probe/contact|temperature/.*|covariate/.*)"
)
CLEAR = 0.0078  # m, z above every ball and within the calibrated volume
# Fresh points, m: none of them is a point of the plan; the low ones lie between the balls.
CHECKS = [(x, y, CLEAR) for x in (-0.015, 0.002, 0.014) for y in (-0.009, 0.011, 0.027)]
CHECKS += [(x, y, z) for x, y in ((0.0, -0.009), (0.001, 0.027), (-0.013, 0.010), (0.012, 0.009)) for z in (0.0, -0.006)]
FRAMES = ("probe_tip", "probe_tip_corrected")


def without_seconds(text):
    found = json.loads(text or "{}")
    found.get("genetic", {}).pop("seconds", None)
    return found


class Demo:
    def __init__(self, folder, plan, model):
        self.folder, self.plan, self.model = folder, plan, model
        self.lock = threading.Lock()
        self.truth, self.frames = {}, {frame: {} for frame in FRAMES}
        rospy.Subscriber("axis_driver/truth", PointStamped, self.take_truth, queue_size=1000)
        rospy.Subscriber("/tf", TFMessage, self.take_frames, queue_size=1000)
        self.axes = actionlib.SimpleActionClient("axis_driver/move", MoveAction)
        self.measure = actionlib.SimpleActionClient("measure/run", MeasureAction)

    def take_truth(self, message):
        with self.lock:
            self.truth[message.header.stamp] = (message.point.x, message.point.y, message.point.z)

    def take_frames(self, message):
        with self.lock:
            slides = {}
            for t in message.transforms:
                v = t.transform.translation
                if t.child_frame_id in FRAMES:
                    self.frames[t.child_frame_id][t.header.stamp] = (v.x, v.y, v.z)
                elif t.child_frame_id in ("x_slide", "y_slide", "z_slide"):
                    slides[t.child_frame_id] = (v.x, v.y, v.z)
            if len(slides) == 3:  # the nominal tip of three_axis sits on its last slide
                total = tuple(sum(values) for values in zip(*slides.values()))
                self.frames["probe_tip"][message.transforms[0].header.stamp] = total

    def errors_at_checks(self, frame):
        """RMS and largest distance between a frame and the true tip, um, over the fresh points."""
        errors = []
        for point in CHECKS:
            for names, position in ((["z"], [CLEAR]), (["x", "y"], point[:2]), (["z"], point[2:])):
                self.go(names, position)
            with self.lock:
                self.truth.clear()
                self.frames[frame].clear()
            errors.append(self.error_now(frame))
        return math.sqrt(sum(e * e for e in errors) / len(errors)), max(errors)

    def go(self, names, position):
        goal = MoveGoal(kind=MoveGoal.GO, name=names, position=list(position), linear_speed=0.02)
        self.axes.send_goal(goal)
        self.axes.wait_for_result()
        rospy.rostime.wallsleep(0.02)  # its last status may still be on the way
        if self.axes.get_state() != actionlib.GoalStatus.SUCCEEDED:
            raise RuntimeError("a check position was not reached: " + self.axes.get_goal_status_text())

    def error_now(self, frame):
        for _ in range(500):
            with self.lock:
                both = sorted(set(self.truth) & set(self.frames[frame]))
                if len(both) >= 3:
                    stamp = both[-1]
                    return 1e6 * math.dist(self.truth[stamp], self.frames[frame][stamp])
            rospy.rostime.wallsleep(0.02)
        raise RuntimeError("no frame '%s' arrives with the stamps of the joint states" % frame)

    def record(self, bag):
        recorder = subprocess.Popen(["rosbag", "record", "-q", "-O", bag, "-e", TOPICS, "__name:=record"])
        contacts = rospy.Publisher("reference", ReferenceMeasurement, queue_size=1)  # heard by whoever records a session
        for _ in range(500):
            if contacts.get_num_connections() >= 2:
                return recorder
            rospy.rostime.wallsleep(0.02)
        raise RuntimeError("rosbag record does not start")

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
            self.measure.wait_for_result()
            result = self.measure.get_result()
            if self.measure.get_state() != actionlib.GoalStatus.SUCCEEDED:
                raise RuntimeError("measurement: " + result.message)
        finally:
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
        with open(os.path.join(self.folder, "calibration.json"), "w") as out:
            out.write(answer.json + "\n")
        promoted = rospy.ServiceProxy("calibration_server/promote", Promote)()
        print("promote: %s" % promoted.message, flush=True)
        after = self.errors_at_checks("probe_tip_corrected")
        print("error of the frame against the simulated truth at %d fresh points:" % len(CHECKS))
        print("  before (probe_tip)            RMS %7.2f um, largest %7.2f um" % before)
        print("  after  (probe_tip_corrected)  RMS %7.2f um, largest %7.2f um" % after, flush=True)
        return 0 if after[0] < before[0] else 1

    @staticmethod
    def tell(feedback):
        if feedback.move % 100 == 0:
            print("move %d of %d, %d contacts" % (feedback.move, feedback.moves, feedback.contacts), flush=True)


if __name__ == "__main__":
    rospy.init_node("demo")
    try:
        status = Demo(*rospy.myargv()[1:]).run()
    except (RuntimeError, rospy.ROSException) as error:
        print("demo: %s" % error, file=sys.stderr)
        status = 1
    sys.exit(status)
