// A file of measurements before it is a session: what was understood of it, what it does not say, and the button that imports it.

import { h } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import { act, upload, useDocument } from "./server.js";
import { Action, Choice, Empty, Section, Table } from "./parts.js";

const kFiles = ".bag,.csv,.tsv,.txt,.log,.dat,.asc,.tpt,.cfg";
const kLargestText = 50000; // letters of an artifact or a URDF: the request holds both
const kShipped = ["three_axis", "five_axis"];

const say = (detail) => dispatchEvent(new CustomEvent("mm-said", { detail }));

/** Sends a dropped or chosen file: a bag is opened, anything else looked at first. */
export async function sendFile(file) {
  say({ ok: true, message: file.name + " is being read" });
  const end = await upload(file);
  const look = end.ok && !/\.bag$/i.test(file.name) && location.hash !== "#import";
  if (look) { addEventListener("hashchange", () => say(end), { once: true }); location.hash = "import"; } else say(end);
}

const Picker = ({ label, accept, take }) => h("label", { class: "button" }, label, h("input", { type: "file", accept, class: "hidden", onChange: (e) => { if (e.target.files[0]) take(e.target.files[0]); e.target.value = ""; } }));
export const FilePicker = ({ label }) => h(Picker, { label, accept: kFiles, take: sendFile });

const kNothingSaid = { columns: {}, settings: {}, more: "", output: "", format: "" };
let kept = Object.assign({ number: 0, machine: "", urdf: "", artifact: "", artifactName: "", artifactFrom: "", compensation: "" }, kNothingSaid);
let asked = Math.floor(Math.random() * 1e9); // number of a look, which another page hardly has

const oneLine = (text) => text.replace(/[\r\n]+/g, " ");
/** The answers as the mapping of `mm import`. */
function mappingOf(wish) {
  const columns = Object.entries(wish.columns).filter(([, as]) => as).map(([name, as]) => JSON.stringify(name) + ": " + JSON.stringify(as));
  return Object.entries(wish.settings).filter(([, s]) => s.value.trim()).map(([key, s]) => key + ": " + oneLine(s.value) + "\n").join("")
    + (columns.length ? "columns: {" + columns.join(", ") + "}\n" : "") + wish.more;
}
const bodyOf = (wish) => ({ file: wish.number, machine: wish.machine, urdf: wish.urdf, artifact: wish.artifact, artifact_from: wish.artifactFrom, mapping: mappingOf(wish), format: wish.format, compensation: wish.compensation });

/** Asks for a preview whenever what is wished is another one; for one at a time. @return what was refused, and the number of the look. */
function useLook(wish) {
  const [refused, setRefused] = useState(""), [number, setNumber] = useState(0), wanted = useRef(null), busy = useRef(false);
  const body = JSON.stringify(bodyOf(wish));
  useEffect(() => {
    if (!wish.number) return;
    wanted.current = body;
    (async () => {
      if (busy.current) return;
      busy.current = true;
      while (wanted.current) {
        const now = JSON.parse(wanted.current), look = (asked += 1);
        wanted.current = null;
        const end = await act("preview", Object.assign({ asked: look }, now));
        setRefused(end.ok ? "" : end.message);
        setNumber(look);
      }
      busy.current = false;
    })();
  }, [body]);
  return [refused, number];
}

/** A machine or an artifact as a file of this person: its text is sent. */
async function textOf(file, use) {
  const text = await file.text();
  if (text.length > kLargestText) say({ ok: false, message: file.name + " has more than " + kLargestText + " letters; use mm import" });
  else use(text, file.name);
}

