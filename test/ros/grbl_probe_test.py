#!/usr/bin/env python3
"""What the nodes make of the probe's switch at a controller: no contact is made up where it chatters, is stuck or dead; a stop at a
collision; and after all of it the machine measures again."""
import math
import os
import unittest

import actionlib
import rospy
import rostest
from actionlib_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticArray
from measuring_machine.msg import MeasureAction, MeasureGoal, MoveAction, MoveGoal, MoveResult, ProbeContact

import cycle_support
import support

PLAN, TOUCHES = "test/ros/grbl_plan.yaml", 8
CENTRE, DISTANCE, SCALE = (0.030, 0.030, 0.020), 0.009, (1.0005, 1.0, 1.0)  # m, of the double: ball and tip
ZERO = 0.040  # m: the double's scales count from its own zero, there on the joints


class GrblProbe(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.double, cls.contacts, cls.said = support.Double(25918), [], []
        cls.work = support.folder()
        cls.plan = support.shorter_plan(os.path.join(cls.work, "plan.yaml"), TOUCHES, PLAN)
        rospy.Subscriber("probe/contact", ProbeContact, cls.contacts.append)
        rospy.Subscriber("/diagnostics", DiagnosticArray, lambda m: cls.said.extend(s.message for s in m.status))
        cls.axes = actionlib.SimpleActionClient("axis_driver/move", MoveAction)
        cls.measure = actionlib.SimpleActionClient("measure/run", MeasureAction)
        assert support.served(cls.axes, cls.measure, seconds=60)

    @classmethod
    def tearDownClass(cls):
        support.remove(cls.work)
        support.remove(rospy.get_param("/compensation/store"))

    def setUp(self):
        self.double.tell("probe ok")
        cycle_support.ready()
        self.contacts.clear()
        self.said.clear()

    def run_plan(self):
        self.measure.send_goal(MeasureGoal(plan=self.plan))
        self.assertTrue(support.ended(self.measure, 90))
        return self.measure.get_state(), self.measure.get_result()

    def rests(self):
        self.assertTrue(support.wait_until(lambda: not self.double.tell("machine")["moving"], 5))

    def chattering_plan(self):
        """@return its contacts: each touch has one at most, on the ball, and what is missed is said."""
        self.contacts.clear()
        self.said.clear()
        state, result = self.run_plan()
        print("chatter: %d contacts, %d missed: %s" % (result.contacts, result.missed, result.message))
        # A touch that does not settle is tried again and set aside, a way back that the switch ends is begun again: the plan goes on,
        # unless several touches in a row have no contact.
        if state != GoalStatus.SUCCEEDED:
            self.assertIn("in a row without a contact", result.message)
        else:
            self.assertEqual(result.contacts + result.missed, TOUCHES, result.message)
        # Where the switch closes is by chance: now and then it is no touch that meets it. What is missed is said.
        if result.contacts < TOUCHES:
            self.assertRegex(result.message, "tried again|set aside|closed again on the way back|in a row without a contact")
        if result.contacts == 0:
            self.assertTrue(support.wait_until(lambda: any("the probe opened again at once" in s for s in self.said)), set(self.said))
        support.wait_until(lambda: len(self.contacts) >= result.contacts, 10)  # they come beside the result
        self.assertEqual(len(self.contacts), result.contacts, "each touch is one contact at most, however often the switch closes")
        self.rests()
        for contact in self.contacts:
            at = dict(zip(contact.name, contact.position))
            away = math.sqrt(sum(((at[j] - ZERO) * k + ZERO - c) ** 2 for j, c, k in zip("xyz", CENTRE, SCALE)))
            # 0.5 um a millisecond of approach, and a closure in some of those
            self.assertLess(abs(away - DISTANCE), 15e-6, contact)
        return result.contacts

    def away_from_the_ball(self):
        """Where a plan has given up."""
        self.double.tell("probe ok")
        self.axes.send_goal(MoveGoal(name=["z"], position=[0.031], linear_speed=0.005))
        self.assertTrue(support.ended(self.axes, 30), "%s %s" % (self.double.tell("machine"), self.said[-9:]))

    def test_1_a_switch_that_chatters(self):
        # On a busy computer the first closing and the opening behind it are heard together, touch after touch: no contact is made up
        # of those. But a switch that is closed half of the time is a contact sooner or later.
        for _ in range(5):
            self.double.tell("probe chatter")
            if self.chattering_plan() > 0:
                return
            self.away_from_the_ball()
        self.fail("no contact in five plans")

    def test_2_closed_already(self):
        self.double.tell("probe stuck")
        state, result = self.run_plan()
        print("stuck: " + result.message)
        self.assertEqual((state, result.contacts), (GoalStatus.ABORTED, 0))
        self.assertEqual(self.contacts, [])
        self.rests()

    def test_3_never_closed(self):
        self.double.tell("probe dead")
        state, result = self.run_plan()
        print("dead: " + result.message)
        self.assertEqual((state, result.contacts), (GoalStatus.ABORTED, 0))
        self.assertIn("in a row without a contact", result.message)
        self.assertEqual(self.contacts, [])
        self.rests()

    def test_4_a_collision(self):
        self.axes.send_goal(MoveGoal(name=["x", "y", "z"], position=[0.030, 0.030, 0.031], linear_speed=0.02))
        self.assertTrue(support.ended(self.axes, 30))
        self.assertEqual(self.axes.get_result().outcome, MoveResult.REACHED, self.axes.get_result().message)
        self.axes.send_goal(MoveGoal(name=["z"], position=[0.020], linear_speed=0.005))
        self.assertTrue(support.ended(self.axes, 30))
        result = self.axes.get_result()
        print("collision: %s; went %.3f mm into the ball" % (result.message, self.double.tell("machine")["deepest"]))
        self.assertEqual(result.outcome, MoveResult.TRIPPED, result.message)
        self.assertLess(self.double.tell("machine")["depth"], 0.5)
        self.assertEqual(self.contacts, [], "a collision is no contact")
        self.rests()

    def test_5_and_it_measures_again(self):
        self.away_from_the_ball()
        state, result = self.run_plan()
        self.assertEqual((state, result.contacts, result.missed), (GoalStatus.SUCCEEDED, TOUCHES, 0), result.message)


if __name__ == "__main__":
    rospy.init_node("grbl_probe_test")
    rostest.rosrun("measuring_machine", "grbl_probe", GrblProbe)
