#!/usr/bin/env python3
"""Without a clock that runs nothing is homed nor moved, and it is said why; with one it is."""
import threading
import time
import unittest

import rospy
import rostest
from measuring_machine.msg import AxisStatus
from rosgraph_msgs.msg import Clock
from std_srvs.srv import Trigger

import support


class StuckTime(unittest.TestCase):
    def call(self, name):
        rospy.wait_for_service(name, 60)
        return rospy.ServiceProxy(name, Trigger)()

    def test_nothing_moves_without_a_clock(self):
        self.addCleanup(support.remove, rospy.get_param("/compensation/store"))
        status = []
        rospy.Subscriber("axis_driver/status", AxisStatus, status.append)
        answer = self.call("axis_driver/home")
        self.assertFalse(answer.success)
        self.assertIn("ROS time stands still: /use_sim_time is true", answer.message)
        self.assertTrue(support.wait_until(lambda: status and "time stands still" in status[-1].fault))
        self.assertFalse(status[-1].homed)
        clock, runs = rospy.Publisher("/clock", Clock, queue_size=10), [True]

        def run():
            while runs[0]:
                clock.publish(Clock(rospy.Time.from_sec(time.time())))
                time.sleep(0.01)

        thread = threading.Thread(target=run)
        thread.start()
        try:
            self.assertTrue(support.wait_until(lambda: self.call("axis_driver/home").success, 20))
        finally:
            runs[0] = False
            thread.join()
        self.assertTrue(support.wait_until(lambda: not self.call("axis_driver/home").success))


if __name__ == "__main__":
    rospy.init_node("stuck_time_test")
    rostest.rosrun("measuring_machine", "stuck_time", StuckTime)