function Settings({ wish, change, file }) {
  const session = useDocument("session"), machine = useDocument("machine");
  const own = session ? session.machine : machine ? machine.name : "";
  const machines = [["", own ? own + " (in hand)" : "choose …"], ...kShipped.map((m) => [m, m])].concat(wish.urdf ? [[wish.machine, wish.machine]] : []);
  const artifacts = [["", "none"]].concat(session ? [["session", "of the open session"]] : []).concat(wish.artifact ? [["file", wish.artifactName]] : []);
  return h("div", { class: "controls" },
    h(Choice, { id: "import-machine", label: "Machine", value: wish.machine, options: machines, onChange: (v) => change({ machine: v, urdf: v === wish.machine ? wish.urdf : "" }) }),
    h(Picker, { label: "A URDF …", accept: ".urdf,.xml", take: (f) => textOf(f, (text, name) => change({ machine: name, urdf: text })) }),
    h(Choice, { id: "import-artifact", label: "Artifact that was touched", value: wish.artifact ? "file" : wish.artifactFrom, options: artifacts, onChange: (v) => change(v === "file" ? {} : { artifactFrom: v, artifact: "", artifactName: "" }) }),
    h(Picker, { label: "An artifact file …", accept: ".yaml,.yml", take: (f) => textOf(f, (text, name) => change({ artifact: text, artifactName: name, artifactFrom: "" })) }),
    h(Choice, { id: "import-format", label: "Format", value: wish.format, options: [["", "as recognised"], ...file.formats.map((f) => [f.name, f.name + ": " + f.what])], onChange: (v) => change({ format: v }) }),
    h(Choice, { id: "import-compensation", label: "The controller compensated", value: wish.compensation, options: [["", "not stated"], ["none", "nothing"]], onChange: (v) => change({ compensation: v }) }));
}

/** What the file does not say, as questions with choices; what was answered stays to be taken back. */
function Questions({ wish, change, preview }) {
  const answer = (q, value) => (q.key === "columns" ? change({ columns: Object.assign({}, wish.columns, { [q.column]: value }) })
    : change({ settings: Object.assign({}, wish.settings, { [q.key]: { value, choices: q.choices, suggested: q.suggested } }) }));
  const answered = Object.entries(wish.settings).filter(([key, s]) => s.value && !preview.asked.some((q) => q.key === key)).map(([key, s]) => Object.assign({ key, column: null }, s));
  const all = [...preview.asked.filter((q) => q.key !== "columns" || q.column), ...answered];
  if (!all.length && !preview.faults.length) return null;
  const wordsOf = (value) => (preview.column_choices.find((c) => c.value === value) || { words: value }).words;
  return h(Section, { title: preview.faults.length ? "What is missing" : "What was answered", lead: preview.faults.length ? "Without an answer to these, or a corrected file, it is not imported." : null },
    preview.faults.map((f) => h("p", { class: "warning", key: f }, f)),
    all.length ? h("div", { class: "controls" }, all.map((q) => {
      const id = "ask-" + q.key + "-" + (q.column || ""), label = q.column ? "Column " + q.column : said(q.key.replace(/_/g, " "));
      const value = q.column ? wish.columns[q.column] || "" : (wish.settings[q.key] || { value: "" }).value;
      const choices = value && !q.choices.includes(value) ? [value, ...q.choices] : q.choices;
      return q.choices.length ? h(Choice, { key: id, id, label, value, options: [["", "choose …"], ...choices.map((c) => [c, q.column ? said(wordsOf(c)) : c])], onChange: (v) => answer(q, v) })
        : h("label", { class: "choice", for: id, key: id }, h("span", null, label), h("input", { id, value, placeholder: "e.g. " + q.suggested, maxlength: 60, onChange: (e) => answer(q, e.target.value) }));
    })) : null);
}

/** Another meaning for a column: everything that one may be. */
function Meaning({ name, column, understood, wish, change, choices }) {
  const groups = [...new Set(choices.map((c) => c.group))], value = wish.columns[column] || "";
  return h("select", { "aria-label": "Meaning of " + name, value, onChange: (e) => change({ columns: Object.assign({}, wish.columns, { [column]: e.target.value }) }) },
    h("option", { value: "", selected: !value }, understood ? "as understood" : "choose …"), value && !choices.some((c) => c.value === value) ? h("option", { value, selected: true }, value) : null,
    groups.map((g) => h("optgroup", { label: g, key: g }, choices.filter((c) => c.group === g).map((c) => h("option", { key: c.value, value: c.value, selected: c.value === value }, said(c.words))))));
}

const figure = (x) => minus(String(Number(x.toPrecision(6))));

