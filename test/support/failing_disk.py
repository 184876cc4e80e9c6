"""A disk that fails when it is told to, for programs that test/support/failing_disk.cpp is preloaded into."""
import errno
import mmap
import os
import struct

REALLY = {"EIO": errno.EIO, "ENOSPC": errno.ENOSPC}
LONG, THOROUGH = (os.environ.get(name, "0") not in ("", "0") for name in ("MM_LONG_TESTS", "MM_THOROUGH_TESTS"))


class FailingDisk:
    """Below one folder; the words are those of mm_test::FailingDiskControl (failing_disk.h)."""

    def __init__(self, folder, library):
        self.folder = os.path.realpath(folder)
        with open(self.folder + ".control", "wb") as file:
            file.write(bytes(40))
        with open(self.folder + ".control", "r+b") as file:
            self.control = mmap.mmap(file.fileno(), 40)
        self.environment = dict(os.environ, LD_PRELOAD=library, FAILING_DISK_FOLDER=self.folder + "/",
                                FAILING_DISK_CONTROL=self.folder + ".control", TMPDIR=os.path.join(self.folder, "tmp"))
        os.makedirs(os.path.join(self.folder, "tmp"), exist_ok=True)

    def count(self):
        """From now on; nothing fails."""
        self.control[:40] = bytes(40)

    def breaks(self, fault):
        what, way, n, cause = fault
        self.control[:40] = bytes(40)
        self.control[16:40] = struct.pack("<qiiii", n, 0, 0 if way == "once" else 1, REALLY[cause], 0)
        self.control[24:28] = struct.pack("<i", 1 if what == "read" else 2)  # last: it begins now

    def mends(self):
        self.control[24:28] = bytes(4)

    def counts(self):
        """Reads and writes since `count` or `breaks`."""
        return struct.unpack("<qq", self.control[:16])

    def faults(self):
        """Every way to fail of what was just counted: all n in a long test, else the first, the last and some between, fewer every day."""
        all_of_them = []
        for what, most in zip(("read", "write"), self.counts()):
            step, ends = (1, 0) if LONG else (max(1, most // 4), 2) if THOROUGH else (max(1, most // 2), 1)
            for way in ("once", "lasting"):
                for n in range(1, most + 1):
                    if ends < n <= most - ends and n % step != 0:
                        continue
                    causes = ["EIO"] if what == "read" else ["EIO", "ENOSPC"]
                    all_of_them += [(what, way, n, c) for c in (causes if LONG else [causes[n % len(causes)]])]
        return all_of_them


def said(fault):
    """What the system calls the cause of a fault."""
    return os.strerror(REALLY[fault[3]])
