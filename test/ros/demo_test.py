#!/usr/bin/env python3
"""The demo ends well by itself; mm finds the same from its bag, to the bit."""
import os
import unittest

import rospy
import rostest

import support

MODEL = os.path.join(support.PACKAGE, "config/demo_model.yaml")
FAST = [] if support.long_tests() else ["time_factor:=" + os.environ.get("MM_DEMO_TIME_FACTOR", "25"), "rate:=20"]


class Demo(unittest.TestCase):
    def test_demo(self):
        folder = support.folder()
        self.addCleanup(support.remove, folder)
        points = 24 if support.thorough_tests() else 8  # of the plan itself, or every day as few as reach as high as the check points
        plan = support.shorter_plan(os.path.join(folder, "plan.yaml"), points)
        demo = support.launch(support.free_port(), "demo.launch", "folder:=" + folder, "plan:=" + plan, *FAST)
        self.addCleanup(support.stop, demo)
        output, _ = demo.communicate(timeout=280)
        self.assertEqual(demo.returncode, 0, output)
        self.assertIn("live session and bag give the same to the bit", output)
        self.assertIn("demo: passed", output)
        before, after = support.errors(output)
        self.assertGreater(before, 5.0)
        self.assertLess(after, 1.0)
        with open(os.path.join(folder, "calibration.json")) as f:
            served = support.figures(f.read())
        self.assertEqual(served["observations"], 5 * points)
        bag = os.path.join(folder, "session.bag")
        self.assertEqual(support.figures(support.mm("calibrate", bag, "--model", MODEL, "--seed", "1", "--json")), served)


if __name__ == "__main__":
    rospy.init_node("demo_test")
    rostest.rosrun("measuring_machine", "demo", Demo)
