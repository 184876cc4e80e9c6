#!/usr/bin/env python3
"""The demo ends well by itself; its bag replayed, and read by mm, gives the same calibration to the bit; master restart."""
import json
import os
import re
import signal
import subprocess
import time
import unittest

import rospy
import rostest

import support

PORTS = [support.free_port() for _ in range(4)]
MODEL = os.path.join(support.PACKAGE, "config/demo_model.yaml")


def environment(port):
    return dict(os.environ, ROS_MASTER_URI="http://localhost:%d" % port)


def launch(port, *arguments):
    return subprocess.Popen(["roslaunch", "-p", str(port), "measuring_machine"] + list(arguments), stdout=subprocess.PIPE,
                            stderr=subprocess.STDOUT, text=True, env=environment(port), start_new_session=True)


def stop(process):
    if process.poll() is None:
        os.killpg(process.pid, signal.SIGINT)
        try:
            process.wait(20)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)


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

    def test_1_demo(self):
        demo = launch(PORTS[0], "demo.launch", "folder:=" + self.folder)
        self.addCleanup(stop, demo)
        output, _ = demo.communicate(timeout=200)
        self.assertEqual(demo.returncode, 0, output)
        self.assertIn("live session and bag give the same to the bit", output)
        before = re.search(r"before \(probe_tip\) +RMS +([0-9.]+) um", output)
        after = re.search(r"after +\(probe_tip_corrected\) +RMS +([0-9.]+) um", output)
        self.assertTrue(before and after, output)
        print(before.group(0), "->", after.group(0))
        self.assertGreater(float(before.group(1)), 5.0)
        self.assertLess(float(after.group(1)), 1.0)

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

    def test_4_master_restart_is_said(self):
        port = PORTS[2]
        master = subprocess.Popen(["rosmaster", "--core", "-p", str(port)], env=environment(port), stdout=subprocess.DEVNULL)
        self.addCleanup(master.kill)
        time.sleep(2)
        urdf = os.path.join(support.PACKAGE, "urdf/three_axis.urdf")
        with open(urdf) as f:
            subprocess.run(["python3", "-c", "import rosgraph,sys; rosgraph.Master('/t').setParam('/robot_description', sys.argv[1])", f.read()],
                           env=environment(port), check=True)
        log = os.path.join(self.folder, "compensation.log")
        with open(log, "w") as out:
            node = subprocess.Popen([support.node("compensation"), "_store:=" + self.folder], env=environment(port), stdout=out, stderr=out)
        self.addCleanup(node.kill)

        def said(words):
            with open(log) as f:
                return words in f.read()

        time.sleep(3)
        self.assertIsNone(node.poll())
        master.kill()
        master.wait()
        self.assertTrue(support.wait_until(lambda: said("does not answer: what is connected goes on"), 10))
        self.assertIsNone(node.poll(), "the node outlives its master")


if __name__ == "__main__":
    rospy.init_node("demo_test")
    rostest.rosrun("measuring_machine", "demo", Demo)
