#!/usr/bin/env python3
"""Promote and rollback under load: no missed frame, and no frame that mixes two calibrations."""
import os
import time
import unittest

import actionlib
import rospy
import rostest
from measuring_machine.msg import MoveAction, MoveGoal
from measuring_machine.srv import Calibrate, Promote, Rollback
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

import support


class Swap(unittest.TestCase):
    def test_1_no_frame_before_homing_and_travel_known_after_a_restart(self):
        """An error that depends on the direction of travel: the driver tells it to a node that starts after the motion."""
        folder = support.folder()
        self.addCleanup(support.remove, folder)
        bag = support.simulate(os.path.join(folder, "s.bag"))
        frames, statuses = support.Frames("probe_tip_corrected"), support.Statuses()
        support.calibrate_and_promote(bag, support.model("{type: scale, axis: x}", "{type: backlash, axis: x}"))
        self.assertTrue(statuses.says("the axes are not homed"), [s.message for s in statuses.all])
        self.assertEqual(frames.of("probe_tip_corrected"), {})
        rospy.wait_for_service("axis_driver/home", 20)
        self.assertTrue(rospy.ServiceProxy("axis_driver/home", Trigger)().success)
        self.assertTrue(support.wait_until(lambda: frames.of("probe_tip_corrected")), [s.message for s in statuses.all])
        support.kill("/compensation")
        seen = len(statuses.all)
        self.assertTrue(support.wait_until(lambda: any(s.frames > 0 for s in statuses.all[seen:]), 20),
                        [s.message for s in statuses.all[seen:]])

    def test_2_swaps(self):
        folder = support.folder()
        self.addCleanup(support.remove, folder)
        self.addCleanup(support.remove, rospy.get_param("/compensation/store"))
        bag = support.simulate(os.path.join(folder, "s.bag"))
        rospy.wait_for_service("axis_driver/home", 20)
        self.assertTrue(rospy.ServiceProxy("axis_driver/home", Trigger)().success)
        one = support.calibrate_and_promote(bag, support.model("{type: scale, axis: x}"))
        rospy.wait_for_service("calibration_server/calibrate", 20)
        calibrate = rospy.ServiceProxy("calibration_server/calibrate", Calibrate)
        two = calibrate(bag=bag, method="least_squares", model=support.model("{type: scale, axis: x}", "{type: scale, axis: y}"))
        promote = rospy.ServiceProxy("calibration_server/promote", Promote)
        rollback = rospy.ServiceProxy("calibration_server/rollback", Rollback)

        joints, frames, statuses = {}, support.Frames("probe_tip_corrected"), support.Statuses()

        def take(message):
            joints[message.header.stamp.to_nsec()] = message.position

        rospy.Subscriber("joint_states", JointState, take, queue_size=None, buff_size=1 << 24, tcp_nodelay=True)
        axes = actionlib.SimpleActionClient("axis_driver/move", MoveAction)
        self.assertTrue(support.served(axes, seconds=10))
        self.assertTrue(support.wait_until(lambda: statuses.last().calibration_id == one.calibration_id))
        # What was under way then may still be of test 1's calibration, and arrive late.
        in_use = rospy.Time.now().to_nsec()
        self.assertTrue(support.wait_until(lambda: joints and max(joints) > in_use))
        self.assertTrue(support.wait_until(lambda: any(stamp > in_use for stamp in frames.of("probe_tip_corrected"))))
        # Towards z = 0.006 and back, with x and y as well; nothing is in the way above the plate.
        axes.send_goal(MoveGoal(name=["x", "y", "z"], position=[0.012, 0.0, 0.0075], linear_speed=0.001))
        began = max(max(joints), in_use)
        swaps, before = 0, len(joints)
        while swaps <= 20 or len(joints) - before < 2000:
            self.assertTrue(promote(calibration_id=two.calibration_id).success)
            time.sleep(0.13)
            self.assertTrue(rollback(calibration_id=one.calibration_id).success)
            time.sleep(0.17)
            swaps += 2
        ended = max(joints)
        axes.cancel_all_goals()
        self.assertTrue(support.wait_until(lambda: max(frames.of("probe_tip_corrected")) > ended))
        wanted = {s for s in list(joints) if began <= s <= ended}  # a copy: states still arrive
        found = {s: f for s, f in frames.of("probe_tip_corrected").items() if began <= s <= ended}
        self.assertGreater(len(wanted), 1500)
        self.assertEqual(frames.doubled, 0)
        self.assertEqual(wanted - set(found), set(), "frames missed")

        sx1, sx2, sy2 = support.scale(one.json, "x"), support.scale(two.json, "x"), support.scale(two.json, "y")
        self.assertGreater(abs(sx1 - sx2), 1e-8)  # the two can be told apart
        kinds = {"one": 0, "two": 0}
        for stamp, (x, y, z) in found.items():
            q = joints[stamp]
            first = abs(x - q[0] * (1 + sx1)) + abs(y - q[1]) + abs(z - q[2])
            second = abs(x - q[0] * (1 + sx2)) + abs(y - q[1] * (1 + sy2)) + abs(z - q[2])
            self.assertLess(min(first, second), 1e-12, "a frame of neither calibration")
            kinds["one" if first < second else "two"] += 1
        self.assertGreater(kinds["one"], 300)
        self.assertGreater(kinds["two"], 300)
        print("swaps %d, frames %d of %d, by calibration %s" % (swaps, len(found), len(wanted), kinds))


if __name__ == "__main__":
    rospy.init_node("swap_test")
    rostest.rosrun("measuring_machine", "swap", Swap)
