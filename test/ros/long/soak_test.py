#!/usr/bin/env python3
"""MM_SOAK_MINUTES of everything at once: two machines at 1 kHz that are measured, calibrated, diagnosed and corrected by
service, a replay in a loop, and at its end what was lost, how the memory went, how late the frames were."""
import os
import statistics
import sys
import threading
import time
import unittest
import xmlrpc.client

import actionlib
import rosgraph
import rospy
import rostest
from measuring_machine.msg import MeasureAction, MeasureGoal
from measuring_machine.srv import Calibrate, Compare, CorrectTarget, Diagnose
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), ".."))
import support  # noqa: E402

MINUTES = float(os.environ.get("MM_SOAK_MINUTES", "30"))
MACHINES = ("m1", "m2")
NODES = ("axis_driver", "probe", "temperature", "measure", "calibration_server", "compensation")
PLAN = os.path.join(support.PACKAGE, "test/ros/short_plan.yaml")
SAMPLE, BETWEEN = 3.0, 12.0  # s: frames are compared with joint states for so long, so often
GROWTH = 8.0                 # MB that a node may gain from the second third to the last: sessions and logs are bounded, not empty
SETTLED = 20.0               # min: the threads of a diagnosis keep what they had; after some of them no more is asked for


def memory(name):
    """RSS of a node, MB."""
    pid = xmlrpc.client.ServerProxy(rosgraph.Master("/soak").lookupNode(name)).getPid("/soak")[2]
    with open("/proc/%d/status" % pid) as f:
        return next(int(line.split()[1]) for line in f if line.startswith("VmRSS")) / 1024.0


class Sample:
    """Joint states and corrected frames of one machine for a while, by their stamps."""

    def __init__(self, machine):
        self.child, self.states, self.frames, self.lock = "%s/probe_tip_corrected" % machine, {}, {}, threading.Lock()
        self.subscribers = [
            rospy.Subscriber("/%s/joint_states" % machine, JointState, self.state, queue_size=None, buff_size=1 << 22, tcp_nodelay=True),
            rospy.Subscriber("/tf", TFMessage, self.frame, queue_size=None, buff_size=1 << 22, tcp_nodelay=True)]

    def state(self, message):
        if message.header.frame_id != "unhomed" and "x" in message.name:
            self.states[message.header.stamp.to_nsec()] = time.time()

    def frame(self, message):
        for t in message.transforms:
            if t.child_frame_id == self.child:
                self.frames[t.header.stamp.to_nsec()] = time.time()

    def end(self):
        """@return states, those without a frame, s from a stamp to the arrival of its frame."""
        time.sleep(0.5)
        for s in self.subscribers:
            s.unregister()
        if not self.states or not self.frames:
            return len(self.states), len(self.states), []
        # the first that both have, and half a second before the end
        begin = max(min(self.states), min(self.frames))
        end = min(max(self.states), max(self.frames)) - int(0.3e9)
        inner = [s for s in self.states if begin <= s <= end]
        return len(inner), sum(s not in self.frames for s in inner), [self.frames[s] - 1e-9 * s for s in inner if s in self.frames]


