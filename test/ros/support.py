"""What the rostests share: mm, sessions, logs of frames and statuses."""
import json
import os
import random
import re
import shutil
import signal
import socket
import subprocess
import tempfile
import threading
import time
import xmlrpc.client

import rosgraph
import roslib.packages
import rospy
from actionlib import CommState
from measuring_machine.msg import CompensationStatus
from measuring_machine.srv import Calibrate, Promote
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage

PACKAGE = roslib.packages.get_pkg_dir("measuring_machine")
REAPER = os.path.join(PACKAGE, "test/ros/reaper.py")
# The errors that the sessions of these tests have, by themselves: the answers are checked against these.
HIDDEN = ("scale:x=0.001", "scale:y=-0.0005")


def node(name):
    return roslib.packages.find_node("measuring_machine", name)[0]


def mm(*arguments):
    done = subprocess.run([node("mm")] + list(arguments), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    if done.returncode not in (0, 1):
        raise AssertionError("mm %s: %s" % (" ".join(arguments), done.stderr))
    return done.stdout


def simulate(bag, plan="config/demo_plan.yaml", hide=(), seed=1, machine="three_axis"):
    arguments = ["simulate", "--machine", machine, "--plan", os.path.join(PACKAGE, plan), "--seed", str(seed)]
    for source in hide:
        arguments += ["--hide", source]
    mm(*arguments, "-o", bag)
    return bag


def model(*effects):
    return "effects: [%s]" % ", ".join(effects)


def ended(client, seconds):
    """Waits for the end of the goal of an actionlib client. Its own wait_for_result never returns where the end came before
    send_goal did, as of a goal that is refused at once."""
    return wait_until(lambda: client.gh is not None and client.gh.get_comm_state() == CommState.DONE, seconds)


def served(*clients, seconds=60.0):
    """Waits, in real time, for the servers of actionlib clients: its own wait counts simulated time, which leaps over any bound when
    the first clock comes, and stands still before."""
    found = [False for _ in clients]

    def look(number):
        while not found[number] and not rospy.is_shutdown():
            found[number] = clients[number].wait_for_server(rospy.Duration(0.1))

    for number in range(len(clients)):
        threading.Thread(target=look, args=(number,), daemon=True).start()
    return wait_until(lambda: all(found), seconds)


def wait_until(true, seconds=10.0):
    end = time.time() + seconds
    while time.time() < end:
        if true():
            return True
        time.sleep(0.02)
    return bool(true())


def long_tests():
    """Whether the environment asks for the tests at their full length, hours."""
    return os.environ.get("MM_LONG_TESTS", "0") not in ("", "0")


def thorough_tests():
    """Whether it asks for more than an everyday run has time for, as continuous integration does."""
    return long_tests() or os.environ.get("MM_THOROUGH_TESTS", "0") not in ("", "0")


def environment(port):
    return dict(os.environ, ROS_MASTER_URI="http://localhost:%d" % port)


def launch(port, *arguments, namespace="/"):
    """A launch file of the package under a master of its own, as a user starts it."""
    return subprocess.Popen([REAPER, "roslaunch", "-p", str(port), "measuring_machine"] + list(arguments),
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                            # roslaunch would keep what it prints until it ends, unless it is told not to
                            env=dict(environment(port), ROS_NAMESPACE=namespace, PYTHONUNBUFFERED="1"))


def stop(process):
    if process.poll() is None:
        process.send_signal(signal.SIGINT)
        process.wait(40)  # the reaper itself kills what does not end


class Output:
    """What a process prints, read as it comes: a line can be waited for, with an end."""

    def __init__(self, process):
        self.process, self.lines = process, []
        self.reader = threading.Thread(target=lambda: self.lines.extend(process.stdout), daemon=True)
        self.reader.start()

    def __str__(self):
        return "".join(self.lines)

    def count(self, words):
        return sum(words in line for line in list(self.lines))

    def says(self, words, seconds, times=1):
        """False when the process ends, or the time, before it has said so."""
        wait_until(lambda: self.count(words) >= times or not self.reader.is_alive(), seconds)
        return self.count(words) >= times

    def ends(self, seconds):
        self.reader.join(seconds)
        return not self.reader.is_alive() and self.process.wait(10) is not None


def figures(text):
    """Parameters and residual figures of a calibration's JSON: all but the seconds that it took."""
    found = json.loads(text)
    if found.get("genetic"):
        found["genetic"].pop("seconds")
    return found


def errors(output):
    """RMS before and after that the demo printed, um."""
    found = [re.search(r"%s +RMS +([0-9.]+) um" % frame, output) for frame in (r"\(probe_tip\)", r"\(probe_tip_corrected\)")]
    assert all(found), output
    return [float(f.group(1)) for f in found]


def shorter_plan(target, points, source="config/demo_plan.yaml"):
    """The plan of the demo with fewer contacts a ball."""
    with open(os.path.join(PACKAGE, source)) as f:
        text, changed = re.subn(r"points: [0-9]+", "points: %d" % points, f.read())
    assert changed, source
    with open(target, "w") as f:
        f.write(text)
    return target


def calibrate_live(port, model_file, namespace="/"):
    """What the calibration server under that master says of its live session: (JSON, message)."""
    script = ("import sys; import rospy; from measuring_machine.srv import Calibrate;"
              "rospy.wait_for_service('calibration_server/calibrate', 20);"
              "a = rospy.ServiceProxy('calibration_server/calibrate', Calibrate)(model=sys.argv[1], seed=1);"
              "sys.stderr.write(a.message); print(a.json)")
    done = subprocess.run(["python3", "-c", script, model_file], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                          env=dict(environment(port), ROS_NAMESPACE=namespace), timeout=60)
    return done.stdout or "{}", done.stderr


def diagnose_live(port, calibration_file):
    """What the calibration server under that master misses in its live session: (JSON, message)."""
    script = ("import sys; import rospy; from measuring_machine.srv import Diagnose;"
              "a = rospy.ServiceProxy('calibration_server/diagnose', Diagnose)(calibration=sys.argv[1]);"
              "sys.stderr.write(a.message); print(a.json)")
    done = subprocess.run(["python3", "-c", script, calibration_file], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                          env=environment(port), timeout=60)
    return done.stdout or "{}", done.stderr


def folder():
    return tempfile.mkdtemp(prefix="mm_rostest_")


def parameter(answer, effect, **keys):
    """Value of the first parameter of an effect in the JSON of a calibration."""
    for p in json.loads(answer)["parameters"]:
        if p["effect"]["type"] == effect and all(p["effect"].get(k) == v for k, v in keys.items()):
            return p["value"], p["unit"]
    raise AssertionError("no parameter of %s in %s" % (effect, answer))


def scale(answer, axis):
    value, unit = parameter(answer, "scale", axis=axis)
    assert unit == "um/m", unit
    return 1e-6 * value


def calibrate_and_promote(bag, effects, server="calibration_server/"):
    rospy.wait_for_service(server + "calibrate", 20)
    answer = rospy.ServiceProxy(server + "calibrate", Calibrate)(bag=bag, model=effects, method="least_squares")
    assert answer.calibration_id, answer.message
    promoted = rospy.ServiceProxy(server + "promote", Promote)(calibration_id=answer.calibration_id)
    assert promoted.success, promoted.message
    return answer


class Frames:
    """Every frame of some children on /tf, by its stamp in ns."""

    def __init__(self, *children):
        self.lock = threading.Lock()
        self.frames = {child: {} for child in children}
        self.doubled = 0
        self.subscriber = rospy.Subscriber("/tf", TFMessage, self.take, queue_size=None, buff_size=1 << 24, tcp_nodelay=True)

    def take(self, message):
        with self.lock:
            for t in message.transforms:
                if t.child_frame_id not in self.frames:
                    continue
                stamp = t.header.stamp.to_nsec()
                self.doubled += stamp in self.frames[t.child_frame_id]
                v = t.transform.translation
                self.frames[t.child_frame_id][stamp] = (v.x, v.y, v.z)

    def of(self, child):
        with self.lock:
            return dict(self.frames[child])

    def taken(self, child):
        """Those since the last call; they are forgotten here."""
        with self.lock:
            frames, self.frames[child] = self.frames[child], {}
            return frames

    def newest(self, child):
        """Stamp of the last one in ns; 0: none, or taken."""
        with self.lock:
            return next(reversed(self.frames[child]), 0)


class Statuses:
    def __init__(self, topic="compensation/status"):
        self.all = []
        self.subscriber = rospy.Subscriber(topic, CompensationStatus, self.all.append, queue_size=None)

    def last(self):
        return self.all[-1] if self.all else CompensationStatus()

    def says(self, words, seconds=5.0, since=0):
        return wait_until(lambda: any(words in s.message for s in self.all[since:]), seconds)


class Joints:
    """Stands for an axis driver."""

    NAMES = ["x", "y", "z"]

    def __init__(self, topic="joint_states"):
        self.publisher = rospy.Publisher(topic, JointState, queue_size=1000)
        self.stamp = rospy.Time.from_sec(time.time())

    def ready(self, listeners=2):
        return wait_until(lambda: self.publisher.get_num_connections() >= listeners)

    def send(self, position=(0.005, 0.003, 0.001), names=None, velocity=(1e-3, 1e-3, 1e-3), ahead=0.01):
        """@return the stamp in ns."""
        self.stamp += rospy.Duration(ahead)
        message = JointState(name=list(names or self.NAMES), position=list(position), velocity=list(velocity))
        message.header.stamp = self.stamp
        self.publisher.publish(message)
        return self.stamp.to_nsec()


class Double:
    """A double's control line."""

    def __init__(self, port):
        self.line = connect(port).makefile("rw")

    def tell(self, command):
        self.line.write(command + "\n")
        self.line.flush()
        return json.loads(self.line.readline())


def home_again(seconds=40):
    """Homes an axis driver that may just have died and not be back yet. @return whether it is homed."""
    def homed():
        try:
            rospy.wait_for_service("axis_driver/home", 20)
            return rospy.ServiceProxy("axis_driver/home", Trigger)().success
        except rospy.ServiceException:
            return False  # still the one that died

    return wait_until(homed, seconds)


def connect(port, seconds=20):
    """To the control line of a double, as soon as that is there."""
    end = time.time() + seconds
    while True:
        try:
            return socket.create_connection(("127.0.0.1", port))
        except OSError:
            if time.time() > end:
                raise
            time.sleep(0.05)


def kill(name):
    """Ends one node of this test's master, as a crash would."""
    answer = xmlrpc.client.ServerProxy(rosgraph.Master("/test").lookupNode(name)).getPid("/test")
    os.kill(answer[2], 9)


def free_port():
    """Below the ports that the kernel gives to connections: one of those may be taken before it is used."""
    while True:
        port = random.randint(12000, 32000)
        with socket.socket() as s:
            try:
                s.bind(("", port))
                return port
            except OSError:
                pass


def remove(path):
    shutil.rmtree(path, ignore_errors=True)
