"""Tries the documents: run by documents_test.sh; prints `ok …` and `not ok …` lines."""
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile

from told import THOROUGH, say

ROOT = os.path.abspath(os.path.join(os.path.dirname(__file__), "..", ".."))
MM = os.environ["MM"]


def text_of(name):
    with open(os.path.join(ROOT, name), encoding="utf-8") as file:
        return file.read()


def run(line, folder):
    """A line of a document; `mm` is the program under test."""
    environment = dict(os.environ, HOME=folder)
    environment["PATH"] = os.path.dirname(os.path.abspath(MM)) + ":" + environment["PATH"]
    return subprocess.run(["bash", "-c", line], cwd=folder, env=environment, capture_output=True, text=True, timeout=300)


def typed_lines(text):
    """Lines of indented or fenced blocks that begin with mm or printf, continued ones joined; without a placeholder."""
    fenced, lines = False, []
    for line in text.replace("\\\n", " ").split("\n"):
        if line.lstrip().startswith("```"):
            fenced = not fenced
        elif (fenced or line.startswith("    ")) and re.match(r"\s*(mm|printf) ", line) and "…" not in line:
            lines.append(line.strip())
    return lines


def examples(text, folder):
    """The examples of a page, beside those of examples/formats."""
    shutil.copytree(os.path.join(ROOT, "examples", "formats"), folder, dirs_exist_ok=True)
    for name, body in re.findall(r"```\w+ file=(\S+)\n(.*?)```", text, re.S):
        with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
            file.write(body)
    if not THOROUGH:  # every day batch_test.sh diagnoses in a batch
        manifest, steps = os.path.join(folder, "manifest.yaml"), "steps: [check, calibrate, diagnose]"
        with open(manifest, encoding="utf-8") as file:
            whole = file.read()
        say(steps in whole, "docs/formats.md: the manifest has its steps")
        with open(manifest, "w", encoding="utf-8") as file:
            file.write(whole.replace(steps, "steps: [check, calibrate]"))


def try_typed(document, folder, typed_elsewhere=()):
    """Types the lines of a page, each once, without those that are typed in the same folder elsewhere; what they print."""
    printed = []
    for line in dict.fromkeys(typed_lines(text_of(document))):
        if line in typed_elsewhere:
            continue
        done = run(line, folder)
        say(done.returncode == 0, f"{document}: {line[:70]}", done.stderr.strip()[-300:])
        printed += (done.stdout + done.stderr).split("\n")
    return printed


def try_quoted(document, printed):
    """Every line of a text block is one that the page's commands printed; … stands for anything."""
    blocks = re.findall(r"^```text\n(.*?)^```", text_of(document), re.M | re.S)
    quoted = [line for line in "".join(blocks).split("\n") if line.strip()]
    wrong = []
    for line in quoted:
        form = re.compile(r" ?.*?".join(re.escape(part.strip()) for part in " ".join(line.split()).split("…")))
        if not any(form.fullmatch(" ".join(said.split())) for said in printed):
            wrong.append(line.strip())
    say(bool(quoted) and not wrong, f"{document}: what it quotes is printed", "; ".join(wrong))


def try_pages(documents, work):
    """Pages whose lines are typed in a folder of their own, two below the package's."""
    for document in documents:
        folder = os.path.join(work, "build", os.path.basename(document)[:-len(".md")])
        os.makedirs(folder)
        try_quoted(document, try_typed(document, folder))


def ranges(text):
    """(section, key, a value outside) of every range in the tables."""
    section, found = "", []
    for line in text.split("\n"):
        title = re.match(r"## (.*)|\*\*(\w+)\*\*", line)
        if title:
            section = title.group(1) or title.group(2)
        cells = [cell.strip() for cell in line.split("|")[1:-1]]
        if len(cells) != 4:
            continue
        keys = [key.split(": ")[-1] for key in re.findall(r"`([^`<]+)`", cells[0])]
        for bound in cells[2].split(", "):
            numbers = re.fullmatch(r"(-?[\d.e]+) to (-?[\d.e]+)", bound)
            outside = None
            if numbers:
                outside = 2.0 * float(numbers.group(2)) + 1.0
            elif re.fullmatch(r"(\d+) or more", bound):
                outside = int(bound.split()[0]) - 1
            elif bound == "above 0":
                outside = 0
            if outside is not None:
                each = keys if len(cells[2].split(", ")) == 1 else [keys[cells[2].split(", ").index(bound)]]
                found += [(section, key, outside) for key in each]
    return found


def try_ranges(text, folder):
    kinds = {
        "Artifact": ("artifact.yaml", "mm import contacts.csv --artifact {} --machine three_axis -o x.bag"),
        "Model": ("model.yaml", "mm check readings.bag --model {}"),
        "postures": ("laser_plan.yaml", "mm simulate --machine five_axis --plan {} -o x.bag"),
        "": ("plan.yaml", "mm simulate --machine three_axis --plan {} -o x.bag"),
    }
    tried = 0
    for section, key, value in ranges(text):
        name, command = kinds.get(section, kinds[""])
        with open(os.path.join(folder, name), encoding="utf-8") as file:
            whole = file.read()
        # the part of the file that the section is about
        first = {"Simulated instrument": "instrument"}.get(section, section)
        part = re.search(r"^" + first + r":.*?(?=^\w|\Z)", whole, re.M | re.S) or re.search(r".*?(?=^touch:|\Z)", whole, re.M | re.S)
        places = list(re.finditer(r"\b" + key + r": (\[[^\]]*\]|[^,}\s]+)", whole[:part.end()]))
        places = [place for place in places if place.start() >= part.start()]
        if not places:
            say(False, f"docs/formats.md: {key} of {section} is in an example")
        for place in places:
            with open(os.path.join(folder, "changed.yaml"), "w", encoding="utf-8") as file:
                file.write(whole[:place.start(1)] + repr(value) + whole[place.end(1):])
            done = run(command.format("changed.yaml"), folder)
            tried += 1
            if done.returncode != 2 or key not in done.stderr:
                say(False, f"docs/formats.md: {key} = {value} of {section} is refused", done.stderr.strip()[-200:])
    say(tried > 60, f"docs/formats.md: {tried} values outside their ranges were tried")


