#!/usr/bin/env python3
"""A demo that fails, and one that is stopped by Ctrl-C, say so in one line."""
import os
import unittest

import rospy
import rostest

import support

PLAN = os.path.join(support.PACKAGE, "test/ros/short_plan.yaml")


class DemoEnds(unittest.TestCase):
    def start(self, *arguments):
        folder = support.folder()
        self.addCleanup(support.remove, folder)
        demo = support.launch(support.free_port(), "demo.launch", "folder:=" + folder, *arguments)
        self.addCleanup(support.stop, demo)
        return folder, demo, support.Output(demo)

    def test_a_demo_that_fails_says_so(self):
        folder, _, output = self.start("model:=/nowhere/model.yaml", "plan:=" + PLAN, "time_factor:=8", "rate:=20")
        self.assertTrue(output.ends(150), str(output))
        self.assertIn("demo: FAILED: ", str(output))
        self.assertRegex(str(output), r"REQUIRED process \[demo-[0-9]+\] has died")
        with open(os.path.join(folder, "result")) as result:
            self.assertIn("FAILED: ", result.read())

    def test_ctrl_c(self):
        folder, demo, output = self.start("time_factor:=8", "rate:=20")
        self.assertTrue(output.says("move 100 of ", 120), str(output))
        support.stop(demo)
        self.assertTrue(output.ends(40), str(output))
        self.assertIn("demo: stopped", str(output))
        self.assertNotIn("Traceback", str(output))
        self.assertNotIn("demo: passed", str(output))
        with open(os.path.join(folder, "result")) as result:
            self.assertEqual(result.read(), "stopped\n")
        # What was measured until then is a bag that was closed, and can be read.
        bag = os.path.join(folder, "session.bag")
        self.assertTrue(os.path.exists(bag), os.listdir(folder))
        self.assertIn("contacts", support.mm("check", bag))


if __name__ == "__main__":
    rospy.init_node("demo_ends_test")
    rostest.rosrun("measuring_machine", "demo_ends", DemoEnds)
