#!/usr/bin/env python3
"""Joint states that are not the driver's, or cannot be true: foreign_states.py <trials> [filter]. One row a kind and moment:
corrected frames that were off their truth by more than 3 sigma, and how long none came. See scripts/foreign_states."""
import copy
import re
import statistics
import sys
import threading
import time

import rospy
from measuring_machine.msg import MoveGoal
from sensor_msgs.msg import JointState

from kill_table import KillTable
from stage import rng, support

HOUR = 3600.0
LOOKED = 0.5  # s that the frames are looked at after the last foreign state
BEFORE = 0.15  # s that is heard first: a stamp that is late lies in it
SECOND = 0.3  # s that a second publisher sends
AGAIN = 10.0  # s within which frames must come again


def stray(state, random):
    """As `rostopic pub -1` sends it: a place elsewhere, at rest, of no homing."""
    other = JointState(name=["x", "y", "z"], position=[state.position[0] - 2e-3, state.position[1], state.position[2] + 1e-3],
                       velocity=[0.0, 0.0, 0.0])
    other.header.stamp = rospy.Time.now()
    return other


def own(state, ahead=0.0, **changed):
    """A state of the driver as it is, but for what is changed. @param ahead s of its stamp before the present; None: no stamp."""
    other = copy.deepcopy(state)
    other.header.stamp = rospy.Time() if ahead is None else rospy.Time.now() + rospy.Duration(ahead)
    for key, value in changed.items():
        setattr(other, key, value)
    return other


def first(values, value):
    return [value] + list(values)[1:]


def beside(state):
    return [state.position[0] - 2e-3] + list(state.position)[1:]


KINDS = {
    "stray, rostopic pub": stray,
    "stray, without a stamp": lambda s, r: own(s, None, position=beside(s)),
    "stray, as the driver's": lambda s, r: own(s, position=beside(s), velocity=[0.0] * len(s.position)),
    "second publisher": lambda s, r: own(s, position=[p + r.uniform(-1e-3, 1e-3) for p in s.position]),
    "an hour back": lambda s, r: own(s, -HOUR, position=beside(s)),
    "an hour ahead": lambda s, r: own(s, HOUR, position=beside(s)),
    "0.1 s late": lambda s, r: own(s, -0.1, position=beside(s)),
    "0.1 s early": lambda s, r: own(s, 0.1, position=beside(s)),
    "NaN": lambda s, r: own(s, position=first(s.position, float("nan"))),
    "velocity NaN": lambda s, r: own(s, velocity=first(s.velocity, float("nan"))),
    "infinite": lambda s, r: own(s, position=first(s.position, float("inf"))),
    "too few positions": lambda s, r: own(s, position=list(s.position)[:-1]),
    "too many names": lambda s, r: own(s, name=list(s.name) + ["w"]),
    "a joint twice": lambda s, r: own(s, name=list(s.name) + ["x"], position=list(s.position) + [s.position[0] - 2e-3], velocity=list(s.velocity) + [0.0]),
}


class ForeignStates(KillTable):
    def settle(self, moving):
        """In x, where there is play: at rest after a way down, or on a way up that lasts."""
        x, y, z = self.hardware.start
        self.place((x + 1.0, y, z))
        self.place((x, y, z))
        if moving:
            self.axes.send_goal(MoveGoal(name=["x"], position=[1e-3 * (x + 9.0)], linear_speed=5e-3))
            self.watch.wait(lambda: self.watch.speed() > 4e-3 and self.watch.joints.position[0] > 1e-3 * x + 1e-4, 10, "a motion past the play")
        self.watch.wait(lambda: self.watch.compensation.publishing, 30, "a corrected frame")

    def send(self, kind, random):
        out = rospy.Publisher("joint_states", JointState, queue_size=100)
        assert support.wait_until(lambda: "/compensation" in [c.endpoint_id for c in out.impl.connections], 10), "nobody listens"
        end = time.time() + (SECOND if kind == "second publisher" else 0.0)
        while True:
            state = copy.deepcopy(self.watch.joints)
            out.publish(KINDS[kind](state, random))
            if time.time() >= end:
                break
            threading.Event().wait(0.005)
        threading.Event().wait(0.1)
        return out

    def trial(self, kind, number, moving):
        """@return frames compared, those that were wrong, the largest error in m, s until frames came again."""
        self.settle(moving)
        self.watch.forget()
        threading.Event().wait(BEFORE)
        out = self.send(kind, rng(kind, number))
        began = time.time()
        threading.Event().wait(LOOKED)
        found = self.watch.wrong_frames()
        for stamp, error in found[1][:3]:
            print("    %s: wrong by %.3f um: %s" % (kind, 1e6 * error, self.watch.around(stamp)), file=sys.stderr, flush=True)
        newest = max(self.watch.frames, default=0)
        again = time.time() - began if self.watch.frames and newest > 1e9 * (began + LOOKED / 2) else None
        if again is None:
            self.watch.forget()
            support.wait_until(lambda: self.watch.frames, AGAIN)
            again = time.time() - began if self.watch.frames else float("inf")
        else:
            again = 0.0
        out.unregister()
        self.axes.cancel_all_goals()
        support.ended(self.axes, 10)
        return found + (again,)


ROW = "%-26s %-10s %6d %9d %7d %7d %10.3f %10s %8s"
HEADER = "%-26s %-10s %6s %9s %7s %7s %10s %10s %8s" % ("joint state", "axes", "trials", "compared", "wrong", "trials", "largest um", "none for s", "most")


def main(trials, pattern="."):
    chosen = [(k, m) for k in KINDS for m in ("at rest", "moving") if re.search(pattern, k + " " + m)]
    if not chosen:
        sys.exit("foreign_states: nothing is called '%s'; one is '%s at rest'" % (pattern, next(iter(KINDS))))
    stage, bad = ForeignStates("simulated"), 0
    try:
        stage.place(stage.hardware.start)
        print(HEADER)
        for kind, moment in chosen:
            found = []
            for number in range(trials):
                found.append(stage.trial(kind, number, moment == "moving"))
                if found[-1][3] == float("inf"):  # they do not come again by themselves
                    stage.place(stage.hardware.start)
            compared, wrong, again = sum(f[0] for f in found), [len(f[1]) for f in found], sorted(f[3] for f in found)
            print(ROW % (kind, moment, trials, compared, sum(wrong), sum(w > 0 for w in wrong), 1e6 * max(f[2] for f in found),
                         "%.2f" % statistics.median(again), "%.2f" % again[-1]))
            bad += sum(wrong) > 0 or again[-1] == float("inf") or compared == 0
    finally:
        stage.end()
    print("foreign states: %d rows of %d trials, %d of them not as they must be" % (len(chosen), trials, bad), flush=True)
    support.remove(stage.stage.folder)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.stdout.reconfigure(line_buffering=True)
    sys.exit(main(int(sys.argv[1]), *sys.argv[2:3]))
