#!/usr/bin/env python3
"""Whether the axes are homed is state of the driver's life: no corrected frame of one that came up unhomed."""
import os
import unittest

import rospy
import rostest
from sensor_msgs.msg import JointState

import support

KILLS = 40 if support.long_tests() else 6
CORRECTED = "probe_tip_corrected"


class Respawn(unittest.TestCase):
    def home(self):
        self.assertTrue(support.home_again())

    def test_no_frame_of_a_machine_that_is_not_homed(self):
        folder = support.folder()
        self.addCleanup(support.remove, folder)
        self.addCleanup(support.remove, rospy.get_param("/compensation/store"))
        bag = support.simulate(os.path.join(folder, "s.bag"))
        support.calibrate_and_promote(bag, support.model("{type: scale, axis: x}"))
        frames, statuses, unhomed, homed = support.Frames(CORRECTED), support.Statuses(), set(), set()

        def take(message):
            (unhomed if message.header.frame_id == "unhomed" else homed).add(message.header.stamp.to_nsec())

        rospy.Subscriber("joint_states", JointState, take, queue_size=None, buff_size=1 << 24, tcp_nodelay=True)
        self.home()
        self.assertTrue(support.wait_until(lambda: frames.of(CORRECTED), 20), [s.message for s in statuses.all])
        wrong = 0
        for kill in range(KILLS):
            before = len(unhomed)
            support.kill("/axis_driver")
            # Of the next life as many joint states as 0.4 s have, and what compensation makes of them.
            self.assertTrue(support.wait_until(lambda: len(unhomed) > before + 200, 30))
            mark = len(statuses.all)
            self.assertTrue(statuses.says("the axes are not homed", 10, since=max(0, mark - 20)))
            wrong += len(unhomed & set(frames.of(CORRECTED)))
            self.home()
            last = max(homed, default=0)
            self.assertTrue(support.wait_until(lambda: any(s > last for s in frames.of(CORRECTED)), 20), "frames come again")
        self.assertEqual(wrong, 0, "corrected frames of an unhomed machine")
        print("%d kills, %d joint states of unhomed axes, %d frames" % (KILLS, len(unhomed), len(frames.of(CORRECTED))))


if __name__ == "__main__":
    rospy.init_node("respawn_test")
    rostest.rosrun("measuring_machine", "respawn", Respawn)
