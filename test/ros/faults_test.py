#!/usr/bin/env python3
"""Each fault, and what the user sees of it."""
import json
import math
import os
import time
import unittest

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from measuring_machine.msg import CorrectedContact, ProbeContact, SensorReadings
from measuring_machine.srv import (AddEffect, Calibrate, Cancel, Compare, CorrectTarget, Promote, RemoveEffect,
                                   Rollback)
from sensor_msgs.msg import Temperature

import support

CORRECTED = "probe_tip_corrected"


def service(name, kind, **request):
    rospy.wait_for_service("calibration_server/" + name, 20)
    return rospy.ServiceProxy("calibration_server/" + name, kind)(**request)


class Faults(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = support.folder()
        cls.store = rospy.get_param("/compensation/store")
        cls.bag = support.simulate(os.path.join(cls.folder, "s.bag"))
        cls.joints = support.Joints()
        cls.frames = support.Frames(CORRECTED)
        cls.statuses = support.Statuses()
        cls.sensor = rospy.Publisher("temperature/bed", Temperature, queue_size=10)
        cls.scales = support.calibrate_and_promote(cls.bag, support.model("{type: scale, axis: x}", "{type: scale, axis: y}"))
        assert cls.joints.ready()
        assert support.wait_until(lambda: cls.statuses.last().calibration_id == cls.scales.calibration_id)

    @classmethod
    def tearDownClass(cls):
        support.remove(cls.folder)
        support.remove(cls.store)

    def use(self, answer):
        service("promote", Promote, calibration_id=answer.calibration_id)
        self.assertTrue(support.wait_until(lambda: self.statuses.last().calibration_id == answer.calibration_id))

    def setUp(self):
        if self.statuses.last().calibration_id != self.scales.calibration_id:
            self.use(self.scales)
        self.expect_frame(self.joints.send())
        self.mark = len(self.statuses.all)

    def expect_frame(self, stamp, position=(0.005, 0.003, 0.001)):
        self.assertTrue(support.wait_until(lambda: stamp in self.frames.of(CORRECTED), 3.0), "no frame")
        found = self.frames.of(CORRECTED)[stamp]
        x = position[0] * (1 + support.scale(self.scales.json, "x"))
        y = position[1] * (1 + support.scale(self.scales.json, "y"))
        for value, expected in zip(found, (x, y, position[2])):
            self.assertAlmostEqual(value, expected, delta=1e-11)

    def expect_nothing(self, stamp, words):
        self.assertTrue(self.statuses.says(words, since=self.mark),
                        "status never said '%s', but %s" % (words, [s.message for s in self.statuses.all[self.mark:]]))
        self.assertNotIn(stamp, self.frames.of(CORRECTED))

    def test_a_live_session_that_is_empty(self):
        self.assertIn("the session is empty", service("calibrate", Calibrate, model=support.model("{type: scale, axis: x}")).message)

    def test_nan(self):
        withheld = self.statuses.last().withheld
        stamp = self.joints.send((math.nan, 0.003, 0.001))
        self.expect_nothing(stamp, "reading of joint x is not known")
        self.expect_frame(self.joints.send())
        self.assertTrue(support.wait_until(lambda: self.statuses.last().withheld == withheld + 1))

    def test_missing_joint(self):
        for _ in range(10):
            stamp = self.joints.send((0.005, 0.003), names=["x", "y"], velocity=(1e-3, 1e-3))
        self.expect_nothing(stamp, "no reading of joint z")
        self.expect_frame(self.joints.send())

    def test_two_drivers_share_the_joints(self):
        self.joints.send((0.004, 0.002), names=["x", "y"], velocity=(1e-3, 1e-3))
        self.expect_frame(self.joints.send((0.001,), names=["z"], velocity=(1e-3,)), (0.004, 0.002, 0.001))

    def test_names_in_another_order(self):
        self.expect_frame(self.joints.send((0.001, 0.006, 0.002), names=["z", "x", "y"]), (0.006, 0.002, 0.001))

    def test_sizes_that_differ(self):
        stamp = self.joints.send((0.005, 0.003))
        self.expect_nothing(stamp, "3 names, 2 positions")

    def test_outside_the_calibrated_volume(self):
        stamp = self.joints.send((0.005, 0.003, 0.0195))
        self.expect_nothing(stamp, "z")
        self.assertTrue(support.wait_until(lambda: self.statuses.last().extrapolating))

    def test_clock_jumps_ahead(self):
        self.expect_frame(self.joints.send(ahead=3600.0))
        self.expect_frame(self.joints.send())

    def test_clock_goes_back(self):
        self.expect_frame(self.joints.send(ahead=-3000.0))
        self.expect_frame(self.joints.send())

    def test_a_foreign_publisher_costs_no_frame(self):
        """A gripper whose clock is three seconds behind, and one ahead, between all joint states."""
        foreign = support.Joints()
        self.assertTrue(foreign.ready())
        before = self.statuses.last().withheld
        stamps = []
        for i in range(100):
            foreign.stamp = self.joints.stamp + rospy.Duration(3.0 if i % 2 else -3.0)
            foreign.send((0.01,), names=["gripper"], velocity=(0.0,))
            stamps.append(self.joints.send())
        self.assertTrue(support.wait_until(lambda: set(stamps) <= set(self.frames.of(CORRECTED))),
                        "%d of 100 are left" % len(set(stamps) & set(self.frames.of(CORRECTED))))
        self.assertTrue(support.wait_until(lambda: self.statuses.last().frames > 0))
        self.assertEqual(self.statuses.last().withheld, before)

    def test_a_calibration_of_another_machine(self):
        """A copy of the URDF in which the probe stands 10.44 mm lower."""
        with open(os.path.join(support.PACKAGE, "urdf/three_axis.urdf")) as f:
            urdf = f.read().replace('<child link="probe_tip"/>', '<child link="probe_tip"/><origin xyz="0 0 -0.01044"/>')
        copy = os.path.join(self.folder, "copy.urdf")
        with open(copy, "w") as f:
            f.write(urdf)
        other = support.simulate(os.path.join(self.folder, "other.bag"), machine=copy)
        found = service("calibrate", Calibrate, bag=other, method="least_squares", model=support.model("{type: scale, axis: x}"))
        self.assertTrue(found.calibration_id, found.message)
        self.assertIn("it cannot be promoted here: calibration '%s' is of another machine: its probe's tip stands at (0, 0, -10.44) mm"
                      % found.calibration_id, found.message)
        refused = service("promote", Promote, calibration_id=found.calibration_id)
        self.assertFalse(refused.success)
        self.assertIn("here at (0, 0, 0) mm", refused.message)
        # by hand, past every service: what is in use stays in use
        links = os.path.join(self.store, "active")
        os.symlink(found.calibration_id + ".yaml", links + ".new")
        os.rename(links + ".new", links)
        self.assertTrue(self.statuses.says("is of another machine", since=self.mark))
        self.assertTrue(self.statuses.says("read before, stays in use", since=self.mark))
        self.expect_frame(self.joints.send())
        self.assertTrue(service("promote", Promote, calibration_id=self.scales.calibration_id).success)
        self.assertTrue(support.wait_until(lambda: self.joints.send() and self.statuses.last().message == ""),
                        self.statuses.last().message)

    def test_out_of_order(self):
        stamp = self.joints.send(ahead=-0.015)
        self.expect_nothing(stamp, "older than the one before")
        self.joints.send(ahead=0.1)

    def test_travel_is_unknown_after_the_clock_went_back(self):
        lagging = service("calibrate", Calibrate, bag=self.bag, method="least_squares",
                          model=support.model("{type: scale, axis: x}", "{type: backlash, axis: x}"))
        self.use(lagging)
        self.joints.send()
        stamp = self.joints.send(ahead=-3000.0, velocity=(0.0, 0.0, 0.0))
        self.expect_nothing(stamp, "direction of travel of x is not known (the model has an error that depends on it); move x, in either direction")
        for i in range(20):  # an encoder at rest: a nanometre a second is no motion
            stamp = self.joints.send((0.005 + (i % 2) * 1e-9, 0.003, 0.001), velocity=((i % 2) * 2e-9 - 1e-9, 0.0, 0.0))
        self.expect_nothing(stamp, "direction of travel of x is not known")
        stamp = self.joints.send((0.00501, 0.003, 0.001))
        self.assertTrue(support.wait_until(lambda: stamp in self.frames.of(CORRECTED)))

    def test_temperature_lost(self):
        warm = service("calibrate", Calibrate, bag=self.bag, method="least_squares",
                       model=support.model("{type: scale, axis: x}", "{type: thermal_expansion, axis: x, sensor: bed}"))
        self.use(warm)
        self.assertTrue(support.wait_until(lambda: self.sensor.get_num_connections() > 0))
        reading = Temperature(temperature=20.5)
        reading.header.stamp = self.joints.stamp
        self.sensor.publish(reading)
        self.assertTrue(support.wait_until(lambda: self.joints.send() in self.frames.of(CORRECTED)
                                           or support.wait_until(lambda: self.joints.stamp.to_nsec() in self.frames.of(CORRECTED), 0.2)))
        self.mark = len(self.statuses.all)
        stamp = self.joints.send(ahead=1.5)
        self.expect_nothing(stamp, "temperature bed is not known")
        self.assertTrue(support.wait_until(lambda: self.statuses.last().sensor_lost))

    def test_temperature_frozen_or_silent_sensor(self):
        said, passed = [], []
        rospy.Subscriber("/diagnostics", DiagnosticArray, lambda m: said.extend(s.message for s in m.status))
        rospy.Subscriber("temperature/frame", Temperature, passed.append)
        spaced = []
        rospy.Subscriber("temperature/motor_left", Temperature, spaced.append)
        out = rospy.Publisher("axis_driver/temperatures", SensorReadings, queue_size=10, latch=True)
        self.assertTrue(support.wait_until(lambda: out.get_num_connections() > 0))
        sent = 0

        def frozen():
            nonlocal sent
            message = SensorReadings(name=["frame", "air", "motor left"], temperature=[21.253, math.nan, 20.0 + 0.01 * sent])
            message.header.stamp = rospy.Time.now()
            out.publish(message)
            sent += 1
            time.sleep(0.1)  # ten readings a second
            return any("sensor 'frame' is frozen" in s for s in said)

        self.assertTrue(support.wait_until(frozen), said)
        self.assertTrue(any("sensor 'air' does not answer" in s for s in said), said)
        self.assertGreater(len(passed), 0)
        # it passed while it was not yet frozen, which takes a second for what is read to 0.001 K
        held = passed[-1].header.stamp - passed[0].header.stamp
        self.assertLess(held, rospy.Duration(1.0))
        self.assertGreater(sent, len(passed))
        self.assertTrue(support.wait_until(lambda: spaced and spaced[-1].header.frame_id == "workpiece"), "a name with a space")

    def test_calibration_file_damaged_while_active(self):
        file = os.path.join(self.store, self.scales.calibration_id + ".yaml")
        with open(file) as f:
            good = f.read()
        with open(file, "w") as f:
            f.write(good[: len(good) // 2])
        try:
            self.assertTrue(self.statuses.says(os.path.basename(file), since=self.mark))
            self.assertTrue(self.statuses.says("read before, stays in use", since=self.mark))
            self.expect_frame(self.joints.send())
        finally:
            with open(file, "w") as f:
                f.write(good)
        self.assertTrue(support.wait_until(lambda: self.joints.send() and self.statuses.last().message == ""),
                        self.statuses.last().message)

    def test_node_dies_and_comes_back(self):
        support.kill("/compensation")
        before = len(self.statuses.all)
        self.assertTrue(support.wait_until(lambda: len(self.statuses.all) > before, 20.0))
        self.assertTrue(self.joints.ready())
        self.assertTrue(support.wait_until(
            lambda: support.wait_until(lambda s=self.joints.send(): s in self.frames.of(CORRECTED), 0.3), 10.0))

    def test_no_joint_states(self):
        self.assertTrue(self.statuses.says("no joint states are received", since=self.mark))
        self.assertFalse(self.statuses.last().publishing)

    def test_correct_target(self):
        rospy.wait_for_service("compensation/correct_target", 10)
        ask = rospy.ServiceProxy("compensation/correct_target", CorrectTarget)
        request = CorrectTarget._request_class(name=["z", "y", "x"], position=[0.0, 0.0, 0.0])
        request.target.x, request.target.y, request.target.z = 0.010, 0.020, 0.002
        found = ask(request)
        self.assertTrue(found.success, found.message)
        self.assertEqual(found.name, ["x", "y", "z"])
        self.assertAlmostEqual(found.position[0] * (1 + support.scale(self.scales.json, "x")), 0.010, delta=1e-10)
        self.assertAlmostEqual(found.position[1] * (1 + support.scale(self.scales.json, "y")), 0.020, delta=1e-10)
        request.target.x = 0.5
        self.assertFalse(ask(request).success)
        request.name = ["x", "q", "z"]
        self.assertIn("'q' is not a joint", ask(request).message)

    def test_corrected_contact(self):
        found = []
        listener = rospy.Subscriber("probe/contact_corrected", CorrectedContact, found.append)
        out = rospy.Publisher("probe/contact", ProbeContact, queue_size=10)
        self.assertTrue(support.wait_until(lambda: listener.get_num_connections() > 0 and out.get_num_connections() > 1))
        contact = ProbeContact(name=["z", "y", "x"], position=[0.001, 0.003, 0.005], velocity=[-1e-3, 0.0, 0.0],
                               laser_reading=math.nan, feature="b0")
        contact.header.stamp = self.joints.stamp
        out.publish(contact)
        self.assertTrue(support.wait_until(lambda: found))
        self.assertAlmostEqual(found[0].position.x, 0.005 * (1 + support.scale(self.scales.json, "x")), delta=1e-11)
        self.assertEqual((found[0].feature, found[0].calibration_id), ("b0", self.scales.calibration_id))
        repeatability = 1e-6 * json.loads(self.scales.json)["repeatability_um"]
        self.assertGreater(found[0].sigma, repeatability)
        # scales alone leave errors of this machine unexplained, and the sigma allows for what wanders of them
        unexplained = 1e-6 * json.loads(self.scales.json)["rms_um"]
        self.assertLess(found[0].sigma, 3 * repeatability + 2 * unexplained)
        contact.position[0] = math.nan
        mark = len(self.statuses.all)
        out.publish(contact)
        self.assertTrue(self.statuses.says("contact on 'b0' is not corrected: reading of joint z is not known", since=mark),
                        self.statuses.all[mark:])
        self.assertEqual(len(found), 1)

    def test_the_candidate_beside(self):
        candidates = support.Frames("probe_tip_candidate")
        other = service("calibrate", Calibrate, bag=self.bag, method="least_squares", model=support.model("{type: scale, axis: z}"))
        self.assertTrue(support.wait_until(lambda: self.statuses.last().candidate_id == other.calibration_id))
        stamp = self.joints.send()
        self.expect_frame(stamp)
        self.assertTrue(support.wait_until(lambda: stamp in candidates.of("probe_tip_candidate")))
        x, y, z = candidates.of("probe_tip_candidate")[stamp]
        self.assertEqual((x, y), (0.005, 0.003))
        self.assertAlmostEqual(z, 0.001 * (1 + support.scale(other.json, "z")), delta=1e-12)
        self.joints.send((math.nan, 0.003, 0.001))
        self.assertTrue(support.wait_until(lambda: "joint x" in self.statuses.last().candidate_message))
        self.use(other)
        self.joints.send((math.nan, 0.003, 0.001))
        self.assertTrue(support.wait_until(lambda: "joint x" in self.statuses.last().message and not self.statuses.last().candidate_id))
        self.assertEqual(self.statuses.last().candidate_message, "", "there is no candidate of which to say it")

    def test_requests_that_cannot_be_answered(self):
        missing = service("calibrate", Calibrate, bag="/nowhere/s.bag", model=support.model("{type: scale, axis: x}"))
        self.assertFalse(missing.success)
        self.assertIn("/nowhere/s.bag", missing.message)
        self.assertIn("axiss", service("calibrate", Calibrate, bag=self.bag, model=support.model("{type: scale, axiss: x}")).message)
        self.assertIn("is neither a file", service("calibrate", Calibrate, bag=self.bag, model="nosuchmodel").message)
        # An inline model is YAML however long it is; a file that is none is not read, and a device is no bag.
        long = support.model(*["{type: straightness, axis: %s, direction: %s, degree: %d}" % (a, d, n) for a in "xyz" for d in "xyz"
                               if a != d for n in (2, 3, 4)])
        self.assertGreater(len(long), 1000)
        self.assertTrue(service("calibrate", Calibrate, bag=self.bag, method="least_squares", model=long).calibration_id)
        secret = service("calibrate", Calibrate, bag=self.bag, model="/etc/passwd").message
        self.assertIn("'/etc/passwd' is no model file", secret)
        self.assertNotIn("root:", secret)
        self.assertIn("/dev/zero: is not a regular file", service("calibrate", Calibrate, bag="/dev/zero", model=long).message)
        self.assertIn("annealing", service("calibrate", Calibrate, bag=self.bag, method="annealing").message)
        self.assertIn("nosuchid", service("compare", Compare, bag=self.bag, calibration="nosuchid").message)
        self.assertIn("nosuchid", service("promote", Promote, calibration_id="nosuchid").message)
        self.assertIn("nosuchid", service("rollback", Rollback, calibration_id="nosuchid").message)
        self.assertIn("blacklash", service("add_effect", AddEffect, effect="{type: blacklash, axis: x}").message)
        self.assertEqual(service("cancel", Cancel).message, "nothing is running")

    def test_the_loop_by_service(self):
        first = service("calibrate", Calibrate, bag=self.bag, method="least_squares", model=support.model("{type: scale, axis: x}", "{type: scale, axis: y}"))
        self.assertTrue(first.success, first.message)
        self.assertRegex(first.message, r"RMS [0-9.]+ um -> [0-9.]+ um, held out [0-9.]+ um; repeatability ")
        self.assertIn("next: rosservice call /calibration_server/diagnose '{bag: %s}'" % self.bag, first.message)
        compared = service("compare", Compare, bag=self.bag)
        self.assertTrue(compared.success, compared.message)
        self.assertRegex(compared.message, r"RMS [0-9.]+ um -> [0-9.]+ um")
        added = service("add_effect", AddEffect, effect="{type: squareness, axis: x, of: y}")
        self.assertTrue(added.success, added.message)
        value, unit = support.parameter(added.json, "squareness", axis="x")
        self.assertEqual(unit, "um/m")
        self.assertAlmostEqual(value, 500, delta=20)  # hidden by the plan: 500 urad
        removed = service("remove_effect", RemoveEffect, effect="{type: squareness, axis: x, of: y}")
        self.assertTrue(removed.success, removed.message)
        self.assertAlmostEqual(support.scale(removed.json, "x"), support.scale(first.json, "x"), delta=1e-9)
        never = service("rollback", Rollback, calibration_id=first.calibration_id)
        self.assertFalse(never.success)
        self.assertIn("was never active", never.message)
        again = service("rollback", Rollback)
        self.assertFalse(again.success and not again.message)


if __name__ == "__main__":
    rospy.init_node("faults_test")
    rostest.rosrun("measuring_machine", "faults", Faults)
