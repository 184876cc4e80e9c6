#!/usr/bin/env python3
"""What is measured once the recorder says that it records is in the bag, and it says what the bag lacks; so does mm."""
import os
import signal
import subprocess
import unittest

import rosbag
import rospy
import rostest
from measuring_machine.msg import Measured, ProbeContact
from sensor_msgs.msg import JointState
from std_msgs.msg import String

import support

PATIENCE = 60.0  # s


class Record(unittest.TestCase):
    def setUp(self):
        self.folder = support.folder()
        self.addCleanup(support.remove, self.folder)
        self.bag = os.path.join(self.folder, "s.bag")
        self.begun = rospy.Time.from_sec(1e9)
        self.count = 0
        self.publishers = {}
        self.publish("joint_states", JointState)
        self.publish("measure/measured", Measured, latch=True)

    def tearDown(self):
        for publisher in self.publishers.values():
            publisher.unregister()

    def publish(self, topic, kind, **options):
        self.publishers[topic] = rospy.Publisher(topic, kind, queue_size=1000, **options)

    def start(self):
        recorder = subprocess.Popen(["rosrun", "measuring_machine", "session_recorder.py", self.bag, "__name:=record"],
                                    stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.addCleanup(support.stop, recorder)
        return recorder, support.Output(recorder)

    def touch(self, times):
        for _ in range(times):
            self.count += 1
            contact = ProbeContact(feature="b0")
            contact.header.stamp = self.begun + rospy.Duration(self.count)
            self.publishers["probe/contact"].publish(contact)
            self.publishers["measure/measured"].publish(self.measured(self.begun, self.count))

    @staticmethod
    def measured(begun, count):
        message = Measured(contacts=count)
        message.header.stamp = begun
        return message

    def contacts(self):
        with rosbag.Bag(self.bag) as bag:
            return bag.get_message_count("/probe/contact")

    def end(self, recorder, said):
        recorder.send_signal(signal.SIGINT)
        self.assertTrue(said.ends(PATIENCE), str(said))

    def test_all_that_is_measured_after_it_says_so(self):
        recorder, said = self.start()
        # A machine whose probe does not answer yet is not ready: nothing may be measured.
        self.assertTrue(support.wait_until(lambda: self.publishers["joint_states"].get_num_connections() > 0, PATIENCE))
        self.publish("probe/contact", ProbeContact)
        heard = rospy.wait_for_message("record/recording", String, PATIENCE)
        self.assertEqual(heard.data, self.bag)
        self.assertGreater(self.publishers["probe/contact"].get_num_connections(), 0, "it said so too early")
        # counted by the plan before, which was over when this one began
        self.publishers["measure/measured"].publish(self.measured(self.begun - rospy.Duration(100), 7))
        self.touch(40)
        self.end(recorder, said)
        self.assertEqual(self.contacts(), 40)
        self.assertTrue(said.count("40 contacts, all that were measured"), str(said))

    def test_what_the_bag_lacks_is_said(self):
        self.publish("probe/contact", ProbeContact)
        self.touch(10)  # nobody records yet
        recorder, said = self.start()
        rospy.wait_for_message("record/recording", String, PATIENCE)
        self.touch(30)
        self.end(recorder, said)
        self.assertEqual(self.contacts(), 30)
        self.assertTrue(said.count("lacks 10 of 40 contacts"), str(said))


if __name__ == "__main__":
    rospy.init_node("record_test")
    rostest.rosrun("measuring_machine", "recording", Record)
