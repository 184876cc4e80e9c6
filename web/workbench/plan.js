// A plan drawn on the machine before it runs: the balls, where each approach begins and ends, in which order, and the way between.

import { h } from "preact";
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { act, useDocument } from "./server.js";
import { Tile, Tiles } from "./parts.js";
import { Space, rgb } from "./machine.js";
import { unitOf, value } from "./units.js";

const kPause = 500; // ms after the last letter
const kFirst = "#2166ac", kLast = "#e08214";
const first = rgb(kFirst), last = rgb(kLast);
const between = (share) => first.map((v, k) => v + share * (last[k] - v));

/** Asks the server for the picture of a plan when nobody has typed for a moment. The server draws one plan, whichever page asked last: what is
 * drawn for another page takes nothing away from this one. @return picture, null: none yet; why there is none, null: there is, or will be. */
function useLook(text, plan) {
  const own = useRef(null), [refused, setRefused] = useState(null);
  if (!plan || plan.text === text) own.current = plan; // none any more: it was of another machine
  const shown = own.current && own.current.text === text ? own.current : null;
  const why = refused && refused.text === text ? refused.message : null;
  useEffect(() => {
    if (refused && !why) setRefused(null); // it was said of another text
    if (!text.trim() || shown || why) return undefined;
    let here = true;
    const timer = setTimeout(() => act("look", { plan: text }).then((end) => { if (here) setRefused(end.ok ? null : { text, message: end.message }); }), kPause);
    return () => { here = false; clearTimeout(timer); };
  }, [text, !shown, plan]); // until this page has had its own picture once
  return { shown, why };
}

function drawingOf(plan) {
  const count = plan.feature.length, points = { at: [], colours: [] }, lines = { at: [], colours: [] }, way = rgb("#8a8f96");
  for (let i = 3; i + 2 < plan.way_mm.length; i += 3) {
    lines.at.push(...plan.way_mm.slice(i - 3, i + 3));
    lines.colours.push(...way, ...way);
  }
  for (let n = 0; n < count; ++n) {
    const colour = between(count > 1 ? n / (count - 1) : 0), from = plan.from_mm.slice(3 * n, 3 * n + 3), to = plan.to_mm.slice(3 * n, 3 * n + 3);
    points.at.push(...from);
    points.colours.push(...colour);
    lines.at.push(...from, ...to);
    lines.colours.push(...colour, ...colour);
  }
  const balls = plan.features.filter((f) => f.ball && f.centre_mm.every(known)).map((f) => Object.assign({ label: f.name }, f));
  return { points, lines, balls };
}

/** One measurement in words. */
function sentence(plan, n) {
  const at = plan.to_mm.slice(3 * n, 3 * n + 3).map((v) => num(value(v, "mm"), 4)).join(", ");
  const what = plan.feature[n] >= 0 ? plan.features[plan.feature[n]].name + " at " : "at ";
  return n + 1 + " of " + plan.measurements + ": " + what + at + " " + unitOf("mm") + ", line " + plan.line[n] + " of the plan";
}

/** @param live state of the machine, null where none is. */
export function PlanPicture({ text, live }) {
  const plan = useDocument("plan"), machine = useDocument("machine"), { shown, why } = useLook(text, plan);
  const [step, setStep] = useState(0);
  useEffect(() => setStep(0), [shown && shown.text]);
  const drawing = useMemo(() => (shown ? drawingOf(shown) : null), [shown]);
  const joints = machine ? machine.joints : [], many = joints.length;
  const readings = useMemo(() => (shown && step > 0 ? shown.readings.slice((step - 1) * many, step * many) : live ? live.readings : null), [shown, step, many, live && JSON.stringify(live.readings)]);
  const mark = useMemo(() => (shown && step > 0 ? { at: shown.to_mm.slice(3 * step - 3, 3 * step), radius_mm: 1 } : null), [shown, step]);
  if (why) return h("p", { class: "warning", role: "status" }, said(why));
  if (!text.trim()) return h("p", { class: "empty" }, "A plan is drawn here before it runs.");
  if (!shown || !machine) return h("p", { class: "empty", role: "status" }, "The plan is being drawn …");
  const count = shown.feature.length;
  return h("div", { class: "plan" },
    h(Tiles, null,
      h(Tile, { label: "Measurements", value: String(shown.measurements), note: shown.moves + " moves" }),
      h(Tile, { label: "Takes at least", value: duration(shown.time_s), note: "at the speeds of the plan, without acceleration" }),
      h(Tile, { label: "Touches", value: shown.features.length + (shown.features.length === 1 ? " feature" : " features"), note: shown.features.slice(0, 9).map((f) => f.name).join(", ") + (shown.features.length > 9 ? " …" : "") })),
    shown.left_off ? h("p", { class: "note" }, "The first " + count + " measurements are drawn; " + shown.left_off + " follow.") : null,
    h("p", { class: "legend" }, h("span", null, "first"), h("i", { class: "ramp", style: { background: "linear-gradient(to right, " + kFirst + ", " + kLast + ")" } }), h("span", null, "last"), h("span", null, "point: where an approach begins; line from it: the approach to the surface; grey: the way between")),
    h(Space, { urdf: machine.urdf, joints, readings, points: drawing.points, lines: drawing.lines, balls: drawing.balls, mark, label: "The plan on the machine: " + shown.measurements + " measurements", note: step ? "The machine as it stands at this measurement." : live ? "The machine as it stands now." : "" }),
    count ? h("label", { class: "choice grow", for: "step" }, h("span", null, "Look through it"), h("input", { id: "step", type: "range", min: 0, max: count, value: step, onInput: (e) => setStep(Number(e.target.value)) }), h("span", { role: "status" }, step ? sentence(shown, step - 1) : "before the first")) : null);
}
