"""The workbench in a browser: the whole loop by its buttons, every view, its limits. Prints `ok …` and `not ok …` lines.
MM_SCREENSHOTS=<folder> keeps a picture of each view in both widths and both colours."""
import io
import json
import os
import re
import signal
import struct
import subprocess
import sys
import tempfile
import threading
import urllib.parse
import urllib.request
import zipfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from browser import Browser  # noqa: E402
from told import THOROUGH, check

MM = os.environ["MM"]
VIEWS = ["import", "session", "compare", "diagnose", "ledger", "correct", "measure", "heat", "history"]
SCREENS = [(1280, "light"), (400, "dark"), (1280, "dark"), (400, "light")]  # every day each width and each colour once


def mm(*arguments):
    subprocess.run([MM] + list(arguments), check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


class Workbench:
    def __init__(self, *arguments, cwd=None):
        self.process = subprocess.Popen([MM, "workbench"] + list(arguments), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                        stderr=subprocess.PIPE, text=True, cwd=cwd)
        self.errors = []
        threading.Thread(target=lambda: self.errors.extend(self.process.stderr), daemon=True).start()
        self.url = self.process.stdout.readline().strip()

    def peak_megabytes(self):
        with open("/proc/%d/status" % self.process.pid) as f:
            return int(re.search(r"VmHWM:\s+(\d+)", f.read()).group(1)) / 1024.0

    def stop(self):
        self.process.send_signal(signal.SIGINT)
        return self.process.wait(30)


def number(text):
    found = re.search(r"([0-9.]+)", text or "")
    return float(found.group(1)) if found else None


def tile(browser, label):
    """Value of the tile whose label begins so."""
    return browser.wait("""(() => { const t = [...document.querySelectorAll(".tile")].find((x) => x.querySelector(".label").textContent.startsWith(%s));
                           return t && t.querySelector(".value").textContent; })()""" % json.dumps(label))


def go(browser, view):
    browser.evaluate("location.hash = %s" % json.dumps(view))
    browser.wait("document.querySelector('main').getAttribute('aria-label').toLowerCase() === %s && document.querySelector('main').children.length > 0"
                 % json.dumps(view))


def loop(browser, bench, folder):
    browser.open(bench.url + "#compare")
    before = number(tile(browser, "RMS, this calibration"))
    check("the misfit is seen", before and before > 0.7, before)
    shown = browser.wait("document.querySelector('#x') && document.querySelector('#x').value")
    check("what explains most is drawn first", shown == "x travel direction", shown)
    go(browser, "diagnose")
    browser.click("Diagnose")
    sentence = browser.wait("document.querySelector('.verdict .sentence') && document.querySelector('.verdict .sentence').innerText", 120)
    check("the missing effect is named", sentence.startswith("Missing: backlash of x"), sentence)
    card = browser.text("article.effect")
    check("with its size and uncertainty", re.search(r"gap = \d\.\d+ ± 0\.\d+ µm", card), card)
    check("with cause and remedy", "Cause" in card and "Remedy" in card and "Preload" in card, card)
    browser.click("Add", "document.querySelector('article.effect')")
    sentence = browser.wait("[...document.querySelectorAll('.verdict .sentence')].map((x) => x.innerText).find((t) => !t.startsWith('Missing'))", 120)
    check("then nothing is missing, and nobody had to ask", sentence.startswith("Nothing is missing"), sentence)
    go(browser, "ledger")
    browser.wait("document.querySelectorAll('.bars .step').length === 2")
    steps = [number(t) for t in browser.evaluate("[...document.querySelectorAll('.bars .figure')].map((x) => x.innerText)")]
    check("the error falls", steps[1] < 0.5 * steps[0], steps)
    go(browser, "compare")
    after = number(browser.wait("""(() => { const t = [...document.querySelectorAll(".tile")].find((x) => x.querySelector(".label").textContent.startsWith("RMS, this calibration"));
        const value = t && t.querySelector(".value").textContent; return value && parseFloat(value) < %g && value; })()""" % (0.5 * before)))
    check("and is seen where it was compared", after < 0.5 * before, (before, after))
    go(browser, "correct")
    browser.click("Promote")
    browser.click("Make ")
    said = browser.wait("[...document.querySelectorAll('.said')].map((x) => x.innerText).find((t) => t)")
    check("it is promoted", said.endswith("is active"), said)
    links = os.listdir(os.path.join(folder, "store"))
    check("in the folder of calibrations", "active" in links, links)


def pictures(browser):
    """A chart is kept as files, and its points are picked by keys."""
    go(browser, "compare")
    browser.wait("document.querySelector('.chart canvas')")
    browser.evaluate("document.querySelector('.chart').dispatchEvent(new KeyboardEvent('keydown', { key: 'End', bubbles: true })), true")
    row = browser.wait("document.querySelector('.card[role=status] b') && document.querySelector('.card[role=status] b').innerText")
    check("a point is picked by a key", row.startswith("Row "), row)
    browser.evaluate("""(() => { const real = URL.createObjectURL; window.kept = [];
        URL.createObjectURL = (file) => { file.text().then((text) => window.kept.push(text)); return real(file); }; return true; })()""")
    browser.click("Keep the picture (SVG)")
    svg = browser.wait("window.kept.length === 1 && window.kept[0]")
    browser.click("Keep its numbers (CSV)")
    csv = browser.wait("window.kept.length === 2 && window.kept[1]")
    drawn = int(re.search(r"Drawn: (\d+) of", browser.text("main")).group(1))
    check("the picture has every point", svg.count('r="2"') == drawn and ">" + browser.evaluate("document.querySelector('#x').value") in svg, (svg.count('r="2"'), drawn))
    check("the numbers have names and every row", csv.startswith('"') and csv.count("\r\n") == drawn + 1, csv[:80])


def export(browser):
    go(browser, "correct")
    browser.click("Export", "document.querySelector('#controller').closest('section')")
    address = browser.wait("[...document.querySelectorAll('a.button')].filter((a) => a.innerText === 'Keep the export').map((a) => a.href)[0]", 120)
    with urllib.request.urlopen(address, timeout=60) as answer:
        archive = zipfile.ZipFile(io.BytesIO(answer.read()))
    names = [os.path.basename(n) for n in archive.namelist()]
    check("the export is one file", "README.md" in names and "representability.json" in names, names)


def hiccups(browser, bench):
    """A document that is refused is asked for again; a task that is cancelled while it waits has an end."""
    go(browser, "compare")
    before = tile(browser, "RMS, this calibration")
    module = "import('/t/%s/app/server.js')" % urllib.parse.parse_qs(urllib.parse.urlparse(bench.url).query)["token"][0]
    browser.evaluate("""(() => { const real = window.fetch; window.refused = 0;
        window.fetch = (path, how) => (String(path).startsWith("/data/compare") && window.refused < 2
            ? (window.refused += 1, Promise.resolve(new Response('{"message": "too many requests"}', { status: 429, headers: { "Content-Type": "application/json" } })))
            : real(path, how)); })()""")
    browser.evaluate("%s.then((m) => m.act('calibrate', { method: 'least_squares' })).then((end) => { window.calibrated = end; }), true" % module)
    ended = browser.wait("window.calibrated && window.refused === 2 && window.calibrated", 120)
    check("calibrated anew", ended["ok"], ended)
    check("a document that was refused is asked for again", tile(browser, "RMS, this calibration") == before, before)
    browser.evaluate("%s.then((m) => { const both = [m.act('diagnose'), m.act('diagnose')]; Promise.all(both).then((ends) => { window.ends = ends; }); }), true" % module)
    browser.wait("document.querySelector('.running') && document.querySelector('.running').innerText.includes('1 waiting')")
    browser.click("Cancel")
    ends = browser.wait("window.ends", 120)
    check("what was cancelled while it waited is said", [e["ok"] for e in ends] == [False, False] and ends[1]["message"] == "cancelled before it began", ends)


def formula(browser):
    go(browser, "diagnose")
    for typed, good in (("k1*x*", False), ("k1*x*y", True)):
        browser.evaluate("""(() => { const f = document.querySelector("#formula"); f.value = %s; f.dispatchEvent(new Event("input", { bubbles: true })); })()"""
                         % json.dumps(typed))
        wanted = "can be added" if good else "formula"
        said = browser.wait("document.querySelector('#formula-said').innerText.includes(%s) && document.querySelector('#formula-said').innerText"
                            % json.dumps(wanted) + (" && !document.querySelector('#formula').hasAttribute('aria-invalid')" if good
                                                    else " && document.querySelector('#formula').hasAttribute('aria-invalid')"))
        check("a formula is checked as it is typed: %s" % typed, said, said)


def plan(browser, bench, folder):
    """A plan is drawn before it runs; meshes of the machine's URDF by their package alone."""
    go(browser, "measure")
    with open("config/demo_plan.yaml") as f:
        text = f.read()
    typing = """(() => { const p = document.querySelector("#plan"); p.value = %s; p.dispatchEvent(new Event("input", { bubbles: true })); })()"""
    browser.evaluate(typing % json.dumps(text.replace("touch:", "touches:")))
    refused = browser.wait("document.querySelector('.warning') && document.querySelector('.warning').innerText")
    check("a plan is judged as it is typed", "touches" in refused, refused)
    browser.evaluate(typing % json.dumps(text))
    check("a plan is drawn with its measurements", tile(browser, "Measurements") == "120", tile(browser, "Measurements"))
    browser.wait("document.querySelector('.plan .canvas') && document.querySelector('.plan .canvas').dataset.frameMs")
    pixels = """(() => { const c = document.querySelector('.plan canvas'), d = document.createElement('canvas'); d.width = c.width; d.height = c.height;
        const p = d.getContext('2d'); p.drawImage(c, 0, 0); let n = 0; const v = p.getImageData(0, 0, d.width, d.height).data;
        for (let i = 0; i < v.length; i += 4) if (v[i + 3] > 0) n += 1; return n; })()"""
    check("and it can be seen", browser.evaluate(pixels) > 5000, browser.evaluate(pixels))
    browser.evaluate("""(() => { const s = document.querySelector("#step"); s.value = 30; s.dispatchEvent(new Event("input", { bubbles: true })); })()""")
    said = browser.wait("document.querySelector('.plan [role=status]').innerText.startsWith('30 of 120') && document.querySelector('.plan [role=status]').innerText")
    check("each measurement can be looked at", re.search(r"30 of 120: b\d at .* mm, line \d+", said), said)


ONE_TRIANGLE = {
    ".stl": "solid one\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0.1 0 0\nvertex 0.1 0.2 0.3\nendloop\nendfacet\nendsolid one\n",
    ".obj": "mtllib none.mtl\nv 0 0 0\nv 0.1 0 0\nv 0.1 0.2 0.3\nf 1 2 3\n",
    # in millimetres, z up, moved by a node, with a picture: as RViz, by its unit, and not turned
    ".dae": """<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset><unit name="millimeter" meter="0.001"/>
        <up_axis>Z_UP</up_axis></asset><library_images><image id="i"><init_from>skin.png</init_from></image></library_images><library_effects><effect id="e">
        <profile_COMMON><newparam sid="u"><surface type="2D"><init_from>i</init_from></surface></newparam><newparam sid="q"><sampler2D><source>u</source>
        </sampler2D></newparam><technique sid="t"><phong><diffuse><texture texture="q" texcoord="c"/></diffuse></phong></technique></profile_COMMON></effect>
        </library_effects><library_materials><material id="m"><instance_effect url="#e"/></material></library_materials><library_geometries><geometry id="g">
        <mesh><source id="s"><float_array id="f" count="9">-5 0 0 95 0 0 95 200 300</float_array><technique_common><accessor source="#f" count="3" stride="3">
        <param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source><vertices id="v">
        <input semantic="POSITION" source="#s"/></vertices><triangles count="1" material="k"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p>
        </triangles></mesh></geometry></library_geometries><library_visual_scenes><visual_scene id="w"><node id="n"><translate>5 0 0</translate>
        <instance_geometry url="#g"><bind_material><technique_common><instance_material symbol="k" target="#m"/></technique_common></bind_material>
        </instance_geometry></node></visual_scene></library_visual_scenes><scene><instance_visual_scene url="#w"/></scene></COLLADA>""",
}


def mesh_files(browser, bench):
    """Each kind of mesh in m and in the axes of its file; what is no mesh is refused in words."""
    module = "import('/t/%s/app/meshes.js')" % urllib.parse.parse_qs(urllib.parse.urlparse(bench.url).query)["token"][0]
    read = module + ".then((m) => { try { return [...m.meshCorners(%s, %s)]; } catch (error) { return error.message; } })"
    typed = "new TextEncoder().encode(%s).buffer"
    wanted = [0, 0, 0, 0.1, 0, 0, 0.1, 0.2, 0.3]
    binary = b" " * 80 + struct.pack("<I12fH", 1, 0, 0, 1, *wanted, 0)
    kinds = [(kind, typed % json.dumps(text)) for kind, text in ONE_TRIANGLE.items()] + [(".stl", "new Uint8Array(%s).buffer" % list(binary))]
    for kind, text in kinds:
        corners = browser.evaluate(read % (json.dumps(kind), text))
        check("a mesh %s is read in m" % kind, len(corners) == 9 and all(isinstance(c, float) or isinstance(c, int) for c in corners)
              and max(abs(c - w) for c, w in zip(corners, wanted)) < 1e-6, corners)
    square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n"
    check("a square is two triangles", len(browser.evaluate(read % ('".obj"', typed % json.dumps(square)))) == 18)
    edges = ONE_TRIANGLE[".obj"] + "l 1 2\np 1\n"
    check("edges beside faces are left out", len(browser.evaluate(read % ('".obj"', typed % json.dumps(edges)))) == 9)
    for kind, text in ((".stl", ""), (".stl", "root:x:0:0:root:/root:/bin/bash\n"), (".stl", "solid x\nfacet normal 0 0\n"), (".obj", "v 1 2\n"), (".dae", "solid"),
                       (".dae", "<robot/>"), (".dae", ""), (".stl", ONE_TRIANGLE[".stl"].replace("0.3", "1e99"))):
        said = browser.evaluate(read % (json.dumps(kind), typed % json.dumps(text)))
        check("no mesh %s: %r" % (kind, text[:20]), isinstance(said, str) and said.startswith(("is not read: ", "has ")), said)


def meshes(browser, folder):
    """A machine whose bed is drawn by files of a package, one that is no mesh, and one that is not there."""
    package = os.path.join(folder, "drawn", "cell")
    os.makedirs(os.path.join(package, "meshes"))
    with open(os.path.join(package, "package.xml"), "w") as f:
        f.write('<package format="2"><name>cell</name><version>1.0.0</version><description>d</description>'
                '<maintainer email="a@b.c">a</maintainer><license>l</license></package>')
    corners = [(0, 0, 0), (0.03, 0, 0), (0.03, 0.04, 0), (0, 0.04, 0), (0.015, 0.02, 0.03)]
    faces = [(0, 2, 1), (0, 3, 2), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)]
    with open(os.path.join(package, "meshes", "bed.stl"), "w") as f:
        f.write("solid bed\n" + "".join("facet normal 0 0 0\nouter loop\n%sendloop\nendfacet\n" % "".join("vertex %g %g %g\n" % corners[i] for i in face)
                                        for face in faces) + "endsolid bed\n")
    for name, text in (("bed.obj", ONE_TRIANGLE[".obj"]), ("bed.dae", ONE_TRIANGLE[".dae"]), ("no.dae", "<robot/>")):
        with open(os.path.join(package, "meshes", name), "w") as f:
            f.write(text)
    with open("urdf/three_axis.urdf") as f:
        urdf = f.read()
    more = "".join("<visual><geometry><mesh filename=\"package://cell/meshes/%s\"/></geometry></visual>" % name for name in ("bed.stl", "bed.obj", "bed.dae", "no.dae", "none.stl"))
    machine = os.path.join(folder, "cell.urdf")
    with open(machine, "w") as f:
        f.write(urdf.replace("<visual>", more + "<visual>", 1))
    bag = os.path.join(folder, "cell.bag")
    mm("simulate", "--machine", machine, "--plan", "config/demo_plan.yaml", "-o", bag)
    before = os.environ.get("ROS_PACKAGE_PATH", "")
    os.environ["ROS_PACKAGE_PATH"] = os.path.join(folder, "drawn") + (":" + before if before else "")
    bench = Workbench(bag, "--store", os.path.join(folder, "store_cell"))
    os.environ["ROS_PACKAGE_PATH"] = before
    try:
        browser.open("about:blank")
        browser.open(bench.url + "#session")
        browser.wait("document.querySelector('.canvas') && document.querySelector('.canvas').dataset.frameMs")
        said = browser.wait("document.querySelector('figcaption .missing') && document.querySelector('figcaption .missing').innerText")
        check("a mesh that is not there is said", "none.stl" in said and "no.dae (is not read" in said and "bed" not in said, said)
        check("meshes of a package are drawn", browser.wait("document.querySelector('.canvas').dataset.meshes === '3'"))
        mesh_files(browser, bench)
        check("they are asked for by no path", not [r for r in browser.requests if "bed." in r or "cell" in r or "skin" in r])
    finally:
        bench.stop()


