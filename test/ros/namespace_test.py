#!/usr/bin/env python3
"""One of several machines on a master: its bag is read without a word about its namespace, and replayed in it, to the bit."""
import os
import subprocess
import unittest

import rospy
import rostest

import support

MODEL = os.path.join(support.PACKAGE, "config/demo_model.yaml")


class Namespace(unittest.TestCase):
    def test_demo_and_replay(self):
        folder = support.folder()
        self.addCleanup(support.remove, folder)
        plan = support.shorter_plan(os.path.join(folder, "plan.yaml"), 8)
        demo = support.launch(support.free_port(), "demo.launch", "folder:=" + folder, "plan:=" + plan, "time_factor:=8", "rate:=20",
                              namespace="/machine1")
        self.addCleanup(support.stop, demo)
        output, _ = demo.communicate(timeout=280)
        self.assertIn("demo: passed", output, output[-3000:])
        bag = os.path.join(folder, "session.bag")
        with open(os.path.join(folder, "calibration.json")) as f:
            served = support.figures(f.read())
        self.assertEqual(served["observations"], 40)
        self.assertEqual(support.figures(support.mm("calibrate", bag, "--model", MODEL, "--seed", "1", "--json")), served)

        port = support.free_port()
        replay = support.launch(port, "replay.launch", "bag:=" + bag, "rate:=25",
                                "store:=" + os.path.join(folder, "calibrations"), namespace="/machine1")
        self.addCleanup(support.stop, replay)
        said = support.Output(replay)
        self.assertTrue(said.says("has been played", 60), str(said))
        # the clock of the master is that of the bag, whatever the namespace
        clocks = subprocess.run(["rostopic", "list"], stdout=subprocess.PIPE, text=True, env=support.environment(port),
                                timeout=20).stdout.split()
        self.assertIn("/clock", clocks)
        self.assertNotIn("/machine1/clock", clocks)
        frames = subprocess.run(["rostopic", "echo", "-n1", "/machine1/compensation/status/frames"], stdout=subprocess.PIPE,
                                text=True, env=support.environment(port), timeout=20).stdout
        self.assertGreater(int(frames.split()[0]), 500)
        found, message = support.calibrate_live(port, MODEL, "/machine1")
        self.assertEqual(support.figures(found), served, message)


if __name__ == "__main__":
    rospy.init_node("namespace_test")
    rostest.rosrun("measuring_machine", "namespace", Namespace)
