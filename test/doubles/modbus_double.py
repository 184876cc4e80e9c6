#!/usr/bin/env python3
"""Temperature modules on a line of Modbus RTU (Modbus over Serial Line V1.02): functions 3 and 4, exceptions 1 to 3, a CRC.
Unit 1, holding register 0: 0.01 degC, int16; register 2 and 3: float32, high word first. Unit 2, input register 5: 0.1 degC, int16.
--link <path>: a symbolic link to the pty, whose name nobody knows before."""
import argparse
import math
import os
import struct
import time

import device_double

WRONG = 20.0  # K by which a wrong module is wrong


def crc(data):
    value = 0xFFFF
    for byte in data:
        value ^= byte
        for _ in range(8):
            value = (value >> 1) ^ 0xA001 if value & 1 else value >> 1
    return struct.pack("<H", value)


class Modbus(device_double.Double):
    def __init__(self, a, link):
        self.machine = device_double.Machine(1, None, 0.0, [1.0] * 3, 1.0)
        self.line, self.held, self.requests = b"", None, 0
        super().__init__(a)
        if link:
            if os.path.islink(link):
                os.remove(link)
            os.symlink(os.ttyname(self.slave), link)

    def tick(self, seconds):
        pass

    def power(self, on):
        self.line = b""

    def set_fault(self, fault):
        self.held = self.now() if fault == "stuck" else None
        return super().set_fault(fault)

    def now(self):
        """degC: a slow wave, which no two readings share."""
        return 20.5 + 0.5 * math.sin(time.monotonic() / 3.0)

    def temperature(self):
        if self.held is not None:
            return self.held
        return self.now() + (WRONG if self.fault == "wrong" else 0.0)

    def registers(self, unit, function):
        t = self.temperature()
        high, low = struct.unpack(">HH", struct.pack(">f", t + 1.0))
        if (unit, function) == (1, 3):
            return {0: round(100 * t) & 0xFFFF, 1: 0, 2: high, 3: low}
        if (unit, function) == (2, 4):
            return {5: round(10 * (t - 30.0)) & 0xFFFF}
        return None

    def received(self, connection, data):
        self.line += data
        while len(self.line) >= 8:
            request = self.line[:8]
            if crc(request[:6]) != request[6:]:
                self.line = self.line[1:]
                continue
            self.line = self.line[8:]
            self.answer(connection, *struct.unpack(">BBHH", request[:6]))

    def answer(self, connection, unit, function, first, count):
        self.requests += 1
        if unit not in (1, 2):
            return
        values = self.registers(unit, function)
        if values is None:
            body = struct.pack("BBB", unit, function | 0x80, 1)
        elif not 1 <= count <= 125:
            body = struct.pack("BBB", unit, function | 0x80, 3)
        elif any(first + i not in values for i in range(count)):
            body = struct.pack("BBB", unit, function | 0x80, 2)
        else:
            body = struct.pack("BBB", unit, function, 2 * count) + b"".join(
                struct.pack(">H", values[first + i]) for i in range(count))
        self.say(connection, (body + crc(body)).decode("latin-1"))

    def say(self, connection, text):
        if self.fault == "stuck":  # a module that is stuck says what it said before
            self.outgoing.append((time.monotonic(), connection, text.encode("latin-1")))
            return
        super().say(connection, text)

    def command(self, words):
        if words[0] == "requests":
            return {"requests": self.requests}
        return {"error": "unknown"}


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--link", default="")
    arguments = device_double.arguments(1)
    arguments.pty = True
    Modbus(arguments, parser.parse_known_args()[0].link).run()
