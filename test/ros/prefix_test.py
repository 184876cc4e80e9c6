#!/usr/bin/env python3
"""With a prefix every header names a frame that is in the tree, and nothing else is in it."""
import os
import unittest

import actionlib
import dynamic_reconfigure.client
import rospy
import rostest
import tf2_ros
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PointStamped
from measuring_machine.msg import Artifact, CorrectedContact, MeasureAction, MeasureGoal, ProbeContact, ProbeLatch
from sensor_msgs.msg import JointState, Temperature
from std_srvs.srv import Trigger

import support

TOPICS = {"joint_states": JointState, "probe/contact": ProbeContact, "probe/contact_corrected": CorrectedContact,
          "axis_driver/latch": ProbeLatch, "axis_driver/truth": PointStamped, "artifact": Artifact, "temperature/bed": Temperature}


class Prefix(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = support.folder()
        cls.frames, cls.groups = {topic: set() for topic in TOPICS}, {}
        for topic, kind in TOPICS.items():
            rospy.Subscriber("/m1/" + topic, kind, lambda m, t=topic: cls.frames[t].add(m.header.frame_id), queue_size=None)
        rospy.Subscriber("/diagnostics_agg", DiagnosticArray, lambda m: cls.groups.update((s.name, s) for s in m.status))
        cls.buffer = tf2_ros.Buffer()
        cls.listener = tf2_ros.TransformListener(cls.buffer)
        cls.statuses = support.Statuses("/m1/compensation/status")

    @classmethod
    def tearDownClass(cls):
        support.remove(cls.folder)
        support.remove(rospy.get_param("/m1/compensation/store"))

    def test_1_every_header_names_a_frame_of_the_tree(self):
        rospy.wait_for_service("/m1/axis_driver/home", 30)
        self.assertTrue(rospy.ServiceProxy("/m1/axis_driver/home", Trigger)().success)
        bag = support.simulate(os.path.join(self.folder, "s.bag"))
        support.calibrate_and_promote(bag, support.model("{type: scale, axis: x}"), "/m1/calibration_server/")
        measure = actionlib.SimpleActionClient("/m1/measure/run", MeasureAction)
        self.assertTrue(support.served(measure))
        self.assertTrue(support.wait_until(lambda: self.statuses.last().publishing, 10), self.statuses.last())
        measure.send_goal(MeasureGoal(plan=os.path.join(support.PACKAGE, "test/ros/short_plan.yaml")))
        self.assertTrue(support.ended(measure, 60))
        self.assertTrue(measure.get_result().contacts > 0, measure.get_result())
        self.assertTrue(support.wait_until(lambda: all(self.frames.values()), 10), self.frames)
        named = set().union(*self.frames.values())
        self.assertEqual(named, {"m1/workpiece", "m1/unhomed"} if "m1/unhomed" in named else {"m1/workpiece"}, self.frames)
        for tip in ("probe_tip", "probe_tip_corrected"):
            self.assertTrue(support.wait_until(lambda: self.buffer.can_transform("m1/workpiece", "m1/" + tip, rospy.Time(0))), tip)

        def bare():
            return [name for name in self.buffer._getFrameStrings() if not name.startswith("m1/")]

        self.assertEqual(bare(), [])

    def test_2_diagnostics_are_a_tree(self):
        for group in ("Axes", "Probe", "Temperatures", "Plan", "Calibration", "Correction"):
            name = "/Measuring machine/" + group
            self.assertTrue(support.wait_until(lambda: name in self.groups and self.groups[name].values, 20), (name, sorted(self.groups)))

    def test_3_what_may_change_while_it_runs(self):
        client = dynamic_reconfigure.client.Client("/m1/compensation", timeout=10)
        self.assertEqual(client.get_configuration()["margin"], 0.1)
        joints = actionlib.SimpleActionClient("/m1/measure/run", MeasureAction)
        self.assertTrue(support.served(joints))
        self.assertTrue(support.wait_until(lambda: self.statuses.last().publishing, 10), self.statuses.last())
        frames = self.statuses.last().frames
        client.update_configuration({"sensor_timeout": 5.0, "margin": 0.0})
        self.assertEqual(rospy.get_param("/m1/compensation/margin"), 0.0)
        self.assertTrue(support.wait_until(lambda: self.statuses.last().frames > frames or self.statuses.last().withheld))
        client.update_configuration({"margin": 0.5})
        self.assertTrue(support.wait_until(lambda: self.statuses.last().publishing), self.statuses.last())


if __name__ == "__main__":
    rospy.init_node("prefix_test")
    rostest.rosrun("measuring_machine", "prefix", Prefix)
