#!/usr/bin/env python3
"""Sensors of the kernel and on Modbus RTU: what they read, and what the user sees of each fault of each device."""
import unittest

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import Temperature
from std_srvs.srv import Trigger

import support

# topic, how far above the wave of its double it reads, resolution (K)
KERNEL = {"bed": (0.0, 0.001), "air": (0.0, 0.003), "hot_end": (2.0, 0.001)}
MODBUS = {"spindle": (0.0, 0.01), "motor": (1.0, 0.001), "coolant": (0.0, 0.1)}


class Sensors(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.doubles = {"modbus": support.Double(25913), "kernel": support.Double(25914)}
        cls.said, cls.heard = [], {name: [] for name in list(KERNEL) + list(MODBUS) + ["broken", "gone", "nobody"]}
        cls.listeners = [rospy.Subscriber("temperature/" + name, Temperature, cls.heard[name].append) for name in cls.heard]
        rospy.Subscriber("/diagnostics", DiagnosticArray, lambda m: cls.said.extend(s.message for s in m.status))

    def hears(self, names, seconds=20, readings=2):
        """Each of them so often, from now on."""
        marks = {name: len(self.heard[name]) for name in names}
        self.assertTrue(support.wait_until(lambda: all(len(self.heard[n]) >= marks[n] + readings for n in names), seconds),
                        {n: len(self.heard[n]) - marks[n] for n in names})

    def says(self, words, seconds=20):
        mark = len(self.said)
        self.assertTrue(support.wait_until(lambda: any(words in s for s in self.said[mark:]), seconds),
                        (words, sorted(set(self.said[mark:]))))

    def test_1_what_they_read(self):
        self.hears(list(KERNEL) + list(MODBUS))
        for name, (above, resolution) in {**KERNEL, **MODBUS}.items():
            for message in self.heard[name]:
                self.assertGreaterEqual(message.temperature, 20.0 + above - resolution, name)
                self.assertLessEqual(message.temperature, 21.0 + above + resolution, name)
            self.assertEqual(self.heard[name][0].header.frame_id, "workpiece")
        # those of one double show one wave: sampled within the time of the wave that a poll takes
        last = {n: self.heard[n][-1].temperature - {**KERNEL, **MODBUS}[n][0] for n in list(KERNEL) + list(MODBUS)}
        for names in (KERNEL, MODBUS):
            self.assertLess(max(last[n] for n in names) - min(last[n] for n in names), 0.6, last)
        for words in ("sensor 'broken' does not answer: its driver reports a fault", "there is no 'nosuch'; there are: ",
                      "sensor 'nobody' does not answer: serial:"):
            self.says(words)
        self.assertFalse(self.heard["broken"] or self.heard["gone"] or self.heard["nobody"])

    def test_2_every_fault_of_every_device(self):
        words = {"off": "does not answer", "stuck": "is frozen", "garbage": "does not answer", "wrong": "jumped by 20"}
        for device, names in (("kernel", KERNEL), ("modbus", MODBUS)):
            others = MODBUS if device == "kernel" else KERNEL
            # every day what test_drivers asks of the devices for each fault is asked of the node for two
            every = ("off", "stuck", "garbage", "wrong", "slow", "intermittent")
            for fault in every if support.thorough_tests() else ("off", "wrong"):
                self.hears(names)
                marks = {name: len(self.heard[name]) for name in names}
                self.doubles[device].tell("fault " + fault)
                if fault in words:
                    name = next(iter(names)).replace("_", " ")
                    self.says("sensor '%s' %s" % (name, words[fault]))
                    self.hears(others)  # which are not kept waiting
                if fault == "wrong":  # for longer than a body needs for 20 K as fast as it can
                    since = {name: len(self.heard[name]) for name in names}
                    self.hears(others, 40, readings=30)
                    self.assertEqual(since, {name: len(self.heard[name]) for name in names}, "believed after a while")
                if fault == "slow":
                    self.hears(names)
                if fault == "intermittent":
                    self.says("sensor '%s' does not answer" % next(iter(names)))
                    self.hears(names)
                for name, (above, resolution) in names.items():
                    for message in self.heard[name][marks[name]:]:
                        self.assertLess(abs(message.temperature - 20.5 - above), 0.5 + resolution, (device, fault, name))
                print("%s %s: %s" % (device, fault, next((s for s in reversed(self.said) if "sensor '" in s and "nobody" not in s), "")))
                self.doubles[device].tell("fault ok")
                self.hears(names, 30)

    def test_3_a_sensor_that_was_exchanged_is_accepted_by_a_service(self):
        accept = rospy.ServiceProxy("temperature/accept", Trigger)
        self.hears(MODBUS)
        answer = accept()
        self.assertFalse(answer.success, answer.message)
        for fault, degrees in (("wrong", 40.5), ("ok", 20.5)):
            self.doubles["modbus"].tell("fault " + fault)
            self.says("sensor 'spindle' jumped by")
            said = []
            self.assertTrue(support.wait_until(lambda: said.append(accept().message) or all("sensor '%s' is" % n in " ".join(said) for n in MODBUS)),
                            said)
            self.hears(MODBUS)
            self.assertLess(abs(self.heard["spindle"][-1].temperature - degrees), 0.6)


if __name__ == "__main__":
    rospy.init_node("sensors_test")
    rostest.rosrun("measuring_machine", "sensors", Sensors)
