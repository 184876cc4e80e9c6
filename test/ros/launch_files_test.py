#!/usr/bin/env python3
"""Every launch file with every argument that it has, as roslaunch reads it: its nodes are there, and what one launch set ends with it."""
import functools
import glob
import os
import unittest
import unittest.mock
import xml.etree.ElementTree as xml

import rospkg
import roslib.packages
import rostest
from roslaunch.config import ROSLaunchConfig
from roslaunch.rlutil import check_roslaunch
from roslaunch.xmlloader import XmlLoader

import support

FILES = sorted(glob.glob(os.path.join(support.PACKAGE, "launch/*.launch")))
PLAN = os.path.join(support.PACKAGE, "config/demo_plan.yaml")
# Values beside the default one. An argument that is not here fails the test: it belongs here.
VALUES = {
    "address": ["0.0.0.0"], "bag": ["/tmp/s.bag"], "clock": ["true"], "compensation": ["none"], "controller": [os.path.join(support.PACKAGE, "config/grbl.yaml")],
    "fault": ["probe_stuck", "probe_dead", "temperature_frozen", "temperature_lost"], "folder": ["/tmp/d"], "frame_prefix": ["m1/"],
    "hardware": ["simulated", "grbl", "linuxcnc"], "hide": ["backlash:x=3um; scale:y=0.001"], "hosts": ["here there"],
    "instrument": ["false"], "loop": ["true"],
    "machine": ["three_axis", "five_axis", os.path.join(support.PACKAGE, "urdf/five_axis.urdf")], "machine_ns": ["/m1"],
    "margin": ["0.5"], "model": [os.path.join(support.PACKAGE, "config/demo_model.yaml")], "nominal_rate": ["20"], "open": ["false"],
    "plan": [PLAN], "port": ["8080"], "probe": ["touch", "laser"], "rate": ["20"], "respawn": ["false", "true"], "rviz": ["true"],
    "seed": ["7"], "sensors": [os.path.join(support.PACKAGE, "config/sensors.yaml")], "serial": ["MM-7"], "store": ["/tmp/store"],
    "tf_prefix": ["m1"], "time_factor": ["10"], "view": ["five_axis"],
}


PACKAGES = rospkg.RosPack()  # reads every package of this computer once


@functools.lru_cache(maxsize=None)
def found(package, program):
    return bool(roslib.packages.find_node(package, program, PACKAGES))


def arguments(file):
    return {a.get("name"): a for a in xml.parse(file).getroot().findall("arg") if "value" not in a.attrib}


def read(file, **given):
    """As roslaunch reads it. What has no default gets the first of its values."""
    for name, argument in arguments(file).items():
        if "default" not in argument.attrib:
            given.setdefault(name, VALUES[name][0])
    config = ROSLaunchConfig()
    XmlLoader().load(file, config, argv=["%s:=%s" % pair for pair in given.items()], verbose=False)
    return config


class LaunchFiles(unittest.TestCase):
    def test_every_argument(self):
        read_ones = 0
        for file in FILES:
            for name in arguments(file):
                for value in VALUES[name]:
                    config = read(file, **{name: value})
                    self.assertEqual(config.config_errors, [], (file, name, value))
                    read_ones += 1
                    for node in config.nodes:
                        self.assertTrue(found(node.package, node.type),
                                        "%s: no %s/%s" % (file, node.package, node.type))
        self.assertGreater(read_ones, 80)

    def test_every_argument_is_explained(self):
        for file in FILES:
            for name, argument in arguments(file).items():
                self.assertTrue(argument.get("doc"), "%s: %s has no doc" % (file, name))

    def test_nominal_frames_are_fifty_a_second_of_the_wall(self):
        for name in ("instrument", "workbench"):
            for given, rate in (({}, 50), ({"time_factor": "10"}, 50), ({"time_factor": "10", "clock": "true"}, 5)):
                config = read(os.path.join(support.PACKAGE, "launch", name + ".launch"), **given)
                self.assertAlmostEqual(config.params["/robot_state_publisher/publish_frequency"].value, rate, msg=(name, given))

    def test_nodes_know_whether_they_are_started_again(self):
        for name, given in (("instrument", {}), ("workbench", {}), ("workbench", {"instrument": "false"}), ("replay", {}), ("demo", {})):
            config = read(os.path.join(support.PACKAGE, "launch", name + ".launch"), **given)
            for node in config.nodes:
                if node.package == "measuring_machine":
                    self.assertEqual(dict(node.env_args).get("MM_RESPAWN", "false") == "true", bool(node.respawn), (name, node.name))
            self.assertNotIn("/respawn", config.params, "it would outlive the launch")

    def test_roslaunch_check(self):
        with unittest.mock.patch("rospkg.RosPack", lambda *_: PACKAGES):  # else it reads them all again for every node
            for file in FILES:
                self.assertIsNone(check_roslaunch(file, ignore_unset_args=True), file)

    def test_nothing_of_one_launch_is_left_to_the_next(self):
        """The controller's parameters of a simulation would be refused by another one's."""
        for file in FILES:
            config = read(file)
            for node in config.nodes:
                if node.package in ("rosbag", "rviz") or not any(p.startswith("/%s/" % node.name) for p in config.params):
                    continue
                self.assertIn("/%s/" % node.name, config.clear_params, file)

    def test_one_prefix_is_all_frames(self):
        for name in ("instrument", "workbench", "replay", "correction"):
            config = read(os.path.join(support.PACKAGE, "launch", name + ".launch"), frame_prefix="m1/")
            self.assertEqual((config.params["/frame_prefix"].value, config.params["/tf_prefix"].value), ("m1/", "m1"), name)

    def test_who_dies_comes_back(self):
        for name in ("instrument", "workbench"):
            for node in read(os.path.join(support.PACKAGE, "launch", name + ".launch")).nodes:
                self.assertTrue(node.respawn, node.name)


if __name__ == "__main__":
    rostest.rosrun("measuring_machine", "launch_files", LaunchFiles)
