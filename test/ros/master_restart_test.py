#!/usr/bin/env python3
"""The nodes say that the master is gone, and with the next one they can be found again, with their parameters."""
import os
import subprocess
import time
import unittest
import xmlrpc.client

import rospy
import rostest

import support

NODES = {"axis_driver": "/axis_driver/home", "compensation": "/compensation/correct_target",
         "calibration_server": "/calibration_server/calibrate"}


class MasterRestart(unittest.TestCase):
    def start_master(self):
        master = subprocess.Popen([support.REAPER, "rosmaster", "--core", "-p", str(self.port)], env=support.environment(self.port),
                                  stdout=subprocess.DEVNULL)
        self.addCleanup(support.stop, master)
        self.assertTrue(support.wait_until(lambda: self.ask("getPid"), 20))
        return master

    def ask(self, method, *arguments):
        try:
            code, _, value = getattr(xmlrpc.client.ServerProxy("http://localhost:%d" % self.port), method)("/test", *arguments)
            return value if code == 1 else None
        except OSError:
            return None

    def registered(self, kind):
        """Nodes that the master knows to publish (0), subscribe (1) or serve (2): {name: those who have it}."""
        state = self.ask("getSystemState")
        return {name: set(nodes) for name, nodes in state[kind]} if state else {}

    def run_command(self, *command):
        return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                              env=support.environment(self.port), timeout=40).stdout

    def test_restart(self):
        self.port = support.free_port()
        folder = support.folder()
        self.addCleanup(support.remove, folder)
        master = self.start_master()
        with open(os.path.join(support.PACKAGE, "urdf/three_axis.urdf")) as urdf:
            self.ask("setParam", "/robot_description", urdf.read())
        machine = {"/serial": "MM-7", "/frame_prefix": "m1/", "/tf_prefix": "m1"}
        for name, value in machine.items():
            self.ask("setParam", name, value)
        logs, nodes = {}, []
        for name in NODES:
            logs[name] = os.path.join(folder, name + ".log")
            with open(logs[name], "w") as out:
                arguments = ["_rate:=50.0"] if name == "axis_driver" else ["_store:=" + folder]
                nodes.append(subprocess.Popen([support.REAPER, support.node(name)] + arguments,
                                              env=support.environment(self.port), stdout=out, stderr=out))
            self.addCleanup(support.stop, nodes[-1])
        for service in NODES.values():
            self.assertTrue(support.wait_until(lambda s=service: self.ask("lookupService", s), 20), service)

        def said(words):
            found = []
            for name, log in logs.items():
                with open(log) as f:
                    found += [name] * f.read().count(words)
            return sorted(found)

        self.ask("setParam", "/compensation/late", "what a node sets after its start")
        time.sleep(3.0)  # the services are looked at every second, and nobody tells when that was
        topics, subscriptions, services = (self.registered(kind) for kind in range(3))
        for turn in range(1, 4 if support.long_tests() else 2):
            everybody = sorted(list(NODES) * turn)
            support.stop(master)
            self.assertTrue(support.wait_until(lambda: said("does not answer: existing connections continue") == everybody, 20),
                            said("does not answer"))
            master = self.start_master()
            self.assertTrue(support.wait_until(lambda: said("this node is registered again") == everybody, 20),
                            said("this node is registered again"))
            self.assertTrue(all(node.poll() is None for node in nodes), "the nodes outlive their master")
            for kind, before in enumerate((topics, subscriptions, services)):
                now = self.registered(kind)
                missing = {name: who - now.get(name, set()) for name, who in before.items() if who - now.get(name, set())}
                self.assertEqual(missing, {}, "turn %d, kind %d" % (turn, kind))
        self.assertIn("probe_mount", self.ask("getParam", "/robot_description"))
        self.assertEqual(self.ask("getParam", "/compensation/store"), folder)
        self.assertEqual({name: self.ask("getParam", name) for name in machine}, machine)
        self.assertEqual(self.ask("getParam", "/compensation/late"), "what a node sets after its start")
        self.assertIn("success: True", self.run_command("rosservice", "call", "/axis_driver/home"))
        self.assertIn("no calibration is active", self.run_command("rosservice", "call", "/correct_target", "{}"))
        self.assertIn("nothing is running", self.run_command("rosservice", "call", "/calibration_server/cancel", "{}"))
        self.assertIn("- x\n  - y\n  - z", self.run_command("rostopic", "echo", "-n1", "/joint_states"))
        self.assertIn("no calibration is active", self.run_command("rostopic", "echo", "-n1", "/compensation/status/message"))


if __name__ == "__main__":
    rospy.init_node("master_restart_test")
    rostest.rosrun("measuring_machine", "master_restart", MasterRestart)
