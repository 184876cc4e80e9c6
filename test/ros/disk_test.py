#!/usr/bin/env python3
"""The calibration server on a disk that fails at the n-th read or write of a service: the answer says why in one line, nothing that
was kept is lost, what is active is what it was or what was asked for, and the next call goes on as if nothing had been."""
import os
import shutil
import subprocess
import sys
import unittest

import rospy
import rostest
from measuring_machine.srv import Calibrate, Promote, Rollback, Verify

import support

sys.path.insert(0, os.path.join(support.PACKAGE, "test/support"))
import failing_disk  # noqa: E402

MODELS = [support.model("{type: scale, axis: x}"),
          support.model("{type: scale, axis: x}", "{type: scale, axis: y}", "{type: scale, axis: z}", "{type: squareness, axis: x, of: y}",
                        "{type: backlash, axis: x}")]


class DiskTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = support.folder()
        cls.bag = support.simulate(os.path.join(cls.folder, "s.bag"))
        cls.worn = support.simulate(os.path.join(cls.folder, "worn.bag"), seed=3, hide=["scale:x=-0.002"])  # x errs to the other side by now
        cls.store, cls.copy = os.path.join(cls.folder, "store"), os.path.join(cls.folder, "copy")
        program = support.node("calibration_server")
        library = os.path.join(os.path.dirname(program), "..", "libfailing_disk.so")
        assert os.path.exists(library), library + " is not built: make failing_disk"
        cls.disk = failing_disk.FailingDisk(cls.folder, os.path.realpath(library))
        cls.node = subprocess.Popen([program, "__name:=calibration_server", "_store:=" + cls.store], env=cls.disk.environment)
        cls.services = {}
        for name, kind in (("calibrate", Calibrate), ("promote", Promote), ("rollback", Rollback), ("verify", Verify)):
            rospy.wait_for_service("calibration_server/" + name, 60)
            cls.services[name] = rospy.ServiceProxy("calibration_server/" + name, kind)
        cls.ids = []
        for text in MODELS:
            cls.ids.append(cls.call("calibrate", bag=cls.bag, method="least_squares", model=text).calibration_id)
            assert cls.call("promote").success

    @classmethod
    def tearDownClass(cls):
        cls.node.terminate()
        cls.node.wait(30)
        os.remove(cls.disk.folder + ".control")
        support.remove(cls.folder)

    @classmethod
    def call(cls, name, **request):
        return cls.services[name](**request)

    def active(self):
        return os.path.basename(os.readlink(os.path.join(self.store, "active")))[:-len(".yaml")]

    def put_back(self):
        shutil.rmtree(self.store)
        shutil.copytree(self.copy, self.store, symlinks=True)

    def everything_is_whole(self, promotions):
        for name in os.listdir(self.copy):
            if name.endswith(".yaml"):
                with open(os.path.join(self.copy, name)) as before, open(os.path.join(self.store, name)) as now:
                    self.assertEqual(before.read(), now.read(), name + " is not what it was")
        for name in set(os.listdir(self.store)) - set(os.listdir(self.copy)):  # those that are new
            if name.endswith(".yaml") and not os.path.islink(os.path.join(self.store, name)):
                support.mm("apply", os.path.join(self.folder, "states.csv"), "--calibration", os.path.join(self.store, name), "-o", "-")
        with open(os.path.join(self.store, "promotions")) as file:
            self.assertTrue(file.read().startswith(promotions), "lines of the list are lost")

    def sweep(self, name, good=lambda answer: answer.success, **request):
        """good: the disk let it do what was asked."""
        shutil.copytree(self.store, self.copy, symlinks=True)
        self.addCleanup(shutil.rmtree, self.copy)
        with open(os.path.join(self.folder, "states.csv"), "w") as file:
            file.write("time_s,x_mm,y_mm,z_mm,x_velocity_mm_s\n0,1,2,3,1\n")
        with open(os.path.join(self.store, "promotions")) as file:
            promotions = file.read()
        before = self.active()
        self.disk.count()
        answer = self.call(name, **request)
        self.assertTrue(good(answer), answer.message)
        faults, wanted, refused = self.disk.faults(), self.active(), 0
        wrong = []
        for fault in faults:
            try:
                self.put_back()
                refused += self.once(fault, name, good, request, (before, wanted), promotions)
            except AssertionError as error:
                self.disk.mends()
                wrong.append("%s: %s" % (fault, error))
        print("%s: %d faults, %d refused" % (name, len(faults), refused))
        self.put_back()
        self.assertEqual(wrong, [])
        self.assertGreater(refused, 3)

    def once(self, fault, name, good, request, actives, promotions):
        """@return whether it was refused."""
        before, wanted = actives
        self.disk.breaks(fault)
        answer = self.call(name, **request)
        self.disk.mends()
        self.assertIsNone(self.node.poll(), "the node has ended")
        self.assertIn(self.active(), actives)
        self.everything_is_whole(promotions)
        if good(answer):
            self.assertEqual(self.active(), wanted)
            return False
        self.assertTrue(failing_disk.said(fault) in answer.message or " disk" in answer.message, answer.message)
        self.assertEqual(answer.message.count("\n"), 0, answer.message)
        if self.active() == before:
            again = self.call(name, **request)
            self.assertTrue(good(again), again.message)
            self.assertEqual(self.active(), wanted)
            self.assertEqual([n for n in os.listdir(self.store) if ".mm-tmp-" in n], [])
        return True

    def test_1_promote(self):
        self.sweep("promote", calibration_id=self.ids[0])

    def test_2_rollback(self):
        self.sweep("rollback")

    def test_3_calibrate(self):
        self.sweep("calibrate", bag=self.bag, method="least_squares", model=MODELS[1])

    def test_4_verify_that_rolls_back(self):
        self.sweep("verify", good=lambda a: a.success and "rolled back" in a.message, bag=self.worn, automatic_rollback=True)


if __name__ == "__main__":
    rospy.init_node("disk_test")
    rostest.rosrun("measuring_machine", "disk", DiskTest)
