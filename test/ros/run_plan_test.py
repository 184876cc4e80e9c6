#!/usr/bin/env python3
"""The command run_plan: it asks and goes on, cancels at Ctrl-C, and its exit status says how the plan ended."""
import os
import signal
import subprocess
import unittest

import rospy
import rostest
from measuring_machine.msg import ProbeContact

import support

SHORT = os.path.join(support.PACKAGE, "test/ros/short_plan.yaml")


class RunPlan(unittest.TestCase):
    def setUp(self):
        self.folder = support.folder()
        self.addCleanup(support.remove, self.folder)
        self.contacts = []
        self.heard = rospy.Subscriber("probe/contact", ProbeContact, self.contacts.append, queue_size=None)
        self.addCleanup(self.heard.unregister)

    def plan(self, more, points=8):
        path = os.path.join(self.folder, "plan.yaml")
        with open(SHORT) as short, open(path, "w") as f:
            # upwards first: the plan before may have been cancelled beside a ball
            text = short.read().replace("points: 8", "points: %d" % points).replace("touch:", "moves:\n  - {z_mm: 12}\ntouch:")
            f.write(text + more)
        return path

    def start(self, *arguments):
        process = subprocess.Popen([support.node("run_plan"), *arguments], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                   stderr=subprocess.STDOUT, text=True)
        self.addCleanup(process.kill)
        return process, support.Output(process)

    def test_1_it_asks_and_goes_on(self):
        self.assertTrue(support.home_again())
        process, said = self.start(self.plan("placements: [{name: flat}, {name: again}]\n"))
        self.assertTrue(said.says("set up placement 'again'", 60), str(said))
        self.assertTrue(support.wait_until(lambda: len(self.contacts) == 8), "the whole first placement")
        self.assertIsNone(process.poll(), "it waits for the operator")
        process.stdin.write("\n")
        process.stdin.flush()
        self.assertTrue(said.says("done: 16 contacts, 0 missed", 60), str(said))
        self.assertEqual(process.wait(20), 0)

    def test_2_ctrl_c_cancels(self):
        process, said = self.start(self.plan("", points=200))
        self.assertTrue(support.wait_until(lambda: len(self.contacts) >= 2, 60))
        process.send_signal(signal.SIGINT)
        self.assertTrue(said.says("cancelled before move", 60), str(said))
        self.assertTrue(said.says("--first", 10), "how to go on")
        self.assertEqual(process.wait(20), 1)

    def test_3_the_end_of_the_terminal_cancels(self):
        process, _ = self.start(self.plan("", points=200))
        self.assertTrue(support.wait_until(lambda: len(self.contacts) >= 2, 60))
        process.send_signal(signal.SIGHUP)
        self.assertEqual(process.wait(60), 1, "it waited for the end of the plan")

    def test_4_what_cannot_begin(self):
        for arguments, words in ((["none.yaml"], "no such file"), ([self.plan("speeed: 3\n")], "speeed"), ([SHORT, "--first", "99"], "moves 0 to")):
            process, said = self.start(*arguments)
            self.assertTrue(said.says(words, 60), str(said))
            self.assertEqual(process.wait(20), 2, str(said))


if __name__ == "__main__":
    rospy.init_node("run_plan_test")
    rostest.rosrun("measuring_machine", "run_plan", RunPlan)
