"""A machine on a master of its own whose line can be cut, and what is watched of it: the true motion, the corrected frames against
the truth, the contacts against the bag. The truth is the simulator's ~truth, or what the double of a controller says of itself."""
import json
import os
import random
import re
import signal
import subprocess
import sys
import threading
import time

import numpy
import rosbag
import rospy
from geometry_msgs.msg import PointStamped
from measuring_machine.msg import AxisStatus, CompensationStatus, MotionStatus, ProbeContact
from sensor_msgs.msg import JointState
from tf2_msgs.msg import TFMessage

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), ".."))
import cycle_support  # noqa: E402
import support  # noqa: E402
from processes import MasterLine  # noqa: E402

HERE = os.path.dirname(os.path.realpath(__file__))
CORRECTED = "probe_tip_corrected"
RATE = 100  # joint states a second, as the driver has it
PLAY = 7e-6  # m, in the simulated axis x
GRID = numpy.arange(-25.0, 25.5, 0.5)  # mm of x at which the calibration is asked for its sigma
FAR = int(5e9)  # ns: a frame so far beyond the states that were heard is of none of them
PLAN = """
name: trial
artifact:
  {{name: ball, pose: known, probe: {{tip_radius_mm: 1.0, repeatability_um: 0.3}}, balls: [{{name: b0, centre_mm: {ball}, radius_mm: {radius}}}]}}
speeds: {{rapid_mm_s: 15, rapid_deg_s: 30, approach_mm_s: 2}}
approach: {{distance_mm: 1.0, overtravel_mm: 0.8}}
clearance: {{z_mm: {clear}}}
"""


class Hardware:
    """Where a machine moves in a trial (mm), and what its calibration knows. From `start`, above the ball, `far` is a slow way of
    several seconds, and `deep` is in the ball."""

    def __init__(self, machine, ball, radius, far, session, hide, effects, others="", homes=True):
        self.homes = homes  # by a motion
        self.others = others  # joints of a plan's moves beside x, y, z: as homing leaves them
        self.machine, self.ball, self.radius, self.session, self.hide, self.effects = machine, ball, radius, session, hide, effects
        top = ball[2] + radius + 1.0
        self.start, self.far, self.deep = (ball[0], ball[1], top + 3.0), (ball[0] + far, ball[1], top + 3.0), (ball[0], ball[1], top - 0.5)
        self.near = (ball[0], ball[1], top + 2.0)

    def artifact(self):
        return PLAN.format(ball=list(self.ball), radius=self.radius, clear=self.start[2])


SCALE = "{type: scale, axis: x}"
HARDWARE = {
    "simulated": Hardware("three_axis", (5.0, 8.0, -2.0), 3.9685, -20.0, "config/demo_plan.yaml", ["scale:x=0.0004", "backlash:x=7um"],
                          [SCALE, "{type: backlash, axis: x}"]),
    "grbl": Hardware("test/data/six_axis.urdf", (30.0, 30.0, 20.0), 8.0, -60.0, "test/ros/grbl_plan.yaml", ["scale:x=0.0005"], [SCALE],
                     ", a_deg: 39, b_deg: 39, c_deg: 39"),
    "linuxcnc": Hardware("test/ros/linuxcnc/machine.urdf", (10.0, 5.0, -20.0), 2.9685, -60.0, "test/ros/linuxcnc/plan.yaml",
                         ["scale:x=0.0005"], [SCALE], homes=False),
}
ZERO = 40.0  # mm: the double's own zero is there on the joints


