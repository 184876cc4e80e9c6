"""Stands in for LinuxCNC's Python module: asks the double at the port that MM_LINUXCNC_DOUBLE names. Here and there as in LinuxCNC's
own, a command returns when it was taken, not when it is done."""
import json
import os
import socket

STATE_ESTOP, STATE_ESTOP_RESET, STATE_OFF, STATE_ON = 1, 2, 3, 4
MODE_MANUAL, MODE_AUTO, MODE_MDI = 1, 2, 3
NML_ERROR, OPERATOR_ERROR, OPERATOR_TEXT = 1, 11, 12


class _Line:
    def __init__(self):
        self.socket = socket.create_connection(("127.0.0.1", int(os.environ["MM_LINUXCNC_DOUBLE"])))
        self.lines = self.socket.makefile("r")

    def ask(self, *words):
        self.socket.sendall((json.dumps(words) + "\n").encode())
        return json.loads(self.lines.readline())


nmlfile = _Line().ask("nmlfile")


class stat(_Line):
    def poll(self):
        self.__dict__.update(self.ask("status"))


class error_channel(_Line):
    def poll(self):
        text = self.ask("error")
        return text and (OPERATOR_ERROR, text)


class command(_Line):
    serial = 0

    def __getattr__(self, name):
        def send(*values):
            self.serial = self.ask(name, *values)
        return send
