// The page: its views, what runs, and what every view shares.

import { h, render } from "preact";
import { useEffect, useState } from "preact/hooks";
import { act, connect, name, state, useDocument, useNews } from "./server.js";
import { Action, Choice, useUnits } from "./parts.js";
import { units } from "./units.js";
import { ImportView, sendFile } from "./import.js";
import { SessionView } from "./session.js";
import { CompareView } from "./compare.js";
import { DiagnoseView } from "./diagnose.js";
import { LedgerView } from "./ledger.js";
import { CorrectView } from "./correct.js";
import { MeasureView } from "./measure.js";
import { HeatView } from "./heat.js";
import { HistoryView } from "./history.js";

/** @type {[string, string, Function][]} */
const kViews = [["import", "Import", ImportView], ["session", "Session", SessionView], ["compare", "Compare", CompareView], ["diagnose", "Diagnose", DiagnoseView], ["ledger", "Ledger", LedgerView],
  ["correct", "Correct", CorrectView], ["measure", "Measure", MeasureView], ["heat", "Heat", HeatView], ["history", "History", HistoryView]];
const viewOf = () => (kViews.find(([id]) => id === location.hash.slice(1)) || kViews[1])[0];

function setTheme(theme) {
  if (theme) document.documentElement.dataset.theme = theme;
  else delete document.documentElement.dataset.theme;
  localStorage.setItem("mm-theme", theme);
  dispatchEvent(new Event("mm-theme"));
}

const lastPart = (path) => path.split("/").pop();

/** Which session and which machine every view shows. */
function Opened() {
  const session = useDocument("session"), machine = useDocument("machine");
  const name = session ? session.machine : machine ? machine.name : "";
  const words = (session ? lastPart(session.name) : "No session") + (name ? ", machine " + lastPart(name).replace(/\.urdf$/, "") : "");
  return h("p", { class: "opened", title: words }, words);
}

function Running() {
  useNews();
  const live = state.live;
  if (!state.connected) return h("p", { class: "running lost", role: "alert" }, live ? "The workbench does not answer; what you see is the last that it said." : "Connecting …");
  if (!live || !live.task) return null;
  const t = live.task;
  return h("div", { class: "running", role: "status" }, h("span", null, said(t.name.replace(/_/g, " ")) + (t.stage ? ": " + said(t.stage) : "") + (live.waiting ? ", " + live.waiting + " waiting" : "")), h("progress", { max: 1, value: t.share || 0, "aria-label": t.name }), h("span", { class: "note" }, num(t.seconds, 2) + " s"), h("button", { onClick: () => act("cancel") }, "Cancel"));
}

function Said() {
  const [said_, set] = useState(null);
  useEffect(() => { const take = (e) => set(e.detail); const forget = () => set(null); addEventListener("mm-said", take); addEventListener("hashchange", forget); return () => { removeEventListener("mm-said", take); removeEventListener("hashchange", forget); }; }, []);
  return said_ ? h("p", { class: said_.ok ? "running" : "running lost", role: said_.ok ? "status" : "alert" }, h("span", null, said_.message), h("button", { onClick: () => set(null), "aria-label": "Close the message" }, "×")) : null;
}

function StopButton() {
  useNews();
  return state.live && state.live.machine ? h(Action, { label: "Stop", kind: "stop", title: "Stops every axis. Key: Escape twice", run: () => act("stop") }) : null;
}

function Page() {
  useUnits();
  const [view, setView] = useState(viewOf), [who, setWho] = useState(name.get()), [dropping, setDropping] = useState(false), [help, setHelp] = useState(false);
  const [theme, chooseTheme] = useState(localStorage.getItem("mm-theme") || "");
  useEffect(() => {
    const go = () => { setView(viewOf()); scrollTo(0, 0); };
    let escaped = 0;
    const key = (e) => {
      if (e.key === "Escape") { if (performance.now() - escaped < 600 && state.live && state.live.machine) act("stop"); escaped = performance.now(); setHelp(false); return; }
      if (e.ctrlKey || e.metaKey || e.altKey || /^(INPUT|TEXTAREA|SELECT)$/.test(e.target.tagName)) return;
      const at = Number(e.key) - 1;
      if (kViews[at]) location.hash = kViews[at][0];
      else if (e.key === "?") setHelp((v) => !v);
    };
    const over = (e) => { if ([...e.dataTransfer.types].includes("Files")) { e.preventDefault(); setDropping(true); } };
    const leave = (e) => { if (!e.relatedTarget) setDropping(false); };
    const drop = (e) => { e.preventDefault(); setDropping(false); if (e.dataTransfer.files[0]) sendFile(e.dataTransfer.files[0]); };
    /** @type {[string, EventListener][]} */
    const heard = [["hashchange", go], ["keydown", key], ["dragover", over], ["dragleave", leave], ["drop", drop]];
    for (const [event, listener] of heard) addEventListener(event, listener);
    return () => { for (const [event, listener] of heard) removeEventListener(event, listener); };
  }, []);
  useEffect(() => { document.title = kViews.find(([id]) => id === view)[1] + " – workbench"; }, [view]);
  const View = kViews.find(([id]) => id === view)[2];
  return h("div", null,
    h("header", { class: "top" }, h("a", { class: "skip", href: "#view", onClick: (e) => { e.preventDefault(); document.getElementById("view").focus(); } }, "Skip to the view"), h("div", { class: "brand" }, h("h1", null, "Workbench"), h(Opened), h(StopButton)),
      h("nav", { "aria-label": "Views" }, h("ul", null, kViews.map(([id, title], i) => h("li", { key: id }, h("a", { href: "#" + id, "aria-current": id === view ? "page" : null, title: "Key " + (i + 1) }, title))))),
      h("details", { class: "settings" }, h("summary", null, "Settings"), h("div", { class: "controls" },
        h(Choice, { id: "deviation", label: "Deviations", value: units.deviation, options: [["um", "µm (lengths in mm)"], ["mm", "mm"], ["in", "mil (lengths in inch)"]], onChange: (v) => units.choose("deviation", v) }),
        h(Choice, { id: "angle", label: "Angles", value: units.angle, options: [["arcsec", "arc seconds"], ["deg", "degrees"]], onChange: (v) => units.choose("angle", v) }),
        h(Choice, { id: "theme", label: "Colours", value: theme, options: [["", "as the system"], ["light", "light"], ["dark", "dark"]], onChange: (v) => { chooseTheme(v); setTheme(v); } }),
        h("label", { class: "choice", for: "who" }, h("span", null, "Your name, for the log"), h("input", { id: "who", value: who, maxlength: 40, autocomplete: "name", onInput: (e) => { setWho(e.target.value); name.set(e.target.value); } })),
        h("button", { onClick: () => setHelp(true) }, "Keys")))),
    h(Running), h(Said),
    help ? h("div", { class: "card help", role: "dialog", "aria-label": "Keys" }, h("p", null, "1 to 9: the views. ?: this. Tab and Enter reach everything; arrow keys turn a picture of the machine that has the focus, and go from point to point of one of residuals. Escape twice: stop the machine."), h("button", { onClick: () => setHelp(false) }, "Close")) : null,
    h("main", { id: "view", tabindex: -1, "aria-label": kViews.find(([id]) => id === view)[1] }, h(View, { key: view })),
    dropping ? h("div", { class: "dropping" }, "Drop a file of measurements, or a bag") : null);
}

setTheme(localStorage.getItem("mm-theme") || "");
connect();
render(h(Page), document.getElementById("workbench"));
