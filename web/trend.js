// The page of mm history --trend: how each parameter went through the calibrations of a machine.

const main = document.getElementById("report");
const kDay = 86400e3;

/** Least squares, as the answer tells it, through the weighted middle of the comparable points. */
function lineOf(t) {
  const points = t.points.filter((p) => p.comparable && p.k2 > 0);
  const weights = points.map((p) => 1 / p.k2 ** 2);
  const sum = weights.reduce((a, b) => a + b, 0);
  const at = points.map((p) => Date.parse(p.measured) / kDay);
  const middle = (values) => values.reduce((s, v, i) => s + v * weights[i], 0) / sum;
  const day = middle(at), value = middle(points.map((p) => p.value));
  const ends = [Math.min(...at), Math.max(...at)];
  return { x: ends.map((d) => new Date(d * kDay).toISOString()), y: ends.map((d) => value + (t.per_30_days / 30) * (d - day)) };
}

function trendFigure(t) {
  const title = t.effect_in_words + ", " + t.name;
  return figure({
    name: title, label: title + " in " + t.points.length + " calibrations: " + t.in_words,
    caption: t.significant ? said(t.in_words) + ", p " + pValue(t.p_value) : known(t.per_30_days) ? "No significant trend: " + plusMinus(t.per_30_days, t.per_30_days_k2 / 2, t.unit) + " in 30 days (k = 2), p " + pValue(t.p_value) : "No trend can be told.",
    make: (c) => {
      const points = (list, hollow) => ({ x: list.map((p) => p.measured), y: list.map((p) => p.value), error_y: { type: "data", array: list.map((p) => p.k2), color: c.soft, thickness: 1.2, width: 3 },
        mode: "markers", type: "scatter", marker: { size: 8, color: hollow ? c.card : c.accent, line: { color: c.accent, width: 1.5 } }, text: list.map((p) => plain(p.id)),
        hovertemplate: "%{text}<br>%{y:.4g} " + plain(unitText(t.unit)) + "<extra></extra>" });
      const same = t.points.filter((p) => p.comparable), other = t.points.filter((p) => !p.comparable);
      const traces = [points(same, false)];
      if (other.length) traces.push(points(other, true));
      if (t.significant) traces.unshift(Object.assign(lineOf(t), { mode: "lines", type: "scatter", line: { color: c.warm, width: 2 }, hoverinfo: "skip" }));
      return [traces, { yaxis: { title: titled(unitText(t.unit)) }, xaxis: { type: "date", nticks: 5 } }];
    },
  }).node;
}

function page() {
  const significant = data.trends.filter((t) => t.significant);
  const told = data.trends.some((t) => known(t.per_30_days));
  const times = data.trends.flatMap((t) => t.points.map((p) => p.measured)).sort();
  main.replaceChildren(
    el("header", {}, el("h1", {}, "Trend of " + data.machine.split("/").pop()),
      el("p", { class: "meta" }, (times.length ? clock(times[0]) + " to " + clock(times[times.length - 1]) + ", " : "") + data.store),
      el("div", { class: "verdict " + (significant.length ? "scatter" : told ? "explained" : "insufficient_data") }, el("div", { class: "badge" }, significant.length ? "Changing" : told ? "Steady" : "Not known"),
        el("p", { class: "sentence" }, said(data.in_words)))));
  if (data.left_out.length) main.append(el("p", { class: "warning" }, "Left out: " + data.left_out.join("; ")));
  const grid = (id, title, list) => list.length && main.append(el("section", { "aria-labelledby": id }, el("h2", { id }, title), el("div", { class: "grid" }, list.map(trendFigure))));
  grid("changing", "Significant trends", significant);
  grid("steady", "No significant trend", data.trends.filter((t) => !t.significant));
  main.append(el("section", { "aria-labelledby": "table" }, el("h2", { id: "table" }, "All parameters"),
    table("Values ± expanded uncertainty, k = 2; the change is that of the last calibration against the first", [["Parameter", ""], ["Calibrations", "n"], ["Last", "n"], ["Change", "n"], ["In 30 days", "n"], ["p", "n"]],
      data.trends.map((t) => {
        const last = t.points[t.points.length - 1];
        const row = [t.effect_in_words + ", " + t.name, String(t.points.length), plusMinus(last.value, last.k2 / 2, t.unit), plusMinus(t.change, t.change_k2 / 2, t.unit), plusMinus(t.per_30_days, t.per_30_days_k2 / 2, t.unit), pValue(t.p_value)];
        row.chosen = t.significant;
        return row;
      }))));
  main.append(el("footer", {}, el("h3", {}, "How to read the figures"), el("p", {},
    "Bars are expanded uncertainties, k = 2. A line is drawn where a trend is significant: less than 1 % by chance, corrected for all parameters. A hollow mark was calibrated over another range from which the effect counts, and is not in the line. This page is complete in itself and loads nothing from a network. Figures by Plotly.js (MIT). " + clock(data.created))));
}

page();
drawAll();
