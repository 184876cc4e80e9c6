"""Hostile clients against `mm workbench`, each kind for MM_LOAD_SECONDS (1; MM_LONG_TESTS: 10), while an honest page and an honest
program go on. Prints what reached the server, how long the honest ones waited, memory, and `ok …` and `not ok …` lines."""
import json
import multiprocessing
import os
import signal
import subprocess
import tempfile
import time

from told import LONG, check
from workbench_clients import (PATIENCE, RATE, Address, Honest, announced, bombs, endless, flood_with_token, flood_without_token, foreigners,
                               formulas, slow_loris)

MM = os.environ["MM"]
SECONDS = float(os.environ.get("MM_LOAD_SECONDS", "10" if LONG else "1"))
PLAN = """name: short
artifact:
  name: ball
  pose: known
  probe: {tip_radius_mm: 1.0, repeatability_um: 0.3}
  balls:
    - {name: b0, centre_mm: [0.0, 0.0, 0.0], radius_mm: 3.9685}
    - {name: b1, centre_mm: [13.0, 8.0, 2.0], radius_mm: 3.9685}
touch: {features: all, points: 12, cone_deg: 90}
"""


class Server:
    def __init__(self, folder):
        self.folder = folder
        for name in ("store", "home", "tmp"):
            os.mkdir(os.path.join(folder, name))
        bag, plan = os.path.join(folder, "short.bag"), os.path.join(folder, "short.yaml")
        with open(plan, "w") as f:
            f.write(PLAN)
        subprocess.run([MM, "simulate", "--machine", "three_axis", "--plan", plan, "--seed", "3", "-o", bag], check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.process = subprocess.Popen([MM, "workbench", bag, "--store", os.path.join(folder, "store")], stdin=subprocess.DEVNULL,
                                        stdout=subprocess.PIPE, stderr=open(os.path.join(folder, "errors"), "w"), text=True,
                                        # who starts these tests in the background has made them deaf to Ctrl-C
                                        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL), env=dict(os.environ, HOME=os.path.join(folder, "home"), TMPDIR=os.path.join(folder, "tmp")))
        self.address = Address(self.process.stdout.readline().strip())

    def memory(self, which="VmRSS"):
        """MB; VmHWM: at most, since that was asked for the last time."""
        with open("/proc/%d/status" % self.process.pid) as f:
            mb = next(int(line.split()[1]) for line in f if line.startswith(which)) / 1024.0
        if which == "VmHWM":
            with open("/proc/%d/clear_refs" % self.process.pid, "w") as f:
                f.write("5")
        return mb

    def handles(self):
        return len(os.listdir("/proc/%d/fd" % self.process.pid))

    def processor(self):
        """s of processor time so far."""
        with open("/proc/%d/stat" % self.process.pid) as f:
            fields = f.read().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def stop(self):
        self.process.send_signal(signal.SIGINT)
        try:
            return self.process.wait(60)
        except subprocess.TimeoutExpired:
            self.process.kill()
            return "killed"

    def files(self):
        """All that stands in its folders, but for the log of who did what."""
        found = {}
        for base, _, names in os.walk(self.folder):
            for name in names:
                path = os.path.join(base, name)
                if name not in ("workbench.log", "errors"):
                    found[os.path.relpath(path, self.folder)] = (os.path.getsize(path), os.stat(path).st_mtime_ns)
        return found


def work(kind, address, argument, queue):
    queue.put(kind(address, time.time() + SECONDS, argument))  # from here on: a full computer starts a process late


def attack(server, honest, name, kind, *arguments):
    """Runs a kind of client once for each argument, at the same time. @return what they counted, together; the seconds that they took."""
    honest.forget()
    server.memory("VmHWM")
    queue, begun, cpu = multiprocessing.Queue(), time.time(), server.processor()
    workers = [multiprocessing.Process(target=work, args=(kind, server.address, a, queue), daemon=True) for a in arguments]
    for w in workers:
        w.start()
    total = {}
    for _ in workers:
        for key, value in queue.get(timeout=SECONDS + 20 * PATIENCE).items():
            total[key] = max(total.get(key, 0), value) if key == "longest ms" else total.get(key, [] if isinstance(value, list) else 0) + value
    took = time.time() - begun
    for w in workers:
        w.join()
    answered = sum(v for k, v in total.items() if isinstance(k, int) and k > 0)
    print("%s, %.1f s: %.0f answers a second %s; %s; server: at most %.0f MB, %d handles, %.0f %% of a processor"
          % (name, took, answered / took, {k: round(v, 1) if isinstance(v, float) else v for k, v in sorted(total.items(), key=str)}, honest.tell(),
             server.memory("VmHWM"), server.handles(), 100 * (server.processor() - cpu) / took), flush=True)
    check("%s: it lives" % name, server.process.poll() is None)
    check("%s: honest clients are answered" % name, honest.kept and honest.new and max(honest.kept + honest.new) < PATIENCE, honest.tell())
    check("%s: no honest client is turned away" % name, not honest.failed, honest.failed[:3])
    # a page that was slow gets the latest state, not all of them
    times, numbers = [begun] + [t for t, _ in honest.live] + [begun + took], [n for _, n in honest.live]
    check("%s: the live page goes on" % name, honest.lost is None and numbers and all(a < b for a, b in zip(numbers, numbers[1:]))
          and max(b - a for a, b in zip(times, times[1:])) < PATIENCE, honest.lost or honest.live)
    return total, took


