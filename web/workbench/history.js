// Every calibration that was kept; any two beside each other; ISO pictures in the report.

import { h } from "preact";
import { useMemo, useState } from "preact/hooks";
import { act, documentAddress, downloadAddress, useDocument, useNumber } from "./server.js";
import { Action, Choice, Empty, Section, Table } from "./parts.js";
import { Chart, axis } from "./chart.js";
import { measured, rms, shown, text, unitOf } from "./units.js";

const parameterNames = (c) => new Map(c.effects.flatMap((e) => e.values.map((v) => [said(e.in_words) + ": " + v.name, v])));

/** Two values with their uncertainties: whether they differ by more than these allow. */
function differ(a, b) {
  if (!a || !b || !known(a.std) || !known(b.std)) return "–";
  const times = Math.abs(a.value - b.value) / Math.hypot(a.std, b.std);
  return num(times, 2) + (times > 2 ? " ×, more than chance" : " ×");
}

function Beside({ list }) {
  const good = list.filter((c) => !c.damaged);
  const [first, setFirst] = useState(null), [second, setSecond] = useState(null);
  const a = good.find((c) => c.id === first) || good[Math.max(0, good.length - 2)], b = good.find((c) => c.id === second) || good[good.length - 1];
  if (good.length < 2) return h(Empty, null, "With two calibrations or more, any two stand here beside each other.");
  const options = good.map((c) => [c.id, c.id + (c.active ? " (active)" : "")]), pa = parameterNames(a), pb = parameterNames(b);
  const names = [...new Set([...pa.keys(), ...pb.keys()])];
  const cell = (v) => (v ? (v.held ? text(v.value, v.unit, 5) + " (held)" : measured(v.value, v.std, v.unit)) : "not in the model");
  return h("div", null, h("div", { class: "controls" }, h(Choice, { id: "first", label: "Compare", value: a.id, options, onChange: setFirst }), h(Choice, { id: "second", label: "with", value: b.id, options, onChange: setSecond })),
    h(Table, { caption: "Parameters ± expanded uncertainty (k\u00a0=\u00a02), and their difference in standard uncertainties of it", columns: [["Parameter"], [a.id, "n"], [b.id, "n"], ["difference", "n"]],
      rows: [["held-out RMS", rms(a.held_out_rms_um, a.observations, "um"), rms(b.held_out_rms_um, b.observations, "um"), "–"], ...names.map((n) => [n, cell(pa.get(n)), cell(pb.get(n)), differ(pa.get(n), pb.get(n))])], most: 40 }));
}

function Trend({ list }) {
  const good = list.filter((c) => !c.damaged && known(c.held_out_rms_um)), all = useMemo(() => [...new Set(good.flatMap((c) => [...parameterNames(c).keys()]))], [list]);
  const [what, setWhat] = useState("");
  if (good.length < 2) return null;
  const value = (c) => { if (!what) return { value: c.held_out_rms_um, std: c.held_out_rms_um / Math.sqrt(2 * c.observations), unit: "um" }; const v = parameterNames(c).get(what); return v && !v.held ? v : null; };
  const drawn = good.filter((c) => value(c)), unit = drawn.length ? value(drawn[0]).unit : "um", factor = shown(unit)[0];
  const x = drawn.map((c, i) => i + 1), y = drawn.map((c) => value(c).value * factor), half = drawn.map((c) => 2 * (value(c).std || 0) * Math.abs(factor));
  const bars = (c) => (u) => { u.ctx.save(); u.ctx.strokeStyle = c.accent; u.ctx.lineWidth = 1.5 * devicePixelRatio; x.forEach((v, i) => { const px = u.valToPos(v, "x", true); u.ctx.beginPath(); u.ctx.moveTo(px, u.valToPos(y[i] - half[i], "y", true)); u.ctx.lineTo(px, u.valToPos(y[i] + half[i], "y", true)); u.ctx.stroke(); }); u.ctx.restore(); };
  const low = Math.min(...y.map((v, i) => v - half[i])), high = Math.max(...y.map((v, i) => v + half[i])), room = 0.08 * (high - low) || Math.abs(high) * 0.1 || 1;
  const make = (c) => [{ scales: { x: { time: false, range: [0.5, x.length + 0.5] }, y: { range: [low - room, high + room] } }, axes: [axis(c, "calibration", { splits: () => x, values: () => x.map(String) }), axis(c, (what || "held-out RMS") + ", " + unitOf(unit), { size: 64 })], series: [{}, { stroke: c.accent, width: 1.5, points: { show: true, size: 7, fill: c.accent } }], hooks: { draw: [bars(c)] } }, [x, y], x.map((v, i) => ({ x: v, y: y[i], half: half[i], colour: c.accent }))];
  return h(Section, { title: "Trend" }, h(Choice, { id: "what", label: "Trend of", value: what, options: [["", "held-out RMS"], ...all.map((n) => [n, n])], onChange: setWhat }),
    drawn.length ? h("figure", null, h(Chart, { make, inputs: [list, what, factor], label: "Trend of " + (what || "held-out RMS") + " over " + drawn.length + " calibrations" }), h("figcaption", null, "Oldest first; the bars are the expanded uncertainty, k\u00a0=\u00a02. Different sessions and models are beside each other here.")) : null);
}

