#!/usr/bin/env python3
"""A session that was recorded, played again through the nodes: the same calibration as by mm, to the bit; in a loop."""
import json
import os
import re
import subprocess
import unittest

import rospy
import rostest

import support

MODEL = os.path.join(support.PACKAGE, "config/demo_model.yaml")


class Replay(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = support.folder()
        cls.bag = support.simulate(os.path.join(cls.folder, "session.bag"),
                                   support.shorter_plan(os.path.join(cls.folder, "plan.yaml"), 8))
        cls.by_mm = support.mm("calibrate", cls.bag, "--model", MODEL, "--seed", "1", "--json",
                               "-o", os.path.join(cls.folder, "c.yaml"))
        support.mm("promote", os.path.join(cls.folder, "c.yaml"), "--store", os.path.join(cls.folder, "calibrations"))

    @classmethod
    def tearDownClass(cls):
        support.remove(cls.folder)

    def start(self, *arguments, bag=None):
        port = support.free_port()
        replay = support.launch(port, "replay.launch", "bag:=" + (bag or self.bag), "store:=" + os.path.join(self.folder, "calibrations"),
                                *arguments)
        self.addCleanup(support.stop, replay)
        return port, support.Output(replay)

    def test_1_replay_and_mm_agree_to_the_bit(self):
        port, said = self.start("rate:=25")
        self.assertTrue(said.says("has been played", 60), str(said))
        found, message = support.calibrate_live(port, MODEL)
        self.assertEqual(support.figures(found), support.figures(self.by_mm), message)

    def test_4_a_file_without_times(self):
        """Neither its rows' times nor its directions of travel are those that the joint states seem to have."""
        if not support.thorough_tests():
            return  # every day BagSession.KeepsThatNobodyRecordedTimes asks it of the bag
        bag, model, calibration = [os.path.join(self.folder, name) for name in ("untimed.bag", "backlash.yaml", "untimed.yaml")]
        support.mm("import", os.path.join(support.PACKAGE, "examples/import/iso230_2_x.csv"), "--machine", "three_axis", "-o", bag)
        with open(model, "w") as f:
            f.write(support.model("{type: backlash, axis: x}"))
        calibrated = support.mm("calibrate", bag, "--model", model, "--seed", "1", "--json", "-o", calibration)
        port, said = self.start("rate:=25", bag=bag)
        self.assertTrue(said.says("has been played", 60), str(said))
        found, message = support.calibrate_live(port, model)
        self.assertEqual(support.figures(found), support.figures(calibrated), message)
        found, message = support.diagnose_live(port, calibration)
        self.assertEqual(json.loads(found), json.loads(support.mm("diagnose", bag, "--calibration", calibration, "--json")), message)

    def test_3_a_bag_that_is_not_there_ends_the_launch(self):
        missing = os.path.join(self.folder, "none.bag")
        replay = support.launch(support.free_port(), "replay.launch", "bag:=" + missing)
        self.addCleanup(support.stop, replay)
        said = support.Output(replay)
        self.assertTrue(said.ends(90), str(said))
        self.assertEqual(said.count("replay: %s: there is no such file" % missing), 1, str(said))

    def test_2_a_replay_in_a_loop(self):
        """The clock goes back at every turn: the live session begins anew, frames go on."""
        port, said = self.start("rate:=60", "loop:=true")
        self.assertTrue(said.says("the clock went back: a new live session begins", 60, times=2), str(said))
        answer = subprocess.run(["rosservice", "call", "/calibration_server/calibrate", "{model: 'effects: []', method: least_squares}"],
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=support.environment(port), timeout=60).stdout
        observations = re.search(r'observations\\": (\d+)', answer.replace("\n", ""))
        self.assertTrue(observations, answer)
        self.assertLessEqual(int(observations.group(1)), 40)
        frames = subprocess.run(["rostopic", "echo", "-n1", "/compensation/status/frames"], stdout=subprocess.PIPE, text=True,
                                env=support.environment(port), timeout=20).stdout
        self.assertGreater(int(frames.split()[0]), 100)


if __name__ == "__main__":
    rospy.init_node("replay_test")
    rostest.rosrun("measuring_machine", "replay", Replay)
