// What the machine is corrected by: the active calibration and the one in hand.

import { h } from "preact";
import { useMemo, useState } from "preact/hooks";
import { act, downloadAddress, state, useDocument, useNumber } from "./server.js";
import { Action, Choice, Empty, Section, Table, Tile, Tiles, colours, useTheme } from "./parts.js";
import { Space, rgb } from "./machine.js";
import { measured, text, unitOf, value } from "./units.js";

const kCandidate = "#e69f00";

function exaggerate(fields) {
  const most = Math.max(0, ...fields.flatMap((f) => f.move_um.map((m) => Math.hypot(...m)))) / 1000;
  return most > 0 ? Math.max(1, roundDown((0.15 * longestSide(fields.flatMap((f) => f.at_mm))) / most)) : 1;
}

const rmsOf = (list) => (list.length ? Math.sqrt(list.reduce((s, v) => s + v * v, 0) / list.length) : null);

function FieldFigures({ name, field }) {
  if (!field) return h(Tile, { label: name, value: "none" });
  const sizes = field.at_mm.length ? field.move_um.map((m) => Math.hypot(...m)) : [], sigma = field.at_mm.length ? rmsOf(field.std_um) : null;
  return h(Tile, { label: name + (field.id ? ", " + field.id : ""), value: sizes.length ? measured(rmsOf(sizes), sigma, "um") : "–", note: sizes.length ? "RMS of the correction over the volume (k\u00a0=\u00a02), largest " + text(Math.max(...sizes), "um") : said(field.reason || "") });
}

/** The tables for a controller, to be kept as a file. */
function Export() {
  const catalogue = useDocument("catalogue"), exported = useNumber("export"), [chosen, choose] = useState("");
  const controllers = catalogue ? catalogue.controllers : [];
  if (!controllers.length) return null;
  const controller = chosen || controllers[0].name;
  return h(Section, { title: "Export", lead: "The calibration in hand as the tables of a controller, with what to install where and what of it the controller carries (mm export)." },
    h("p", { class: "controls" }, h(Choice, { id: "controller", label: "Controller", value: controller, options: controllers.map((t) => [t.name, t.title]), onChange: choose }),
      h(Action, { label: "Export", run: () => act("export", { controller }) }), exported ? h("a", { class: "button", href: downloadAddress("export"), download: "" }, "Keep the export") : null));
}

export function CorrectView() {
  const field = useDocument("correct"), session = useDocument("session"), c = useDocument("calibration"), verified = useDocument("verify");
  const live = state.live && state.live.machine;
  const theme = useTheme(), same = !!(field && field.active && c && c.id === field.active.id);
  const fields = field ? [field.active, field.candidate].filter((f) => f && f.at_mm.length) : [];
  const drawn = useMemo(() => {
    const lines = { at: [], colours: [] }, points = { at: [], colours: [] };
    if (!field) return { lines, points, times: 1 };
    const times = exaggerate(fields);
    for (const [f, colour] of [[field.active, rgb(colours().blue)], [same ? null : field.candidate, rgb(kCandidate)]]) {
      if (!f) continue;
      f.at_mm.forEach((p, i) => {
        lines.at.push(...p, ...p.map((x, k) => x + (f.move_um[i][k] / 1000) * times));
        lines.colours.push(...colour, ...colour);
        points.at.push(...p);
        points.colours.push(0.5, 0.5, 0.5);
      });
    }
    return { lines, points, times };
  }, [field, theme, same]);
  if (!field || !c) return h(Empty, null, "There is no calibration yet.");
  return h("div", null,
    h(Tiles, null, h(FieldFigures, { name: "Active", field: field.active }), h(FieldFigures, { name: "In hand", field: field.candidate }),
      live ? h(Tile, { label: "Corrected tip", value: live.corrected_mm ? live.corrected_mm.map((x) => num(value(x, "mm"), 5)).join(", ") + " " + unitOf("mm") : "–", note: live.corrected_mm ? "± " + text(2 * live.std_um, "um", 2) + " (k\u00a0=\u00a02)" : said(live.status) }) : null),
    h("p", { class: "controls" },
      h(Action, { label: "Promote", kind: "primary", disabled: !c.kept || same, title: c.kept ? "makes the calibration in hand the active one" : "only what was added here, or stands in the history, can be promoted", confirm: "Make " + c.id + " active", run: () => act("promote", { id: c.id }) }),
      h(Action, { label: "Roll back", confirm: "Make active what was before", disabled: !field.active, run: () => act("rollback") }),
      h(Action, { label: "Verify on this session", disabled: !field.active, title: "holds the active calibration against the session that is open: fresh points, measured after it", run: () => act("verify") })),
    verified ? h("div", { class: "card", role: "status" }, h("h3", null, { helped: "It helped", no_change: "No change", worse: "It is worse", mixed: "Mixed" }[verified.verdict] || verified.verdict), h("p", null, said(verified.in_words))) : null,
    !c.kept ? h("p", { class: "note" }, "This calibration was fitted on opening and is not saved; add an effect or calibrate, then promote it.") : same ? h("p", { class: "note" }, "What is in hand is active.") : null,
    h(Section, { title: "The correction in the volume" }, fields.length ? h(Space, { urdf: session && session.urdf, joints: session ? session.joints : [], readings: live ? live.readings : null, points: drawn.points, lines: drawn.lines, label: "Correction vectors on a grid over the calibrated volume",
      note: (same ? "Blue: active, and in hand." : "Blue: active. Orange: in hand.") + " Vectors are drawn " + drawnLonger(drawn.times) + "."}) : h(Empty, null, "The correction is zero, or cannot be told without a state: ", (field.candidate && said(field.candidate.reason)) || "a model without effects corrects nothing.")),
    h(Export),
    h(Section, { title: "Where it holds" }, h(Table, { caption: "Readings and temperatures that the calibration in hand has seen", columns: [["Input"], ["from", "n"], ["to", "n"]], rows: c.ranges.map((r) => [r.name, text(r.lower, r.unit, 5), text(r.upper, r.unit, 5)]) })));
}
