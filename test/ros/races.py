#!/usr/bin/env python3
"""Reads what the thread sanitizer wrote: races.py <file> ... Prints the reports that concern this package, and the number of each kind.

Debian's libraries are not built with the sanitizer: it sees their accesses, but not all of what orders them (the atomic
counters of a shared pointer whose other half is inlined here). A report is a library's own where every access, and every lock of a
cycle, was made by a function of the library itself: beside code of this package none is. So is one where oneTBB's own bookkeeping
is on one side: nobody else sees that memory before it is given back. And so is one where the library gives memory back that it
counts the owners of (a message's buffer), and the sanitizer no longer knows who read it: the last owner gives it back.
The last line is `<ours> <libraries'>`; the exit status is 1 where one is ours."""
import collections
import re
import sys

TBB = re.compile(r"tbb::detail|/usr/include/oneapi/|\(libtbb\.so")
LIBRARIES = re.compile(
    r"\(lib(roscpp|xmlrpcpp|rosconsole\w*|log4cxx|rosbag|rosbag_storage|boost_\w+|apr\w*-1)\.so|ros::(SerializedMessage::~|ServiceCallbackHelperT)|serializeMessage<rosgraph_msgs::Log_|" + TBB.pattern)
# What a library's templates and the sanitizer itself put on top of the caller's frame.
ON_TOP = re.compile(r"libtsan\.so|^(void |bool )?boost::|^(void )?std::|^((void|ros::\w+) )?ros::(SubscriptionCallbackHelperT|serialization|MessageEvent)"
                    r"|/usr/(include|lib/gcc)/(?!oneapi)")
FREED = re.compile(r"Write of size \d+ .*\n\s+#0 operator delete")
STACK = re.compile(r"(acquired here|(Write|Read|read|write) of size|atomic write|atomic read|^WARNING.*(unlock|destroy|double lock))")


def callers(report):
    """The frame that made each access or took each lock: the first that is neither the sanitizer's nor a template's; "?" where the
    sanitizer does not know it."""
    found, wanted = [], False
    for line in report.splitlines():
        frame = re.match(r"\s+#\d+ (.*)", line)
        if frame is None:
            begins = bool(STACK.search(line))
            if wanted and (begins or not line.strip()):
                found.append("?")
                wanted = False
            wanted = wanted or begins
        elif wanted and (LIBRARIES.search(frame.group(1)) or not ON_TOP.search(frame.group(1))):
            found.append(frame.group(1))
            wanted = False
    return found


def main():
    ours, kinds = [], collections.Counter()
    for name in sys.argv[1:]:
        with open(name, errors="replace") as file:
            for report in file.read().split("=================="):
                if "WARNING: ThreadSanitizer" not in report:
                    continue
                frames = callers(report)
                if FREED.search(report):
                    frames = [f for f in frames if f != "?"]
                if frames and (all(LIBRARIES.search(f) for f in frames) or any(TBB.search(f) for f in frames)):
                    kinds[re.search(r"ThreadSanitizer: ([^(\n]*)", report).group(1).strip() + " in " + frames[0].split("(")[0]] += 1
                else:
                    ours.append(report)
    for report in ours:
        print(report)
    for kind, count in kinds.most_common():
        print(f"{count:5} a library's own: {kind}")
    print(len(ours), sum(kinds.values()))
    return 1 if ours else 0


if __name__ == "__main__":
    sys.exit(main())
