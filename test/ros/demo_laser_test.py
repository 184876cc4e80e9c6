#!/usr/bin/env python3
"""Five axes and a laser: its place in the head is found, and the corrected frame is right."""
import os
import unittest

import rospy
import rostest

import support

FAST = [] if support.long_tests() else ["time_factor:=8", "rate:=20"]
READINGS = 30 if support.thorough_tests() else 10  # in each of twelve postures


class DemoLaser(unittest.TestCase):
    def test_five_axes_and_a_laser(self):
        folder = support.folder()
        self.addCleanup(support.remove, folder)
        plan = support.shorter_plan(os.path.join(folder, "plan.yaml"), READINGS, "config/plans/five_axis_ball.yaml")
        demo = support.launch(support.free_port(), "demo.launch", "machine:=five_axis", "probe:=laser", "folder:=" + folder,
                              "plan:=" + plan, *FAST)
        self.addCleanup(support.stop, demo)
        output, _ = demo.communicate(timeout=280)
        self.assertIn("demo: passed", output)
        self.assertIn("measured: %d contacts" % (12 * READINGS), output)
        before, after = support.errors(output)
        self.assertGreater(before, 100.0)  # the laser stands 150 um beside its place
        self.assertLess(after, 1.0)


if __name__ == "__main__":
    rospy.init_node("demo_laser_test")
    rostest.rosrun("measuring_machine", "demo_laser", DemoLaser)
