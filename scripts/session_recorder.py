#!/usr/bin/env python3
"""Records a session: `session_recorder.py <bag> [namespace of the machine]`. Once every publisher of the session's topics is heard, it
says so, and publishes the bag's name latched on `~recording`: what is measured from then on is in the bag. At its end it says what the
bag lacks."""
import os
import re
import signal
import subprocess
import sys
import xmlrpc.client

import rosbag
import rosgraph
import rospy
from std_msgs.msg import String

TOPICS = (
    "(joint_states|reference|artifact|robot_description|controller_compensation|times_assumed|imported_from|axis_driver/status|probe/contact|measure/measured|temperature/.*|covariate/.*)"
)


class Recorder:
    def __init__(self, bag, space):
        self.bag, self.space = bag, space.rstrip("/") + "/"
        self.master = rosgraph.Master(rospy.get_name())
        self.name = rospy.get_name() + "_bag"
        # not by the command `rosbag record`, which ends before what it started has closed the bag
        self.process = subprocess.Popen(
            ["rosrun", "rosbag", "record", "-q", "-O", bag, "-e", self.space + TOPICS, "__name:=" + self.name.rsplit("/", 1)[1]],
            start_new_session=True, env=dict(os.environ, ROS_NAMESPACE=rospy.get_namespace()))

    def serves(self, node):
        """The topics that a node sends to the recorder: from the moment that it says so, all that it publishes. None: it has gone."""
        try:
            _, _, connections = xmlrpc.client.ServerProxy(self.master.lookupNode(node)).getBusInfo(rospy.get_name())
        except (rosgraph.MasterException, OSError, xmlrpc.client.Error):
            return None
        return {c[4] for c in connections if c[1] == self.name and c[2] == "o" and c[5]}

    def hears_all(self):
        try:
            publishers, _, _ = self.master.getSystemState()
        except (rosgraph.MasterException, OSError, xmlrpc.client.Error):
            return False
        session = {topic: nodes for topic, nodes in publishers if re.fullmatch(self.space + TOPICS, topic)}
        served = {node: self.serves(node) for node in {node for nodes in session.values() for node in nodes}}
        heard = {topic for topic, nodes in session.items() if any(served[node] is not None for node in nodes)}
        return (self.space + "joint_states" in heard and heard & {self.space + "probe/contact", self.space + "reference"}
                and all(served[node] is None or topic in served[node] for topic, nodes in session.items() for node in nodes))

    def run(self):
        ready = rospy.Publisher("~recording", String, queue_size=1, latch=True)
        told = False
        while self.process.poll() is None and not rospy.is_shutdown():
            if not told and self.hears_all():
                told = True
                print("recording %s: what is measured now is in it" % self.bag, flush=True)
                ready.publish(String(self.bag))
            rospy.rostime.wallsleep(0.1)
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        status = self.process.wait()
        if not os.path.exists(self.bag):
            print("%s was not recorded (status %d of rosbag record)" % (self.bag, status), file=sys.stderr, flush=True)
            return 1
        print(self.lacks(), flush=True)
        return 0

    def lacks(self):
        """What was measured, as the measure node counted it, and is not in the bag. A count stands for its session, from its stamp to the
        next one's; of one that was over before the bag began nothing is lacking."""
        with rosbag.Bag(self.bag) as bag:
            counts = {m.header.stamp: m.contacts for _, m, _ in bag.read_messages(self.space + "measure/measured")}
            stamps = [m.header.stamp for _, m, _ in bag.read_messages(self.space + "probe/contact")]
        starts = list(counts)
        measured = 0
        for number, start in enumerate(starts):
            end = next((s for s in starts[number + 1:] if not s.is_zero()), None)
            if end is None or any(start <= s < end for s in stamps):
                measured += counts[start]
        if len(stamps) < measured:
            return "%s lacks %d of %d contacts: they were measured before it was recorded" % (self.bag, measured - len(stamps), measured)
        return "%s: %d contacts, all that were measured" % (self.bag, len(stamps))


def main():
    rospy.init_node("record")
    arguments = rospy.myargv()[1:]
    if len(arguments) not in (1, 2):
        print(__doc__, file=sys.stderr)
        return 2
    return Recorder(os.path.abspath(arguments[0]), arguments[1] if len(arguments) > 1 else rospy.get_namespace()).run()


if __name__ == "__main__":
    sys.exit(main())
