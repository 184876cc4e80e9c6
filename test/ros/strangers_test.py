#!/usr/bin/env python3
"""Joint states that are not the driver's: no frame is made of them, none of the driver's gets wrong by them, and they are named."""
import math
import os
import unittest

import actionlib
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from measuring_machine.msg import MoveAction, MoveGoal
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

import support

CORRECTED = "probe_tip_corrected"
EACH = 50
PLAY = 7e-6  # m
REST = (-0.005, 0.0, 0.0075)
HOUR = 3600.0


class Strangers(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = support.folder()
        bag = support.simulate(os.path.join(cls.folder, "s.bag"), plan="config/plans/nine_ball_plate.yaml", hide=("backlash:x=7um",))
        cls.frames, cls.statuses, cls.said, cls.own = support.Frames(CORRECTED), support.Statuses(), [], {}
        rospy.Subscriber("/diagnostics", DiagnosticArray, lambda m: cls.said.extend(s.message for s in m.status))
        rospy.Subscriber("joint_states", JointState, cls.take, queue_size=None, buff_size=1 << 24, tcp_nodelay=True)
        cls.stray = rospy.Publisher("joint_states", JointState, queue_size=1000, tcp_nodelay=True)
        support.calibrate_and_promote(bag, support.model("{type: backlash, axis: x}"))
        cls.axes = actionlib.SimpleActionClient("axis_driver/move", MoveAction)
        assert support.served(cls.axes)
        rospy.wait_for_service("axis_driver/home", 20)
        assert rospy.ServiceProxy("axis_driver/home", Trigger)().success
        # the simulator's, robot_state_publisher, calibration server, compensation and this one listen
        assert support.wait_until(lambda: cls.stray.get_num_connections() >= 4)
        assert support.wait_until(lambda: cls.frames.of(CORRECTED)), [s.message for s in cls.statuses.all]

    @classmethod
    def tearDownClass(cls):
        support.remove(cls.folder)
        support.remove(rospy.get_param("/compensation/store"))

    @classmethod
    def take(cls, message):
        if message._connection_header["callerid"] == "/axis_driver":
            cls.own[message.header.stamp.to_nsec()] = message.position

    def move(self, x, speed=0.01):
        self.axes.send_goal(MoveGoal(name=["x", "y", "z"], position=[x, *REST[1:]], linear_speed=speed))
        self.assertTrue(support.ended(self.axes, 30))

    def go_down(self):
        """To the place of rest, with the play taken up downwards. @return error of the frame there, m."""
        self.move(REST[0] + 0.002)
        self.move(REST[0])
        return self.error_now()

    def error_now(self):
        """Corrected frame less reading of x, at a state that is yet to come."""
        after = max(self.own)
        found = []

        def one():
            found[:] = [s for s in self.frames.of(CORRECTED) if s > after and s in self.own]
            return found

        self.assertTrue(support.wait_until(one, 5), self.statuses.last().message)
        return self.frames.of(CORRECTED)[found[0]][0] - self.own[found[0]][0]

    def send(self, position, velocity=(0.0, 0.0, 0.0), away=0.0):
        message = JointState(name=["x", "y", "z"], position=list(position), velocity=list(velocity))
        message.header.stamp = rospy.Time.now() + rospy.Duration(away)
        self.stray.publish(message)

    def expect_right(self, send):
        """No frame of a stray state, and the driver's as before: none wrong by more than 3 sigma."""
        right = self.go_down()
        self.frames.taken(CORRECTED)
        mark, withheld = len(self.statuses.all), self.statuses.last().withheld
        self.said.clear()
        for i in range(EACH):
            send(i)
            rospy.sleep(0.02)  # two states of the driver between them
        self.assertTrue(support.wait_until(lambda: self.statuses.last().withheld >= withheld + EACH), self.statuses.last())
        self.error_now()
        self.assertTrue(support.wait_until(lambda: max(self.own) >= max(self.frames.of(CORRECTED))))
        found, sigma = self.frames.taken(CORRECTED), self.statuses.last().sigma
        self.assertTrue(0.0 < sigma < 0.5e-6, sigma)
        wrong = [s for s, f in found.items() if s not in self.own or abs(f[0] - self.own[s][0] - right) > 3 * sigma]
        print("%d stray states, %d frames, %d wrong; sigma %.3f um" % (EACH, len(found), len(wrong), 1e6 * sigma))
        self.assertEqual(wrong, [])
        self.assertGreater(len(found), EACH)
        words = "joint states from " + rospy.get_name()  # rostest gives the name
        self.assertTrue(self.statuses.says(words, since=mark), [s.message for s in self.statuses.all[mark:]])
        self.assertTrue(support.wait_until(lambda: any(words in s for s in self.said)), sorted(set(self.said)))
        self.assertTrue(self.statuses.last().publishing)

    def test_1_the_play_is_seen(self):
        down = self.go_down()
        self.move(REST[0] + 0.002)
        self.assertAlmostEqual(abs(self.error_now() - down), PLAY, delta=0.2e-6)

    def test_2_a_stray_place(self):
        self.expect_right(lambda i: self.send([-0.007, 0.0, 0.0075]))

    def test_3_on_the_way_up(self):
        self.expect_right(lambda i: self.send([REST[0] + 1e-5 * i, *REST[1:]], (1e-3, 0.0, 0.0)))

    def test_4_late(self):
        self.expect_right(lambda i: self.send([-0.007, 0.0, 0.0075], away=-HOUR))

    def test_5_early(self):
        self.expect_right(lambda i: self.send([-0.007, 0.0, 0.0075], away=HOUR))

    def test_6_not_a_number(self):
        self.expect_right(lambda i: self.send([math.nan, 0.0, 0.0075], (math.nan, 0.0, 0.0)))

    def test_7_compensation_comes_up_among_them(self):
        """It is the driver's status that says whose the joints are, not who was heard first."""
        right = self.go_down()
        support.kill("/compensation")
        seen = len(self.statuses.all)
        self.frames.taken(CORRECTED)

        def up():
            self.send([-0.007, 0.0, 0.0075])
            return any(s.frames > 20 and s.withheld > 20 for s in self.statuses.all[seen:])

        self.assertTrue(support.wait_until(up, 30), self.statuses.last())
        self.assertTrue(support.wait_until(lambda: max(self.own) >= max(self.frames.of(CORRECTED))))
        found = self.frames.taken(CORRECTED)
        wrong = [s for s, f in found.items() if s not in self.own or abs(f[0] - self.own[s][0] - right) > 0.2e-6]
        self.assertEqual(wrong, [])


if __name__ == "__main__":
    rospy.init_node("strangers_test")
    rostest.rosrun("measuring_machine", "strangers", Strangers)
