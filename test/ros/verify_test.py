#!/usr/bin/env python3
"""The service verify: what it says of fresh points, and what was active before becomes active again where it does not help."""
import json
import os
import unittest

import rospy
import rostest
from measuring_machine.srv import Verify

import support

ALL = ("{type: scale, axis: x}", "{type: scale, axis: y}", "{type: scale, axis: z}", "{type: squareness, axis: x, of: y}",
       "{type: backlash, axis: x}")


def verify(**request):
    rospy.wait_for_service("calibration_server/verify", 20)
    return rospy.ServiceProxy("calibration_server/verify", Verify)(**request)


def active():
    return os.path.splitext(os.path.basename(os.readlink(os.path.join(rospy.get_param("/calibration_server/store"), "active"))))[0]


class VerifyTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = support.folder()
        bag = lambda name, **how: support.simulate(os.path.join(cls.folder, name), **how)
        cls.calibrated, cls.fresh = bag("s.bag"), bag("fresh.bag", seed=2)
        cls.worn = bag("worn.bag", seed=3, hide=["scale:x=-0.002"])  # x errs to the other side by now

    @classmethod
    def tearDownClass(cls):
        support.remove(cls.folder)
        support.remove(rospy.get_param("/calibration_server/store"))

    def test_it_says_whether_it_helped_and_takes_back_what_does_not(self):
        answer = verify(bag=self.fresh)
        self.assertFalse(answer.success)
        self.assertIn("no calibration is active", answer.message)

        one = support.calibrate_and_promote(self.calibrated, support.model(ALL[0])).calibration_id
        two = support.calibrate_and_promote(self.calibrated, support.model(*ALL)).calibration_id
        answer = verify(bag=self.fresh, automatic_rollback=True)
        self.assertTrue(answer.success, answer.message)
        found = json.loads(answer.json)
        self.assertEqual((found["verdict"], found["finding"], found["drifted"]), ("helped", "corrected", False), answer.message)
        self.assertLess(found["rms_um"][1], 0.5)
        self.assertGreater(found["rms_um"][0], 3.0)
        self.assertEqual(active(), two)

        answer = verify(bag=self.fresh, loaded=True)  # nothing was loaded while it was measured
        self.assertTrue(answer.success, answer.message)
        self.assertEqual(json.loads(answer.json)["finding"], "not_corrected", answer.message)
        self.assertIn("is it loaded?", answer.message)
        self.assertEqual(active(), two)

        answer = verify(bag=self.worn, automatic_rollback=True)
        self.assertTrue(answer.success, answer.message)
        self.assertEqual(json.loads(answer.json)["verdict"], "worse", answer.message)
        self.assertIn("rolled back: %s is active again" % one, answer.message)
        self.assertEqual(active(), one)

        answer = verify(bag=self.worn, calibration=two, automatic_rollback=True)
        self.assertTrue(answer.success, answer.message)
        self.assertIn("is not the active calibration, so nothing is rolled back", answer.message)
        self.assertEqual(active(), one)

    def test_what_cannot_be_read_is_named(self):
        support.calibrate_and_promote(self.calibrated, support.model(*ALL))
        answer = verify(bag=self.fresh, loaded=True, export_folder=self.folder)
        self.assertFalse(answer.success)
        self.assertIn("holds no representability.json", answer.message)
        answer = verify(bag=os.path.join(self.folder, "none.bag"))
        self.assertFalse(answer.success)
        self.assertIn("none.bag", answer.message)


if __name__ == "__main__":
    rospy.init_node("verify_test")
    rostest.rosrun("measuring_machine", "verify", VerifyTest)