class Soak(unittest.TestCase):
    def call(self, name, kind, **request):
        rospy.wait_for_service(name, 30)
        return rospy.ServiceProxy(name, kind)(**request)

    def work(self, machine, bag):
        """One after the other until the time is over; what fails is kept."""
        server = "/%s/calibration_server/" % machine
        client = actionlib.SimpleActionClient("/%s/measure/run" % machine, MeasureAction)
        if not support.served(client):  # a goal that is sent before the server listens is lost
            self.failures.append("%s: the action server of measure did not answer in 60 s" % machine)
            return
        model = support.model("{type: scale, axis: x}", "{type: scale, axis: y}")
        while time.time() < self.until:
            try:
                began, at = time.time(), {"move": -1, "since": time.time()}
                client.send_goal(MeasureGoal(plan=PLAN), feedback_cb=lambda f: at.update(move=f.move, since=time.time()))
                assert support.ended(client, 120), "the plan has not ended after %.0f s: state %d, move %d for %.0f s" % (
                    time.time() - began, client.get_state(), at["move"], time.time() - at["since"])
                result = client.get_result()
                assert result.missed == 0 and result.contacts > 0, result.message
                answer = self.call(server + "calibrate", Calibrate, bag=bag, model=model, method="least_squares")
                assert answer.calibration_id, answer.message
                answer = self.call(server + "compare", Compare, bag=bag)
                assert answer.success, answer.message
                answer = self.call(server + "diagnose", Diagnose, bag=bag)
                assert answer.success, answer.message
                request = CorrectTarget._request_class(name=["x", "y", "z"], position=[0.0, 0.0, 0.0])
                request.target.x = 0.005
                rospy.wait_for_service("/%s/compensation/correct_target" % machine, 30)
                answer = rospy.ServiceProxy("/%s/compensation/correct_target" % machine, CorrectTarget)(request)
                assert answer.success, answer.message
                self.rounds[machine] += 1
            except Exception as e:  # told at the end
                self.failures.append("%s: %s" % (machine, e))
                time.sleep(1.0)

    def test_everything_at_once(self):
        folder = support.folder()
        self.addCleanup(support.remove, folder)
        self.addCleanup(support.remove, os.path.dirname(rospy.get_param("/m1/compensation/store")))
        bags = {}
        for seed, machine in enumerate(MACHINES, 1):
            bags[machine] = support.simulate(os.path.join(folder, machine + ".bag"), seed=seed)
            self.assertTrue(self.call("/%s/axis_driver/home" % machine, Trigger).success)
            support.calibrate_and_promote(bags[machine], support.model("{type: scale, axis: x}", "{type: scale, axis: y}"),
                                          "/%s/calibration_server/" % machine)
        replay = support.launch(support.free_port(), "replay.launch", "bag:=" + bags["m1"], "rate:=5", "loop:=true",
                                "store:=" + os.path.join(folder, "replayed"))
        self.addCleanup(support.stop, replay)
        self.until = time.time() + 60.0 * MINUTES
        self.rounds, self.failures = {m: 0 for m in MACHINES}, []
        workers = [threading.Thread(target=self.work, args=(m, bags[m]), daemon=True) for m in MACHINES]
        for w in workers:
            w.start()
        began, rss, latest = time.time(), [], []
        states = lost = 0
        while time.time() < self.until:
            samples = [Sample(m) for m in MACHINES]
            time.sleep(SAMPLE)
            for sample in samples:
                n, missing, late = sample.end()
                states, lost = states + n, lost + missing
                latest.append((time.time() - began, sorted(late)))
            rss.append((time.time() - began, {(m, n): memory("/%s/%s" % (m, n)) for m in MACHINES for n in NODES}))
            time.sleep(BETWEEN)
        for w in workers:
            w.join(240)
        self.assertIsNone(replay.poll(), "the replay goes on")
        self.tell(states, lost, rss, latest)

    def tell(self, states, lost, rss, latest):
        print("%.1f min, rounds of measure, calibrate, compare, diagnose, correct: %s, %d failed %s"
              % (MINUTES, self.rounds, len(self.failures), sorted(set(self.failures))[:5]))
        print("%d joint states compared with frames, %d without" % (states, lost))
        half = 60.0 * MINUTES / 2
        for name, part in (("first", [l for t, ls in latest if t < half for l in ls]), ("second", [l for t, ls in latest if t >= half for l in ls])):
            part.sort()
            if part:
                print("latency from stamp to frame, %s half: median %.1f, 99 %% %.1f, most %.1f ms"
                      % (name, 1e3 * part[len(part) // 2], 1e3 * part[int(0.99 * len(part))], 1e3 * part[-1]))
        # a calibration that runs while it is looked at has what it works with: medians of thirds
        third = max(1, len(rss) // 3)
        of = {n: (statistics.median(r[n] for _, r in rss[-2 * third:-third] or rss), statistics.median(r[n] for _, r in rss[-third:])) for n in rss[0][1]}
        grown = {n: last - middle for n, (middle, last) in of.items()}
        print("calibration_server of m1, MB: " + " ".join("%.0f" % r[("m1", "calibration_server")] for _, r in rss))
        for (machine, node), mb in sorted(grown.items()):
            print("%s/%-20s %6.1f MB, %+.2f MB from the second third to the last" % (machine, node, of[(machine, node)][1], mb))
        self.assertEqual(self.failures, [])
        self.assertGreater(min(self.rounds.values()), 0)
        self.assertGreater(states, 1000)
        self.assertEqual(lost, 0)
        if MINUTES >= SETTLED:
            self.assertLess(max(grown.values()), GROWTH)


if __name__ == "__main__":
    rospy.init_node("soak_test")
    rostest.rosrun("measuring_machine", "soak", Soak)
