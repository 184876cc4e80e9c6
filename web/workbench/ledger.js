// The model step by step, and the error as it fell.

import { h } from "preact";
import { useState } from "preact/hooks";
import { act, downloadAddress, useDocument } from "./server.js";
import { Action, Empty, Section, Table } from "./parts.js";
import { measured, rms, text } from "./units.js";

/** The steps with their error before and after, as bars that fall. */
function Bars({ steps, noise, unit, count }) {
  const most = Math.max(...steps.map((s) => s.error), noise || 0) || 1;
  return h("div", { class: "bars", role: "img", "aria-label": "Held-out RMS: " + steps.map((s) => s.name + " " + text(s.error, unit)).join(", ") },
    steps.map((s, i) => h("div", { class: "step", key: i },
      h("div", { class: "name" }, s.name), h("div", { class: "track" }, h("i", { class: s.bad ? "bad" : "", style: { width: (100 * s.error) / most + "%" } }), known(noise) ? h("b", { style: { left: (100 * noise) / most + "%" } }) : null), h("div", { class: "figure" }, rms(s.error, count, unit)))),
    known(noise) ? h("p", { class: "note" }, "The line: repeatability " + text(noise, unit) + ", below which no model reaches. ± is the expanded uncertainty, k\u00a0=\u00a02.") : h("p", { class: "note" }, "± is the expanded uncertainty, k\u00a0=\u00a02."));
}

/** "gap: difference between the two directions of travel": each meaning once. */
const meanings = (values) => [...new Map(values.filter((v) => v.meaning).map((v) => [v.meaning, v])).values()].slice(0, 6).map((v) => v.name + ": " + said(v.meaning)).join("; ");

export function LedgerView() {
  const c = useDocument("calibration"), catalogue = useDocument("catalogue");
  const [typed, setTyped] = useState("");
  if (!c) return h(Empty, null, "There is no calibration yet.");
  const unit = c.unit, key = "held_out_rms_" + unit, plainKey = "rms_" + unit;
  const steps = [];
  for (const e of c.ledger) {
    const pair = e[key] || [null, null];
    if (!steps.length && known(pair[0]) && e.action === "calibrate" && c.ledger[0] === e && e.yaml === "" && pair[0] !== pair[1]) steps.push({ name: "nominal machine", error: pair[0] });
    if (known(pair[1])) steps.push({ name: e.action === "calibrate" ? (c.effects.length && c.ledger.length === 1 ? "calibrated" : steps.length ? "calibrated" : "model without effects") : (e.action === "add" ? "+ " : e.action === "remove" ? "− " : e.action + " ") + said(withSymbol(e)), error: pair[1], bad: known(pair[0]) && pair[1] > pair[0] * 1.0001 });
  }
  return h("div", null,
    h(Section, { title: "Error after each step", lead: "Held-out RMS after each step: of blocks of time that the fit did not see.", action: h(Action, { label: "Add all", title: "diagnoses and adds until nothing is missing", run: () => act("add_all") }) },
      steps.length ? h(Bars, { steps, noise: c.repeatability_from === "estimated" ? null : c["repeatability_" + unit], unit, count: c.observations }) : h(Empty, null, "No step has a held-out figure.")),
    h(Section, { title: "Effects of the model", lead: c.id ? "Calibration " + c.id + (c.kept ? "" : ", a file of its own, not in the history") : "Fitted on opening; kept as soon as an effect is added.",
      action: h("a", { class: "button", href: downloadAddress("calibration.yaml"), download: "" }, "Keep the calibration as a file") },
      c.effects.length ? c.effects.map((e) => h("article", { class: "card effect", key: e.yaml, "aria-label": e.in_words }, h("div", { class: "heading" }, h("h3", null, said(withSymbol(e))), h(Action, { label: "Take back", title: "removes it and refits", confirm: "Take it back", run: () => act("remove", { effect: e.yaml }) })),
        h("p", { class: "size" }, e.values.slice(0, 6).map((v) => v.name + " = " + (v.held ? text(v.value, v.unit, 5) + " (held)" : measured(v.value, v.std, v.unit))).join(", ") + (e.values.length > 6 ? " and " + (e.values.length - 6) + " more" : "") + (e.values.some((v) => !v.held) ? " (k\u00a0=\u00a02)" : "")), h("p", { class: "note" }, meanings(e.values)))) : h("p", { class: "empty" }, "None: the machine as its scales read."),
      h("form", { class: "formula card", onSubmit: (e) => e.preventDefault() },
        h("label", { class: "choice grow", for: "own" }, h("span", null, "Add an effect of the catalogue"), h("input", { id: "own", list: "catalogue", value: typed, maxlength: 1000, spellcheck: false, autocomplete: "off", placeholder: "{type: straightness, axis: x, direction: z, degree: 2}", onInput: (e) => setTyped(e.target.value) })),
        h("datalist", { id: "catalogue" }, (catalogue ? catalogue.effects : []).filter((e) => e.example).map((e) => h("option", { key: e.type, value: e.example }, e.shown_by))),
        h(Action, { label: "Add", disabled: !typed.trim(), run: () => act("add", { effect: typed }) }))),
    h(Section, { title: "Every step" }, h(Table, { caption: "What each did to the error (± expanded uncertainty, k\u00a0=\u00a02)", columns: [["Step"], ["RMS", "n"], ["held-out RMS", "n"], ["when (UTC)", "nowrap"], ["taken from", "nowrap"]],
      rows: c.ledger.map((e) => [e.action === "calibrate" ? "calibrate" : e.action + " " + said(withSymbol(e)), ...[plainKey, key].map((k) => (e[k] ? rms(e[k][0], c.observations, unit) + " → " + rms(e[k][1], c.observations, unit) : "–")), clock(e.time, ""), e.calibration || "–"]) })),
    h(Section, { title: "Calibrate anew", lead: "The same effects from the beginning, by a search of the whole range. The steps so far stay in the history." },
      h("p", { class: "controls" }, h(Action, { label: "Least squares", run: () => act("calibrate", { method: "least_squares" }) }), " ", h(Action, { label: "Genetic search, then least squares", run: () => act("calibrate", { method: "staged_mutation" }) }))));
}
