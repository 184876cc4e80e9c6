#!/usr/bin/env python3
"""Temperatures as the kernel shows them, in a made-up tree below --root: hwmon0 `coretemp`-like chip `bench` with temp1 and a
broken temp2, IIO device `bme280` with raw, offset and scale, and `mcp9600` with a processed value. Values come ten times a second.
Faults: off: the chips are gone; stuck: one value; garbage: no number; wrong: 20 K too warm; slow: 0.4 s late; intermittent."""
import argparse
import math
import os
import random
import shutil
import time

import device_double

WRONG = 20.0  # K
PERIOD = 0.1  # s


class Sysfs(device_double.Double):
    def __init__(self, a, root):
        self.machine = device_double.Machine(1, None, 0.0, [1.0] * 3, 1.0)
        self.root, self.held, self.next, self.there = root, None, 0.0, False
        self.noise = random.Random(3)
        self.fault, self.since = "ok", time.monotonic()
        self.show(True)
        super().__init__(a)

    def address(self):
        return self.root

    def received(self, connection, data):
        pass

    def power(self, on):
        pass

    def set_fault(self, fault):
        self.held = self.wave() if fault == "stuck" else None
        answer = super().set_fault(fault)
        self.next = 0.0
        self.tick(0.0)
        return answer

    def wave(self, late=0.0):
        return 20.5 + 0.5 * math.sin((time.monotonic() - late) / 3.0)

    def temperature(self):
        if self.held is not None:
            return self.held
        if self.fault == "wrong":
            return self.wave() + WRONG
        return self.wave(device_double.SLOW if self.fault == "slow" else 0.0)

    def write(self, path, text):
        """In one step, as a file of the kernel: never half of it."""
        whole = os.path.join(self.root, path)
        os.makedirs(os.path.dirname(whole), exist_ok=True)
        with open(whole + "~", "w") as f:
            f.write(text + "\n")
        os.rename(whole + "~", whole)

    def show(self, there):
        if there != self.there and not there:
            for folder in ("class/hwmon", "bus/iio/devices"):
                shutil.rmtree(os.path.join(self.root, folder), ignore_errors=True)
        if there and not self.there:
            self.write("class/hwmon/hwmon0/name", "other")
            self.write("class/hwmon/hwmon0/temp1_input", "99000")
            self.write("class/hwmon/hwmon1/name", "bench")
            self.write("class/hwmon/hwmon1/temp2_input", "20000")
            self.write("class/hwmon/hwmon1/temp2_fault", "1")
            self.write("bus/iio/devices/iio:device0/name", "bme280")
            self.write("bus/iio/devices/iio:device0/in_temp_offset", "-200")
            self.write("bus/iio/devices/iio:device0/in_temp_scale", "2.5")
            self.write("bus/iio/devices/iio:device1/name", "mcp9600")
        self.there = there

    def tick(self, seconds):
        now = time.monotonic()
        if now < self.next:
            return
        self.next = now + PERIOD
        self.show(self.fault != "off" and not self.silent())
        if not self.there:
            return
        t = 1000 * self.temperature()
        values = {"class/hwmon/hwmon1/temp1_input": "%d" % round(t),
                  "bus/iio/devices/iio:device0/in_temp_raw": "%d" % round(t / 2.5 + 200),
                  "bus/iio/devices/iio:device1/in_temp_input": "%.1f" % t}
        for path, value in values.items():
            if self.fault == "garbage":
                value = "".join(chr(self.noise.randrange(33, 127)) for _ in value) + "#"
            self.write(path, value)

    def run(self):
        try:
            super().run()
        finally:
            shutil.rmtree(self.root, ignore_errors=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--root", required=True)
    Sysfs(device_double.arguments(1), parser.parse_known_args()[0].root).run()
