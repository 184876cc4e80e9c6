#!/usr/bin/env python3
"""How soon an emergency stop stops, whatever else is asked of the computer and of the driver."""
import subprocess
import sys
import threading
import time
import unittest

import actionlib
import rosgraph
import rospy
import rostest
from measuring_machine.msg import MoveAction, MoveActionGoal, MoveGoal
from measuring_machine.srv import BreakDevice
from std_srvs.srv import SetBool, Trigger

import support

FLOOD = """
import rospy
from measuring_machine.msg import MoveActionGoal, MoveGoal
rospy.init_node("large", disable_signals=True)
out = rospy.Publisher("axis_driver/move/goal", MoveActionGoal, queue_size=1)
large = MoveActionGoal(goal=MoveGoal(feature="x" * 20000000))
large.goal_id.id = "/large-1-1.0"
while out.get_num_connections() == 0:
    rospy.rostime.wallsleep(0.01)
print("flooding", flush=True)
while True:
    out.publish(large)
"""


class EmergencyStop(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.axes = actionlib.SimpleActionClient("axis_driver/move", MoveAction)
        assert support.served(cls.axes, seconds=60)

    @classmethod
    def tearDownClass(cls):
        support.remove(rospy.get_param("/compensation/store"))

    def call(self, service, kind=Trigger, **keys):
        rospy.wait_for_service(service, 20)
        return rospy.ServiceProxy(service, kind)(**keys)

    def home(self):
        self.assertTrue(support.wait_until(lambda: self.call("axis_driver/home").success, 10))

    def test_1_under_load(self):
        """From the call to the answer, which comes after the controller was told."""
        emergency = rospy.ServiceProxy("axis_driver/emergency_stop", SetBool, persistent=True)
        threads, processes, flood = [], [], [True]

        def homes():
            for _ in range(5):
                one = threading.Thread(target=lambda: rospy.ServiceProxy("axis_driver/home", Trigger)())
                one.start()
                threads.append(one)

        def goals():
            def run():
                out = rospy.Publisher("axis_driver/move/goal", MoveActionGoal, queue_size=1000)
                while flood[0]:
                    goal = MoveActionGoal(goal=MoveGoal(name=["x"], position=[0.001]))
                    goal.goal_id.id = "/flood-%d" % time.monotonic_ns()
                    out.publish(goal)
                    time.sleep(0.002)
            threads.append(threading.Thread(target=run))
            threads[-1].start()

        def stuck():
            self.call("axis_driver/break_device", BreakDevice, fault="stuck")

        def busy():
            for _ in range(4):
                processes.append(subprocess.Popen([sys.executable, "-c", "while True: pass"]))

        for name, load in (("nothing", lambda: None), ("five calls of home", homes), ("500 goals a second", goals),
                           ("a device that does not answer", stuck), ("four busy processes", busy)):
            self.home()
            load()
            took = []
            for _ in range(10):
                began = time.monotonic()
                answer = emergency(True)
                took.append(1e3 * (time.monotonic() - began))
                self.assertTrue(answer.success, answer.message)
                time.sleep(0.05)
            flood[0] = False
            for one in threads:
                one.join()
            for one in processes:
                one.kill()
                one.wait()
            self.call("axis_driver/break_device", BreakDevice, fault="ok")
            print("emergency stop, load %s: median %.1f ms, largest %.1f ms" % (name, sorted(took)[5], max(took)))
            # Promised are 50 ms, 99 times in a hundred, to whom the computer lets run. One that waits for homing or a device takes seconds.
            self.assertLess(sorted(took)[5], 50.0, name)
            self.assertLess(max(took), 500.0, name)
            self.assertFalse(self.call("axis_driver/home").success)
            self.assertTrue(support.wait_until(lambda: emergency(False).success, 5))
            self.axes.send_goal(MoveGoal(name=["x", "y", "z"], position=[0.0, 0.0, 0.010]))
            self.assertTrue(support.ended(self.axes, 20))
            self.assertIn("not homed", self.axes.get_result().message)
            flood[0] = True

    def test_2_beside_large_messages(self):
        """20 MB each to the topic that everybody may send to, and a new connection for each call."""
        flood = subprocess.Popen([sys.executable, "-c", FLOOD], stdout=subprocess.PIPE)  # of its own: it would hold this interpreter
        self.assertEqual(flood.stdout.readline(), b"flooding\n")
        uri = rosgraph.Master("/test").lookupService("/axis_driver/emergency_stop")
        took = []
        try:
            for _ in range(200):
                stop = rospy.ServiceProxy("axis_driver/emergency_stop", SetBool)
                began = time.monotonic()
                self.assertTrue(stop(True).success)
                took.append(1e3 * (time.monotonic() - began))
        finally:
            flood.kill()
            flood.communicate()
        took.sort()
        print("emergency stop at %s beside 20 MB: median %.1f ms, 99 %% %.1f ms, most %.1f ms" % (uri, took[100], took[197], took[-1]))
        self.assertLess(took[197], 50.0)
        self.assertTrue(support.wait_until(lambda: rospy.ServiceProxy("axis_driver/emergency_stop", SetBool)(False).success))


if __name__ == "__main__":
    rospy.init_node("emergency_stop_test")
    rostest.rosrun("measuring_machine", "emergency_stop", EmergencyStop)
