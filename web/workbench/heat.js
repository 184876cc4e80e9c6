// Temperatures and whatever else was logged, and how the residual moves with time.

import { h } from "preact";
import { useMemo } from "preact/hooks";
import { useDocument } from "./server.js";
import { Empty, Section, Table } from "./parts.js";
import { Chart, axis, curveWithBand } from "./chart.js";
import { classes, wordColours } from "./scatter.js";
import { shown, unitOf } from "./units.js";

const hours = (list) => list.map((s) => s / 3600);

/** Several series on one time axis. */
function together(series) {
  const times = [...new Set(series.flatMap((s) => s.time_s))].sort((a, b) => a - b), place = new Map(times.map((t, i) => [t, i]));
  return [hours(times), ...series.map((s) => { const y = Array(times.length).fill(undefined); s.time_s.forEach((t, i) => { y[place.get(t)] = s.value[i]; }); return y; })];
}

function Courses({ series, label, unit }) {
  const data = useMemo(() => together(series), [series]);
  const make = (c) => { const words = wordColours(c); return [{
    legend: { show: true, live: false },
    scales: { x: { time: false } },
    axes: [axis(c, "time, h"), axis(c, unit, { size: 60 })],
    series: [{ label: "time" }, ...series.map((s, i) => ({ label: s.name, named: s.name, stroke: words[i % words.length], width: 1.5, dash: [[], [6, 3], [2, 3]][Math.floor(i / words.length) % 3], spanGaps: true, points: { show: s.time_s.length < 30 } }))],
  }, data]; };
  return h("figure", null, h(Chart, { make, inputs: [series], label, tall: true }));
}

/** Mean residual of classes of time, with its band. */
function Drift({ points }) {
  const time = points.columns.find((c) => c.name === "time"), residual = points.columns[0], factor = shown(points.unit)[0];
  const bins = useMemo(() => {
    if (!time) return [];
    const rows = residual.values.map((v, r) => r).filter((r) => known(residual.values[r]) && known(time.values[r])).sort((a, b) => time.values[a] - time.values[b]);
    return classes(hours(rows.map((r) => time.values[r])), rows.map((r) => residual.values[r]), null, Math.max(3, Math.min(30, Math.floor(rows.length / 12))));
  }, [points]);
  if (bins.length < 3) return h(Empty, null, "Too few measurements to see a drift.");
  const of = (f) => bins.map((b) => f(b) * factor);
  const make = (c) => curveWithBand(c, { x: bins.map((b) => b.at), y: of((b) => b.mean), half: of((b) => b.half), xLabel: "time, h", yLabel: "mean residual, " + unitOf(points.unit) });
  return h("figure", null, h(Chart, { make, inputs: [bins, factor], label: "Mean residual of " + bins.length + " classes of time with their bands" }), h("figcaption", null, "Mean of measured \u2212 model in each class ± 2 standard errors: a mean away from zero that stays away is a drift that the model does not know."));
}

/** The sensors that the model uses. */
function chosen(calibration) {
  const used = new Map();
  for (const e of calibration ? calibration.effects : []) for (const [k, v] of Object.entries(e.effect)) if (k === "sensor" || k === "sensors") for (const s of [].concat(v)) used.set(s, [...(used.get(s) || []), e.in_words]);
  return used;
}

export function HeatView() {
  const heat = useDocument("heat"), points = useDocument("points"), calibration = useDocument("calibration");
  if (!heat) return h(Empty, null, "No session is open.");
  const used = chosen(calibration);
  const extent = (list) => list.filter(known).reduce(([a, b], v) => [Math.min(a, v), Math.max(b, v)], [Infinity, -Infinity]);
  return h("div", null,
    h(Section, { title: "Temperatures" }, heat.temperatures.length ? [h(Courses, { series: heat.temperatures, label: "Temperatures of " + heat.temperatures.length + " sensors against time", unit: "temperature, °C" }),
      h(Table, { caption: "Sensors", columns: [["Sensor"], ["range", "nowrap"], ["samples", "n"], ["used by", "text"]], rows: heat.temperatures.map((s) => { const [a, b] = extent(s.value); return [s.name, num(a, 4) + " … " + num(b, 4) + " °C", String(s.samples), (used.get(s.name) || []).map(said).join("; ") || "–"]; }) })] : h(Empty, null, "No temperature was logged; without one, effects of heat can only be told as drift.")),
    points ? h(Section, { title: "Drift of the residual" }, h(Drift, { points })) : null,
    heat.covariates.length ? h(Section, { title: "Other quantities" }, heat.covariates.map((s) => h(Courses, { key: s.name, series: [s], label: s.name + " against time", unit: s.name + ", " + unitText(s.unit) }))) : null);
}
