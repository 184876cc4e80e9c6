#!/usr/bin/env python3
"""The workbench on a live machine, through its server as a page uses it."""
import json
import os
import signal
import sys
import threading
import time
import unittest
import urllib.error
import urllib.parse
import urllib.request
import xmlrpc.client

import rosgraph
import rospy
import rostest
from measuring_machine.msg import AxisStatus, MotionStatus

import support

sys.path.insert(0, os.path.join(support.PACKAGE, "test", "support"))
from browser import Socket  # noqa: E402


class Page:
    """What a page does: a live connection with its heartbeat, and requests with the token."""

    def __init__(self, url, beats=True):
        parts = urllib.parse.urlparse(url)
        self.base, self.token = "http://" + parts.netloc, urllib.parse.parse_qs(parts.query)["token"][0]
        self.socket = Socket("ws://%s/live?token=%s" % (parts.netloc, self.token))
        self.client = json.loads(self.socket.receive())["client"]
        self.states, self.changed, self.beats, self.open = [], threading.Condition(), beats, True
        threading.Thread(target=self.read, daemon=True).start()
        threading.Thread(target=self.beat, daemon=True).start()

    def read(self):
        try:
            while self.open:
                state = json.loads(self.socket.receive())
                with self.changed:
                    self.states.append((time.time(), state))
                    self.changed.notify_all()
        except (OSError, ValueError):
            self.open = False

    def beat(self):
        while self.open and self.beats:
            try:
                self.socket.send("heartbeat")
            except OSError:
                return
            time.sleep(0.2)

    def close(self):
        if self.open:
            self.open = False
            self.socket.socket.shutdown(2)

    def state(self):
        with self.changed:
            return self.states[-1][1] if self.states else None

    def wait(self, true, seconds=60):
        end = time.time() + seconds
        with self.changed:
            while not (self.states and true(self.states[-1][1])):
                if not self.changed.wait(max(0.0, end - time.time())):
                    return False
            return True

    def data(self, name):
        request = urllib.request.Request(self.base + "/data/" + name, headers={"X-Workbench-Token": self.token})
        with urllib.request.urlopen(request, timeout=20) as answer:
            return json.loads(answer.read())

    def post(self, action, **body):
        request = urllib.request.Request(self.base + "/action/" + action, json.dumps(dict(body, who="test")).encode(),
                                         {"X-Workbench-Token": self.token})
        try:
            with urllib.request.urlopen(request, timeout=20) as answer:
                return answer.status, json.loads(answer.read())
        except urllib.error.HTTPError as refused:
            return refused.code, json.loads(refused.read())

    def act(self, action, seconds=120, **body):
        """An action to its end: (ok, message)."""
        status, answer = self.post(action, **body)
        if "number" not in answer:
            return status == 200, answer["message"]
        ended = {}

        def over(state):
            for e in state["ended"]:
                if e["number"] == answer["number"]:
                    ended.update(e)
            return bool(ended)

        if not self.wait(over, seconds):
            raise AssertionError("%s does not end: %s" % (action, self.state()))
        return ended["ok"], ended["message"]


