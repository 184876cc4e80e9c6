#!/usr/bin/env python3
"""A goal that goes out as its connection is cut is heard by nobody: no status will name it, and no end of it will come."""
import os
import unittest

import actionlib
import rospy
import rostest
from actionlib_msgs.msg import GoalID, GoalStatusArray
from measuring_machine.msg import AxisStatus, MeasureAction, MeasureGoal, MotionStatus, MoveActionFeedback, MoveActionGoal, MoveActionResult
from measuring_machine.srv import TakeMotion, TakeMotionResponse

import support

SOON = 10.0  # s; the goal is lost after 2 s, without that the plan waits for ever


class DeafDriver:
    """Says everything that an axis driver says, and of no goal that it has come."""

    def __init__(self):
        self.goals, self.given = [], 0
        self.status = rospy.Publisher("axis_driver/status", AxisStatus, queue_size=1, latch=True)
        self.motion = rospy.Publisher("axis_driver/motion", MotionStatus, queue_size=1, latch=True)
        self.heard = rospy.Publisher("axis_driver/move/status", GoalStatusArray, queue_size=1)
        self.ends = [rospy.Publisher("axis_driver/move/feedback", MoveActionFeedback, queue_size=1),
                     rospy.Publisher("axis_driver/move/result", MoveActionResult, queue_size=1)]
        rospy.Subscriber("axis_driver/move/goal", MoveActionGoal, self.goals.append)
        rospy.Subscriber("axis_driver/move/cancel", GoalID, lambda _: None)
        rospy.Service("axis_driver/take", TakeMotion, self.take)
        self.status.publish(AxisStatus(homed=True, name=["x", "y", "z"], travel=[0, 0, 0]))
        self.motion.publish(MotionStatus())
        rospy.Timer(rospy.Duration(0.2), lambda _: self.heard.publish(GoalStatusArray()))

    def take(self, request):
        self.given += request.seconds == 0.0
        return TakeMotionResponse(success=True, ticket=1)


class Unheard(unittest.TestCase):
    def test_a_goal_that_nobody_heard_ends_its_plan_and_not_the_next(self):
        driver = DeafDriver()
        measure = actionlib.SimpleActionClient("measure/run", MeasureAction)
        self.assertTrue(support.served(measure))
        for number in (1, 2):
            measure.send_goal(MeasureGoal(plan=os.path.join(support.PACKAGE, "test/ros/short_plan.yaml")))
            self.assertTrue(support.ended(measure, SOON), "plan %d has no end" % number)
            self.assertIn("its connection was lost", measure.get_result().message)
            self.assertTrue(support.wait_until(lambda: len(driver.goals) == number))
            self.assertEqual(driver.given, number, "the axes are given back, which stops them")


if __name__ == "__main__":
    rospy.init_node("unheard_test")
    rostest.rosrun("measuring_machine", "unheard", Unheard)
