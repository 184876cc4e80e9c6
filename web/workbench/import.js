// A file of measurements before it is a session: what was understood of it, what it does not say, and the button that imports it.

import { h } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import { act, isLatest, upload, useDocument, useNumber } from "./server.js";
import { Action, Choice, Empty, Section, Table } from "./parts.js";

const kFiles = ".bag,.csv,.tsv,.txt,.log,.dat,.asc,.tpt,.cfg";
const kLargestText = 50000; // bytes of an artifact or a URDF: the request holds both
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

const kNothingSaid = { columns: {}, settings: {}, questions: {}, more: "", output: "", format: "" };
let kept = Object.assign({ number: 0, machine: "", urdf: "", artifact: "", artifactName: "", artifactFrom: "", compensation: "" }, kNothingSaid);

const oneLine = (text) => text.replace(/[\r\n]+/g, " ");
/** The answers as the mapping of `mm import`. */
function mappingOf(wish) {
  const columns = Object.entries(wish.columns).filter(([, as]) => as).map(([name, as]) => JSON.stringify(name) + ": " + JSON.stringify(as));
  return Object.entries(wish.settings).filter(([, value]) => value.trim()).map(([key, value]) => key + ": " + oneLine(value) + "\n").join("")
    + (columns.length ? "columns: {" + columns.join(", ") + "}\n" : "") + wish.more;
}
/** What is asked for. @param session number of the one whose machine and artifact may be taken. */
const bodyOf = (wish, session) => ({ file: wish.number, session, machine: wish.machine, urdf: wish.urdf, artifact: wish.artifact, artifact_from: wish.artifactFrom, mapping: mappingOf(wish), format: wish.format, compensation: wish.compensation });

/** A number of a text: pages that wish the same share a preview. */
function numberOf(text) {
  let number = 2166136261; // FNV-1a
  for (let i = 0; i < text.length; i += 1) number = Math.imul(number ^ text.charCodeAt(i), 16777619);
  return (number >>> 0) + 1;
}

/** Asks for a preview whenever what is wished is another one; for one at a time. @return what is wished, its number, how the look at it ended (null: it has not), and to look once more. */
function useLook(wish, session) {
  const [last, setLast] = useState(null), [turn, setTurn] = useState(0), wanted = useRef(null), busy = useRef(false);
  const body = JSON.stringify(bodyOf(wish, session));
  useEffect(() => {
    if (!wish.number) return;
    wanted.current = body;
    (async () => {
      if (busy.current) return;
      busy.current = true;
      while (wanted.current) {
        const now = wanted.current;
        wanted.current = null;
        const end = await act("preview", Object.assign({ asked: numberOf(now) }, JSON.parse(now)));
        setLast({ body: now, ok: end.ok, message: end.message });
      }
      busy.current = false;
    })();
  }, [body, turn]);
  return { body, number: numberOf(body), end: last && last.body === body ? last : null, again: () => { setLast(null); setTurn((n) => n + 1); } };
}

/** A machine or an artifact as a file of this person: its text is sent. */
async function textOf(file, use) {
  const text = await file.text();
  if (file.size > kLargestText) say({ ok: false, message: file.name + " has more than " + kLargestText / 1000 + " KB; use mm import" });
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

const idOf = (q) => "ask-" + q.key + "-" + (q.column || "");
const answerTo = (wish, q) => (q.column ? wish.columns[q.column] : wish.settings[q.key]) || "";

/** What the file does not say, as questions with choices; what was answered stays where it was, to be taken back. */
function Questions({ wish, change, preview }) {
  const open = Object.fromEntries(preview.asked.map((q) => [idOf(q), q]));
  const all = Object.values(Object.assign({}, wish.questions, open)).filter((q) => open[idOf(q)] || answerTo(wish, q));
  const answer = (q, value) => change(Object.assign({ questions: Object.fromEntries(all.map((one) => [idOf(one), one])) },
    q.column ? { columns: Object.assign({}, wish.columns, { [q.column]: value }) } : { settings: Object.assign({}, wish.settings, { [q.key]: value }) }));
  const wordsOf = (value) => (preview.column_choices.find((c) => c.value === value) || { words: value }).words;
  return h(Section, { title: "What is missing", lead: preview.faults.length ? "Without an answer to these, or a corrected file, it is not imported." : null },
    h("div", { "aria-live": "polite" }, preview.faults.length ? preview.faults.map((f) => h("p", { class: "warning", key: f }, f)) : h("p", { class: "note" }, "Nothing.")),
    all.length ? h("div", { class: "controls" }, all.map((q) => {
      const id = idOf(q), label = q.column ? "Column " + q.column : said(q.key.replace(/_/g, " ")), value = answerTo(wish, q);
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

function Done({ preview, looked, wish, change, file }) {
  const output = wish.output || file.output, doubts = preview.questions;
  const run = async () => {
    const end = await act("import", Object.assign(JSON.parse(looked), { output }));
    if (end.ok) change({ output: "" });
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
      h(Action, { key: looked, label: "Import", kind: "primary", disabled: !looked || !!preview.faults.length, title: looked && !preview.faults.length ? "writes the bag and opens it" : "it cannot be imported yet", confirm: doubts.length ? "It is as it should be: import" : null, run })));
}

export function ImportView() {
  const file = useDocument("import"), found = useDocument("preview");
  const [wish, set] = useState(kept);
  const change = (more) => { kept = Object.assign({}, kept, more); set(kept); };
  useEffect(() => { if (file && file.number !== kept.number) change(Object.assign({ number: file.number }, kNothingSaid)); }, [file && file.number]);
  const look = useLook(wish, useNumber("session")), last = useRef(null);
  if (!file) return h("div", null, h(Section, { title: "Import", action: h(FilePicker, { label: "Choose a file …" }), lead: "A table of measurements or an instrument's file becomes a session: ISO 230-2, ball bar, R-test, step gauge, tracker, contacts, pointing of a telescope, bed probing of a printer. Choose one, or drop it onto the page; a bag is opened at once." }),
    h(Empty, null, "No file was chosen yet. What was understood of it is shown here before anything is written."));
  if (found && found.asked_by === look.number) last.current = found;
  const preview = last.current && last.current.number === wish.number ? last.current : null; // the last stays until the next is here
  const own = !!preview && preview.asked_by === look.number, { end } = look, refused = !!end && !end.ok;
  const why = refused ? said(end.message) : end && !own && isLatest("preview") ? "another page looks at this file" : "";
  return h("div", null,
    h(Section, { title: "Import", action: h(FilePicker, { label: "Another file …" }), lead: file.name + ", " + file.lines + " lines" + (preview && preview.format ? ": " + preview.format + (preview.how ? ", " + preview.how : "") : "") + "." },
      h(Settings, { wish, change, file }), why ? h("p", { class: "warning", role: "alert" }, why, " ", h("button", { onClick: look.again }, "Look again")) : null),
    preview ? h("div", { "aria-busy": !own && !why }, h(Questions, { wish, change, preview }), h(Columns, { preview, wish, change }),
      h("details", null, h("summary", null, "More lines for the mapping"), h("label", { class: "choice column", for: "import-more" }, h("span", null, "YAML as of --columns: features, fixed, header_line …"), h("textarea", { id: "import-more", rows: 4, maxlength: 8000, spellcheck: false, value: wish.more, onChange: (e) => change({ more: e.target.value }) }))),
      h(Done, { preview, looked: own && end && end.ok ? look.body : "", wish, change, file })) : why ? null : h(Empty, null, "…"));
}
