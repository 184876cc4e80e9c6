"""The workbench on a disk that fails at the n-th read or write: an action is done, or says in one line why not and can be asked for
again; what is kept and the log stay whole. Prints `ok …` and `not ok …` lines."""
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.parse
import urllib.request

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
import failing_disk  # noqa: E402
from told import check

MM = os.environ["MM"]
LIBRARY = os.path.realpath(os.path.join(os.path.dirname(MM), "..", "libfailing_disk.so"))
ROOT = os.path.abspath(os.path.join(os.path.dirname(__file__), "..", ".."))


def mm(*words, folder=None):
    return subprocess.run([MM, *words], cwd=folder, capture_output=True, text=True)


class Workbench:
    def __init__(self, disk, bag, store):
        self.process = subprocess.Popen([MM, "workbench", bag, "--store", store], env=disk.environment, stdin=subprocess.DEVNULL,
                                        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        url = urllib.parse.urlparse(self.process.stdout.readline().strip())
        self.base, self.token = "http://" + url.netloc, urllib.parse.parse_qs(url.query)["token"][0]
        self.wait(lambda: any(line["who"] == "mm workbench" for line in self.log()))

    def wait(self, true, seconds=120):
        end = time.time() + seconds
        while not true():
            if time.time() > end or self.process.poll() is not None:
                raise AssertionError("the workbench does not answer, or has ended: %s" % self.process.poll())
            time.sleep(0.02)

    def ask(self, path, body=None):
        request = urllib.request.Request(self.base + path, body, {"X-Workbench-Token": self.token})
        with urllib.request.urlopen(request, timeout=60) as answer:
            return answer.read()

    def log(self):
        return json.loads(self.ask("/data/log"))["lines"]

    def lines(self, action):
        return [line["what"] for line in self.log() if line["what"].startswith(action + ": ")]

    def act(self, action, body):
        """To its end. @return what the log says of it."""
        before = len(self.lines(action))
        if isinstance(body, bytes):
            self.ask("/upload?name=sent.bag&who=test", body)
        else:
            self.ask("/action/" + action, json.dumps(dict(body, who="test")).encode())
        self.wait(lambda: len(self.lines(action)) > before)
        return self.lines(action)[0][len(action) + 2:]

    def stop(self):
        self.process.send_signal(signal.SIGINT)
        return self.process.wait(60)


def whole(work, store, copy, log):
    """What is wrong with the store and the log, or an empty text."""
    for name in os.listdir(copy):
        if name.endswith(".yaml"):
            with open(os.path.join(copy, name), "rb") as a, open(os.path.join(store, name), "rb") as b:
                if a.read() != b.read():
                    return name + " is not what it was"
    history = mm("history", "--store", store, "--json")
    damaged = [c for c in json.loads(history.stdout)["calibrations"] if c.get("damaged")]
    if damaged:
        return str(damaged)
    with open(os.path.join(store, "workbench.log")) as file:
        text = file.read()
    if not text.startswith(log):
        return "lines of the log are lost"
    # A line that was cut by a full disk may stand there alone, but no other is written behind it.
    odd = [line for line in text[len(log):].splitlines() if line.count("Z  ") > 1]
    if odd:
        return "two lines of the log are one: %s" % odd[0]
    left = os.listdir(os.path.join(work, "tmp"))
    return "left in the folder of temporary files: %s" % left if left else ""


def sweep(disk, bench, work, store, action, body, good):
    copy = os.path.join(work, "copy")
    shutil.rmtree(copy, ignore_errors=True)
    time.sleep(0.3)  # the log's last line
    shutil.copytree(store, copy, symlinks=True)
    before = os.readlink(os.path.join(store, "active"))
    disk.count()
    said = bench.act(action, body)
    if not good(said):
        return check(action + " without a fault", False, said)
    time.sleep(0.3)
    faults, wanted, refused, wrong = disk.faults(), os.readlink(os.path.join(store, "active")), 0, []
    for fault in faults:
        for name in os.listdir(store):
            if name != "workbench.log":
                os.remove(os.path.join(store, name))
        for name in os.listdir(copy):
            if name != "workbench.log":
                shutil.copy2(os.path.join(copy, name), os.path.join(store, name), follow_symlinks=False)
        with open(os.path.join(store, "workbench.log")) as file:
            log = file.read()
        disk.breaks(fault)
        said = bench.act(action, body)
        time.sleep(0.05)  # the log's line
        disk.mends()
        active = os.readlink(os.path.join(store, "active"))
        why = whole(work, store, copy, log)
        plain = said.split(" (this line could not")[0]
        if active not in (before, wanted):
            why = why or "active is " + active
        if good(plain) and active != wanted:
            why = why or "it says that it is done: " + said
        if not good(plain):
            refused += 1
            if not (failing_disk.said(fault) in said or "the disk reports an error" in said) or not said.startswith("refused: "):
                why = why or "it does not say why: " + said
            if active == before:
                again = bench.act(action, body)
                why = why or ("" if good(again) else "again: " + again)
        if why:
            wrong.append("%s: %s" % (fault, why))
    check("%s: %d faults, %d refused" % (action, len(faults), refused), not wrong and refused > 0, "; ".join(wrong[:4]))


def main():
    if not os.path.exists(LIBRARY):
        return check("the failing disk is built (make failing_disk)", False, LIBRARY)
    work = tempfile.mkdtemp(prefix="mm_workbench_disk_")
    disk = failing_disk.FailingDisk(work, LIBRARY)
    try:
        for seed, name in ((1, "s"), (2, "t")):
            made = mm("simulate", "--machine", "three_axis", "--plan", os.path.join(ROOT, "test/ros/short_plan.yaml"), "--seed", str(seed),
                      "-o", os.path.join(work, name + ".bag"))
            check("a session is made", made.returncode == 0, made.stderr)
        for effects in ("{type: scale, axis: x}", "{type: scale, axis: y}"):
            with open(os.path.join(work, "m.yaml"), "w") as file:
                file.write("machine: three_axis\neffects: [%s]\n" % effects)
            mm("calibrate", "s.bag", "--model", "m.yaml", "--method", "least_squares", "--force", "-o", "c.yaml", folder=work)
            mm("promote", "c.yaml", "--store", "store", folder=work)
        store = os.path.join(work, "store")
        ids = sorted(name[:-5] for name in os.listdir(store) if name.endswith(".yaml") and not os.path.islink(os.path.join(store, name)))
        other = [i for i in ids if i != os.readlink(os.path.join(store, "active"))[:-5]][0]
        bench = Workbench(disk, os.path.join(work, "s.bag"), store)
        with open(os.path.join(work, "t.bag"), "rb") as file:
            sent = file.read()
        done = lambda said: not said.startswith("refused: ")
        sweep(disk, bench, work, store, "promote", {"id": other}, done)
        sweep(disk, bench, work, store, "rollback", {}, done)
        sweep(disk, bench, work, store, "calibrate", {"model": "effects: [{type: scale, axis: z}]", "method": "least_squares"}, done)
        sweep(disk, bench, work, store, "export", {"controller": "csv"}, done)
        sweep(disk, bench, work, store, "open", sent, done)
        check("the workbench ends as asked", bench.stop() in (0, 130))
    finally:
        shutil.rmtree(work, ignore_errors=True)
        os.remove(disk.folder + ".control")


main()