class Stage:
    """Started once, for many trials. Calls that wait fail with what did not come."""

    def __init__(self, hardware, rate=RATE):
        self.name, self.hardware, self.rate, self.processes = hardware, HARDWARE[hardware], rate, []
        self.folder = support.folder()
        self.store = os.path.join(self.folder, "store")
        self.log = open(os.path.join(self.folder, "log"), "w")
        master = support.free_port()
        self.begin([support.REAPER, "rosmaster", "--core", "-p", str(master)], master)
        support.connect(master).close()
        self.port = support.free_port()
        self.line = MasterLine(self.port, master)
        os.environ.update(ROS_MASTER_URI="http://localhost:%d" % self.port, ROS_LOG_DIR=self.folder)
        self.double = None
        self.controller = []
        if hardware == "grbl":
            self.start_double()
        if hardware == "linuxcnc":
            from linuxcnc_machine import LinuxCnc
            self.double = LinuxCnc(self.folder)
            # The driver's own limits, not those of a test on a busy computer.
            self.controller = ["hardware:=linuxcnc", "controller:=" + self.write("linuxcnc.yaml", "coordinates: XYZAB\npoll_rate: 100\n")]
        self.instrument = self.begin([support.REAPER, "roslaunch", "measuring_machine", "instrument.launch", "plan:=" + self.write("plan.yaml", self.plan("wait")),
                                      "machine:=" + self.path(self.hardware.machine), "store:=" + self.store, "rate:=%d" % rate,
                                      "margin:=10", "hide:=" + ";".join(self.hardware.hide)] + self.controller)
        rospy.init_node("trials", disable_signals=True)
        self.watch = Watch(self)
        self.bag = os.path.join(self.folder, "session.bag")
        self.recorder = self.begin(["rosrun", "rosbag", "record", "-O", self.bag, "-e", "/" + cycle_support.TOPICS])
        assert support.wait_until(lambda: os.path.exists(self.bag + ".active"), 30), "nothing is recorded"

    @staticmethod
    def path(machine):
        return os.path.join(support.PACKAGE, machine) if machine.endswith(".urdf") else machine

    def write(self, name, text):
        path = os.path.join(self.folder, name)
        with open(path, "w") as f:
            f.write(text)
        return path

    def begin(self, command, port=None, out=None):
        environment = support.environment(port) if port else dict(os.environ)
        self.processes.append(subprocess.Popen(command, stdout=out or self.log, stderr=self.log, text=True, env=environment))
        return self.processes[-1]

    def start_double(self):
        # reaches of 40 mm/s: a homing lasts for a while
        command = [os.path.join(HERE, "../../doubles/grbl_double.py"), "--homing", "20", "--ball"]
        command += [str(v - ZERO) for v in self.hardware.ball] + [str(self.hardware.radius), "--scale", "1.0005", "1", "1"]
        process = self.begin(command, out=subprocess.PIPE)
        where = json.loads(process.stdout.readline())
        self.double = support.Double(where["control"])
        self.control_port = int(where["address"].rsplit(":", 1)[1])
        with open(os.path.join(support.PACKAGE, "test/ros/grbl.yaml")) as f:
            lines = [line for line in f if not line.startswith("address")]
        self.controller = ["hardware:=grbl", "controller:=" + self.write("grbl.yaml", "address: %s\n%s" % (where["address"], "".join(lines)))]

    def plan(self, moment):
        """A touch, then the moment of the trial; it lasts for seconds."""
        h = self.hardware
        place = lambda p, **more: "  - {x_mm: %g, y_mm: %g, z_mm: %g%s%s}\n" % (*p, h.others, "".join(", %s: %s" % item for item in more.items()))
        moves = place(h.near, feature="b0", speed_mm_s=3)
        moves += {"move": place(h.far, speed_mm_s=4), "probe": place(h.near, feature="b0", speed_mm_s=0.5),
                  "wait": place(h.start, wait_s=1.0) + place(h.far, speed_mm_s=4)}[moment]
        return h.artifact() + "moves:\n" + moves

    def calibrate(self):
        """What the machine has is found in a session that has it, and promoted."""
        with open(os.path.join(support.PACKAGE, self.hardware.session)) as f:
            text = f.read().split("  errors:")[0]  # it has those of the hardware and no others
        plan = self.write("session.yaml", re.sub(r", a_deg.*?(?=})", self.hardware.others, text))
        bag = support.simulate(os.path.join(self.folder, "calibration.bag"), plan, self.hardware.hide,
                               machine=self.path(self.hardware.machine))
        answer = support.calibrate_and_promote(bag, support.model(*self.hardware.effects))
        self.scale = support.scale(answer.json, "x")
        if not self.double:
            self.sigmas = numpy.minimum(*(self.sigma_over_x(answer.calibration_id, travel) for travel in (-1, 1)))

    def sigma_over_x(self, calibration, travel):
        """@return m at GRID, as the calibration says it of its own parameters; it is the same over y and z."""
        rows = "".join("%g,%g,%g,%d\n" % (x, *self.hardware.start[1:], travel) for x in GRID)
        states, corrected = self.write("grid.csv", "x_mm,y_mm,z_mm,x_velocity_mm_s\n" + rows), os.path.join(self.folder, "corrected.csv")
        support.mm("apply", states, "--calibration", os.path.join(self.store, calibration + ".yaml"), "--margin", "10", "--force", "-o", corrected)
        with open(corrected) as f:
            return numpy.array([1e-6 * float(line.split(",")[-2]) for line in list(f)[1:]])

    def sigma(self, x):
        """m of a corrected frame at x (m), of the direction of travel for which it is less, without play that is being taken up. (That of
        the status is up to a second old, and so of another place.)"""
        return float(numpy.interp(1e3 * x, GRID, self.sigmas))

    def end(self):
        self.line.mend()
        support.stop(self.recorder)
        # rosbag's wrapper ends before what it started has given the bag its name
        assert support.wait_until(lambda: os.path.exists(self.bag), 20), "the bag was not finished"
        rospy.signal_shutdown("the trials are over")  # while there is a master to be told
        for process in self.processes:
            process.send_signal(signal.SIGINT)
        for process in self.processes:
            process.wait(60)  # the reapers kill what does not end
        self.line.cut()
        if self.name == "linuxcnc":
            self.double.end()

    def recorded(self):
        """@return stamps of the contacts in the bag, which is finished."""
        with rosbag.Bag(self.bag) as bag:
            return {m.header.stamp.to_nsec() for _, m, _ in bag.read_messages(["/probe/contact"])}


