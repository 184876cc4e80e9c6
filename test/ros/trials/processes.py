"""What is done to a process: signals, and connections that are cut without asking either end."""
import ctypes
import os
import socket
import threading
import xmlrpc.client

import rosgraph

PIDFD_GETFD = 438  # system call


def address(text):
    return int(text.rsplit(":", 1)[1], 16)


def tcp():
    """{inode: (own port, other port)} of the established connections of this computer."""
    found = {}
    for name in ("/proc/net/tcp", "/proc/net/tcp6"):
        with open(name) as lines:
            next(lines)
            for line in lines:
                words = line.split()
                if words[3] == "01":
                    found[words[9]] = (address(words[1]), address(words[2]))
    return found


def sockets(pid):
    """{descriptor: (own port, other port)} of a process's TCP connections."""
    every, found = tcp(), {}
    for fd in os.listdir("/proc/%d/fd" % pid):
        try:
            to = os.readlink("/proc/%d/fd/%s" % (pid, fd))
        except OSError:
            continue  # closed meanwhile
        if to.startswith("socket:[") and to[8:-1] in every:
            found[int(fd)] = every[to[8:-1]]
    return found


def cut(pid, other=None, port=None):
    """Shuts the TCP connections of a process with another one, or with a port, as a network does that is lost for a moment: both
    ends see them end. @return how many."""
    there = set(sockets(other).values()) if other else set()
    libc, number = ctypes.CDLL(None, use_errno=True), 0
    handle = os.pidfd_open(pid)
    try:
        for fd, (mine, its) in sockets(pid).items():
            if (its, mine) not in there and its != port:
                continue
            copy = libc.syscall(PIDFD_GETFD, handle, fd, 0)
            if copy < 0:
                raise OSError(ctypes.get_errno(), "no access to the connections of process %d; run as root" % pid)
            with socket.socket(fileno=copy) as one:
                try:
                    one.shutdown(socket.SHUT_RDWR)
                    number += 1
                except OSError:
                    pass  # it ended by itself
    finally:
        os.close(handle)
    return number


def pid_of(node):
    """@return its process, or None while the master does not know it, or it does not answer."""
    try:
        uri = rosgraph.Master("/trials").lookupNode(node)
        pid = xmlrpc.client.ServerProxy(uri).getPid("/trials")[2]
        os.kill(pid, 0)
        return pid
    except (rosgraph.MasterError, OSError, xmlrpc.client.Error):
        return None


class MasterLine:
    """The way of every node to the master. `cut` makes the master dead for all of them, `mend` brings it back as it was."""

    def __init__(self, port, master):
        self.port, self.master, self.connections, self.lock = port, master, set(), threading.Lock()
        self.listener = None
        self.mend()

    def mend(self):
        if self.listener is None:
            self.listener = socket.create_server(("", self.port), reuse_port=False, backlog=128)
            threading.Thread(target=self.accept, args=(self.listener,), daemon=True).start()

    def cut(self):
        listener, self.listener = self.listener, None
        if listener:
            listener.shutdown(socket.SHUT_RDWR)
            listener.close()
        with self.lock:
            ended, self.connections = self.connections, set()
        for one in ended:
            self.end(one)

    @staticmethod
    def end(one):
        try:
            one.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass
        one.close()

    def accept(self, listener):
        while True:
            near = far = None
            try:
                near, _ = listener.accept()
                far = socket.create_connection(("127.0.0.1", self.master))
                for one in (near, far):
                    one.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            except OSError:
                for one in (near, far):
                    if one is not None:
                        self.end(one)
                if self.listener is not listener:
                    return  # the line was cut
                continue  # who called has gone, or the master is busy: this one connection alone is lost
            with self.lock:
                if self.listener is not listener:  # cut meanwhile: this one, too
                    self.end(near)
                    self.end(far)
                    return
                self.connections |= {near, far}
            for source, target in ((near, far), (far, near)):
                threading.Thread(target=self.pump, args=(source, target), daemon=True).start()

    def pump(self, source, target):
        try:
            while True:
                data = source.recv(1 << 16)
                if not data:
                    break
                target.sendall(data)
        except OSError:
            pass
        with self.lock:
            self.connections -= {source, target}
        for one in (source, target):
            self.end(one)