class Workbench(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        assert support.wait_until(lambda: rospy.has_param("/workbench/url"), 60)
        cls.url = rospy.get_param("/workbench/url")
        page = Page(cls.url)
        # the nodes of the machine start beside the workbench: a stop must reach them before a page may arm
        assert page.wait(lambda s: s["machine"] and not s["machine"]["no_stop"]), page.state()
        page.close()
        with open(os.path.join(support.PACKAGE, "test/ros/workbench_plan.yaml")) as f:
            cls.plan = f.read()
        # the same from wherever the machine stands: upwards first; and with a long way above the balls before
        up = "moves:\n  - {z_mm: 12}\n"
        cls.again = cls.plan.replace("touch:", up + "touch:").replace("points: 12", "points: 6").replace("demo_plate", "fresh_points")
        there_and_back = "  - {x_mm: 13, y_mm: 28, speed_mm_s: 5}\n  - {x_mm: -13, y_mm: -8, speed_mm_s: 5}\n"
        cls.long_way = cls.plan.replace("touch:", up + 40 * there_and_back + "touch:")

    def test_1_nothing_moves_before_it_is_armed(self):
        page = Page(self.url)
        self.addCleanup(page.close)
        for action in ("home", "run"):
            ok, message = page.act(action, client=page.client, plan=self.plan)
            self.assertFalse(ok)
            self.assertIn("arm", message)

    def test_2_measure_diagnose_add_promote(self):
        page, frames = Page(self.url), support.Frames("probe_tip_corrected")
        self.addCleanup(page.close)
        self.assertEqual(page.act("arm", client=page.client), (True, "armed: the machine moves as long as this page is open"))
        self.assertTrue(page.act("home", client=page.client)[0])
        ok, message = page.act("run", client=page.client, plan=self.plan)
        self.assertTrue(ok, message)
        self.assertIn("60 observations", message)
        # how many states a second came depends on the computer; their numbers rise, and they follow the machine
        moving = [(t, s) for t, s in page.states if s["machine"]["moving"]]
        sequence = [s["sequence"] for _, s in page.states]
        self.assertEqual(sequence, sorted(set(sequence)))
        seconds = moving[-1][0] - moving[0][0]
        print("workbench: %.1f states a second while the machine moved" % (len(moving) / seconds))
        self.assertGreater(len({tuple(s["machine"]["readings"]) for _, s in moving}), 30)
        ok, message = page.act("diagnose")
        self.assertTrue(ok, message)
        missing = page.data("diagnosis")["missing"]
        self.assertTrue(missing, message)
        self.assertIn(missing[0]["in_words"], message)
        before = page.data("compare")["rms_um"]
        effect = "{%s}" % ", ".join("%s: %s" % item for item in missing[0]["effect"].items())
        ok, message = page.act("add", effect=effect)
        self.assertTrue(page.data("calibration")["kept"], message)
        self.assertLess(page.data("compare")["rms_um"], 0.95 * before)
        identity = page.data("calibration")["id"]
        self.assertEqual(frames.of("probe_tip_corrected"), {})
        ok, message = page.act("promote", id=identity)
        self.assertEqual((ok, message), (True, identity + " is active"))
        self.assertTrue(support.wait_until(lambda: frames.of("probe_tip_corrected"), 20), "no corrected frame after the promotion")
        self.assertTrue(page.wait(lambda s: s["machine"]["calibration"] == identity and s["machine"]["corrected_mm"], 20), page.state())
        # the session that was fitted says nothing new; a few fresh points do
        ok, message = page.act("verify")
        self.assertFalse(ok, message)
        self.assertIn("fitted to this session", message)
        ok, message = page.act("run", client=page.client, plan=self.again)
        self.assertTrue(ok, message)
        self.assertIn("30 observations", message)
        ok, message = page.act("verify")
        self.assertTrue(ok, message)
        self.assertEqual(page.data("verify")["in_words"], message)
        self.assertTrue(page.wait(lambda s: s["machine"]["corrected_mm"], 20), page.state())
        tip, nominal = page.state()["machine"]["corrected_mm"], page.state()["machine"]["nominal_mm"]
        self.assertGreater(max(abs(a - b) for a, b in zip(tip, nominal)), 0.1e-3)  # mm
        ok, message = page.act("rollback")
        self.assertFalse(ok)  # nothing was active before: in the words of the service
        self.assertIn("before", message)
        self.assertTrue(page.act("disarm", client=page.client)[0])

    def moving(self, page):
        """Arms the page and lets it move the machine, which is homed, by a plan. @return stops so far."""
        self.assertTrue(page.wait(lambda s: s["armed"] is None))
        self.assertTrue(page.act("arm", client=page.client)[0])
        stops = self.motion[-1].stops
        page.post("run", client=page.client, plan=self.long_way)
        self.assertTrue(page.wait(lambda s: s["machine"]["moving"] and s["machine"]["measuring"]), page.state())
        return stops

    def still(self, stops, why):
        self.assertTrue(support.wait_until(lambda: self.motion[-1].stops > stops, 30), why)
        self.assertTrue(support.wait_until(lambda: not self.axes[-1].moving, 30), why)

    def listen(self):
        self.motion, self.axes = [], []
        rospy.Subscriber("axis_driver/motion", MotionStatus, self.motion.append)
        rospy.Subscriber("axis_driver/status", AxisStatus, self.axes.append)
        self.assertTrue(support.wait_until(lambda: self.motion and self.axes))

    def test_3_a_closed_page_stops_the_machine(self):
        self.listen()
        # every day the page that closes: what BenchMotionTest and LiveConnectionTest ask of the server is asked of the node for one way
        for leave in ("close", "silence", "stop") if support.thorough_tests() else ("close",):
            page = Page(self.url)
            self.addCleanup(page.close)
            stops = self.moving(page)
            if leave == "close":
                page.close()
            elif leave == "silence":
                page.beats = False
            else:
                self.assertTrue(page.act("stop")[0])
            self.still(stops, leave)
            watcher = Page(self.url)
            self.addCleanup(watcher.close)
            self.assertTrue(watcher.wait(lambda s: s["task"] is None and s["armed"] is None, 60), watcher.state())
            page.close()

    def test_4_the_end_of_the_workbench_stops_the_machine(self):
        self.listen()
        page = Page(self.url)
        self.addCleanup(page.close)
        stops = self.moving(page)
        node = rosgraph.Master("/workbench_test").lookupNode("/workbench")
        process = xmlrpc.client.ServerProxy(node).getPid("/workbench_test")[2]
        os.kill(process, signal.SIGTERM)
        self.still(stops, "SIGTERM")
        self.assertTrue(support.wait_until(lambda: not os.path.exists("/proc/%d" % process), 60), "it does not end")


if __name__ == "__main__":
    rospy.init_node("workbench_test")
    rostest.rosrun("measuring_machine", "workbench_live", Workbench)
