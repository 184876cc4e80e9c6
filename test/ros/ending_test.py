#!/usr/bin/env python3
"""The driver of grbl is asked to end, in every way, or killed, or stands still, in the middle of a slow motion or of homing."""
import os
import signal
import threading
import time
import unittest
import xmlrpc.client

import actionlib
import rosgraph
import rospy
import rostest
from measuring_machine.msg import MoveAction, MoveGoal, MoveResult

import support

REST = 1.0  # s


class Ending(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.axes = actionlib.SimpleActionClient("axis_driver/move", MoveAction)
        cls.double = support.Double(25922)

    @classmethod
    def tearDownClass(cls):
        support.remove(rospy.get_param("/compensation/store"))

    def machine(self):
        return self.double.tell("machine")

    def pid(self):
        return xmlrpc.client.ServerProxy(rosgraph.Master("/test").lookupNode("/axis_driver")).getPid("/test")[2]

    def move(self):
        self.assertTrue(support.served(self.axes))
        self.assertTrue(support.home_again())
        self.axes.send_goal(MoveGoal(name=["x"], position=[0.010], linear_speed=0.0005))

    def rests(self, how, told="hold"):
        """What is under way rests, since the control was told so. @return the driver's process."""
        self.assertTrue(support.wait_until(lambda: self.machine()["moving"], 20), "it does not move")
        pid, began = self.pid(), time.monotonic()
        how(pid)
        self.assertTrue(support.wait_until(lambda: not self.machine()["moving"], 20), "it moves on")
        rest = time.monotonic() - began
        times = [t for what, t in self.machine()["told"] if what == told and t > began]
        self.assertTrue(times, "the control was not told to stop")
        print("%s after %.3f s, rest after %.3f s" % (told, times[0] - began, rest))
        self.assertLess(rest, REST)
        return pid

    def end(self, how):
        self.move()
        pid = self.rests(how)
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

    def test_5_sigkill(self):
        self.end(lambda pid: os.kill(pid, signal.SIGKILL))

    def test_6_sigkill_while_homing(self):
        """A feed hold does not end homing."""
        self.assertTrue(support.served(self.axes))
        self.assertTrue(support.home_again())
        self.axes.send_goal(MoveGoal(name=["x"], position=[-0.020], linear_speed=0.05))
        self.assertTrue(support.ended(self.axes, 20))
        homing = threading.Thread(target=support.home_again, daemon=True)
        homing.start()
        self.rests(lambda pid: os.kill(pid, signal.SIGKILL), "reset")
        homing.join(60)

    def test_7_sigstop(self):
        self.move()
        pid = self.rests(lambda pid: os.kill(pid, signal.SIGSTOP))
        os.kill(pid, signal.SIGCONT)
        self.assertTrue(support.ended(self.axes, 20), "the motion has no end")
        self.assertNotEqual(self.axes.get_result().outcome, MoveResult.REACHED)
        self.assertFalse(self.machine()["moving"])
        self.move()
        self.assertTrue(support.wait_until(lambda: self.machine()["moving"], 20), "it moves no more")


if __name__ == "__main__":
    rospy.init_node("ending_test")
    rostest.rosrun("measuring_machine", "ending", Ending)
