#!/usr/bin/env python3
"""The simulated driver is killed after a plan: simulated time does not go back, and the next plan runs on the nodes that are there."""
import os
import unittest

import actionlib
import rospy
import rostest
from measuring_machine.msg import MeasureAction, MeasureGoal
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

import support

PLAN = os.path.join(support.PACKAGE, "test/ros/short_plan.yaml")


class ClockRestart(unittest.TestCase):
    def measure(self):
        self.client.send_goal(MeasureGoal(plan=PLAN))
        self.assertTrue(support.ended(self.client, 60), "the plan neither ends nor fails")
        self.assertEqual(self.client.get_state(), actionlib.GoalStatus.SUCCEEDED, self.client.get_goal_status_text())
        self.assertEqual(self.client.get_result().contacts, 8)

    def test_plans_before_and_after(self):
        stamps, states = [], []
        clock = rospy.Subscriber("/clock", Clock, lambda m: stamps.append(m.clock.to_nsec()), queue_size=None)
        joints = rospy.Subscriber("joint_states", JointState, lambda m: states.append((m.header.frame_id, m.header.stamp)), queue_size=None)
        self.client = actionlib.SimpleActionClient("measure/run", MeasureAction)
        self.assertTrue(support.served(self.client))
        self.assertTrue(support.home_again())
        self.measure()
        measured = len(states)  # all of them homed until the driver dies
        support.kill("/axis_driver")
        self.assertTrue(support.wait_until(lambda: any(frame == "unhomed" for frame, _ in states[measured:]), 60), "it comes up again")
        first = next(i for i in range(measured, len(states)) if states[i][0] == "unhomed")
        self.assertGreater(states[first][1], states[first - 1][1], "the new life begins after the last stamp of the one before")
        self.assertTrue(support.home_again())
        self.measure()
        clock.unregister()
        joints.unregister()
        self.assertTrue(all(a <= b for a, b in zip(stamps, stamps[1:])), "time does not go back")


if __name__ == "__main__":
    rospy.init_node("clock_restart_test")
    rostest.rosrun("measuring_machine", "clock_restart", ClockRestart)
