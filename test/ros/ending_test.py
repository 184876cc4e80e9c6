#!/usr/bin/env python3
"""The driver of grbl is asked to end, in every way, in the middle of a slow motion."""
import os
import signal
import time
import unittest
import xmlrpc.client

import actionlib
import rosgraph
import rospy
import rostest
from measuring_machine.msg import MoveAction, MoveGoal

import support

REST = 1.0  # s


class Ending(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.axes = actionlib.SimpleActionClient("axis_driver/move", MoveAction)
        cls.double = support.Double(25918)

    @classmethod
    def tearDownClass(cls):
        support.remove(rospy.get_param("/compensation/store"))

    def machine(self):
        return self.double.tell("machine")

    def pid(self):
        return xmlrpc.client.ServerProxy(rosgraph.Master("/test").lookupNode("/axis_driver")).getPid("/test")[2]

    def end(self, how):
        self.assertTrue(support.served(self.axes))
        self.assertTrue(support.home_again())
        self.axes.send_goal(MoveGoal(name=["x"], position=[0.010], linear_speed=0.0005))
        self.assertTrue(support.wait_until(lambda: self.machine()["moving"], 20), "it does not move")
        pid, began = self.pid(), time.monotonic()
        how(pid)
        self.assertTrue(support.wait_until(lambda: not self.machine()["moving"], 20), "it moves on")
        rest = time.monotonic() - began
        held = [t for what, t in self.machine()["told"] if what == "hold" and t > began]
        self.assertTrue(held, "the control was not told to hold")
        print("hold after %.3f s, rest after %.3f s" % (held[0] - began, rest))
        self.assertLess(rest, REST)
        self.assertTrue(support.wait_until(lambda: not os.path.exists("/proc/%d" % pid)), "it does not end")
        self.assertTrue(support.wait_until(self.again, 30), "it is not started again")

    def again(self):
        try:
            return os.path.exists("/proc/%d" % self.pid())
        except (OSError, rosgraph.MasterException):  # gone, or the master knows it no more
            return False

    def test_1_sigterm(self):
        self.end(lambda pid: os.kill(pid, signal.SIGTERM))

    def test_2_sighup(self):
        self.end(lambda pid: os.kill(pid, signal.SIGHUP))

    def test_3_sigint(self):
        self.end(lambda pid: os.kill(pid, signal.SIGINT))

    def test_4_rosnode_kill(self):
        """What `rosnode kill` asks of the node, without the time in which that program starts."""
        node = xmlrpc.client.ServerProxy(rosgraph.Master("/test").lookupNode("/axis_driver"))
        self.end(lambda _: node.shutdown("/test", "killed"))


if __name__ == "__main__":
    rospy.init_node("ending_test")
    rostest.rosrun("measuring_machine", "ending", Ending)
