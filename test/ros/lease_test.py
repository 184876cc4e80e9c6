#!/usr/bin/env python3
"""Whoever moves the axes is killed, stands still, or does not renew: they rest within a second, and it is said why."""
import os
import signal
import subprocess
import sys
import time
import unittest
import xmlrpc.client

import actionlib
import rosgraph
import rospy
import rostest
from measuring_machine.msg import HomeAction, HomeGoal, MeasureAction, MeasureGoal, MotionStatus, MoveAction, MoveActionGoal, MoveGoal
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

import support

REST = 1.0         # s from the end of whoever moves to rest
MOVE = """
import actionlib, rospy, sys
from measuring_machine.msg import HomeAction, HomeGoal, MoveAction, MoveGoal
rospy.init_node("mover", anonymous=True)
client = actionlib.SimpleActionClient("axis_driver/" + sys.argv[1], HomeAction if sys.argv[1] == "home" else MoveAction)
client.wait_for_server()
client.send_goal(HomeGoal() if sys.argv[1] == "home" else MoveGoal(name=["x"], position=[0.019], linear_speed=0.001))
rospy.spin()
"""
PLAN = """
name: slow
artifact: {name: none, pose: known, probe: {tip_radius_mm: 1.0}, balls: [{name: b0, centre_mm: [5.0, 8.0, -2.0], radius_mm: 3.9685}]}
speeds: {rapid_mm_s: 1, approach_mm_s: 1}
moves:
  - {x_mm: 19.0, y_mm: 0.0, z_mm: 10.0}
  - {x_mm: 5.0, y_mm: 8.0, z_mm: 5.0, feature: b0}
"""


LATE = """
import time, rospy
from actionlib_msgs.msg import GoalStatusArray
from measuring_machine.msg import MoveActionGoal, MoveActionResult, MoveGoal, MoveResult
rospy.init_node("late")
results = []
rospy.Subscriber("axis_driver/move/result", MoveActionResult, results.append)
out = rospy.Publisher("axis_driver/move/goal", MoveActionGoal, queue_size=1)
while out.get_num_connections() == 0:
    time.sleep(0.01)
goal = MoveActionGoal(goal=MoveGoal(name=["x"], position=[0.01]))
goal.goal_id.id = "/late-1-1.0"
out.publish(goal)
time.sleep(0.4)  # its goal is there before it listens
rospy.Subscriber("axis_driver/move/status", GoalStatusArray, lambda status: None)
while not results:
    time.sleep(0.01)
result = results[0].result
print("reached" if result.outcome == MoveResult.REACHED else result.message)
"""


