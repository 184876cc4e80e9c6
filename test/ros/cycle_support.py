"""A plan on real controllers: measured, recorded, calibrated by service."""
import os
import signal
import subprocess

import actionlib
import rospy
from actionlib_msgs.msg import GoalStatus
from measuring_machine.msg import MeasureAction, MeasureGoal
from measuring_machine.srv import Calibrate
from std_msgs.msg import String
from std_srvs.srv import SetBool, Trigger

import support


def ready(seconds=60):
    """The driver found its controller, and the axes are homed."""
    rospy.wait_for_service("axis_driver/home", seconds)
    reset = rospy.ServiceProxy("axis_driver/emergency_stop", SetBool)
    assert support.wait_until(lambda: reset(False).success, 10)
    home, said = rospy.ServiceProxy("axis_driver/home", Trigger), []

    def homed():
        said.append(home())
        return said[-1].success

    assert support.wait_until(homed, 20), said[-1].message


def record(plan, bag, seconds, first=0):
    """@param first the move with which the plan begins, or goes on. @return the result of the plan."""
    recorder = subprocess.Popen(["rosrun", "measuring_machine", "session_recorder.py", bag, "__name:=recorder"])
    try:
        assert rospy.wait_for_message("/recorder/recording", String, 30).data == bag  # every publisher is heard
        measure = actionlib.SimpleActionClient("measure/run", MeasureAction)
        assert support.served(measure, seconds=20)
        measure.send_goal(MeasureGoal(plan=plan, first=first))
        assert support.ended(measure, seconds), "the plan did not end"
        assert measure.get_state() == GoalStatus.SUCCEEDED, measure.get_result().message
        return measure.get_result()
    finally:
        recorder.send_signal(signal.SIGINT)
        recorder.wait(20)
        assert os.path.exists(bag), "the bag was not finished"


def calibrate(bag, model):
    rospy.wait_for_service("calibration_server/calibrate", 20)
    return rospy.ServiceProxy("calibration_server/calibrate", Calibrate)(bag=bag, model=model, method="least_squares", seed=1)
