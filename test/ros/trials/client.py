#!/usr/bin/env python3
"""A client of the axes, to be ended in the middle: client.py plain home, or client.py <plain|ticket> <kind> <speed, m/s> <x> <y>
<z>. `ticket`: it holds the axes by a ticket of half a second that it renews. SIGUSR1: it stops the axes by the connection that
it opened before they moved."""
import signal
import sys
import threading

import actionlib
import measuring_machine.msg as messages
import rospy
from measuring_machine.srv import TakeMotion
from std_srvs.srv import Trigger

LEASE, RENEWED = 0.5, 0.1  # s

rospy.init_node("trial_client", anonymous=True)
for service in ("stop", "take", "home"):
    rospy.wait_for_service("axis_driver/" + service, 20)
stop, asked = rospy.ServiceProxy("axis_driver/stop", Trigger, persistent=True), threading.Event()
stop()  # nothing moves yet; rospy opens the connection with the first call, and keeps it
take, ticket = rospy.ServiceProxy("axis_driver/take", TakeMotion, persistent=True), 0


def renew():
    while not rospy.core.is_shutdown_requested():
        take(owner="trial", ticket=ticket, seconds=LEASE)
        asked.wait(RENEWED)


def stop_when_asked():
    asked.wait()
    stop()


signal.signal(signal.SIGUSR1, lambda *_: asked.set())
threading.Thread(target=stop_when_asked, daemon=True).start()
if sys.argv[1] == "ticket":
    ticket = take(owner="trial", seconds=LEASE).ticket
    threading.Thread(target=renew, daemon=True).start()
if sys.argv[2] == "home" and not hasattr(messages, "HomeAction"):
    rospy.ServiceProxy("axis_driver/home", Trigger)()
else:
    if sys.argv[2] == "home":
        client, goal = actionlib.SimpleActionClient("axis_driver/home", messages.HomeAction), messages.HomeGoal()
    else:
        client = actionlib.SimpleActionClient("axis_driver/move", messages.MoveAction)
        goal = messages.MoveGoal(kind=int(sys.argv[2]), ticket=ticket, linear_speed=float(sys.argv[3]), name=["x", "y", "z"],
                                 position=[float(v) for v in sys.argv[4:]])
    client.wait_for_server()
    client.send_goal(goal)
    client.wait_for_result()
