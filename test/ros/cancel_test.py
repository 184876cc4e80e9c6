#!/usr/bin/env python3
"""A long call is refused beside another, hears cancel in every stage that it has, and the node lives on."""
import os
import threading
import time
import unittest

import rospy
import rostest
from actionlib import GoalStatus, SimpleActionClient
from measuring_machine.msg import CalibrateAction, CalibrateActionFeedback, CalibrateGoal, DiagnoseAction, DiagnoseGoal, Progress
from measuring_machine.srv import Calibrate, Cancel, Compare, Diagnose

import support


def service(name, kind, **request):
    rospy.wait_for_service("calibration_server/" + name, 20)
    return rospy.ServiceProxy("calibration_server/" + name, kind)(**request)


PATIENCE = 300.0  # s for what comes by itself; the thread sanitizer makes the server some thirty times slower
ALWAYS = ["reading the bag", "genetic"]  # stages of the calibration here


class CancelTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = support.folder()
        cls.bag = support.simulate(os.path.join(cls.folder, "s.bag"))
        cls.big = support.simulate(os.path.join(cls.folder, "big.bag"), "config/plans/micro_machine_tool.yaml")

    @classmethod
    def tearDownClass(cls):
        support.remove(cls.folder)
        support.remove(rospy.get_param("/calibration_server/store"))

    def stages_of(self, bag, effects):
        """Those of a calibration that nobody cancels."""
        seen = []
        watch = rospy.Subscriber("calibration_server/progress", Progress, lambda m: seen.append(m.stage), queue_size=None)
        done = service("calibrate", Calibrate, bag=bag, model=effects)
        self.assertTrue(done.calibration_id, done.message)
        watch.unregister()
        stages = [s for i, s in enumerate(seen) if s and s not in seen[:i]]
        self.assertLessEqual(set(ALWAYS), set(stages))
        self.assertGreater(len(stages), len(ALWAYS))
        return stages

    def test_one_at_a_time_and_cancel_in_every_stage(self):
        """A run on a large session: refused beside it, cancelled in each stage it has (every day two), and the node lives on."""
        effects = support.model("{type: mmt_deviation, axis: x, lead_mm: 0.5}", "{type: mmt_deviation, axis: y, lead_mm: 0.5}", "{type: mmt_deviation, axis: z, lead_mm: 0.5}")
        refused = 0
        stages = self.stages_of(self.big, effects) if support.thorough_tests() else ALWAYS
        for stage in stages:
            now, answers = [""], []
            watch = rospy.Subscriber("calibration_server/progress", Progress, lambda m: now.__setitem__(0, m.stage), queue_size=None)
            call = threading.Thread(target=lambda: answers.append(service("calibrate", Calibrate, bag=self.big, model=effects)))
            call.start()
            self.assertTrue(support.wait_until(lambda: now[0] == stage or answers, PATIENCE))
            if not answers:
                second = service("compare", Compare, bag=self.bag)
                refused += "'calibrate' has been running for" in second.message and not second.success
                service("cancel", Cancel)
            began = time.time()
            call.join(PATIENCE)  # how often a cancel is asked for in each stage: the unit tests Cancel.*
            self.assertFalse(call.is_alive(), "cancel in stage '%s' was not heard" % stage)
            print("cancelled in '%s': answered after %.2f s" % (stage, time.time() - began))
            if stage in ALWAYS:
                self.assertFalse(answers[0].success, stage)
                self.assertIn("cancelled", answers[0].message)
            watch.unregister()
        self.assertGreater(refused, 0)
        small = service("calibrate", Calibrate, bag=self.bag, model=support.model("{type: scale, axis: x}"), method="least_squares")
        for part in range(3 if support.thorough_tests() else 2):
            begun, answers = [], []
            watch = rospy.Subscriber("calibration_server/progress", Progress, lambda m: m.stage in begun or begun.append(m.stage),
                                     queue_size=None)
            call = threading.Thread(target=lambda: answers.append(
                service("diagnose", Diagnose, bag=self.big, calibration=small.calibration_id)))
            call.start()
            # In its first, second and third stage, beside what was there before it began.
            self.assertTrue(support.wait_until(lambda: len([s for s in begun if s]) > part or answers, PATIENCE), begun)
            if answers:
                break  # it was faster
            service("cancel", Cancel)
            began = time.time()
            call.join(PATIENCE)
            self.assertFalse(call.is_alive(), "the diagnosis did not hear cancel")
            print("diagnosis cancelled in '%s': answered after %.2f s" % (begun[-1], time.time() - began))
            self.assertFalse(answers[0].success)
            self.assertIn("cancelled", answers[0].message)
            watch.unregister()
        self.assertTrue(service("compare", Compare, bag=self.bag, calibration=small.calibration_id).success)

    def client(self, name, kind):
        client = SimpleActionClient("calibration_server/" + name, kind)
        self.assertTrue(support.served(client))
        return client

    def test_the_action_does_what_the_service_does(self):
        request = dict(bag=self.bag, model=support.model("{type: scale, axis: x}"), method="least_squares")
        answer, client, stages = service("calibrate", Calibrate, **request), self.client("calibrate", CalibrateAction), []
        # actionlib's client passes over what comes before its send_goal has returned
        heard = rospy.Subscriber("calibration_server/calibrate/feedback", CalibrateActionFeedback,
                                 lambda told: stages.append(told.feedback.stage))
        self.assertTrue(support.wait_until(lambda: heard.get_num_connections() > 0))
        client.send_goal(CalibrateGoal(**request))
        self.assertTrue(support.ended(client, PATIENCE))
        self.assertEqual(client.get_state(), GoalStatus.SUCCEEDED)
        self.assertEqual(support.figures(client.get_result().json), support.figures(answer.json))
        self.assertTrue(client.get_result().calibration_id)
        self.assertTrue(support.wait_until(lambda: "reading the bag" in stages), stages)
        heard.unregister()
        client.send_goal(CalibrateGoal(bag="/nowhere/s.bag", model=request["model"]))
        self.assertTrue(support.ended(client, PATIENCE))
        self.assertEqual(client.get_state(), GoalStatus.ABORTED)
        self.assertIn("/nowhere/s.bag", client.get_result().message)
        diagnosis = self.client("diagnose", DiagnoseAction)
        diagnosis.send_goal(DiagnoseGoal(bag="/nowhere/s.bag"))
        self.assertTrue(support.ended(diagnosis, PATIENCE))
        self.assertEqual(diagnosis.get_state(), GoalStatus.ABORTED)

    def test_a_goal_is_cancelled_and_none_takes_its_place(self):
        goal = CalibrateGoal(bag=self.big, model=support.model("{type: mmt_deviation, axis: x, lead_mm: 0.5}", "{type: mmt_deviation, axis: y, lead_mm: 0.5}"))
        first, second, seen = self.client("calibrate", CalibrateAction), self.client("calibrate", CalibrateAction), []
        first.send_goal(goal, feedback_cb=lambda f: seen.append(f.stage))
        self.assertTrue(support.wait_until(lambda: "genetic" in seen, PATIENCE), seen)
        second.send_goal(goal)
        self.assertTrue(support.ended(second, PATIENCE))
        self.assertEqual(second.get_state(), GoalStatus.REJECTED)
        self.assertIn("'calibrate' has been running for", second.get_result().message)
        refused = service("compare", Compare, bag=self.bag)
        self.assertIn("'calibrate' has been running for", refused.message)
        second.cancel_goal()  # of a goal that has ended: it is not the first one's
        self.assertNotEqual(first.get_state(), GoalStatus.PREEMPTED)
        first.cancel_goal()
        self.assertTrue(support.ended(first, PATIENCE))
        self.assertEqual(first.get_state(), GoalStatus.PREEMPTED)
        self.assertIn("cancelled", first.get_result().message)
        # The cancel of a goal that is over does not reach what another caller began.
        answers = []
        call = threading.Thread(target=lambda: answers.append(service("calibrate", Calibrate, bag=self.bag, method="least_squares",
                                                                      model=support.model("{type: scale, axis: x}"))))
        call.start()
        first.cancel_all_goals()
        call.join(PATIENCE)
        self.assertTrue(answers[0].success, answers[0].message)


if __name__ == "__main__":
    rospy.init_node("cancel_test")
    rostest.rosrun("measuring_machine", "cancel", CancelTest)
