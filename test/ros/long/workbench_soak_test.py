#!/usr/bin/env python3
"""MM_WORKBENCH_MINUTES of ten pages of the workbench on a machine that moves, its joint states at 1 kHz: eight that read, one in a
browser, one that never takes what it is sent. At the end what was lost, how the memory went, how late the states were."""
import json
import multiprocessing
import os
import re
import socket
import struct
import sys
import threading
import time
import unittest
import xmlrpc.client

import rosgraph
import rospy
import rostest

HERE = os.path.dirname(os.path.realpath(__file__))
sys.path.insert(0, os.path.join(HERE, ".."))
import support  # noqa: E402
from workbench_test import Page  # noqa: E402

sys.path.insert(0, os.path.join(support.PACKAGE, "test", "support"))
from browser import Browser, Socket  # noqa: E402

MINUTES = float(os.environ.get("MM_WORKBENCH_MINUTES", "5"))
READERS = 8
NODES = ("workbench", "compensation", "axis_driver", "calibration_server", "measure")
NEAR = 60  # states, 2 s: a reader's last and the newest at the end
GROWTH = 8.0  # MB that a node may gain after the first third
SETTLED = 3.0  # min, for the pools of threads and allocators to have what they need


def text_at(data, at):
    size = struct.unpack_from("<I", data, at)[0]
    return data[at + 4:at + 4 + size], at + 4 + size


class Count:
    """Stamps of the joint states and of the corrected frames, read from the bytes of the messages: nothing is sampled."""

    def __init__(self):
        self.states, self.frames, self.gaps, self.last = {}, {}, 0, None
        self.nominal = 0
        self.subscribers = [rospy.Subscriber(topic, rospy.AnyMsg, take, queue_size=None, buff_size=1 << 24, tcp_nodelay=True)
                            for topic, take in (("/joint_states", self.state), ("/tf", self.frame))]

    def state(self, message):
        data = message._buff
        number, s, ns = struct.unpack_from("<III", data)
        frame, at = text_at(data, 12)
        if struct.unpack_from("<I", data, at)[0] == 0 or text_at(data, at + 4)[0] != b"x":
            return
        if self.last is not None and number != self.last + 1:
            self.gaps += number - self.last - 1
        self.last = number
        if frame != b"unhomed":
            self.states[s * 10**9 + ns] = time.time()

    def frame(self, message):
        data, at = message._buff, 4
        for _ in range(struct.unpack_from("<I", data)[0]):
            s, ns = struct.unpack_from("<II", data, at + 4)
            _, at = text_at(data, at + 12)
            child, at = text_at(data, at)
            at += 56
            if child == b"probe_tip_corrected":
                self.frames[s * 10**9 + ns] = time.time()


