// Which effect is missing, and what else it may be.

import { h } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import { act, downloadAddress, judge, useDocument, useNumber } from "./server.js";
import { Action, Choice, Empty, Meter, Section, Table } from "./parts.js";
import { Chart, curveWithBand } from "./chart.js";
import { measured, rms, shown, text, unitOf } from "./units.js";

const scalar = (v) => (typeof v === "string" && !/^[A-Za-z_][\w-]*$/.test(v) ? '"' + v.replace(/(["\\])/g, "\\$1") + '"' : String(v));
/** An effect of the server's JSON as the YAML that adds it. */
export const yamlOf = (effect) => "{" + Object.entries(effect).map(([k, v]) => k + ": " + (Array.isArray(v) ? "[" + v.map(scalar).join(", ") + "]" : scalar(v))).join(", ") + "}";

/** Adds an effect, and asks what is missing now; the answer stands where the last one stood. */
async function addAndAsk(effect) {
  const end = await act("add", { effect });
  if (end.ok) act("diagnose").then((next) => { if (!next.ok) dispatchEvent(new CustomEvent("mm-said", { detail: next })); });
  return end;
}

const suffixOf = (d) => (known(d.rms_um) || !known(d.rms_arcsec) ? "_um" : "_arcsec");
const unitOfSuffix = (s) => s.slice(1);

function Figure({ label, make, inputs, caption }) {
  return h("figure", null, h(Chart, { make, inputs, label }), h("figcaption", null, caption));
}

function Rivals({ list, variableNote }) {
  if (!list.length) return h("dd", null, variableNote || "none that explains the data nearly as well");
  return h("dd", null, h("ul", { class: "plain" }, list.map((c) => h("li", { key: yamlOf(c.effect) }, h("b", null, withSymbol(c)),
    rivalText(c),
    c.moves ? h("div", { class: "note" }, "To tell: " + said(c.moves)) : null))));
}

function Card({ found, unit, observations, first }) {
  const key = "held_out_rms_" + unit, yaml = yamlOf(found.effect), pair = found[key];
  return h("article", { class: "card effect", "aria-label": found.in_words },
    h("div", { class: "heading" }, h("h3", null, withSymbol(found)), h(Action, { label: "Add", kind: first ? "primary" : "", title: yaml, run: () => addAndAsk(yaml) })),
    h("p", { class: "size" }, found.parameters.length <= 3 ? found.parameters.map((p) => foundSize(p, measured)).join(", ") + " (k\u00a0=\u00a02)" : "size " + text(found["size_" + unit], unit) + " RMS, " + found.parameters.length + " constants"),
    h("dl", null,
      h("dt", null, "Odds"), h("dd", null, found.odds_in_words + " that it acts, against its rivals and chance"),
      pair ? [h("dt", null, "Held-out RMS"), h("dd", null, rms(pair[0], observations, unit) + " → " + rms(pair[1], observations, unit) + " (k\u00a0=\u00a02)")] : null,
      h("dt", null, "Rivals"), h(Rivals, { list: found.confusable_with }),
      found.looks_the_same ? [h("dt", null, "Looks the same"), h("dd", null, found.looks_the_same)] : null,
      h("dt", null, "Cause"), h("dd", null, said(found.cause)),
      h("dt", null, "Remedy"), h("dd", null, said(found.remedy)),
      h("dt", null, "As YAML"), h("dd", null, h("code", null, yaml))));
}

function Profile({ found, observations, unit }) {
  const yaml = yamlOf(found.effect), pair = found["held_out_rms_" + unit];
  const [factor, name] = [shown(found.unit)[0], unitOf(found.unit)];
  const one = found.variables.length === 1;
  const make = (c) => curveWithBand(c, { x: found.curve.map((p) => p[0]), y: found.curve.map((p) => p[1] * factor), half: found.curve.map((p) => 2 * p[2] * factor),
    xLabel: variableName(found.variables[0], found.units[0]) + ", " + unitText(found.units[0]), yLabel: "error along " + found.direction + ", " + name });
  return h("article", { class: "card effect", "aria-label": found.in_words },
    h("div", { class: "heading" }, h("h3", null, withSymbol(found)), h(Action, { label: "Add", kind: "primary", title: yaml, run: () => addAndAsk(yaml) })),
    one ? h(Figure, { make, inputs: [found, factor], label: "Curve of " + found.in_words + " with its band", caption: "The curve ± 2 standard deviations: what no effect of the catalogue explains." }) :
      h(Table, { caption: "Error along " + found.direction + " ± expanded uncertainty (k\u00a0=\u00a02)", columns: [...found.variables.map((v, i) => [variableName(v, found.units[i]) + ", " + unitText(found.units[i]), "n"]), ["error", "n"]], rows: found.curve.map((p) => [num(p[0], 4), num(p[1], 4), measured(p[2], p[3], found.unit)]) }),
    h("dl", null, h("dt", null, "Odds"), h("dd", null, found.odds_in_words), pair ? [h("dt", null, "Held-out RMS"), h("dd", null, rms(pair[0], observations, unit) + " → " + rms(pair[1], observations, unit) + " (k\u00a0=\u00a02)")] : null));
}

/** One's own physics in one line, checked as it is typed. */
function OwnFormula({ directions }) {
  const [direction, setDirection] = useState(directions[0]), [formula, setFormula] = useState(""), [verdict, setVerdict] = useState(null);
  const turn = useRef(0);
  useEffect(() => {
    const mine = ++turn.current;
    if (!formula.trim()) { setVerdict(null); return undefined; }
    const wait = setTimeout(async () => { const answer = await judge(direction, formula, ""); if (mine === turn.current) setVerdict(answer); }, 150);
    return () => clearTimeout(wait);
  }, [direction, formula]);
  const good = verdict && verdict.ok;
  return h("div", { class: "card" }, h("form", { class: "formula", onSubmit: (e) => e.preventDefault() },
    h(Choice, { id: "direction", label: "Error along", value: direction, options: directions.map((d) => [d, d]), onChange: setDirection }),
    h("label", { class: "choice grow", for: "formula" }, h("span", null, "in µm (a rotary joint: ″) ="), h("input", { id: "formula", value: formula, maxlength: 500, spellcheck: false, autocomplete: "off", placeholder: "k1*x*y + k2*sin(2*pi*x/k3)", "aria-describedby": "formula-said", "aria-invalid": verdict && !good ? "true" : null, onInput: (e) => setFormula(e.target.value) })),
    h(Action, { label: "Add the formula", disabled: !good, run: () => addAndAsk(verdict.effect) })),
  h("p", { id: "formula-said", class: verdict && !good ? "said bad" : "note", role: "status" }, verdict ? said(verdict.message) : "Unknowns k1, k2 … are found. Linear joints in mm, rotary ones in rad, t in s, x_velocity in mm/s, x_travel 1 or −1, temperatures in °C by their names."));
}

function Drift({ d }) {
  if (!d.drift.length) return h("p", null, "No drift beside what the model has.");
  return h("div", null, d.drift.map((one) => h("div", { class: "card", key: one.direction }, h("p", null, h("b", null, said(one.in_words)), ". ", said(one.to_do)),
    one.perhaps.length ? h("ul", { class: "plain" }, one.perhaps.map((p) => h("li", { key: yamlOf(p.effect) }, "Perhaps " + withSymbol(p) + ", odds " + p.odds_in_words + ", " + percent(p.share) + " of it"))) : null)));
}

// What follows a variation, the likelier first.
function followers(v) {
  const causes = (v.or_instead || []).map((a) => ({ effect: a.effect, odds: a.odds, words: h("p", null, "Perhaps ", withSymbol(a), ", odds " + a.odds_in_words) }));
  const formula = v.formula ? [{ effect: v.formula, words: h("p", null, h("code", null, v.formula), " follows it") }] : [];
  return causes.length && causes[0].odds > 0.5 ? causes.concat(formula) : formula.concat(causes);
}

export function DiagnoseView() {
  const d = useDocument("diagnosis"), session = useDocument("session"), moves = useNumber("moves");
  const directions = [...(session ? session.joints.map((j) => j.name) : []), "x", "y", "z", "approach"].filter((v, i, all) => all.indexOf(v) === i);
  const again = h(Action, { label: d ? "Diagnose again" : "Diagnose", kind: d ? "" : "primary", run: () => act("diagnose") });
  if (!d) return h("div", null, h(Empty, null, "Which physical effect does the model miss? The answer takes seconds, for a long session a minute.", h("br"), again), session ? h(Section, { title: "Your own formula" }, h(OwnFormula, { directions })) : null);
  const unit = unitOfSuffix(suffixOf(d)), n = d.observations;
  const [first, ...rest] = said(d.sentence).split(/(?<=\.) (?=[A-Z])/);
  const byOdds = d.candidates.filter((c) => !d.missing.some((m) => yamlOf(m.effect) === yamlOf(c.effect)));
  const named = d.missing.filter((m) => !m.one_of_several), several = d.missing.filter((m) => m.one_of_several);
  const cards = (found) => found.map((m) => h(Card, { key: yamlOf(m.effect), found: m, unit, observations: n, first: m === (named[0] || several[0]) }));
  const key = "held_out_rms_" + unit, varies = d.variations || [], nearly = varies.length && d.verdict === "explained";
  return h("div", null,
    h("div", { class: "verdict " + (nearly ? "scatter" : d.verdict), role: "status" }, h("div", { class: "badge" }, nearly ? "Not the same everywhere" : kVerdicts[d.verdict] || d.verdict), h("p", { class: "sentence" }, first), rest.map((r) => h("p", { key: r }, r)), h("p", { class: "note" }, again)),
    named.length ? h(Section, { title: "Missing", action: h(Action, { label: "Add all until nothing is missing", run: () => act("add_all") }) }, cards(named)) : null,
    several.length ? h(Section, { title: "One of several acts", lead: "These data do not tell which: the most probable first, its rivals with their odds." }, cards(several)) : null,
    d.possible.length ? h(Section, { title: "Not established, and not excluded" }, d.possible.map((p) => h("p", { key: yamlOf(p.effect) }, h("b", null, withSymbol(p)), ", odds " + p.odds_in_words + (p.shown_by ? "; would show it: " + said(p.shown_by) : "")))) : null,
    d.profiles.length || d.formulas.length ? h(Section, { title: "What no effect of the catalogue explains" }, d.profiles.map((p) => h(Profile, { key: yamlOf(p.effect), found: p, observations: n, unit })),
      d.formulas.map((f) => { const yaml = yamlOf(Object.assign({ type: "formula" }, Object.fromEntries(Object.entries(f).filter(([k]) => ["direction", "formula", "start"].includes(k))))); return h("div", { class: "card", key: yaml }, h("div", { class: "heading" }, h("h3", null, "The same as a formula: ", h("code", null, f.formula)), h(Action, { label: "Add", run: () => addAndAsk(yaml) })), f[key] ? h("p", null, "Held-out RMS " + rms(f[key][0], n, unit) + " → " + rms(f[key][1], n, unit) + " (k\u00a0=\u00a02)") : null); })) : null,
    varies.length ? h(Section, { title: "Not the same everywhere", lead: "What is left of effects that are in the model with one size, or one shape." }, varies.map((v) => h("div", { class: "card", key: v.in_words + v.along },
      h("h3", null, withSymbol(v) + (v.along ? " along " + v.along : "")),
      h("p", { class: "size" }, measured(v["rms_" + unit], v["rms_std_" + unit], unit) + " RMS is left of it (k\u00a0=\u00a02)"), followers(v).map((f, i) => h("div", { class: "heading", key: f.effect }, f.words, h(Action, { label: "Add", kind: i === 0 ? "primary" : undefined, title: f.effect, run: () => addAndAsk(f.effect) })))))) : null,
    d.next_measurement.length ? h(Section, { title: "What to measure next", action: h("a", { class: "button", href: downloadAddress("moves"), download: "moves.yaml" }, "Keep the plan") }, h("p", null, d.next_measurement.length + " targets that best separate what these data do not" + (moves ? "; the view Measure runs them." : "."))) : null,
    h(Section, { title: "Your own formula", lead: "A formula is one effect more: added, refitted, and in the ledger like any other." }, h(OwnFormula, { directions })),
    h(Section, { title: "Drift" }, h(Drift, { d })),
    d.missing_inputs.length ? h(Section, { title: "Inputs that were not recorded" }, h(Table, { caption: "What could act unseen without them", columns: [["Input"], ["in its place", "text"], ["cannot be excluded", "text"]], rows: d.missing_inputs.map((i) => [i.input, i.assumed ? "assumed " + i.assumed : "–", i.assumed ? "–" : i.in_words || "–"]) })) : null,
    byOdds.length ? h(Section, { title: "Other causes that were tested", lead: "Odds are conditional on what was found; what only imitates it has none. The held-out error is that of each alone, everything refitted with it." }, h(Table, { caption: d.candidates.length + " causes tested, best first", columns: [["Cause"], ["odds", "nowrap"], ["held-out RMS after (k\u00a0=\u00a02)", "nowrap"], ["add", "n"]],
      rows: byOdds.map((c) => [withSymbol(c), c.odds_in_words, c[key] && known(c[key][1]) && c[key][0] !== c[key][1] ? [h(Meter, { share: 1 - c[key][1] / c[key][0] }), rms(c[key][1], n, unit)] : "–", h(Action, { label: "Add", run: () => addAndAsk(yamlOf(c.effect)) })]), most: 8 })) : null,
    d.cannot_show.length ? h(Section, { title: "What this session cannot exclude" }, h(Table, { caption: "Effects, why they stay hidden, and what would show them", columns: [["Effect", "text"], ["why", "text"], ["what would show it", "text"]], rows: d.cannot_show.map((c) => [withSymbol(c), said(c.why), said(c.moves)]), most: 8 })) : null);
}
