#!/usr/bin/env python3
"""kill -9 of each node of the instrument, MM_KILLS times (once, four in a thorough and a hundred in a long test): each comes back, and every corrected frame is
that of its own joint state, of homed axes."""
import os
import threading
import time
import unittest
from bisect import bisect, insort

import rosgraph
import rospy
import rostest
from sensor_msgs.msg import JointState

import support

KILLS = int(os.environ.get("MM_KILLS", "100" if support.long_tests() else "4" if support.thorough_tests() else "1"))
NODES = ("axis_driver", "probe", "temperature", "measure", "calibration_server", "compensation")
CORRECTED = "probe_tip_corrected"
NEXT = int(5e6)  # ns between joint states of one driver, which gives 500 a second
WRONG = 1e-9  # m: a frame of another state, or of another calibration, is further off


class Kills(unittest.TestCase):
    def home(self):
        self.assertTrue(support.home_again())

    def take(self, message):
        with self.lock:
            position = dict(zip(message.name, message.position))
            insort(self.stamps, message.header.stamp.to_nsec())
            self.states[message.header.stamp.to_nsec()] = (message.header.frame_id != "unhomed", position["x"], position["y"])

    def check(self):
        """Frames against their states; both are then forgotten. @return how many frames were compared."""
        with self.lock:
            states, self.states = self.states, {}
        self.newest = max(self.newest, self.last())
        frames = self.frames.taken(CORRECTED)
        frames.update(self.unmatched)
        self.unmatched = {s: f for s, f in frames.items() if s not in states and s > self.newest - int(2e9)}
        with self.lock:
            self.orphans += sum(self.between(s) for s in frames if s not in states and s not in self.unmatched)
        for stamp, (x, y, z) in frames.items():
            if stamp not in states:
                continue
            homed, qx, qy = states.pop(stamp)
            self.unhomed += not homed
            self.wrong += abs(x - qx * (1 + self.scale)) > WRONG or abs(y - qy) > WRONG
            self.compared += 1
        with self.lock:  # the newest may still be on their way
            newest = max(states, default=0) - int(2e9)
            self.states.update({s: v for s, v in states.items() if s > newest})

    def between(self, stamp):
        """Whether joint states were heard shortly before and after it: one of its own would have been, too."""
        at = bisect(self.stamps, stamp)
        return 0 < at < len(self.stamps) and self.stamps[at] - self.stamps[at - 1] < NEXT

    def last(self):
        """Stamp of the newest corrected frame so far."""
        return max(self.newest, self.frames.newest(CORRECTED))

    def contact(self, name):
        try:
            return rosgraph.Master("/test").lookupNode("/" + name)
        except rosgraph.MasterError:
            return ""

    def test_every_node(self):
        folder = support.folder()
        self.addCleanup(support.remove, folder)
        self.addCleanup(support.remove, rospy.get_param("/compensation/store"))
        bag = support.simulate(os.path.join(folder, "s.bag"))
        answer = support.calibrate_and_promote(bag, support.model("{type: scale, axis: x}"))
        self.scale = support.scale(answer.json, "x")
        self.frames, self.states, self.lock = support.Frames(CORRECTED), {}, threading.Lock()
        self.unmatched, self.newest, self.wrong, self.unhomed, self.compared = {}, 0, 0, 0, 0
        self.stamps, self.orphans = [], 0
        rospy.Subscriber("joint_states", JointState, self.take, queue_size=None, buff_size=1 << 24, tcp_nodelay=True)
        self.home()
        self.assertTrue(support.wait_until(lambda: self.frames.of(CORRECTED), 30))
        for name in NODES:
            began, before = time.time(), self.compared
            for _ in range(KILLS):
                was = self.contact(name)
                support.kill("/" + name)
                self.assertTrue(support.wait_until(lambda: self.contact(name) not in ("", was), 30), name + " comes back")
                if name == "axis_driver":
                    time.sleep(0.2)  # unhomed states, of which there must be no frame
                    self.check()
                    self.home()
                last = self.last()
                self.assertTrue(support.wait_until(lambda: self.last() > last, 40),
                                "frames come again after " + name)
                self.check()
            print("%-20s %d kills in %.0f s: %d frames compared" % (name, KILLS, time.time() - began, self.compared - before))
        support.wait_until(lambda: False, 1.0)
        self.check()
        print("%d frames compared with their joint states: %d wrong, %d unhomed, %d of no joint state" % (self.compared, self.wrong,
                                                                                                     self.unhomed, self.orphans))
        self.assertGreater(self.compared, 100 * KILLS)
        self.assertEqual((self.wrong, self.unhomed, self.orphans), (0, 0, 0))


if __name__ == "__main__":
    rospy.init_node("kills_test")
    rostest.rosrun("measuring_machine", "kills", Kills)