class Lease(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.move = actionlib.SimpleActionClient("axis_driver/move", MoveAction)
        cls.homing = actionlib.SimpleActionClient("axis_driver/home", HomeAction)
        cls.measure = actionlib.SimpleActionClient("measure/run", MeasureAction)
        assert support.served(cls.move, cls.measure, cls.homing, seconds=60)
        cls.motion, cls.moved, cls.heard, cls.place = [], 0.0, 0.0, None
        rospy.Subscriber("joint_states", JointState, cls.take, queue_size=None, tcp_nodelay=True)
        rospy.Subscriber("axis_driver/motion", MotionStatus, cls.motion.append)
        assert support.wait_until(lambda: cls.place is not None and cls.motion)

    @classmethod
    def tearDownClass(cls):
        support.remove(rospy.get_param("/compensation/store"))

    @classmethod
    def take(cls, joints):
        """`moved`: when the axes were last seen elsewhere than before, on the clock of this process."""
        cls.heard = time.monotonic()
        if cls.place != joints.position:
            cls.moved = cls.heard
        cls.place = joints.position

    def moving(self, who):
        """His motion is under way, not the end of the homing before it."""
        self.assertTrue(support.wait_until(lambda: who in self.motion[-1].owner, 20), "it is not his")
        began = time.monotonic()
        self.assertTrue(support.wait_until(lambda: self.moved > began, 20), "it does not move")

    def rests(self, since):
        """From then on within a second, and for good."""
        self.assertTrue(support.wait_until(lambda: self.heard - max(self.moved, since) > 1.0, 10), "it moves on")
        print("%s: at rest after %.3f s" % (self.id().split(".")[-1], max(0.0, self.moved - since)))
        self.assertLess(self.moved - since, REST)
        self.assertFalse(self.motion[-1].homing)

    def home(self):
        self.homing.send_goal(HomeGoal())
        self.assertTrue(support.ended(self.homing, 60))
        self.assertEqual(self.homing.get_result().message, "homed")

    def mover(self, what):
        process = subprocess.Popen([sys.executable, "-c", MOVE, what])
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        self.moving("/mover")
        return process

    def start_plan(self, **keys):
        self.home()
        self.measure.send_goal(MeasureGoal(plan=PLAN, **keys))
        self.moving("/measure")

    def test_1_the_client_of_a_move_is_killed(self):
        self.home()
        process = self.mover("move")
        process.kill()
        self.rests(time.monotonic())
        self.home()

    def test_2_the_client_of_homing_is_killed(self):
        self.home()
        self.move.send_goal(MoveGoal(name=["x", "y", "z"], position=[0.019, 0.019, 0.019]))
        self.assertTrue(support.ended(self.move, 20))
        process = self.mover("home")
        process.kill()
        self.rests(time.monotonic())
        self.assertNotEqual(self.place[0], 0.0)

    def test_3_homing_is_cancelled(self):
        self.home()
        self.move.send_goal(MoveGoal(name=["x", "y", "z"], position=[0.019, 0.019, 0.019]))
        self.assertTrue(support.ended(self.move, 20))
        self.homing.send_goal(HomeGoal())
        self.moving("/lease")
        self.homing.cancel_goal()
        self.rests(time.monotonic())
        self.assertTrue(support.ended(self.homing, 5))
        self.assertIn("cancelled", self.homing.get_result().message)

    def pid(self, node):
        return xmlrpc.client.ServerProxy(rosgraph.Master("/test").lookupNode(node)).getPid("/test")[2]

    def another(self, node, pid):
        """Whether roslaunch has started the next one of that name."""
        try:
            return self.pid(node) != pid
        except (OSError, rosgraph.MasterError):
            return False  # the one that ended

    def test_4_measure_is_killed(self):
        self.start_plan()
        os.kill(self.pid("/measure"), signal.SIGKILL)
        self.rests(time.monotonic())
        self.assertTrue(support.wait_until(lambda: "measure (" not in self.motion[-1].owner))
        self.assertTrue(support.served(self.measure), "measure comes back")

    def test_5_measure_stands_still(self):
        self.start_plan()
        pid = self.pid("/measure")
        os.kill(pid, signal.SIGSTOP)
        began = time.monotonic()
        try:
            self.rests(began)
        finally:
            os.kill(pid, signal.SIGCONT)
        self.assertTrue(support.ended(self.measure, 10))
        self.assertIn("was not renewed for 0.5 s; continue from this move", self.measure.get_result().message)
        self.rests(began)  # and does not move on by itself

    def test_5b_the_driver_stands_still(self):
        self.home()
        self.mover("move")
        pid = self.pid("/axis_driver")
        os.kill(pid, signal.SIGSTOP)
        time.sleep(1.5)  # longer than a motion may go unwatched
        continues = time.monotonic()
        os.kill(pid, signal.SIGCONT)
        self.rests(continues)

    def test_6_whoever_began_a_plan_does_not_renew_it(self):
        rospy.wait_for_service("measure/renew", 20)
        renew = rospy.ServiceProxy("measure/renew", Trigger, persistent=True)
        self.start_plan(lease=0.5)
        until = time.monotonic() + 2.0
        while time.monotonic() < until:  # it goes on as long as it is renewed
            self.assertTrue(renew().success)
            time.sleep(0.05)
        self.moving("/measure")
        self.rests(time.monotonic())
        self.assertTrue(support.ended(self.measure, 5))
        self.assertIn("its client has not renewed the lease", self.measure.get_result().message)

    def test_7_measure_is_asked_to_end(self):
        for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGINT):
            self.assertTrue(support.served(self.measure))
            self.start_plan()
            pid = self.pid("/measure")
            os.kill(pid, number)
            self.rests(time.monotonic())
            self.assertTrue(support.wait_until(lambda: not os.path.exists("/proc/%d" % pid)), "it does not end")
            self.assertTrue(support.wait_until(lambda: self.another("/measure", pid), 60), "no other one begins")

    def test_8_a_goal_of_nobody_begins_nothing(self):
        self.home()
        out = rospy.Publisher("axis_driver/move/goal", MoveActionGoal, queue_size=1)
        results = []
        rospy.Subscriber("axis_driver/move/result", MoveAction().action_result.__class__, results.append)
        self.assertTrue(support.wait_until(lambda: out.get_num_connections() > 0))
        goal = MoveActionGoal(goal=MoveGoal(name=["x"], position=[0.01]))
        goal.goal_id.id = "/nobody-1-1.0"
        out.publish(goal)
        self.assertTrue(support.wait_until(lambda: results))
        self.assertIn("'/nobody', which requested the motion, does not subscribe", results[0].result.message)
        late = subprocess.run([sys.executable, "-c", LATE], capture_output=True, text=True, timeout=40)
        self.assertEqual(late.stdout.split("\n")[0], "reached", late)


if __name__ == "__main__":
    rospy.init_node("lease_test")
    rostest.rosrun("measuring_machine", "lease", Lease)
