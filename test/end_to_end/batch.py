"""Tries mm batch and mm fleet: run by batch_test.sh; prints `ok …` and `not ok …` lines, and figures."""
import glob
import json
import os
import random
import shutil
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time

from told import THOROUGH, say

ROOT = os.path.abspath(os.path.join(os.path.dirname(__file__), "..", ".."))
MM = os.environ["MM"]
MACHINES = int(os.environ.get("MACHINES", "6" if THOROUGH else "2"))
SESSIONS = int(os.environ.get("SESSIONS", "4" if THOROUGH else "2"))
KILLS = int(os.environ.get("KILLS", "4" if THOROUGH else "2"))
# Every day try_failures alone diagnoses.
STEPS = os.environ.get("STEPS", "check,calibrate,diagnose" if THOROUGH else "check,calibrate")
FIGURES = {"machines": MACHINES, "sessions": MACHINES * SESSIONS, "steps": STEPS}


def mm(*words, **more):
    return subprocess.run([MM, *words], capture_output=True, text=True, **more)


def batch(manifest, folder, *words, **more):
    begun = time.monotonic()
    done = mm("batch", manifest, "-o", folder, "--json", *words, **more)
    answer = json.loads(done.stdout) if done.stdout else {}
    return done, answer, time.monotonic() - begun


def results(folder):
    """Every finished job: key -> bytes of its result.json."""
    found = {}
    for path in glob.glob(os.path.join(folder, "jobs", "*", "*", "result.json")):
        with open(path, "rb") as file:
            found[os.path.basename(os.path.dirname(path))] = file.read()
    return found


def table(folder, sql):
    with sqlite3.connect(f"file:{folder}/fleet.db?mode=ro", uri=True) as database:
        return database.execute(sql).fetchall()


def whole(folder, count):
    """Nothing lost, nothing twice, nothing half: what is wrong, or an empty text."""
    keys = results(folder)
    rows = table(folder, "SELECT key, status FROM jobs")
    parameters = table(folder, "SELECT job, count(*) FROM parameters GROUP BY job")
    wrong = []
    if len(keys) != count or len(rows) != count:
        wrong.append(f"{len(keys)} folders and {len(rows)} rows of {count} jobs")
    if {key for key, status in rows if status != "waiting"} != set(keys):
        wrong.append("the tables and the folders differ")
    if any(number != 9 for _, number in parameters):
        wrong.append("parameters are missing or twice")
    if os.path.exists(os.path.join(folder, "work")):
        wrong.append("left in work: " + ", ".join(os.listdir(os.path.join(folder, "work"))[:3]))
    return "; ".join(wrong)


def try_local(fleet, work):
    first = os.path.join(work, "local")
    done, answer, seconds = batch(fleet + "/manifest.yaml", first)
    count = MACHINES * SESSIONS
    say(done.returncode == 0 and answer.get("done") == count, f"local: {count} sessions are done", done.stderr)
    say(whole(first, count) == "", "local: the tables and the folders are whole", whole(first, count))
    FIGURES["local_s"] = seconds
    if THOROUGH:
        done, answer, seconds = batch(fleet + "/manifest.yaml", first)
        say(done.returncode == 0 and answer.get("done") == 0 and answer.get("done_before") == count, "nothing is to do: nothing is done")
        FIGURES["nothing_to_do_s"] = seconds
    before = results(first)
    os.remove(glob.glob(os.path.join(first, "jobs", "*", "*", "result.json"))[0])
    os.remove(first + "/fleet.db")
    done, answer, seconds = batch(fleet + "/manifest.yaml", first)
    say(done.returncode == 0 and answer.get("done") == 1 and results(first) == before, "a folder without a result is not in the way", done.stderr)
    say(answer.get("done_before") == count - 1, "what is done is not done again", answer)
    say(whole(first, count) == "", "tables that are lost are filled again from the folders", whole(first, count))
    return first


