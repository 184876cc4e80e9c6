#!/usr/bin/env python3
"""Homing, limits, cancel, stop, emergency stop; a plan with pause, cancel and resume; contacts that are true."""
import math
import os
import re
import subprocess
import time
import unittest

import actionlib
import rosbag
import rospy
import rostest
from actionlib_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from measuring_machine.msg import AxisStatus, MeasureAction, MeasureGoal, MoveAction, MoveGoal, ProbeContact
from measuring_machine.srv import Calibrate
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import JointState, Temperature
from std_srvs.srv import SetBool, Trigger

import cycle_support
import support

PLAN = os.path.join(support.PACKAGE, "test/ros/short_plan.yaml")
CENTRE, DISTANCE = (0.005, 0.008, -0.002), 0.0049685  # m, of short_plan.yaml


class Instrument(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.axes = actionlib.SimpleActionClient("axis_driver/move", MoveAction)
        cls.measure = actionlib.SimpleActionClient("measure/run", MeasureAction)
        assert support.served(cls.axes, cls.measure, seconds=100)
        cls.joints = [None]
        cls.thrown_away = []  # what a node's action client did not listen to
        rospy.Subscriber("/rosout_agg", Log, lambda m: cls.thrown_away.append(m.msg) if m.name == "/measure" and "not tracking" in m.msg else None)
        rospy.Subscriber("joint_states", JointState, lambda m: cls.joints.__setitem__(0, m))
        cls.diagnostics = {}  # of each name the last level and message
        rospy.Subscriber("/diagnostics", DiagnosticArray,
                         lambda m: cls.diagnostics.update({s.name: (s.level, s.message) for s in m.status}))
        cls.status = []
        rospy.Subscriber("axis_driver/status", AxisStatus, cls.status.append)
        assert support.wait_until(lambda: cls.joints[0] and cls.status)

    @classmethod
    def tearDownClass(cls):
        support.remove(rospy.get_param("/compensation/store"))

    def call(self, name, kind=Trigger, *arguments):
        rospy.wait_for_service(name, 20)
        return rospy.ServiceProxy(name, kind)(*arguments)

    def start(self, position, **keys):
        self.feedback = []
        self.axes.send_goal(MoveGoal(name=["x", "y", "z"], position=position, **keys), feedback_cb=self.feedback.append)

    def end(self, seconds=20.0):
        self.assertTrue(support.wait_until(lambda: self.axes.get_state() not in (GoalStatus.PENDING, GoalStatus.ACTIVE), seconds))
        if self.axes.get_state() == GoalStatus.ABORTED:  # its text comes a moment later
            support.wait_until(self.axes.get_goal_status_text, 5.0)
        return self.axes.get_state(), self.axes.get_goal_status_text()

    def moves(self):
        return support.wait_until(lambda: any(abs(v) > 1e-4 for v in self.joints[0].velocity))

    def text(self):
        support.wait_until(self.measure.get_goal_status_text, 5.0)
        return self.measure.get_goal_status_text()

    def reports(self, name, level, words, seconds=10):
        """A status of /diagnostics with this name, level, and words that its message matches."""
        def said():
            found = self.diagnostics.get(name, (None, ""))
            return found[0] == level and re.search(words, found[1])

        self.assertTrue(support.wait_until(said, seconds), "%s: %s" % (name, self.diagnostics.get(name)))

    def test_1_no_motion_before_homing(self):
        self.reports("measure: plan", DiagnosticStatus.OK, "^ready$")
        self.reports("calibration_server: session", DiagnosticStatus.OK, "^ready$")
        self.start([0.0, 0.0, 0.01])
        state, text = self.end()
        self.assertEqual(state, GoalStatus.ABORTED)
        self.assertIn("not homed", text)
        self.assertTrue(self.call("axis_driver/home").success)

    def test_2_limits_of_the_urdf(self):
        for position, words in (([0.021, 0, 0], "joint x: target 21 mm"), ([0, 0, math.nan], "not a number")):
            self.start(position)
            state, text = self.end()
            self.assertEqual(state, GoalStatus.ABORTED)
            self.assertIn(words, text)
        self.axes.send_goal(MoveGoal(name=["w"], position=[0.0]))
        self.assertIn("'w' is not moved", self.end()[1])

    def test_3_progress_cancel_stop(self):
        self.start([0.0, 0.0, 0.010])
        self.assertEqual(self.end()[0], GoalStatus.SUCCEEDED)
        self.assertAlmostEqual(self.joints[0].position[2], 0.010, delta=1e-12)
        self.start([0.015, 0.0, 0.010], linear_speed=0.002)
        self.assertTrue(support.wait_until(lambda: len(self.feedback) > 2))
        shares = [f.progress for f in self.feedback]
        self.assertEqual(shares, sorted(shares))
        self.axes.cancel_goal()
        self.assertEqual(self.end()[0], GoalStatus.PREEMPTED)
        self.assertTrue(0.0 < self.joints[0].position[0] < 0.014)
        self.start([0.015, 0.0, 0.010], linear_speed=0.002)
        self.assertTrue(self.moves())
        self.assertTrue(self.call("axis_driver/stop").success)
        state, text = self.end()
        self.assertEqual(state, GoalStatus.ABORTED)
        self.assertIn("stopped", text)

    def test_4_emergency_stop_needs_homing(self):
        self.start([-0.015, 0.0, 0.010], linear_speed=0.002)
        self.assertTrue(self.moves())
        self.call("axis_driver/emergency_stop", SetBool, True)
        self.assertIn("emergency stop", self.end()[1])
        self.assertFalse(self.call("axis_driver/home").success)
        self.call("axis_driver/emergency_stop", SetBool, False)
        self.start([0.0, 0.0, 0.010])
        self.assertIn("not homed", self.end()[1])
        self.assertTrue(self.call("axis_driver/home").success)

    def test_5b_a_plan_asks_for_a_placement(self):
        contacts, told = [], []
        with open(PLAN) as f:
            plan = f.read() + "placements: [{name: flat}, {name: again}]\n"
        rospy.Subscriber("probe/contact", ProbeContact, contacts.append)
        self.measure.send_goal(MeasureGoal(plan=plan), feedback_cb=told.append)
        self.assertTrue(support.wait_until(lambda: told and told[-1].asks, 60))
        self.assertIn("placement 'again'", told[-1].asks)
        self.assertTrue(told[-1].paused)
        self.assertEqual({c.placement for c in contacts}, {"flat"})
        self.call("measure/pause", SetBool, False)
        self.assertTrue(support.wait_until(lambda: self.measure.get_state() == GoalStatus.SUCCEEDED, 60))
        self.assertEqual({c.placement for c in contacts}, {"flat", "again"})

    def test_5_a_plan_with_pause_cancel_and_resume(self):
        contacts, temperatures, told = [], [], []
        with open(PLAN) as f:  # long enough for a status, which comes twice a second
            plan = f.read().replace("points: 8", "points: 32")
        rospy.Subscriber("probe/contact", ProbeContact, contacts.append)
        rospy.Subscriber("temperature/bed", Temperature, temperatures.append)
        self.measure.send_goal(MeasureGoal(plan=plan), feedback_cb=told.append)
        self.assertTrue(support.wait_until(lambda: len(contacts) >= 2, 30))
        self.call("measure/pause", SetBool, True)
        self.assertTrue(support.wait_until(lambda: told[-1].paused))
        self.reports("measure: plan", DiagnosticStatus.OK, "^paused$")
        self.assertTrue(support.wait_until(lambda: len(contacts) >= told[-1].contacts))
        held = len(contacts)
        time.sleep(1.0)
        self.assertEqual(len(contacts), held)
        self.call("measure/pause", SetBool, False)
        self.reports("measure: plan", DiagnosticStatus.OK, "^measuring$")
        self.assertTrue(support.wait_until(lambda: len(contacts) >= held + 2, 30))
        self.measure.cancel_goal()
        self.assertTrue(support.wait_until(lambda: self.measure.get_state() == GoalStatus.PREEMPTED, 30))
        self.assertTrue(support.wait_until(lambda: self.measure.get_result() and self.measure.get_result().message))
        result = self.measure.get_result()
        self.assertIn("cancelled", result.message)
        self.measure.send_goal(MeasureGoal(plan=plan, first=result.next))
        self.assertTrue(support.wait_until(lambda: self.measure.get_state() == GoalStatus.SUCCEEDED, 40),
                        self.measure.get_goal_status_text())
        self.assertTrue(support.wait_until(lambda: len(contacts) >= 32))
        self.assertLessEqual(len(contacts), 33)  # the one that was cancelled may be touched twice
        self.assertTrue(temperatures)
        for c in contacts:
            self.assertEqual((c.feature, c.name), ("b0", ["x", "y", "z"]))
            away = math.dist(c.position, CENTRE)
            self.assertAlmostEqual(away, DISTANCE, delta=3e-6)  # repeatability 0.3 um, 1 mm of trigger delay: none
            inward = [(q - p) / away for p, q in zip(c.position, CENTRE)]
            approach = (c.approach.x, c.approach.y, c.approach.z)
            self.assertGreater(sum(a * b for a, b in zip(inward, approach)), 0.99)
            self.assertAlmostEqual(math.hypot(*c.velocity), 0.003, delta=1e-6)
        live = self.call("calibration_server/calibrate", Calibrate, "", support.model("{type: probe_radius}"), "least_squares", 1)
        self.assertTrue(live.calibration_id, live.message)
        self.assertIn('"observations": %d' % len(contacts), live.json)

    def test_5_a_cancel_on_the_ball_leaves_it(self):
        for turn in range(4 if support.thorough_tests() else 2):
            told = []
            hurried = rospy.Subscriber("probe/contact", ProbeContact, lambda c: told or told.append(c) or self.measure.cancel_goal())
            self.measure.send_goal(MeasureGoal(plan=PLAN, first=turn))
            self.assertTrue(support.wait_until(lambda: self.measure.get_state() == GoalStatus.PREEMPTED, 30),
                            self.measure.get_goal_status_text())
            hurried.unregister()
            self.assertTrue(support.wait_until(lambda: not self.status[-1].probe_closed, 5), "turn %d" % turn)

    def test_5_one_bad_message_is_set_aside_by_name(self):
        listeners = rospy.Publisher("probe/contact", ProbeContact, queue_size=10), rospy.Publisher("temperature/bed", Temperature, queue_size=10)
        self.assertTrue(all(support.wait_until(lambda p=p: p.get_num_connections() >= 2) for p in listeners))
        bad = ProbeContact(name=["x", "y", "z"], position=[math.nan, 0.0, 0.0], laser_reading=math.nan, feature="b0")
        bad.header.stamp = rospy.Time.now()
        listeners[0].publish(bad)
        def both():
            listeners[1].publish(Temperature(temperature=20.0))  # without a stamp; again, until the server listens
            return self.call("calibration_server/calibrate", Calibrate, "", support.model("{type: probe_radius}"), "least_squares", 1).message

        self.assertTrue(support.wait_until(lambda: re.search("[0-9]+ are set aside", both())), both())
        message = both()
        self.assertIn("candidate ", message)
        self.assertRegex(message, "/probe/contact message [0-9]+ is set aside: the reading of joint 'x' is not a number"
                                  "|/temperature/bed message [0-9]+ is set aside: its header has no stamp")
        self.reports("calibration_server: session", DiagnosticStatus.WARN, "^[0-9]+ set aside, the last: /")

    def test_5_one_contact_of_another_time_costs_no_other(self):
        """Ten minutes behind: in the live session, too, it is one bad contact, and no clock that went back."""
        def answer():
            return self.call("calibration_server/calibrate", Calibrate, "", support.model("{type: probe_radius}"), "least_squares", 1)

        def count(text, pattern):
            found = re.search(pattern, text)
            return int(found.group(1)) if found else 0

        contacts = rospy.Publisher("probe/contact", ProbeContact, queue_size=10)
        self.assertTrue(support.wait_until(lambda: contacts.get_num_connections() >= 2))
        before = answer()
        there = [CENTRE[0], CENTRE[1], CENTRE[2] + DISTANCE]
        late = ProbeContact(name=["x", "y", "z"], position=there, laser_reading=math.nan, feature="b0")
        late.header.stamp = rospy.Time.now() - rospy.Duration(600)
        contacts.publish(late)
        wrong = ProbeContact(name=["x", "y", "z"], position=[math.nan, 0.0, 0.0], laser_reading=math.nan, feature="b0")
        wrong.header.stamp = rospy.Time.now()
        contacts.publish(wrong)  # when this one is there the other is
        aside = "([0-9]+) (?:is|are) set aside"
        self.assertTrue(support.wait_until(lambda: count(answer().message, aside) > count(before.message, aside)), before.message)
        pattern = '"observations": ([0-9]+)'
        self.assertGreaterEqual(count(answer().json, pattern), count(before.json, pattern))

    def test_5_the_server_is_started_again_in_the_middle(self):
        """It answers with what it has, and says how much that is; the plan can be gone on with."""
        told = []
        self.measure.send_goal(MeasureGoal(plan=PLAN), feedback_cb=told.append)
        self.assertTrue(support.wait_until(lambda: told and told[-1].contacts >= 3, 30))
        support.kill("/calibration_server")
        self.assertTrue(support.wait_until(lambda: self.measure.get_state() == GoalStatus.SUCCEEDED, 40),
                        self.measure.get_goal_status_text())

        def live():
            try:
                return self.call("calibration_server/calibrate", Calibrate, "", support.model("{type: probe_radius}"), "least_squares", 1)
            except rospy.ServiceException:
                return None  # still the one that died

        self.assertTrue(support.wait_until(lambda: live() is not None, 20))
        # The plan once more from its second move: what is measured now belongs to the same session.
        self.measure.send_goal(MeasureGoal(plan=PLAN, first=1))
        self.assertTrue(support.wait_until(lambda: self.measure.get_state() == GoalStatus.SUCCEEDED, 40),
                        self.measure.get_goal_status_text())
        answers = []
        self.assertTrue(support.wait_until(lambda: answers.append(live()) or answers[-1].calibration_id, 20), answers[-1].message)
        found = re.search("([0-9]+) of ([0-9]+) measured contacts were received", answers[-1].message)
        self.assertTrue(found, answers[-1].message)
        here, of = int(found.group(1)), int(found.group(2))
        self.assertTrue(3 <= here < of and 14 <= of <= 18, answers[-1].message)
        self.assertIn('"observations": %d' % here, answers[-1].json)

    def test_6_plans_that_cannot_be_run(self):
        for plan, words in (("/nowhere.yaml", "/nowhere.yaml"), ("", "names no plan"),
                            (os.path.join(support.PACKAGE, "config/plans/interferometer.yaml"), "independent instrument")):
            self.measure.send_goal(MeasureGoal(plan=plan))
            self.assertTrue(support.wait_until(lambda: self.measure.get_state() == GoalStatus.ABORTED))
            self.assertIn(words, self.text())
            self.reports("measure: plan", DiagnosticStatus.ERROR, "^the last plan: .*" + words)

    def test_7_the_axis_driver_dies_in_the_middle(self):
        told = []
        self.measure.send_goal(MeasureGoal(plan=PLAN), feedback_cb=told.append)
        self.assertTrue(support.wait_until(lambda: any(f.contacts >= 1 for f in told), 30))
        support.kill("/axis_driver")
        self.assertTrue(support.wait_until(lambda: self.measure.get_state() == GoalStatus.ABORTED, 20))
        self.assertRegex(self.text(), "the axis driver has stopped|not homed")
        # roslaunch starts it again; nothing moves before it is homed.
        def homed():
            try:
                return self.call("axis_driver/home").success
            except rospy.ServiceException:
                return False  # still the one that died

        self.assertTrue(support.wait_until(homed, 20))

    def test_6_a_plan_that_goes_on_in_a_recording_of_its_own(self):
        """Before the driver dies, with which the simulated clock goes back: a goal that is older than the last is none."""
        told = []
        self.measure.send_goal(MeasureGoal(plan=PLAN), feedback_cb=told.append)
        self.assertTrue(support.wait_until(lambda: told and told[-1].contacts >= 3, 30), self.measure.get_goal_status_text())
        self.measure.cancel_goal()
        self.assertTrue(support.wait_until(lambda: self.measure.get_state() == GoalStatus.PREEMPTED, 30))
        support.kill("/measure")  # what it had published once and for all has gone with it
        self.assertTrue(support.served(actionlib.SimpleActionClient("measure/run", MeasureAction)))
        folder = support.folder()
        self.addCleanup(support.remove, folder)
        bag = os.path.join(folder, "second.bag")
        cycle_support.record(PLAN, bag, 40, first=told[-1].move)
        checked = subprocess.run([support.node("mm"), "check", bag], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.assertEqual(checked.returncode, 0, checked.stdout)
        self.assertRegex(checked.stdout, "b0")
        with rosbag.Bag(bag) as recorded:
            stated = [m.data for _, m, _ in recorded.read_messages("/controller_compensation")]
        self.assertTrue(stated and stated[-1] == '{"stated":"none"}', stated)

    def test_9_no_answer_was_thrown_away(self):
        self.assertEqual(self.thrown_away, [])


if __name__ == "__main__":
    rospy.init_node("instrument_test")
    rostest.rosrun("measuring_machine", "instrument", Instrument)