export function HistoryView() {
  const history = useDocument("history"), report = useNumber("report");
  if (!history) return h(Empty, null, "No calibration is kept yet.");
  const list = history.calibrations;
  return h("div", null,
    h(Section, { title: "Calibrations", lead: "Kept in " + history.store }, list.length ? h(Table, { caption: list.length + (list.length === 1 ? " calibration" : " calibrations, latest first"), columns: [["Id", "nowrap"], ["state", "nowrap"], ["created (UTC)", "nowrap"], ["effects", "text"], ["held-out RMS (k\u00a0=\u00a02)", "n"], ["action", "n"]],
      rows: [...list].reverse().map((c) => Object.assign([c.id, c.damaged ? "damaged" : c.active ? "active" : c.candidate ? "candidate" : "", clock(c.created || "", ""), c.damaged ? said(c.damaged) : c.effects.map((e) => said(e.in_words)).join("; ") || "none", rms(c.held_out_rms_um, c.observations, "um"),
        c.damaged ? "" : h("span", { class: "pair-of-buttons" }, h(Action, { label: "Use", title: "takes it in hand on this session", run: () => act("use", { id: c.id }) }), c.active ? null : h(Action, { label: "Promote", confirm: "Make it active", run: () => act("promote", { id: c.id }) }))], { chosen: c.active })) }) : h(Empty, null, "None yet: what is added, or calibrated, is kept here.")),
    h(Section, { title: "Two beside each other" }, h(Beside, { list })),
    h(Trend, { list }),
    h(Section, { title: "Report", lead: "The whole page of mm report, with the pictures of ISO 230-2, 230-3 and 230-4 and the form of the balls, where the session has them.", action: h("span", null, h(Action, { label: report ? "Make it again" : "Make the report", run: () => act("report") }), report ? [" ", h("a", { class: "button", href: downloadAddress("report"), download: "report.html" }, "Keep it as a file")] : null) },
      report ? h("iframe", { class: "report", src: documentAddress("report?number=" + report), title: "Report of the session", sandbox: "allow-scripts", key: report }) : null),
    h(Section, { title: "Who did what" }, h(Log)));
}

function Log() {
  const [lines, setLines] = useState(null);
  const ask = async () => { const answer = await fetch(documentAddress("log")); if (answer.ok) setLines((await answer.json()).lines); };
  return h("div", null, h("p", { class: "controls" }, h("button", { onClick: ask }, lines ? "Read again" : "Show the log")), lines ? h(Table, { caption: "Latest first", columns: [["When (UTC)", "nowrap"], ["who", "nowrap"], ["what", "text"]], rows: lines.map((l) => [clock(l.time, ""), l.who, said(l.what)]), most: 30 }) : null);
}
