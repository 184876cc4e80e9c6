#!/usr/bin/env python3
"""The demo ends well by itself; its bag replayed, and read by mm, gives the same calibration to the bit; master restart."""
import json
import os
import re
import signal
import subprocess
import time
import unittest
import xmlrpc.client

import rospy
import rostest

import support

PORTS = [support.free_port() for _ in range(7)]
MODEL = os.path.join(support.PACKAGE, "config/demo_model.yaml")


def environment(port):
    return dict(os.environ, ROS_MASTER_URI="http://localhost:%d" % port)


def launch(port, *arguments, namespace="/"):
    return subprocess.Popen([support.REAPER, "roslaunch", "-p", str(port), "measuring_machine"] + list(arguments),
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                            env=dict(environment(port), ROS_NAMESPACE=namespace))


def stop(process):
    if process.poll() is None:
        process.send_signal(signal.SIGINT)
        process.wait(40)  # the reaper itself kills what does not end


def figures(text):
    """Parameters and residual figures of a calibration's JSON: all but the seconds that it took."""
    found = json.loads(text)
    if found.get("genetic"):
        found["genetic"].pop("seconds")
    return found


def call(port, service, request, seconds=60):
    return subprocess.run(["rosservice", "call", service, request], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          env=environment(port), timeout=seconds).stdout


