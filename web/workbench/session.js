// What was measured, where, and what it can show.

import { h } from "preact";
import { useMemo } from "preact/hooks";
import { act, state, useDocument } from "./server.js";
import { Action, Empty, Section, Table, Tile, Tiles } from "./parts.js";
import { FilePicker, ImportView } from "./import.js";
import { Space, diverging } from "./machine.js";
import { rangeOf } from "./scatter.js";
import { text, unitOf, value } from "./units.js";

/** The touched places with their residuals as three draws them. */
export function residualPoints(points, which) {
  const values = which === "before" && points.before ? points.before : points.columns[0].values;
  const [low, high] = rangeOf(values), limit = Math.max(Math.abs(low), Math.abs(high)) || 1;
  const at = [], colours = [];
  for (let r = 0; r < points.rows; ++r) {
    if (!known(values[r]) || !known(points.x_mm[r])) continue;
    at.push(points.x_mm[r], points.y_mm[r], points.z_mm[r]);
    diverging(values[r], limit, colours);
  }
  return { at, colours, limit };
}

const range = (j) => { const unit = "lower_deg" in j ? "deg" : "mm"; return num(value(j["lower_" + unit], unit), 4) + " … " + num(value(j["upper_" + unit], unit), 4) + " " + unitOf(unit); };

export function SessionView() {
  const session = useDocument("session"), points = useDocument("points");
  const live = state.live && state.live.machine;
  const arriving = useDocument("contacts");
  const drawn = useMemo(() => (points ? residualPoints(points) : null), [points]);
  const newer = live && arriving && (!session || live.observations !== session.observations);
  const coming = useMemo(() => (arriving ? { at: arriving.at_mm.flat(), colours: arriving.at_mm.flatMap(() => [0.9, 0.62, 0]) } : null), [arriving]);
  const readings = useMemo(() => (live ? live.readings : null), [live && JSON.stringify(live.readings)]);
  if (!session && newer) return h("div", null, h(Tiles, null, h(Tile, { label: "On the machine", value: String(live.observations), note: live.measuring || "not measuring" })),
    h(Section, { title: "Contacts as they come", action: h(Action, { label: "Take the live session", kind: "primary", run: () => act("take_live") }) }, h(Space, { points: coming, label: live.observations + " contacts of the live session", note: "Nominal tips of the contacts so far." })));
  if (!session) return live ? h(Empty, null, ["Nothing is measured yet. ", h(Action, { label: "Take what the machine has measured", run: () => act("take_live") })]) : h(ImportView);
  const p = session.point_set;
  const notes = [session.loss, session.assumed, ...(p.doubts || [])].filter(Boolean);
  const questions = (p.questions || []).map((q) => q.question || q);
  return h("div", null,
    h(Tiles, null,
      h(Tile, { label: "Observations", value: String(p.observations ?? session.observations), note: p.contacts + " contacts, " + p.references + " references" }),
      h(Tile, { label: "Duration", value: duration(p.duration_s) }),
      h(Tile, { label: "Noise of one measurement, " + ({ declared: "declared", assumed: "assumed" }[p.noise_from] || p.noise_from), value: text(p.noise_um, "um") }),
      live ? h(Tile, { label: "On the machine", value: String(live.observations), note: live.measuring || "not measuring" }) : null),
    questions.map((q) => h("p", { class: "warning", key: q }, "Question: " + said(q))),
    notes.map((n) => h("p", { class: "warning", key: n }, said(n))),
    newer ? h(Section, { title: "Contacts as they come", lead: "The machine has measured more than is shown below." }, h(Space, { urdf: session.urdf, joints: session.joints, readings, points: coming, label: live.observations + " contacts of the live session", note: "Nominal tips of the contacts so far." })) : null,
    h(Section, { title: "Where it was touched", action: h("span", null, live ? h(Action, { label: "Take the live session", run: () => act("take_live") }) : null, " ", h(FilePicker, { label: "Open another session …" })) },
      drawn ? h(Space, { urdf: session.urdf, joints: session.joints, readings, points: drawn, balls: points.balls, label: "Machine with " + points.rows + " residuals where they were measured",
        note: "Each point is one measurement; " + (points.columns.some((c) => c.name === "approach x") ? "orange where the machine found the surface too far out, blue too far in" : "orange where the residual (measured \u2212 model) is positive, blue where it is negative") + ", full colour at ± " + text(drawn.limit, points.unit, 2) + "." }) : h(Empty, null, "…")),
    h(Section, { title: "What this session cannot show", lead: p.cannot_show && p.cannot_show.length ? "This session cannot exclude these effects." : "This session would have shown every effect of the catalogue that this machine can have." },
      p.cannot_show && p.cannot_show.length ? h(Table, { caption: "Effects that stay hidden", columns: [["Effect", "text"], ["why", "text"], ["what would show it", "text"]], rows: p.cannot_show.map((c) => [c.in_words || effectName(c.effect), said(c.why), said(c.moves)]) }) : null),
    h(Section, { title: "Coverage" },
      h(Table, { caption: "Joints", columns: [["Joint"], ["range", "nowrap"], ["travel + / − / unknown", "n"], ["correlation with time", "n"]], rows: p.joints.map((j) => [j.name, range(j), j.travel.up + " / " + j.travel.down + " / " + j.travel.unknown, fixed(j.correlation_with_time)]) }),
      p.features.length ? h(Table, { caption: "Balls and points", columns: [["Name"], ["contacts", "n"], ["cone of approach, ± °", "n"], ["uncertainty of the centre alone (k\u00a0=\u00a02)", "n"]], rows: p.features.map((f) => [f.name, String(f.contacts), num(f.cone_half_angle_deg), f.kind !== "ball" ? "–" : known(f.centre_std_per_noise) ? "± " + text(2 * f.centre_std_per_noise * p.noise_um, "um", 2) : "not determined"]) }) : null,
      p.logged.length ? h(Table, { caption: "Logged beside the contacts", columns: [["Quantity"], ["range", "nowrap"], ["missing", "n"]], rows: p.logged.map((i) => [i.name, num(i.lower, 4) + " … " + num(i.upper, 4) + " " + unitText(i.unit), String(i.missing)]) }) : null,
      session.set_aside.length ? h(Table, { caption: "Set aside", columns: [["What and why", "text"]], rows: session.set_aside.map((s) => [said(s)]) }) : null));
}

/** "backlash, axis x" */
export const effectName = (effect) => effect.type.replace(/_/g, " ") + Object.entries(effect).filter(([k]) => k !== "type").map(([k, v]) => ", " + k + " " + v).join("");
