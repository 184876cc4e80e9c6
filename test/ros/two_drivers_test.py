#!/usr/bin/env python3
"""A machine on two controllers, of which one latches nothing: contacts while its joint rests, none while it moves."""
import unittest

import actionlib
import rospy
import rostest
from actionlib_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticArray
from measuring_machine.msg import AxisStatus, MoveAction, MoveGoal, MoveResult, ProbeContact
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

import support

DRIVERS = ("axis_driver", "z_driver")


class TwoDrivers(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.contacts, cls.said, cls.at, cls.moving = [], [], {}, {}
        rospy.Subscriber("probe/contact", ProbeContact, cls.contacts.append)
        rospy.Subscriber("/diagnostics", DiagnosticArray, lambda m: cls.said.extend(s.message for s in m.status))
        rospy.Subscriber("joint_states", JointState, lambda m: cls.at.update(zip(m.name, m.position)))
        rospy.Subscriber("z_driver/status", AxisStatus, lambda m: cls.moving.update(z=m.moving))
        cls.axes = {name: actionlib.SimpleActionClient(name + "/move", MoveAction) for name in DRIVERS}
        assert support.served(*cls.axes.values(), seconds=60)
        for name in DRIVERS:
            rospy.wait_for_service(name + "/home", 60)
            home, answers = rospy.ServiceProxy(name + "/home", Trigger), []
            assert support.wait_until(lambda: answers.append(home()) or answers[-1].success, 40), answers[-1].message

    def move(self, driver, wait=True, **keys):
        joints = {j: keys.pop(j) for j in "xyz" if j in keys}
        self.axes[driver].send_goal(MoveGoal(name=list(joints), position=list(joints.values()), **keys))
        if not wait:
            return None
        self.assertTrue(support.ended(self.axes[driver], 30))
        return self.axes[driver].get_result()

    def touch(self):
        """From beside the ball into it, along x."""
        result = self.move("axis_driver", x=0.006, y=0.0, linear_speed=0.02)
        self.assertEqual(result.outcome, MoveResult.REACHED, result.message)
        result = self.move("axis_driver", kind=MoveGoal.PROBE, x=0.015, linear_speed=0.001)
        self.assertEqual(result.outcome, MoveResult.TRIPPED, result.message)

    def test_1_a_joint_at_rest_is_where_it_says(self):
        result = self.move("z_driver", z=0.0125, linear_speed=0.01)
        self.assertEqual(result.outcome, MoveResult.REACHED, result.message)
        self.touch()
        self.assertTrue(support.wait_until(lambda: self.contacts, 5), sorted(set(self.said)))
        contact = self.contacts[0]
        self.assertEqual(contact.name, ["x", "y", "z"])
        self.assertAlmostEqual(contact.position[2], 0.0125, delta=1e-9)
        self.assertEqual(contact.velocity[2], 0.0)
        # the ball's centre is at x = 15 mm, its surface 6 mm before it with the tip's radius; both heights are the same
        self.assertAlmostEqual(contact.position[0], 0.009, delta=20e-6)
        self.assertGreater(contact.approach.x, 0.99)
        self.assertEqual(len(self.contacts), 1)

    def test_2_a_joint_in_motion_is_no_contact(self):
        self.contacts.clear()
        self.move("axis_driver", x=0.006, y=0.0, linear_speed=0.02)
        self.move("z_driver", wait=False, z=-0.0125, linear_speed=0.001)  # for 25 s
        self.assertTrue(support.wait_until(lambda: self.moving.get("z")))
        self.said.clear()
        self.touch()
        words = "joint 'z' was not latched, and it is not certain that it stood still: its driver reports that it is moving"
        self.assertTrue(support.wait_until(lambda: any(words in s for s in self.said)), sorted(set(self.said)))
        self.assertEqual(self.axes["z_driver"].get_state(), GoalStatus.ACTIVE, "it still moved then")
        self.assertEqual(self.contacts, [])


if __name__ == "__main__":
    rospy.init_node("two_drivers_test")
    rostest.rosrun("measuring_machine", "two_drivers", TwoDrivers)