def try_one_process(fleet, work, first):
    """The same sessions one after the other, and typed one command after the other: figures, and the same bits."""
    folder = os.path.join(work, "one")
    _, answer, seconds = batch(fleet + "/manifest.yaml", folder, "--jobs", "1")
    say(results(folder) == results(first), "one process at a time and several give the same bits")
    FIGURES["one_process_s"] = seconds
    inside = 0.0
    for path in glob.glob(os.path.join(folder, "jobs", "*", "*", "steps.txt")):
        with open(path, encoding="utf-8") as file:
            inside += sum(float(line.split()[2]) / 1000.0 for line in file)
    FIGURES["overhead_ms_a_job"] = 1000.0 * (seconds - inside) / (MACHINES * SESSIONS)
    bags = sorted(glob.glob(fleet + "/m*/*.bag"))[:12 if THOROUGH else 2]
    begun, wrong = time.monotonic(), []
    for bag in bags:
        typed = os.path.join(work, "typed.yaml")
        lines = {"check": ["check", bag, "--model", fleet + "/model.yaml", "--json"],
                 "calibrate": ["calibrate", bag, "--model", fleet + "/model.yaml", "-o", typed, "--method", "least_squares", "--threads", "1",
                               "--json", "--force"],
                 "diagnose": ["diagnose", bag, "--calibration", typed, "--threads", "1", "--json"]}
        done = [mm(*lines[step]) for step in STEPS.split(",")]
        wrong += [d.stderr for d in done if d.returncode > 1]  # 1: the answer is no
    say(not wrong, "the same steps can be typed", "".join(wrong))
    FIGURES["typed_s_a_session"] = (time.monotonic() - begun) / len(bags)


def workers(folder, program=""):
    """Processes that work for this folder: Snakemake and all that it started, or those of one program alone (python: Snakemake)."""
    found = []
    for path in glob.glob("/proc/[0-9]*"):
        try:
            place, name = os.readlink(path + "/cwd"), os.path.basename(os.readlink(path + "/exe")).rstrip("0123456789.")
            with open(path + "/cmdline", "rb") as file:
                words = file.read()
        except OSError:
            continue  # it has ended
        work = os.path.join(folder, "work")
        if (place == work or place.startswith(work + "/") or b"snakemake" in words and work.encode() in words) and program in (name, ""):
            found.append(int(path.split("/")[2]))
    return found


def survivors(folder):
    """Processes that are there still, a second after those that started them were killed."""
    until = time.monotonic() + 1.0
    while workers(folder) and time.monotonic() < until:
        time.sleep(0.02)
    return workers(folder)


def kill_one(process, folder, moments, program=""):
    """One of the processes alone; the batch goes on without it. Returns whether there was one."""
    while process.poll() is None:
        found = workers(folder, program)
        if found:
            try:
                os.kill(moments.choice(found), signal.SIGKILL)
                return True
            except ProcessLookupError:
                continue
    return False


def try_kills(fleet, work, first):
    """Killed at random moments: the batch that was typed by either signal, Snakemake, or any one process below it."""
    folder = os.path.join(work, "killed")
    moments = random.Random(int(os.environ.get("SEED", "3")))
    reach = 0.1 + FIGURES["local_s"] / KILLS
    killed, alone, left, lost = 0, 0, [], ""
    before = {}
    for number in range(KILLS):
        process = subprocess.Popen([MM, "batch", fleet + "/manifest.yaml", "-o", folder, "--json"], stdout=subprocess.DEVNULL,
                                   stderr=subprocess.DEVNULL)
        try:
            process.wait(moments.uniform(0.02, reach))
        except subprocess.TimeoutExpired:
            if number % 2 == 1:  # the batch ends the rest
                alone += kill_one(process, folder, moments, "" if number % 4 == 1 else "mm")
            else:
                process.send_signal(signal.SIGTERM if number % 4 == 0 else signal.SIGKILL)
            process.wait()
            killed += 1
            left += survivors(folder)
            now = results(folder)
            for key, text in now.items():  # whole, whenever one looks
                json.loads(text)
            lost = lost or [key for key, text in before.items() if now.get(key) != text and json.loads(text)["status"] == "done"]
            before = now
    done, answer, _ = batch(fleet + "/manifest.yaml", folder)
    count = MACHINES * SESSIONS
    wrong = whole(folder, count)
    say(done.returncode == 0 and wrong == "", f"killed {killed} times, nothing is lost and nothing is there twice", wrong + done.stderr)
    say(not left, "and nothing of them runs on", left)
    say(not lost, "and what was done stayed as it was", lost)
    say(results(folder) == results(first), "and the results are the same bits")
    say(killed > 0 and alone > 0, f"killed {killed} times, {alone} of them one process alone")
    FIGURES.update(killed=killed, one_alone=alone)