def count(master, going, queue):
    """In a process of its own, so that nothing else holds it up."""
    os.environ["ROS_MASTER_URI"] = master
    rospy.init_node("workbench_soak_count", argv=sys.argv[:1], disable_signals=True)  # not under the name of the test
    c = Count()
    going.wait()
    while going.is_set():
        time.sleep(0.1)
    time.sleep(1.0)
    states, frames = dict(c.states), dict(c.frames)
    # what came while the one subscription stood and the other did not, and what is on its way at the end, does not count
    begin, end = max(min(states), min(frames)) + 300000000, min(max(states), max(frames)) - 300000000
    inner = [s for s in states if begin <= s <= end]
    late = sorted(frames[s] - 1e-9 * s for s in inner if s in frames)
    queue.put({"states": len(inner), "without": sum(s not in frames for s in inner), "gaps": c.gaps, "seconds": 1e-9 * (end - begin),
               "late": [late[len(late) // 2], late[int(0.99 * len(late))], late[-1]] if late else None})


def stalled_socket(url):
    """A page that reads nothing and says that it is there: the server has no reason to end it."""
    found = re.match(r"http://([^/:]+):(\d+)/\?token=(\w+)", url)
    s = socket.socket()
    s.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    s.connect((found.group(1), int(found.group(2))))
    real, socket.create_connection = socket.create_connection, lambda *_: s
    try:
        return Socket("ws://%s:%s/live?token=%s" % found.groups())
    finally:
        socket.create_connection = real


def pages(url, going, queue):
    """The readers and the one that stalls, in a process of their own."""
    parts = re.match(r"http://([^/]+)/\?token=(\w+)", url)
    seen = [[] for _ in range(READERS)]  # (when, sequence, has a correction)

    def read(i):
        page = Socket("ws://%s/live?token=%s" % parts.groups())
        while going.is_set():
            text = page.receive()
            found = re.search(r'"sequence":(\d+)', text)
            if found:
                seen[i].append((time.time(), int(found.group(1)), '"corrected_mm":[' in text))
        page.close()

    stalled = stalled_socket(url)
    threads = [threading.Thread(target=read, args=(i,), daemon=True) for i in range(READERS)]
    for t in threads:
        t.start()
    held = True
    while going.is_set():
        try:
            stalled.send("heartbeat")
        except OSError:
            held = False
        time.sleep(0.25)
    for t in threads:
        t.join(10)
    latest, taken = max((s[-1][1] for s in seen if s), default=0), []
    try:
        while not taken or taken[-1] < latest:
            found = re.search(r'"sequence":(\d+)', stalled.receive())
            if found:
                taken.append(int(found.group(1)))
    except OSError:
        held = False
    queue.put({"seen": seen, "stalled": taken, "held": held})


class WorkbenchSoak(unittest.TestCase):
    def memory(self, name):
        pid = xmlrpc.client.ServerProxy(rosgraph.Master("/soak").lookupNode("/" + name)).getPid("/soak")[2]
        with open("/proc/%d/status" % pid) as f:
            return next(int(line.split()[1]) for line in f if line.startswith("VmRSS")) / 1024.0

    def plan(self):
        """There and back above the balls until the time is over, then a few contacts."""
        with open(os.path.join(support.PACKAGE, "config/demo_plan.yaml")) as f:
            text = f.read()
        there_and_back = "  - {x_mm: 13, y_mm: 28, speed_mm_s: 10}\n  - {x_mm: -13, y_mm: -8, speed_mm_s: 10}\n"
        return text.replace("touch:", "moves:\n  - {z_mm: 12}\n" + int(60 * MINUTES / 8 + 4) * there_and_back + "touch:").replace("points: 24", "points: 6")

    def promoted(self):
        folder = support.folder()
        self.addCleanup(support.remove, folder)
        self.addCleanup(support.remove, rospy.get_param("/compensation/store"))
        bag = support.simulate(os.path.join(folder, "before.bag"), hide=support.HIDDEN)
        support.calibrate_and_promote(bag, support.model("{type: scale, axis: x}", "{type: scale, axis: y}"))

    def test_ten_pages(self):
        self.assertTrue(support.wait_until(lambda: rospy.has_param("/workbench/url"), 60))
        url = rospy.get_param("/workbench/url")
        self.assertTrue(support.home_again(60))
        self.promoted()
        going, told = multiprocessing.Event(), multiprocessing.Queue()
        mover = Page(url)  # it holds the machine, and is none of the ten
        self.addCleanup(mover.close)
        self.assertTrue(mover.wait(lambda s: s["machine"]["corrected_mm"], 30), "no corrected frame after the promotion")
        self.assertTrue(mover.act("arm", client=mover.client)[0])
        mover.post("run", client=mover.client, plan=self.plan())
        self.assertTrue(mover.wait(lambda s: s["machine"]["moving"] and s["machine"]["measuring"], 60), mover.state())
        others = multiprocessing.Process(target=pages, args=(url, going, told), daemon=True)
        self.addCleanup(self.end, going, others)
        with Browser(400, 800) as browser:
            browser.command("Network.disable")  # it would tell of every state
            browser.open(url + "#measure")  # the machine as it moves, and a plan on it
            with open(os.path.join(support.PACKAGE, "test/ros/short_plan.yaml")) as f:
                browser.wait("document.querySelector('#plan')")
                browser.evaluate("""(() => { const p = document.querySelector("#plan"); p.value = %s; p.dispatchEvent(new Event("input", { bubbles: true })); })()"""
                                 % json.dumps(f.read()))
            browser.wait("document.querySelector('.canvas') && document.querySelector('.canvas').dataset.frameMs", 120)
            module = "import('/t/%s/app/server.js')" % re.search(r"token=(\w+)", url).group(1)
            browser.evaluate("""%s.then((m) => { window.drawn = []; let last = m.state.sequence; const look = (now) => {
                if (m.state.sequence !== last) { last = m.state.sequence; window.drawn.push(now); } requestAnimationFrame(look); }; requestAnimationFrame(look); return true; })""" % module)
            going.set()
            COUNTING.set()
            others.start()
            rss, drawn, until = [], [], time.time() + 60 * MINUTES
            while time.time() < until:
                rss.append({n: self.memory(n) for n in NODES})
                self.assertTrue(mover.state()["machine"]["measuring"], mover.state())
                drawn += browser.evaluate("window.drawn.splice(0)")
                time.sleep(min(5.0, max(0.1, until - time.time())))
            clients, newest = max(s["clients"] for _, s in mover.states), mover.state()["sequence"]
            going.clear()
            COUNTING.clear()
            page = browser.evaluate("({ frame: Number(document.querySelector('.canvas').dataset.frameMs), heap: performance.memory.usedJSHeapSize / 1e6 })")
            page["drawn"], errors = drawn, list(browser.errors)
        seen, counted = told.get(timeout=120), COUNTED.get(timeout=120)
        self.assertTrue(mover.act("disarm", client=mover.client)[0])
        self.tell(seen, counted, rss, page, errors, clients, newest)

    @staticmethod
    def end(going, others):
        """Nothing of this test outlives it, whatever became of it."""
        going.clear()
        COUNTING.clear()
        if others.is_alive():
            others.join(20)
            others.kill()

    def tell(self, seen, counted, rss, page, errors, clients, newest):
        print("soak: %.1f min: %d joint states (%.0f a second), %d lost on the way to the counter, %d without a corrected frame; stamp to frame: %s"
              % (MINUTES, counted["states"], counted["states"] / counted["seconds"], counted["gaps"], counted["without"],
                 "median %.1f, 99 %% %.1f, most %.1f ms" % tuple(1e3 * t for t in counted["late"]) if counted["late"] else "none"))
        lost, uncorrected, gaps = 0, 0, []
        for one in seen["seen"]:
            self.assertGreater(len(one), 10)
            self.assertGreater(one[-1][1], newest - NEAR, "a reader whose connection ended")
            lost += one[-1][1] - one[0][1] + 1 - len(one)
            uncorrected += sum(not corrected for _, _, corrected in one)
            gaps += [b[0] - a[0] for a, b in zip(one, one[1:])]
        gaps.sort()
        took = seen["seen"][0][-1][0] - seen["seen"][0][0][0]
        print("soak: %d readers, %d states each (%.1f a second), %d missed, %d without a correction; between two: median %.0f, 99 %% %.0f, most %.0f ms; at most %d pages"
              % (READERS, len(seen["seen"][0]), len(seen["seen"][0]) / took, lost, uncorrected, 1e3 * gaps[len(gaps) // 2], 1e3 * gaps[int(0.99 * len(gaps))],
                 1e3 * gaps[-1], clients))
        print("soak: the page that stalls %s, took %d states at its end" % ("was held" if seen["held"] else "was dropped", len(seen["stalled"])))
        drawn = sorted(b - a for a, b in zip(page["drawn"], page["drawn"][1:]))
        print("soak: the page in the browser: %d states drawn, between two: median %.0f, 99 %% %.0f, most %.0f ms; the machine is drawn in %.1f ms; heap %.0f MB"
              % (len(page["drawn"]), drawn[len(drawn) // 2], drawn[int(0.99 * len(drawn))], drawn[-1], page["frame"], page["heap"]))
        third = rss[len(rss) // 3]
        for n in NODES:
            print("soak: %-20s %6.1f MB at the start, %6.1f after a third, %6.1f at the end" % (n, rss[0][n], third[n], rss[-1][n]))
        self.assertEqual((counted["without"], lost, uncorrected, errors), (0, 0, 0, []))
        self.assertGreater(counted["states"], 0.9 * 1000 * counted["seconds"])
        self.assertTrue(seen["held"])
        self.assertLess(len(seen["stalled"]), 0.5 * len(seen["seen"][0]) if MINUTES >= 1 else 10**6)
        self.assertEqual(seen["stalled"], sorted(set(seen["stalled"])))
        self.assertGreaterEqual(clients, READERS + 2)
        if MINUTES >= SETTLED:
            self.assertLess(max(rss[-1][n] - third[n] for n in NODES), GROWTH)


if __name__ == "__main__":
    COUNTING, COUNTED = multiprocessing.Event(), multiprocessing.Queue()
    multiprocessing.Process(target=count, args=(os.environ["ROS_MASTER_URI"], COUNTING, COUNTED), daemon=True).start()
    rospy.init_node("workbench_soak_test")
    rostest.rosrun("measuring_machine", "workbench_soak", WorkbenchSoak)
