#!/usr/bin/env python3
"""Two machines in namespaces: a probe that never trips and one that is stuck are noticed, and no contact is made up."""
import os
import unittest

import actionlib
import rospy
import rostest
from actionlib_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticArray
from measuring_machine.msg import MeasureAction, MeasureGoal, ProbeContact
from std_srvs.srv import Trigger

import support

PLAN = os.path.join(support.PACKAGE, "test/ros/short_plan.yaml")


class ProbeFaults(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.said, cls.contacts = [], []
        rospy.Subscriber("/diagnostics", DiagnosticArray, lambda m: cls.said.extend((s.name, s.message) for s in m.status))
        for machine in ("m1", "m2"):
            rospy.Subscriber("/%s/probe/contact" % machine, ProbeContact, cls.contacts.append)

    @classmethod
    def tearDownClass(cls):
        support.remove(os.path.dirname(rospy.get_param("/m1/compensation/store")))

    def measure(self, machine):
        home = "/%s/axis_driver/home" % machine
        rospy.wait_for_service(home, 20)
        self.assertTrue(rospy.ServiceProxy(home, Trigger)().success)
        client = actionlib.SimpleActionClient("/%s/measure/run" % machine, MeasureAction)
        self.assertTrue(support.served(client, seconds=20))
        client.send_goal(MeasureGoal(plan=PLAN))
        self.assertTrue(support.ended(client, 60))
        self.assertEqual(client.get_state(), GoalStatus.ABORTED)
        return client.get_result().message

    def expect_diagnostics(self, machine, words):
        self.assertTrue(support.wait_until(lambda: any(machine in n and words in m for n, m in self.said), 10),
                        sorted(set(self.said)))

    def test_a_probe_that_never_trips(self):
        frames = support.Frames("m1/x_slide", "m2/x_slide")
        message = self.measure("m1")
        self.assertIn("in a row without a contact", message)
        self.expect_diagnostics("m1", "the probe does not trigger")
        self.assertEqual(self.contacts, [])
        self.assertTrue(frames.of("m1/x_slide") and frames.of("m2/x_slide"))

    def test_a_probe_that_is_stuck(self):
        self.assertIn("the probe is closed before the probing move", self.measure("m2"))
        self.expect_diagnostics("m2", "the probe is stuck")
        self.assertEqual(self.contacts, [])


if __name__ == "__main__":
    rospy.init_node("probe_faults_test")
    rostest.rosrun("measuring_machine", "probe_faults", ProbeFaults)
