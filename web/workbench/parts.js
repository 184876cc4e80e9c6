// Pieces that several views use.

import { h } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import { units } from "./units.js";

/** Draws its component again when other units are chosen. */
export function useUnits() {
  const [, set] = useState(0);
  useEffect(() => units.listen(() => set((n) => n + 1)), []);
}

/** Whether the colours changed between light and dark: charts are drawn again. */
export function useTheme() {
  const [dark, set] = useState(() => document.documentElement.dataset.theme || (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light"));
  useEffect(() => {
    const look = () => set(document.documentElement.dataset.theme || (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light"));
    const media = matchMedia("(prefers-color-scheme: dark)");
    media.addEventListener("change", look);
    addEventListener("mm-theme", look);
    return () => { media.removeEventListener("change", look); removeEventListener("mm-theme", look); };
  }, []);
  return dark;
}

export function colours() {
  const style = getComputedStyle(document.documentElement);
  return Object.fromEntries(["ink", "soft", "line", "card", "accent", "blue"].map((name) => [name, style.getPropertyValue("--" + name).trim()]));
}

export const Tile = ({ label, value, note }) => h("div", { class: "tile" }, h("div", { class: "label" }, label), h("div", { class: "value" }, value), note ? h("div", { class: "label" }, note) : null);
export const Tiles = ({ children }) => h("div", { class: "tiles" }, children);
export const Empty = ({ children }) => h("p", { class: "empty" }, children);

/** A section with its heading. */
export function Section({ title, lead, children, action }) {
  const id = "s-" + title.toLowerCase().replace(/[^a-z0-9]+/g, "-");
  return h("section", { "aria-labelledby": id }, h("div", { class: "heading" }, h("h2", { id }, title), action || null), lead ? h("p", { class: "lead" }, lead) : null, children);
}

/** A table that scrolls by itself where the window is narrow. Columns: [heading, class]. */
export function Table({ caption, columns, rows, most = 12 }) {
  const [all, set] = useState(false);
  const shown = all || rows.length <= most + 2 ? rows : rows.slice(0, most);
  return h("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": caption },
    h("table", null, h("caption", null, h("span", null, caption)),
      h("thead", null, h("tr", null, columns.map(([name, kind], i) => h("th", { key: i, class: kind, scope: "col" }, name)))),
      h("tbody", null, shown.map((row, r) => h("tr", { key: r, class: row.chosen ? "chosen" : null }, row.map((cell, i) => (i === 0 ? h("th", { key: i, scope: "row", class: columns[0][1] }, cell) : h("td", { key: i, class: columns[i][1] }, cell))))))),
    shown.length < rows.length ? h("button", { class: "more", onClick: () => set(true) }, (rows.length - shown.length) + " more") : null);
}

/** A button whose action takes a while: it says so, and what became of it, where it stands. */
export function Action({ label, run, kind, disabled, title, confirm }) {
  const [busy, setBusy] = useState(false);
  const [said, setSaid] = useState(null);
  const [asking, setAsking] = useState(false);
  const here = useRef(true);
  useEffect(() => () => { here.current = false; }, []);
  const go = async () => {
    if (confirm && !asking) { setAsking(true); return; }
    setAsking(false);
    setBusy(true);
    setSaid(null);
    const end = await run();
    if (!here.current) { // its place is gone, what it said is not
      if (end) dispatchEvent(new CustomEvent("mm-said", { detail: end }));
      return;
    }
    setBusy(false);
    if (end) setSaid(end);
  };
  return h("span", { class: "action" },
    h("button", { class: kind || "", onClick: go, disabled: busy || disabled, title, "aria-busy": busy }, busy ? label + " …" : asking ? confirm : label),
    asking ? h("button", { onClick: () => setAsking(false) }, "No") : null,
    said ? h("span", { class: said.ok ? "said" : "said bad", role: said.ok ? "status" : "alert" }, said.message) : null);
}

export const Meter = ({ share }) => h("span", { class: "meter", "aria-hidden": "true" }, h("i", { style: { width: meterWidth(share) } }));

/** A choice of one word. */
export const Choice = ({ label, value, options, onChange, id }) => h("label", { class: "choice", for: id }, h("span", null, label),
  h("select", { id, value, onChange: (e) => onChange(e.target.value) }, options.map(([v, t]) => h("option", { key: v, value: v, selected: v === value }, t))));
