#!/usr/bin/env python3
"""A node whose parameters are wrong says so and stays, instead of being started again and again; with right ones it starts."""
import unittest

import rosgraph
import rospy
import rostest
import xmlrpc.client
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from sensor_msgs.msg import JointState

import support

DRIVER = "/axis_driver"


def process():
    try:
        return xmlrpc.client.ServerProxy(rosgraph.Master("/test").lookupNode(DRIVER)).getPid("/test")[2]
    except (rosgraph.MasterException, OSError):
        return None


class WrongParameter(unittest.TestCase):
    def test_it_stays_in_error_until_it_is_set_right(self):
        errors, joints = [], []

        def take(message):
            errors.extend(s for s in message.status if s.name == "axis_driver: parameters" and s.level == DiagnosticStatus.ERROR)

        rospy.Subscriber("/diagnostics", DiagnosticArray, take, queue_size=None)
        rospy.Subscriber("joint_states", JointState, joints.append, queue_size=None)
        self.assertTrue(support.wait_until(lambda: errors, 60), "the error stands in /diagnostics")
        self.assertIn("backlsh", errors[0].message)
        self.assertIn("backlash", errors[0].message, "what was meant")
        first = process()
        self.assertIsNotNone(first)
        self.assertTrue(support.wait_until(lambda: len(errors) >= 5, 60), "it is still said")
        self.assertEqual(process(), first, "the same process: it was not started again")
        self.assertFalse(joints)
        rospy.set_param(DRIVER + "/controller/hide", "backlash:x=3um")
        self.assertTrue(support.wait_until(lambda: joints, 60), "with a right parameter it starts")


if __name__ == "__main__":
    rospy.init_node("wrong_parameter_test")
    rostest.rosrun("measuring_machine", "wrong_parameter", WrongParameter)