class Demo(unittest.TestCase):
    folder = support.folder()

    @classmethod
    def tearDownClass(cls):
        support.remove(cls.folder)

    def errors(self, output):
        """RMS before and after, um."""
        found = [re.search(r"%s +RMS +([0-9.]+) um" % frame, output) for frame in (r"\(probe_tip\)", r"\(probe_tip_corrected\)")]
        self.assertTrue(all(found), output)
        return [float(f.group(1)) for f in found]

    def test_1_demo(self):
        demo = launch(PORTS[0], "demo.launch", "folder:=" + self.folder)
        self.addCleanup(stop, demo)
        output, _ = demo.communicate(timeout=200)
        self.assertEqual(demo.returncode, 0, output)
        self.assertIn("live session and bag give the same to the bit", output)
        self.assertIn("demo: passed", output)
        before, after = self.errors(output)
        self.assertGreater(before, 5.0)
        self.assertLess(after, 1.0)

    def test_1_five_axes_and_a_laser(self):
        folder = os.path.join(self.folder, "five")
        demo = launch(PORTS[4], "demo.launch", "machine:=five_axis", "probe:=laser", "folder:=" + folder)
        self.addCleanup(stop, demo)
        output, _ = demo.communicate(timeout=200)
        self.assertIn("demo: passed", output)
        self.assertIn("measured: 360 contacts", output)
        before, after = self.errors(output)
        self.assertGreater(before, 100.0)  # the laser stands 150 um beside its place
        self.assertLess(after, 1.0)

    def test_1_in_a_namespace(self):
        """Several machines on one master: the bag of one of them is read without a word about its namespace."""
        folder = os.path.join(self.folder, "machine1")
        demo = launch(PORTS[6], "demo.launch", "folder:=" + folder, namespace="/machine1")
        self.addCleanup(stop, demo)
        output, _ = demo.communicate(timeout=200)
        self.assertIn("demo: passed", output)
        bag = os.path.join(folder, "session.bag")
        with open(os.path.join(folder, "calibration.json")) as f:
            self.assertEqual(figures(support.mm("calibrate", bag, "--model", MODEL, "--seed", "1", "--json")), figures(f.read()))

    def test_1_a_demo_that_fails_says_so(self):
        folder = os.path.join(self.folder, "failed")
        demo = launch(PORTS[5], "demo.launch", "folder:=" + folder, "model:=/nowhere/model.yaml", "plan:=" + os.path.join(
            support.PACKAGE, "test/ros/short_plan.yaml"))
        self.addCleanup(stop, demo)
        output, _ = demo.communicate(timeout=100)
        self.assertIn("demo: FAILED: ", output)
        self.assertRegex(output, r"REQUIRED process \[demo-[0-9]+\] has died")
        with open(os.path.join(folder, "result")) as result:
            self.assertIn("FAILED: ", result.read())

    def test_2_bag_replay_and_mm_agree_to_the_bit(self):
        bag = os.path.join(self.folder, "session.bag")
        with open(os.path.join(self.folder, "calibration.json")) as f:
            served = figures(f.read())
        self.assertEqual(served["observations"], 120)
        by_mm = figures(support.mm("calibrate", bag, "--model", MODEL, "--seed", "1", "--json"))
        self.assertEqual(by_mm, served)
        replay = launch(PORTS[1], "replay.launch", "bag:=" + bag, "rate:=25", "store:=" + os.path.join(self.folder, "replayed"))
        self.addCleanup(stop, replay)
        output = ""
        for line in replay.stdout:
            output += line
            if "play" in line and "finished cleanly" in line:
                break
        self.assertIsNone(replay.poll(), output)
        script = ("import rospy,sys; from measuring_machine.srv import Calibrate; rospy.wait_for_service('calibration_server/calibrate');"
                  "a=rospy.ServiceProxy('calibration_server/calibrate',Calibrate)(model=sys.argv[1],seed=1);"
                  "sys.stderr.write(a.message); print(a.json)")
        done = subprocess.run(["python3", "-c", script, MODEL], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                              env=environment(PORTS[1]), timeout=60)
        self.assertEqual(figures(done.stdout or "{}"), served, done.stderr)

    def test_3_a_replay_in_a_loop(self):
        """The clock goes back at every turn: the live session begins anew, frames go on."""
        bag = os.path.join(self.folder, "session.bag")
        replay = launch(PORTS[3], "replay.launch", "bag:=" + bag, "rate:=60", "loop:=true",
                        "store:=" + os.path.join(self.folder, "calibrations"))
        self.addCleanup(stop, replay)
        turns, output = 0, ""
        for line in replay.stdout:
            output += line
            turns += "the clock went back: the live session begins anew" in line
            if turns == 2:
                break
        self.assertEqual(turns, 2, output)
        answer = call(PORTS[3], "/calibration_server/calibrate", "{model: '%s', method: least_squares}" % "effects: []")
        observations = int(re.search(r'observations\\": (\d+)', answer.replace("\n", "")).group(1))
        self.assertLessEqual(observations, 120)
        status = subprocess.run(["rostopic", "echo", "-n1", "/compensation/status/frames"], stdout=subprocess.PIPE, text=True,
                                env=environment(PORTS[3]), timeout=20).stdout
        self.assertGreater(int(status.split()[0]), 5000)

    def test_4_master_restart(self):
        """The nodes say that the master is gone, and with the next one they can be found again, with their parameters."""
        port = PORTS[2]

        def start_master():
            master = subprocess.Popen([support.REAPER, "rosmaster", "--core", "-p", str(port)], env=environment(port),
                                      stdout=subprocess.DEVNULL)
            self.addCleanup(stop, master)
            self.assertTrue(support.wait_until(lambda: ask("getPid"), 20))
            return master

        def ask(method, *arguments):
            try:
                code, _, value = getattr(xmlrpc.client.ServerProxy("http://localhost:%d" % port), method)("/test", *arguments)
                return value if code == 1 else None
            except OSError:
                return None

        def run(*command):
            return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=environment(port),
                                  timeout=40).stdout

        master = start_master()
        with open(os.path.join(support.PACKAGE, "urdf/three_axis.urdf")) as urdf:
            ask("setParam", "/robot_description", urdf.read())
        log = os.path.join(self.folder, "master_restart.log")
        nodes = []
        with open(log, "w") as out:
            for name, parameter in (("axis_driver", "_rate:=50.0"), ("compensation", "_store:=" + self.folder)):
                nodes.append(subprocess.Popen([support.REAPER, support.node(name), parameter], env=environment(port), stdout=out, stderr=out))
                self.addCleanup(stop, nodes[-1])
        self.assertTrue(support.wait_until(lambda: ask("lookupService", "/compensation/correct_target"), 20))
        self.assertTrue(support.wait_until(lambda: ask("lookupService", "/axis_driver/home"), 20))
        time.sleep(7.0)  # the services are looked at every five seconds

        def said(words):
            with open(log) as f:
                return f.read().count(words)

        stop(master)
        self.assertTrue(support.wait_until(lambda: said("does not answer: what is connected continues") == 2, 20))
        start_master()
        self.assertTrue(support.wait_until(lambda: said("this node is registered again") == 2, 20))
        self.assertTrue(all(node.poll() is None for node in nodes), "the nodes outlive their master")
        self.assertIn("probe_mount", ask("getParam", "/robot_description"))
        self.assertEqual(ask("getParam", "/compensation/store"), self.folder)
        self.assertIn("success: True", run("rosservice", "call", "/axis_driver/home"))
        self.assertIn("no calibration is active", run("rosservice", "call", "/correct_target", "{}"))
        self.assertIn("- x\n  - y\n  - z", run("rostopic", "echo", "-n1", "/joint_states"))
        self.assertIn("no calibration is active", run("rostopic", "echo", "-n1", "/compensation/status/message"))


if __name__ == "__main__":
    rospy.init_node("demo_test")
    rostest.rosrun("measuring_machine", "demo", Demo)