function Columns({ preview, wish, change }) {
  const anyKey = preview.keys.some((k) => k), from = (c) => (c.unit_from && c.unit_from !== "header" ? " (" + c.unit_from + ")" : "");
  const rows = preview.columns.map((c, i) => [c.name, c.meaning ? said(c.meaning) : h("span", { class: "missing" }, "not understood"), unitText(c.unit) + from(c), c.range ? figure(c.range[0]) + " … " + figure(c.range[1]) : "–"]
    .concat(anyKey ? [preview.keys[i] ? h(Meaning, { name: c.name, column: preview.keys[i], understood: !!c.meaning, wish, change, choices: preview.column_choices }) : ""] : []));
  return h(Section, { title: "Columns" },
    rows.length ? h(Table, { caption: "What each column was understood as", columns: [["Column"], ["is", "text"], ["unit", "nowrap"], ["range, as written", "nowrap"]].concat(anyKey ? [["or", ""]] : []), rows, most: 30 }) : null,
    preview.rows.length && rows.length ? h(Table, { caption: "First rows as written", columns: preview.columns.map((c) => [c.name, "n"]), rows: preview.rows })
      : h("figure", null, h("pre", { class: "lines", tabindex: 0, "aria-label": "First lines of the file" }, preview.head.join("\n")), h("figcaption", null, "First lines of the file.")));
}

function Done({ preview, wish, change, file }) {
  const output = wish.output || file.output, doubts = preview.questions;
  const run = async () => {
    const end = await act("import", Object.assign(bodyOf(wish), { output }));
    if (!end.ok || location.hash === "#session") return end;
    addEventListener("hashchange", () => say(end), { once: true });
    location.hash = "session";
    return null;
  };
  return h(Section, { title: "Session" },
    doubts.map((d) => h("p", { class: "warning", key: d.question }, "Question: " + said(d.question))),
    preview.summary ? h("pre", { class: "lines", tabindex: 0, "aria-label": "What the session holds" }, preview.summary.trim()) : null,
    preview.remarks.length ? h("ul", { class: "plain note" }, preview.remarks.map((r) => h("li", { key: r }, said(r)))) : null,
    h("p", { class: "controls" },
      h("label", { class: "choice grow", for: "import-output" }, h("span", null, "Bag in " + file.folder), h("input", { id: "import-output", value: output, maxlength: 110, spellcheck: false, onChange: (e) => change({ output: e.target.value }) })),
      h(Action, { label: "Import", kind: "primary", disabled: !!preview.faults.length, title: preview.faults.length ? "it cannot be imported yet" : "writes the bag and opens it", confirm: doubts.length ? "It is as it should be: import" : null, run })));
}

export function ImportView() {
  const file = useDocument("import"), found = useDocument("preview");
  const [wish, set] = useState(kept);
  const change = (more) => { kept = Object.assign({}, kept, more); set(kept); };
  useEffect(() => { if (file && file.number !== kept.number) change(Object.assign({ number: file.number }, kNothingSaid)); }, [file && file.number]);
  const [refused, number] = useLook(wish);
  if (!file) return h("div", null, h(Section, { title: "Import", action: h(FilePicker, { label: "Choose a file …" }), lead: "A table of measurements or an instrument's file becomes a session: ISO 230-2, ball bar, R-test, step gauge, tracker, contacts, pointing of a telescope, bed probing of a printer. Choose one, or drop it onto the page; a bag is opened at once." }),
    h(Empty, null, "No file was chosen yet. What was understood of it is shown here before anything is written."));
  const preview = found && found.asked_by === number ? found : null;
  return h("div", null,
    h(Section, { title: "Import", action: h(FilePicker, { label: "Another file …" }), lead: file.name + ", " + file.lines + " lines" + (preview && preview.format ? ": " + preview.format + (preview.how ? ", " + preview.how : "") : "") + "." },
      h(Settings, { wish, change, file }), refused ? h("p", { class: "warning", role: "alert" }, said(refused)) : null),
    preview ? h("div", null, h(Questions, { wish, change, preview }), h(Columns, { preview, wish, change }),
      h("details", null, h("summary", null, "More lines for the mapping"), h("label", { class: "choice column", for: "import-more" }, h("span", null, "YAML as of --columns: features, fixed, header_line …"), h("textarea", { id: "import-more", rows: 4, maxlength: 8000, spellcheck: false, value: wish.more, onChange: (e) => change({ more: e.target.value }) }))),
      h(Done, { preview, wish, change, file })) : refused ? null : h(Empty, null, "…"));
}