def every_view(browser, bench):
    pictures = os.environ.get("MM_SCREENSHOTS")
    with open(os.path.join(os.path.dirname(MM), "..", "..", "..", "web", "axe.min.js")) as axe:
        browser.evaluate(axe.read() + "; typeof axe")
    for width, scheme in SCREENS if THOROUGH or pictures else SCREENS[:2]:
        browser.resize(width, 900 if width > 600 else 800)
        browser.colours(scheme)
        for view in VIEWS:
            go(browser, view)
            browser.wait("!document.querySelector('main').innerText.includes('PAGE ERROR') && document.querySelectorAll('main section').length > 0")
            too_wide = browser.evaluate("document.documentElement.scrollWidth - innerWidth")
            check("%s, %d px, %s: fits" % (view, width, scheme), too_wide <= 0, too_wide)
            opened = browser.evaluate("scrollTo(0, 1e6), document.querySelector('.opened').getBoundingClientRect().top >= 0 && document.querySelector('.opened').innerText")
            check("%s, %d px, %s: session and machine are on the screen" % (view, width, scheme), opened == "plate.bag, machine three_axis", opened)
            found = browser.evaluate("""axe.run(document, { iframes: false }).then((r) => r.violations.map((v) =>
                v.id + ": " + v.nodes.slice(0, 3).map((n) => n.html.slice(0, 120) + " " + (n.any[0] ? n.any[0].message : "")).join(" | ")))""")
            check("%s, %d px, %s: axe-core finds nothing" % (view, width, scheme), not found, found)
            if pictures:
                browser.evaluate("new Promise((r) => requestAnimationFrame(() => requestAnimationFrame(r)))")
                browser.screenshot(os.path.join(pictures, "%s-%d-%s.png" % (view, width, scheme)))
    browser.resize(1280, 900)
    browser.colours("light")