class Watch:
    """Everything that the stage says, as it comes."""

    def __init__(self, stage):
        self.stage, self.changed = stage, threading.Condition()
        self.status, self.motion, self.joints, self.compensation = AxisStatus(), MotionStatus(), JointState(), CompensationStatus()
        self.truth, self.states, self.frames, self.statuses = {}, {}, {}, []
        self.contacts, self.moved_at = [], 0.0
        self.last = None
        fast = dict(queue_size=None, buff_size=1 << 22, tcp_nodelay=True)
        self.subscribers = [rospy.Subscriber(topic, kind, self.take(method), **fast) for topic, kind, method in (
            ("axis_driver/status", AxisStatus, self.take_status), ("axis_driver/motion", MotionStatus, self.take_motion),
            ("joint_states", JointState, self.take_joints), ("compensation/status", CompensationStatus, self.take_compensation),
            ("axis_driver/truth", PointStamped, self.take_truth), ("/tf", TFMessage, self.take_frames),
            ("probe/contact", ProbeContact, self.take_contact))]

    def take(self, method):
        def taken(message):
            with self.changed:
                method(message)
                self.changed.notify_all()
        return taken

    def take_status(self, message):
        self.status = message
        self.statuses.append((message.header.stamp.to_nsec(), bool(message.homed)))

    def take_motion(self, message):
        self.motion = message

    def take_joints(self, message):
        if message._connection_header["callerid"] != "/axis_driver":
            return
        self.joints = message
        self.states[message.header.stamp.to_nsec()] = message.position[:3]

    def take_compensation(self, message):
        self.compensation = message

    def take_truth(self, message):
        p, stamp = (message.point.x, message.point.y, message.point.z), message.header.stamp.to_nsec()
        self.truth[stamp] = p
        if self.last and max(abs(a - b) for a, b in zip(p, self.last)) > 1e-8:
            self.moved_at = 1e-9 * stamp
        self.last = p

    def take_frames(self, message):
        for t in message.transforms:
            if t.child_frame_id == CORRECTED:
                v = t.transform.translation
                self.frames[t.header.stamp.to_nsec()] = (v.x, v.y, v.z)

    def take_contact(self, message):
        self.contacts.append(message.header.stamp.to_nsec())

    def wait(self, true, seconds=20.0, what="what was waited for"):
        end = time.monotonic() + seconds
        with self.changed:
            while not true():
                left = end - time.monotonic()
                if left <= 0.0 or not self.changed.wait(min(left, 0.05)) and time.monotonic() > end:
                    raise AssertionError("%s did not come in %.0f s: %s" % (what, seconds, self.says()))

    def says(self):
        s = self.status
        return "homed %d moving %d probing %d fault '%s', owner '%s', stopped by '%s', at %s, correction '%s'" % (
            s.homed, s.moving, s.probing, s.fault, self.motion.owner, self.motion.stopped_by, list(self.joints.position[:3]), self.compensation.message)

    def speed(self):
        """m/s of the fastest linear axis as the driver says it; it is used to choose the moment, never to judge."""
        return max((abs(v) for v in self.joints.velocity[:3]), default=0.0)

    # -- the true motion
    def last_moved(self):
        """When the machine truly moved last, s of time.time()."""
        if self.stage.double:
            self.moved_at = self.stage.double.tell("machine")["moved"] - time.monotonic() + time.time()
        return self.moved_at

    # -- frames
    def forget(self):
        with self.changed:
            for kept in (self.truth, self.states, self.frames):
                kept.clear()
            del self.statuses[:-1], self.contacts[:]

    def unhomed(self, stamp):
        """Whether the driver said before and behind that stamp that its axes are not homed."""
        before = [homed for at, homed in self.statuses if at < stamp][-1:]
        behind = [homed for at, homed in self.statuses if at > stamp][:1]
        return before == [False] and behind in ([False], [])

    def wrong_frames(self):
        """@return how many corrected frames since `forget` were looked at, those that are wrong (off their truth by more than 3 sigma,
        of axes that are not homed, of a state that the driver never had), and the largest error in m."""
        with self.changed:
            frames, truth, states = dict(self.frames), dict(self.truth), dict(self.states)
        sigma_at, open_play = self.stage.sigma, taking_up(states)
        if self.stage.double:  # its clock is another: the calibration applied to the state of the same stamp
            truth = {s: (p[0] * (1.0 + self.stage.scale), p[1], p[2]) for s, p in states.items()}
            sigma_at, open_play = lambda _: 1e-9 / 3, ()
        stamps = numpy.array(sorted(truth), dtype=numpy.int64)
        compared, wrong, most, first = 0, [], 0.0, min(states, default=0)
        for stamp, frame in frames.items():
            if stamp in truth and stamp < first:
                continue  # its state was heard before `forget`, and what of the play is open is not known
            true, sigma = truth.get(stamp), sigma_at(frame[0])
            if true is None and len(stamps) and not stamps[0] - FAR < stamp < stamps[-1] + FAR:
                error = 1.0
            elif true is None:
                at = int(numpy.searchsorted(stamps, stamp))
                near = 0 < at < len(stamps) and stamps[at] - stamps[at - 1] < 3e9 / self.stage.rate
                if not near:  # the truth was not heard, at the beginning and the end
                    continue
                true = truth[int(stamps[at - 1])]
                error = max(abs(a - b) for a, b in zip(frame, true))
                if max(abs(a - b) for a, b in zip(true, truth[int(stamps[at])])) < 1e-8 and error <= 3 * sigma:
                    continue  # at rest it is right all the same
                error = max(error, 3.001 * sigma)
            else:
                error = max(abs(a - b) for a, b in zip(frame, true))
            compared += 1
            most = max(most, error)
            if not error <= 3 * sigma + (PLAY if stamp in open_play else 0.0) or self.unhomed(stamp):
                wrong.append((stamp, error))
        return compared, wrong, most

    def around(self, stamp):
        """@return what was heard around a stamp: of each joint state x (um from that of the stamp), the truth and the corrected frame."""
        with self.changed:
            stamps = sorted(self.states)
            at = next((i for i, s in enumerate(stamps) if s >= stamp), len(stamps))
            origin = self.states.get(stamp, self.frames.get(stamp, (0.0,)))[0]

            def um(of, s):
                return "%.3f" % (1e6 * (of[s][0] - origin)) if s in of else "none"

            lines = ["%+.4f s: state %s, truth %s, frame %s" % (1e-9 * (s - stamp), um(self.states, s), um(self.truth, s), um(self.frames, s))
                     for s in sorted(set(stamps[max(0, at - 3):at + 3]) | {stamp})]
            said = ["homed %d" % homed for at, homed in self.statuses if abs(at - stamp) < 2e9]
        return "x %.6f m, %s; %s" % (origin, said, "; ".join(lines))


def taking_up(states):
    """@return stamps of states within PLAY of where x turned. The model knows the two ends of play alone, so that there a corrected
    frame may be off by as much; the compensation says so."""
    found, direction, last, turn = set(), 0, None, None
    for stamp in sorted(states):
        x = states[stamp][0]
        went = 0 if last is None else (x > last) - (x < last)
        if went and went != direction:
            turn, direction = last, went
        if turn is not None and abs(x - turn) < PLAY:
            found.add(stamp)
        last = x
    return found


def rng(*what):
    return random.Random(repr(what))