def try_links():
    documents = ["README.md", "CONTRIBUTING.md", "CHANGELOG.md", "src/README.md", "src/effects/README.md"]
    for folder in ("docs/", "docs/tutorials/"):
        documents += [folder + name for name in sorted(os.listdir(os.path.join(ROOT, folder))) if name.endswith(".md")]
    for document in documents:
        text = text_of(document)
        wrong = []
        for target in re.findall(r"\]\(([^)\s]+)\)", text):
            if re.match(r"https?:", target):
                continue
            path, _, anchor = target.partition("#")
            file = os.path.normpath(os.path.join(os.path.dirname(document), path)) if path else document
            if not os.path.exists(os.path.join(ROOT, file)):
                wrong.append(target)
            elif anchor and file.endswith(".md"):
                titles = re.findall(r"^#+ (.*)$", text_of(file), re.M)
                names = [re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles]
                if anchor not in names:
                    wrong.append(target)
        say(not wrong, f"{document}: its links lead somewhere", ", ".join(wrong))


def try_messages():
    """Messages that troubleshooting explains are printed by the program: their fixed parts stand in its sources."""
    program = ""
    for folder, _, names in os.walk(os.path.join(ROOT, "src")):
        for name in names:
            if name.endswith((".cpp", ".h")):
                program += text_of(os.path.join(folder, name))
    program = re.sub(r'"\s*\n\s*"', "", program)
    wrong = []
    for line in text_of("docs/troubleshooting.md").split("\n"):
        cells = line.split("|")
        if len(cells) != 4 or "mm: " in cells[1]:
            continue
        for message in re.findall(r"`([^`]+)`", cells[1]):
            for part in re.split(r"<[^>]*>|…|'|, and | and |: |; ", message):
                if len(part.strip()) > 7 and part.strip() not in program:
                    wrong.append(part.strip())
    say(not wrong, "docs/troubleshooting.md: its messages are those of the program", "; ".join(wrong))


def try_settings():
    """What documents say can be typed to mm exists: its commands and their options."""
    helps = {}

    def help_of(command):
        if command not in helps:
            helps[command] = subprocess.run([MM, *command.split(), "--help"], capture_output=True, text=True).stdout
        return helps[command]

    wrong = []
    for document in ["README.md", "CONTRIBUTING.md", "docs/commands.md", "docs/monday.md", "docs/find_a_missing_effect.md", "docs/troubleshooting.md", "docs/services.md", "docs/formats.md"]:
        for typed in re.findall(r"`(mm \w[^`]*)`", text_of(document)):
            words = shlex.split(typed.replace("…", "").replace("'", ""))
            if words[1:2] and words[1].startswith("<"):
                continue
            command = words[1]
            if words[2:] and "SUBCOMMAND" in help_of(command):
                command += " " + words[2]
            for word in words[1:]:
                option = re.match(r"\[?(--[a-z-]+)", word)
                if option and option.group(1) not in help_of(command) + " --version":
                    wrong.append(f"{document}: {typed}")
            if "Usage: mm " + command not in help_of(command):
                wrong.append(f"{document}: {typed}")
    say(not wrong, "options that the documents name exist", "; ".join(wrong))


def try_topics():
    """Every topic that a node publishes stands in docs/services.md."""
    page, published = text_of("docs/services.md"), set()
    for name in os.listdir(os.path.join(ROOT, "src", "nodes")):
        if name.endswith(".cpp"):
            published |= set(re.findall(r'advertise<[\w:]+>\(\s*"([^"]+)"', text_of(os.path.join("src/nodes", name))))
    wrong = [topic for topic in sorted(published) if not re.search("/" + re.escape(topic.strip("/")) + "[`/]", page)]
    say(len(published) > 15 and not wrong, "docs/services.md: every topic of the nodes", ", ".join(wrong))


def main():
    work = tempfile.mkdtemp()
    try:
        formats = text_of("docs/formats.md")
        folder = os.path.join(work, "formats")
        os.mkdir(folder)
        examples(formats, folder)
        try_typed("docs/formats.md", folder)
        try_ranges(formats, folder)

        folder = os.path.join(work, "build", "try")
        os.makedirs(folder)
        for name in ("config", "examples"):
            os.symlink(os.path.join(ROOT, name), os.path.join(work, name))
        # the picture types these itself, for their figures
        try_typed("README.md", folder, [f"mm diagnose plate.bag --calibration plate{n}.yaml" for n in (1, 2)])
        done = run(f"{ROOT}/scripts/loop_picture . --check", folder)
        say(done.returncode == 0, "docs/loop.svg: its figures are those of the lines of README.md", done.stderr.strip()[-300:])
        try_typed("docs/find_a_missing_effect.md", folder, typed_lines(text_of("README.md")))
        folder = os.path.join(work, "build", "standard")
        os.makedirs(folder)
        try_typed("docs/standard_tests.md", folder)
        tutorials = sorted(os.listdir(os.path.join(ROOT, "docs", "tutorials")))
        try_pages(["docs/monday.md"] + ["docs/tutorials/" + name for name in tutorials], work)
        try_links()
        try_messages()
        try_settings()
        try_topics()
    finally:
        shutil.rmtree(work)


if __name__ == "__main__":
    sys.exit(main())