def units(browser):
    go(browser, "compare")
    metric = tile(browser, "RMS, this calibration")
    browser.evaluate("""(() => { const s = document.querySelector("#deviation"); s.value = "in"; s.dispatchEvent(new Event("change", { bubbles: true })); })()""")
    browser.wait("[...document.querySelectorAll('.tile .value')].some((x) => x.innerText.includes('mil'))")
    inch = tile(browser, "RMS, this calibration")
    check("units are switched", "µm" in metric and abs(number(inch) * 25.4 / number(metric) - 1) < 0.01, (metric, inch))
    browser.evaluate("""(() => { const s = document.querySelector("#deviation"); s.value = "um"; s.dispatchEvent(new Event("change", { bubbles: true })); })()""")


def keys(browser):
    browser.evaluate("document.body.focus()")
    for key, view in (("4", "Diagnose"), ("9", "History"), ("3", "Compare")):
        browser.command("Input.dispatchKeyEvent", type="keyDown", key=key, text=key)
        browser.command("Input.dispatchKeyEvent", type="keyUp", key=key)
        check("key %s: %s" % (key, view), browser.wait("document.querySelector('main').getAttribute('aria-label') === %s" % json.dumps(view)))


def others(browser, bench):
    """Another page's preview stands in the place of this one's: what was seen stays, what was not is asked for again."""
    module = "import('/t/%s/app/server.js')" % urllib.parse.parse_qs(urllib.parse.urlparse(bench.url).query)["token"][0]
    other = "%s.then((m) => m.act('preview', { file: 1, asked: 1, machine: 'five_axis' }))" % module
    tables = "document.querySelectorAll('main table').length === 2 && !document.querySelector('button.primary').disabled"
    browser.evaluate(other + ".then((end) => { window.looked = end.ok; }), true")
    browser.wait("window.looked")
    browser.evaluate("location.hash = 'history', true")
    browser.wait("!document.getElementById('import-machine')")
    browser.evaluate("location.hash = 'import', true")
    check("who comes back sees his file again", browser.wait(tables))
    browser.evaluate("""(() => { const real = window.fetch; let done = false;
        window.fetch = async (path, how) => { if (String(path).startsWith("/data/preview") && !done) { done = true; await %s; } return real(path, how); }; return true; })()""" % other)
    browser.evaluate("""(() => { const s = document.getElementById("import-compensation"); s.value = "none"; s.dispatchEvent(new Event("change", { bubbles: true })); return true; })()""")
    browser.wait("[...document.querySelectorAll('main .warning')].some((w) => w.innerText.includes('another page looks at this file'))")
    check("what was not seen is not imported", browser.evaluate("document.querySelector('button.primary').disabled"))
    browser.click("Look again")
    check("looked again", browser.wait(tables))