def main():
    with tempfile.TemporaryDirectory() as folder:
        server = Server(folder)
        address = server.address
        honest = Honest(address)
        time.sleep(1.0)  # so much of a quiet server is the comparison
        print("alone: " + honest.tell(), flush=True)
        before, rss, handles = server.files(), server.memory(), server.handles()
        try:
            counts, took = attack(server, honest, "10,000 requests a second with the token", flood_with_token, 0.5, 0.5)
            sent = counts.pop("sent")
            check("they are sent: %.0f a second" % (sent / SECONDS), sent >= 0.5 * RATE * SECONDS, counts)
            check("each is answered, what is too much by 429", sum(counts.values()) == sent and set(counts) <= {404, 429}, (sent, counts))
            check("and 1000 a second are let through", counts.get(404, 0) <= 1000 * (took + 1), (counts, took))
            counts, _ = attack(server, honest, "requests without the token, each in a connection of its own", flood_without_token, 1, 1)
            check("none is let through", set(counts) <= {403, 0}, counts)
            counts, _ = attack(server, honest, "the same, a hundred at once", flood_without_token, 50, 50)
            check("nor of a hundred at once", set(counts) <= {403, 0}, counts)
            counts, _ = attack(server, honest, "slow loris", slow_loris, 0)
            check("who dawdles gives way", counts.get(0, 0) > 0, counts)
            counts, _ = attack(server, honest, "endless JSON", endless, "json", "json_foreign")
            check("endless JSON is refused", set(counts) <= {413, 403, 0, 429, "stopped by us", "MB sent"} and counts.get(413, 0) > 0 and counts.get(403, 0) > 0, counts)
            counts, _ = attack(server, honest, "an endless file", endless, "file")
            check("an endless file is refused", set(counts) <= {411, 0, 429, "stopped by us", "MB sent"} and counts.get(411, 0) > 0, counts)
            counts, _ = attack(server, honest, "a file of 1 GB", announced, "1 GB", "1 GB, no token")
            check("a file of 1 GB is refused", set(counts) <= {413, 403, 0, 429, "MB sent"} and counts.get(413, 0) > 0, counts)
            check("nothing of it is kept", server.memory() < rss + 50, server.memory())
            counts, _ = attack(server, honest, "files of 250 MB that are no bags", announced, "250 MB")
            check("they are read, or wait to be", set(counts) <= {202, 409, 0, 429, "MB sent"} and counts.get(202, 0) > 0, counts)
            check("they are read to their end", honest.at_rest(120), honest.state)
            counts, _ = attack(server, honest, "foreign hosts and origins, no token, paths, nonsense", foreigners, 0, 0)
            check("each is refused as it should be", not counts["wrong"], counts["wrong"])
            check("none of them is answered with 200", 200 not in counts, counts)
            counts, _ = attack(server, honest, "formulas that never end", formulas, 0)
            check("each formula is judged within 1 s", counts["longest ms"] < 1000, counts)
            counts, _ = attack(server, honest, "texts that grow", bombs, 0)
            check("they are taken or refused", set(counts) <= {202, 400, 409, 429, 413}, counts)
            check("what was asked comes to an end", honest.at_rest(120), honest.state)
            check("nothing was written", server.files() == before, set(server.files().items()) ^ set(before.items()))
            status, body = address.ask(address.request("GET /data/session?token=" + address.token))
            check("afterwards the session is the one that was opened", status == 200 and json.loads(body)["name"] == "short.bag", body[:200])
            print("server: %.0f MB before, %.0f MB after; %d handles before, %d after" % (rss, server.memory(), handles, server.handles()))
            check("it keeps no memory", server.memory() < rss + 60, (rss, server.memory()))
        finally:
            honest.going = False
            status = server.stop()
        check("Ctrl-C ends it", status in (0, 130), status)


if __name__ == "__main__":
    main()
