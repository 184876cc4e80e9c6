// Running a plan on the machine. Nothing moves from here before the page is armed, and nothing after it has gone.

import { h } from "preact";
import { useState } from "preact/hooks";
import { act, downloadAddress, state, useDocument, useNews, useNumber } from "./server.js";
import { Action, Section, Table, Tile, Tiles } from "./parts.js";
import { unitOf, value } from "./units.js";
import { PlanPicture } from "./plan.js";

function Moves() {
  const d = useDocument("diagnosis");
  if (!d || !d.next_measurement.length) return h("p", { class: "empty" }, "No moves are proposed: the diagnosis proposes some where data do not separate what it found.");
  const moves = d.next_measurement, keys = [...new Set(moves.flatMap((m) => Object.keys(m)))];
  const head = (k) => k.replace(/_(mm|deg|um|s|degC|mm_s|deg_s)$/, (x, unit) => ", " + unitOf(unit.replace("_s", "/s"))).replace(/_/g, " ");
  const cell = (k, v) => (typeof v === "number" ? num(value(v, (/_(mm|deg)$/.exec(k) || [])[1]), 5) : Array.isArray(v) ? v.map((a) => num(a, 2)).join(", ") : v && typeof v === "object" ? Object.entries(v).map(([j, s]) => (s > 0 ? "+" : "−") + j).join(", ") : v ?? "–");
  return h(Table, { caption: "Targets, most useful first", columns: [["#", "n"], ...keys.map((k) => [head(k), "n"])], rows: moves.map((m, i) => [String(i + 1), ...keys.map((k) => cell(k, m[k]))]) });
}

function Live({ live, plan }) {
  const session = useDocument("session");
  const armed = state.live.armed, mine = armed && armed.client === state.client, motion = (name, more) => () => act(name, Object.assign({ client: state.client }, more));
  return h("div", null,
    h("p", { class: "controls" },
      mine ? h(Action, { label: "Disarm", run: motion("disarm") }) : h(Action, { label: "Arm", kind: "primary", disabled: !!(armed || live.no_stop), title: armed ? armed.who + " holds the machine" : live.no_stop ? live.no_stop : "lets this page move the machine as long as it is open", run: motion("arm") }),
      h(Action, { label: "Stop", kind: "stop", run: () => act("stop") }),
      h(Action, { label: "Home", disabled: !mine, run: motion("home") }),
      h(Action, { label: "Run the plan", disabled: !mine || !plan.trim(), confirm: "The machine will move: run", run: motion("run", { plan }) }),
      h(Action, { label: "Pause", disabled: !mine, run: motion("pause") }),
      h(Action, { label: "Go on", disabled: !mine, run: motion("continue") })),
    h("p", { class: mine ? "warning" : "note", role: "status" }, mine ? "Armed: this page can move the machine. Closing it stops every axis." : armed ? armed.who + " holds the machine." : live.no_stop ? "Not armed, because a stop would not reach the machine: " + live.no_stop + "." : "Not armed: nothing on this page moves the machine."),
    h(Tiles, null,
      h(Tile, { label: "Measuring", value: live.measuring ? percent(live.share) : "no plan", note: live.measuring }),
      h(Tile, { label: "Contacts of this session", value: String(live.observations) }),
      (session ? session.joints : []).map((j, i) => h(Tile, { key: j.name, label: j.name, value: known(live.readings[i]) ? num(value(live.readings[i], j.unit), 6) + " " + unitOf(j.unit) : "–" }))),
    live.measuring ? h("progress", { max: 1, value: live.share, "aria-label": "Progress of the plan" }) : null);
}

export function MeasureView() {
  useNews();
  const moves = useNumber("moves"), proposed = useDocument("moves"), [typed, setTyped] = useState(null);
  const live = state.live && state.live.machine, plan = typed ?? proposed ?? "";
  return h("div", null,
    live ? h(Live, { live, plan }) : h("p", { class: "note" }, "This workbench shows a recorded session: no machine is there, and nothing moves. roslaunch measuring_machine workbench.launch shows one, and runs plans."),
    h(Section, { title: "Plan", lead: "Drawn on the machine as it is written; nothing moves before it is run." },
      h("label", { class: "choice column", for: "plan" }, h("span", null, proposed ? "The moves that the diagnosis proposes, or another plan" : "A plan as YAML (mm plan new makes one)"), h("textarea", { id: "plan", rows: 10, maxlength: 60000, spellcheck: false, value: plan, onInput: (e) => setTyped(e.target.value) })),
      h(PlanPicture, { text: plan, live })),
    h(Section, { title: "What to measure next", action: moves ? h("a", { class: "button", href: downloadAddress("moves"), download: "moves.yaml" }, "Keep the plan") : null }, h(Moves)),
    h(Section, { title: "Recalibrate", lead: "Refits the current effects to the open session." }, h(Action, { label: "Recalibrate", run: () => act("calibrate", { method: "least_squares" }) })));
}