def imported(folder):
    """A file is dropped where no session is open: what was understood is shown, a question is answered, the bag is written and opened."""
    work = os.path.join(folder, "imported")
    os.makedirs(work)
    bench = Workbench("--store", os.path.join(folder, "store_imported"), cwd=work)
    drop = """(() => { const d = new DataTransfer(); d.items.add(new File([%s], %s));
        dispatchEvent(new DragEvent("drop", { dataTransfer: d, bubbles: true, cancelable: true })); return true; })()"""
    change = """(() => { const s = document.getElementById(%s); s.focus(); s.value = %s; s.dispatchEvent(new Event("change", { bubbles: true })); return true; })()"""
    try:
        with Browser() as browser:
            browser.open(bench.url)
            check("without a session a file is asked for", "drop it onto the page" in browser.wait("document.querySelector('main .lead') && document.querySelector('main').innerText"))
            with open("examples/import/iso230_2_x.csv") as f:
                text = f.read()
            browser.evaluate(drop % (json.dumps(text.replace("Deviations in um", "")), json.dumps("x.csv")))
            browser.wait("location.hash === '#import' && document.getElementById('import-machine') && true")
            browser.evaluate(change % ('"import-machine"', '"three_axis"'))
            said = browser.wait("document.querySelector('main .warning') && document.querySelector('main .warning').innerText.includes('unit of the deviations') && document.querySelector('main .warning').innerText")
            check("what the file does not say is asked", "x.csv" in said and browser.evaluate("document.querySelector('button.primary').disabled"), said)
            browser.evaluate(change % ('"ask-unit-"', '"um"'))
            rows = browser.wait("""(() => { const t = [...document.querySelectorAll('main table')]; return t.length === 2 && !document.querySelector('button.primary').disabled &&
                                 t.map((x) => x.innerText); })()""")
            check("each column is shown as it was understood", "run 1, upwards\tµm" in rows[0] and "-18,000" in rows[1], rows)
            check("the one who answered is where he was", browser.evaluate("document.activeElement.id") == "ask-unit-", browser.evaluate("document.activeElement.outerHTML.slice(0, 80)"))
            others(browser, bench)
            check("nothing is written before it is wanted", os.listdir(work) == [], os.listdir(work))
            browser.click("Import", "document.querySelector('#import-output').closest('section')")
            opened = browser.wait("location.hash === '#session' && document.querySelector('.opened').innerText.startsWith('x.bag') && document.querySelector('.opened').innerText")
            check("the bag is written and opened", os.listdir(work) == ["x.bag"] and opened == "x.bag, machine three_axis", (os.listdir(work), opened))
            check("no error on the page while importing", not browser.errors, browser.errors[:3])
    finally:
        bench.stop()


