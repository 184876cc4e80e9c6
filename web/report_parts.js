// Text, numbers and elements of the report. Whatever comes from a file goes in as text, never as markup.

const data = JSON.parse(document.getElementById("data").textContent);
const diagnosis = data.diagnosis;
const kUnit = unitText(data.unit);
const kSuffix = data.unit === "arcsec" ? "_arcsec" : "_um";

const length = (value, digits = 3) => withUnit(num(value, digits), data.unit);

/** Uncertainty of an RMS of n independent normal residuals. */
const rmsStd = (rms, n = data.residuals) => (known(rms) && n > 0 ? rms / Math.sqrt(2 * n) : null);
/** An RMS ± its uncertainty, in the unit of the page. */
const rmsText = (rms, n) => plusMinus(rms, rmsStd(rms, n), data.unit);
/** Standard uncertainties of the figures of ISO 230-2, from the scatter of the runs alone; null with single runs. */
function positioningStd(t) {
  const s = [t.s_forward, t.s_backward], mean = [t.forward, t.backward];
  const n = (i, side) => t.runs[i][side];
  const variance = (i, side) => (known(s[side][i]) && n(i, side) > 1 ? s[side][i] ** 2 / n(i, side) : NaN);
  const spread = (i, side) => (n(i, side) > 1 ? s[side][i] ** 2 / (2 * (n(i, side) - 1)) : NaN);
  const all = t.at.flatMap((x, i) => [0, 1].map((side) => [i, side])).filter(([i, side]) => known(mean[side][i]));
  const both = t.at.map((x, i) => i).filter((i) => known(mean[0][i]) && known(mean[1][i]));
  const root = (v) => (known(v) ? Math.sqrt(v) : null);
  const best = (list, value) => list.reduce((a, b) => (value(b) > value(a) ? b : a), list[0]);
  const extremes = (list, upper, lower, v) => (list.length ? root(v(best(list, upper)) + v(best(list, (x) => -lower(x)))) : null);
  const at = ([i, side]) => mean[side][i], edge = (sign) => ([i, side]) => mean[side][i] + sign * 2 * s[side][i];
  const reversal = (i) => variance(i, 0) + variance(i, 1), middle = (i) => (mean[0][i] + mean[1][i]) / 2;
  const widest = (side) => { const list = all.filter((x) => x[1] === side); return list.length ? 16 * spread(...best(list, ([i]) => s[side][i])) : NaN; };
  const b = both.length ? best(both, (i) => Math.abs(mean[0][i] - mean[1][i])) : null;
  const one = (side) => all.filter((x) => x[1] === side);
  const wide = (list) => extremes(list, edge(1), edge(-1), (x) => variance(...x) + 4 * spread(...x)), range = (list) => extremes(list, at, at, (x) => variance(...x));
  return { A_forward: wide(one(0)), A_backward: wide(one(1)), E_forward: range(one(0)), E_backward: range(one(1)), A: extremes(all, edge(1), edge(-1), (x) => variance(...x) + 4 * spread(...x)), E: extremes(all, at, at, (x) => variance(...x)),
    M: extremes(both, middle, middle, (i) => reversal(i) / 4), B: b === null ? null : root(reversal(b)), B_mean: both.length ? root(both.reduce((sum, i) => sum + reversal(i), 0) / both.length ** 2) : null,
    R: b === null ? root(all.length ? widest(all[0][1]) : NaN) : root((widest(0) + widest(1)) / 4 + reversal(b)), R_forward: root(widest(0)), R_backward: root(widest(1)) };
}
/** A table that scrolls by itself where the window is narrow. Columns: [heading, class]; rows of cells. */
function table(caption, columns, rows) {
  const cell = (tag, content, kind, scope) => el(tag, { class: kind || null, scope: scope || null }, content);
  return el("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": caption },
    el("table", {}, el("caption", {}, el("span", {}, caption)),
      el("thead", {}, el("tr", {}, columns.map(([name, kind]) => cell("th", name, kind, "col")))),
      el("tbody", {}, rows.map((row) => el("tr", { class: row.chosen ? "chosen" : null },
        row.map((content, i) => (i === 0 ? cell("th", content, columns[0][1], "row") : cell("td", content, columns[i][1]))))))));
}

function meter(share) {
  return el("span", { class: "meter", "aria-hidden": "true" }, el("i", { style: "width:" + (100 * Math.min(1, Math.max(0, share || 0))).toFixed(1) + "%" }));
}

/** The first rows, and the others behind a line that opens. */
function longTable(caption, columns, rows, shown) {
  if (rows.length <= shown + 2) return [table(caption, columns, rows)];
  return [table(caption, columns, rows.slice(0, shown)),
    el("details", {}, el("summary", {}, (rows.length - shown) + " more"), table(caption + ", continued", columns, rows.slice(shown)))];
}