def standing_still(fleet, folder, *words):
    """A batch of one session whose step waits for ever: its model has become a pipe. Returns it, its manifest, and the step."""
    manifest, model = folder + ".yaml", folder + "_model.yaml"
    shutil.copy(fleet + "/model.yaml", model)
    with open(manifest, "w", encoding="utf-8") as file:
        file.write(f"model: {model}\nsteps: [calibrate]\nsessions:\n  - {{bags: {fleet}/m01/000.bag, machine: m01}}\n")
    process = subprocess.Popen([MM, "batch", manifest, "-o", folder, *words], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    while process.poll() is None and not glob.glob(os.path.join(folder, "work", "*", "job.json")):
        time.sleep(0.005)
    os.rename(model, model + ".kept")
    os.mkfifo(model)
    step = []
    while process.poll() is None and not step:
        step = workers(folder, "mm")
    return process, manifest, step


def try_orphans(fleet, work):
    """A step that waits ends with whoever is killed above it, each of them alone: the first and the last every day."""
    for name in ("mm batch", "python", "bash", "timeout") if THOROUGH else ("mm batch", "timeout"):
        folder = os.path.join(work, "orphan_of_" + name.split()[0])
        process, _, step = standing_still(fleet, folder)
        above = [process.pid] if name == "mm batch" else workers(folder, name)
        for pid in above:
            os.kill(pid, signal.SIGKILL)
        until = time.monotonic() + 2.0
        while any(alive(pid) for pid in step) and time.monotonic() < until:
            time.sleep(0.01)
        left = [pid for pid in step if alive(pid)]
        say(step and len(above) == 1 and not left, f"a step ends with {name} above it", f"{step} {above} {left}")
        process.kill()
        process.communicate()
        for pid in left:
            os.kill(pid, signal.SIGKILL)


def alive(pid):
    try:
        with open(f"/proc/{pid}/stat", "rb") as file:
            return file.read().rsplit(b")", 1)[1].split()[0] not in (b"Z", b"X")
    except OSError:
        return False


def try_interrupt(fleet, work, first):
    """Ctrl-C, and on one process at a time."""
    folder = os.path.join(work, "interrupted")
    process = subprocess.Popen([MM, "batch", fleet + "/manifest.yaml", "-o", folder], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    while process.poll() is None and not results(folder):
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate()
    kept = len(results(folder))
    say(process.returncode == 130 and kept > 0 and "Ctrl-C" in said, "Ctrl-C ends it with 130 and keeps what is done", said)
    done, answer, _ = batch(fleet + "/manifest.yaml", folder, "--jobs", "1")
    say(done.returncode == 0 and answer.get("done_before", 0) >= kept and answer["done"] > 0, "the same line goes on from there", done.stderr)
    say(results(folder) == results(first), "one process at a time and several give the same bits")


def try_limit(fleet, work):
    """A step that stands still ends at its limit, its job fails, and the next run does it again."""
    folder = os.path.join(work, "limited")
    process, manifest, step = standing_still(fleet, folder, "--limit", "1")
    _, said = process.communicate()
    os.replace(folder + "_model.yaml.kept", folder + "_model.yaml")
    say(process.returncode == 1 and "calibrate: took longer than 1 s (--limit)" in said and said.count("\n") == 1, "a step that takes too long is ended and named", said)
    done, answer, _ = batch(manifest, folder)
    say(done.returncode == 0 and answer["done"] == 1, "and tried again by the next run", done.stderr)


def try_profile(fleet, work, first):
    """A profile of Snakemake in which every job of a cluster is a shell of this computer."""
    profile, folder = os.path.join(work, "profile"), os.path.join(work, "profiled")
    os.makedirs(profile)
    with open(profile + "/config.yaml", "w", encoding="utf-8") as file:
        file.write("cluster: sh\njobs: 2\ngroup-components: sessions=2\n")
    done, _, _ = batch(fleet + "/manifest.yaml", folder, "--profile", profile)
    say(done.returncode == 0 and results(folder) == results(first), "a profile of Snakemake: the same bits", done.stderr)
    done, answer, _ = batch(fleet + "/manifest.yaml", os.path.join(work, "no_profile"), "--profile", work + "/nowhere")
    say(done.returncode == 1 and answer["left"] == MACHINES * SESSIONS and "nowhere" in done.stderr and "batch.log" in done.stderr,
        "one that is not there is said", done.stderr)


def try_slurm(fleet, work, first):
    folder = os.path.join(work, "slurm")
    here = os.path.join(ROOT, "test/support/slurm_here")
    script = os.path.join(work, "slurm_test.py")
    if subprocess.run([here, "1", "true"], capture_output=True).returncode == 77:
        print("slurm is not installed (Debian: slurm-wlm): its engine was not tried")
        return
    with open(script, "w", encoding="utf-8") as file:
        file.write(f"import sys; sys.path.insert(0, {os.path.dirname(os.path.abspath(__file__))!r}); import batch\n"
                   f"batch.in_slurm({fleet!r}, {folder!r})\n")
    done = subprocess.run([here, str(min(2, os.cpu_count())), sys.executable, script], capture_output=True, text=True)
    print(done.stdout, end="")
    say(done.returncode == 0, "slurm: started and ended", done.stderr)
    if done.returncode == 0:
        FIGURES.update(json.load(open(folder + ".json", encoding="utf-8")))
    say(results(folder) == results(first), "slurm: the same bits as local")


def in_slurm(fleet, folder):
    """Inside the cluster of this computer: killed, stopped, resumed; what the killed srun left is ended."""
    line = [MM, "batch", fleet + "/manifest.yaml", "-o", folder, "--engine", "slurm"]

    def queue():
        return subprocess.run(["squeue", "--noheader"], capture_output=True, text=True).stdout.strip()

    def begun():
        process = subprocess.Popen(line, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        before = len(results(folder))
        while process.poll() is None and (len(results(folder)) == before or not queue()):
            time.sleep(0.05)
        return process

    process = begun()
    for pid in workers(folder, "srun"):  # it cannot end its job then
        os.kill(pid, signal.SIGKILL)
    process.kill()
    process.wait()
    before = len(results(folder))
    process = begun()
    process.send_signal(signal.SIGINT)
    say(process.wait() == 130 and queue() == "", "slurm: Ctrl-C leaves nothing in the queue", queue())
    done, answer, seconds = batch(fleet + "/manifest.yaml", folder, "--engine", "slurm")
    count = MACHINES * SESSIONS
    say(done.returncode == 0 and whole(folder, count) == "", f"slurm: killed after {before}, resumed, whole", done.stderr + whole(folder, count))
    say(queue() == "", "slurm: nothing is left in the queue", queue())
    shutil.rmtree(folder)
    done, answer, seconds = batch(fleet + "/manifest.yaml", folder, "--engine", "slurm")
    with open(folder + ".json", "w", encoding="utf-8") as file:
        json.dump({"slurm_s": seconds}, file)


def try_failures(fleet, work):
    folder = os.path.join(work, "failing")
    with open(fleet + "/broken.bag", "w", encoding="utf-8") as file:
        file.write("this is no bag\n")
    manifest = os.path.join(fleet, "failing.yaml")
    with open(manifest, "w", encoding="utf-8") as file:
        file.write("model: model.yaml\nsessions:\n  - {bags: broken.bag, machine: m01}\n  - {bags: m01/*.bag, machine: m01}\n")
    done, answer, _ = batch(manifest, folder)
    say(done.returncode == 1 and answer["failed"] == 1 and answer["done"] == SESSIONS, "a job that fails does not stop the others", done.stderr)
    say("failing.yaml:3" in done.stderr and "broken.bag" in done.stderr and "bag" in done.stderr.split("broken.bag", 1)[1], "and says why", done.stderr)
    done, answer, _ = batch(manifest, folder)
    say(done.returncode == 1 and answer["done"] == 0 and answer["failed"] == 0 and len(answer["why"]) == 1, "it is not tried again by itself, and still said", done.stderr)
    done, answer, _ = batch(manifest, folder, "--again")
    say(answer["failed"] == 1, "--again tries it again")
    text = mm("fleet", folder).stdout
    say("broken.bag" in text, "mm fleet lists it", text)


def try_refusals(fleet, work):
    manifest = os.path.join(fleet, "wrong.yaml")
    with open(manifest, "w", encoding="utf-8") as file:
        file.write("model: model.yaml\nsessions:\n  - {bags: m01/*.bag}\n  - {bags: nowhere/*.bag}\n")
    done = mm("batch", manifest, "-o", os.path.join(work, "refused"))
    say(done.returncode == 2 and "wrong.yaml:4" in done.stderr and done.stderr.count("\n") == 1, "a bad entry is named by file and line", done.stderr)
    say(not os.path.exists(os.path.join(work, "refused")), "and nothing is begun")
    done = mm("batch", fleet + "/manifest.yaml", "-o", os.path.join(work, "refused"), env=dict(os.environ, PATH="/nonexistent"))
    say(done.returncode == 2 and "install it (Debian: snakemake)" in done.stderr, "Snakemake that is not installed is named with its package", done.stderr)
    empty = os.path.join(work, "empty")
    os.makedirs(empty)
    done = mm("fleet", empty)
    say(done.returncode == 2 and "fleet.db" in done.stderr, "mm fleet says what a folder lacks", done.stderr)


def try_fleet(first, work):
    page = os.path.join(work, "fleet.html")
    done = mm("fleet", first, "-o", page)
    say(done.returncode == 0 and f"{MACHINES} machines, {MACHINES * SESSIONS} sessions" in done.stdout, "mm fleet counts machines and sessions", done.stderr)
    say(os.path.getsize(page) > 10000, "and writes a page")
    answer = json.loads(mm("fleet", first, "--machine", "m01", "--parameter", "backlash", "--json").stdout)
    say(len(answer["series"]) == 3 and len(answer["series"][0]["points"]) == SESSIONS, "one machine's parameters can be asked for")
    lines = mm("fleet", first, "--csv").stdout.splitlines()
    say(len(lines) == 1 + 9 * MACHINES * SESSIONS, "the CSV has every parameter of every session", len(lines))


def try_faults(work):
    """Machines to which something happened are named, with what; the others are not."""
    fleet, folder = os.path.join(work, "faults"), os.path.join(work, "faults_results")
    told = [("m03", "drifts", "backlash, axis: x"), ("m12", "sensor", "sensor bed is stuck")]
    if THOROUGH:
        told += [("m08", "changed", "squareness"), ("m21", "sensor", "offset of sensor frame changed")]
    only = ["m01", *(["m02", "m04", "m05"] if THOROUGH else []), *(machine for machine, _, _ in told)]
    made = subprocess.run([os.path.join(ROOT, "scripts/fleet_simulation"), "-o", fleet, "--sessions", "16" if THOROUGH else "8",
                           "--steps", "calibrate",
                           "--only", ",".join(only)], capture_output=True, text=True)
    batch(fleet + "/manifest.yaml", folder)
    done = mm("fleet", folder, "--json")
    found = [(f["machine"], f["kind"], f["in_words"]) for f in json.loads(done.stdout)["findings"]] if done.stdout else []
    for machine, kind, words in told:
        say(any(f[0] == machine and f[1] == kind and words in f[2] for f in found), f"{machine} is named: {words}", made.stderr + done.stderr + str(found))
    quiet = [f[2] for f in found if f[0] not in [machine for machine, _, _ in told]]
    say(not quiet, "and no other machine", quiet)


def try_stores(first, work):
    """Calibrations of several machines, promoted into a store each."""
    stores = os.path.join(work, "stores")
    rows = table(first, "SELECT machine, folder FROM jobs ORDER BY machine, date")
    for machine, folder in rows[: 2 * SESSIONS]:
        mm("promote", os.path.join(first, folder, "calibration.yaml"), "--store", os.path.join(stores, machine))
    done = mm("fleet", stores, "--json")
    answer = json.loads(done.stdout) if done.returncode == 0 else {"machines": []}
    say(answer["machines"] == ["m01", "m02"] and answer["done"] == 2 * SESSIONS, "stores of several machines are read and compared", done.stderr)


def try_prior(fleet, first, work):
    """A sister and a machine that is none, with and without what the others say."""

    def fit(bag, *words):
        done = mm("calibrate", bag, "--model", fleet + "/model.yaml", "--method", "least_squares", "--json", *words)
        return done, json.loads(done.stdout) if done.stdout else {"parameters": []}

    prior = ["--prior", first, "--prior-except", "m01"]
    bag = fleet + "/m01/000.bag"
    alone, without = fit(bag)
    done, both = fit(bag, *prior, "-o", os.path.join(work, "prior.yaml"))
    narrower = [w["std"] > b["std"] for w, b in zip(without["parameters"], both["parameters"])]
    say(done.returncode == 0 and both["prior"]["used"] and len(narrower) == 9 and all(narrower), "a prior of sisters narrows every parameter", done.stderr)
    same = [key for key in ("rms_um", "held_out_rms_um", "chi2_per_dof") if both[key] == without[key]]
    say(not same, "the figures are those with the prior", same)
    say("prior from at least" in done.stderr and "prior" not in alone.stderr and "prior" not in without, "it is said, and off unless asked for", done.stderr)
    with open(os.path.join(work, "prior.yaml"), encoding="utf-8") as file:
        say("prior of" in file.read(), "the calibration file tells of it")
    odd = os.path.join(work, "odd.bag")
    mm("simulate", "--machine", "three_axis", "--plan", fleet + "/plan.yaml", "--hide", "backlash:x=12um", "--seed", "9", "-o", odd)
    _, without = fit(odd)
    done, both = fit(odd, *prior)
    same = [p["value"] for p in without["parameters"]] == [p["value"] for p in both["parameters"]]
    say(both["prior"]["contradicted"] and not both["prior"]["used"] and same, "a machine that is no sister is told, and the prior is not used", done.stderr)
    say("this machine differs" in done.stderr and done.stderr.count("this machine differs") == 1, "in one line that names what contradicts", done.stderr)
    done, _ = fit(bag, "--prior", work + "/empty")
    say(done.returncode == 2 and "fleet.db" in done.stderr, "a folder without sisters is refused", done.stderr)


def try_several_pcs(work):
    """The launch file of docs/scale.md, as roslaunch reads it."""
    if shutil.which("roslaunch") is None:
        return
    with open(os.path.join(ROOT, "docs/scale.md"), encoding="utf-8") as file:
        launch = file.read().split("```xml\n", 1)[1].split("```", 1)[0]
    path = os.path.join(work, "several_pcs.launch")
    with open(path, "w", encoding="utf-8") as file:
        file.write(launch)
    done = subprocess.run(["roslaunch", "--nodes", path], capture_output=True, text=True)
    say(done.stdout.split() == ["/m1/axis_driver", "/m2/axis_driver"], "docs/scale.md: roslaunch reads the file for several PCs", done.stderr)


def main():
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job has it ignored, and so would what is started here
    keep = os.environ.get("PROOF")
    work = keep or tempfile.mkdtemp()
    os.makedirs(work, exist_ok=True)
    try:
        fleet = os.path.join(work, "fleet")
        begun = time.monotonic()
        made = subprocess.run([os.path.join(ROOT, "scripts/fleet_simulation"), "-o", fleet, "--machines", str(MACHINES), "--sessions", str(SESSIONS),
                               "--steps", STEPS], capture_output=True, text=True)
        FIGURES["simulation_s"] = time.monotonic() - begun
        if made.returncode != 0:
            return say(False, "the fleet is simulated", made.stderr)
        first = try_local(fleet, work)
        if THOROUGH:
            try_one_process(fleet, work, first)
        try_kills(fleet, work, first)
        try_orphans(fleet, work)
        try_interrupt(fleet, work, first)
        try_limit(fleet, work)
        try_profile(fleet, work, first)
        if THOROUGH:
            try_slurm(fleet, work, first)
        try_failures(fleet, work)
        try_refusals(fleet, work)
        try_fleet(first, work)
        try_faults(work)
        try_stores(first, work)
        if MACHINES > 5:
            try_prior(fleet, first, work)
        try_several_pcs(work)
        print(json.dumps(FIGURES))
        if keep:
            with open(os.path.join(keep, "figures.json"), "w", encoding="utf-8") as file:
                json.dump(FIGURES, file, indent=1)
    finally:
        if not keep:
            shutil.rmtree(work, ignore_errors=True)


if __name__ == "__main__":
    main()