def many_contacts(folder):
    """The 16,310 contacts of the micro machine tool: load, change of a colour and of a filter, memory."""
    bag = os.path.join(folder, "mmt.bag")
    mm("simulate", "--machine", "three_axis", "--plan", "config/plans/micro_machine_tool.yaml", "--hide", "backlash:x=3um", "--seed", "5", "-o", bag)
    bench = Workbench(bag, "--store", os.path.join(folder, "store_mmt"))
    try:
        with Browser() as browser:
            browser.open("about:blank")
            browser.command("Page.navigate", url=bench.url + "#compare")
            loaded = browser.wait("document.querySelector('.chart') && document.querySelector('.chart').dataset.pointsMs && performance.now()")
            change = """new Promise((resolve) => { const e = document.getElementById(%s), began = performance.now(); e.value = %s;
                        e.dispatchEvent(new Event("change", { bubbles: true })); requestAnimationFrame(() => setTimeout(() => resolve(performance.now() - began))); })"""
            times = [browser.evaluate(change % (json.dumps(i), json.dumps(v))) for i, v in
                     (("colour", "z"), ("colour", "time"), ("filter", "x travel direction"), ("word", "1"), ("x", "y"), ("filter", "all"))]
            drawn = browser.evaluate("Number(document.querySelector('.chart').dataset.pointsMs)")
            heap = browser.evaluate("performance.memory.usedJSHeapSize / 1e6")
            go(browser, "session")
            browser.wait("document.querySelector('.canvas') && document.querySelector('.canvas').dataset.frameMs")
            for _ in range(20):
                browser.evaluate("document.querySelector('.canvas').dispatchEvent(new KeyboardEvent('keydown', { key: 'ArrowLeft', bubbles: true }))")
            frame = browser.evaluate("new Promise((r) => requestAnimationFrame(() => requestAnimationFrame(r))).then(() => Number(document.querySelector('.canvas').dataset.frameMs))")
            print("16310 contacts: drawn %.0f ms after the page was asked for; colour, filter, axis: %s ms; points alone %.0f ms; frame of the "
                  "machine %.1f ms; heap of the page %.0f MB; server at most %.0f MB"
                  % (loaded, ", ".join("%.0f" % t for t in times), drawn, frame, heap, bench.peak_megabytes()))
            check("16,310 contacts: no error on the page", not browser.errors, browser.errors)
            # five times what is wanted of a computer that does nothing else, 2 s and 100 ms: these tests share theirs
            check("16,310 contacts: there within 10 s", loaded < 10000, loaded)
            check("16,310 contacts: a change within 500 ms", sorted(times)[len(times) // 2] < 500, times)
            check("16,310 contacts: below 500 MB", bench.peak_megabytes() < 500 and heap < 500, (bench.peak_megabytes(), heap))
    finally:
        bench.stop()


def main():
    with tempfile.TemporaryDirectory() as folder:
        bag = os.path.join(folder, "plate.bag")
        mm("simulate", "--machine", "three_axis", "--plan", "config/plans/nine_ball_plate.yaml", "--hide", "backlash:x=3um", "--seed", "5", "-o", bag)
        refused = subprocess.run([MM, "workbench", os.path.join(folder, "none.bag")], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        check("a bag that is not there is refused in one line", refused.returncode == 2 and refused.stderr.count("\n") == 1 and "none.bag" in refused.stderr,
              refused.stderr)
        bench = Workbench(bag, "--store", os.path.join(folder, "store"))
        try:
            with Browser() as browser:
                loop(browser, bench, folder)
                pictures(browser)
                export(browser)
                hiccups(browser, bench)
                formula(browser)
                units(browser)
                keys(browser)
                plan(browser, bench, folder)
                go(browser, "history")
                browser.click("Make the report")
                check("the report opens on the page", browser.wait("document.querySelector('iframe.report')", 180) is not None)
                every_view(browser, bench)
                host = urllib.parse.urlparse(bench.url).netloc
                foreign = [r for r in browser.requests if not r.startswith(("http://" + host, "ws://" + host, "data:", "blob:", "about:"))]
                check("nothing is asked from another host", not foreign, foreign[:3])
                check("no error on the page", not browser.errors, browser.errors[:3])
                meshes(browser, folder)
        finally:
            status = bench.stop()
        check("Ctrl-C ends it with status 0 or 130", status in (0, 130), status)
        check("it said nothing on standard error", not bench.errors, bench.errors)
        imported(folder)
        if THOROUGH:
            many_contacts(folder)


main()
