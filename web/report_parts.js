"use strict";
// Text, numbers and elements. Whatever comes from a file goes in as text, never as markup.

const data = JSON.parse(document.getElementById("data").textContent);
const diagnosis = data.diagnosis;
const kUnits = { um: "µm", "um/m": "µm/m", "um/K": "µm/K", degC: "°C", deg: "°", "deg/s": "°/s", percent: "%", "1": "" };
const unitText = (unit) => (unit in kUnits ? kUnits[unit] : (unit || "").replace(/\bum\b/g, "µm").replace(/\bdegC\b/g, "°C"));
const kUnit = unitText(data.unit);
const kSuffix = data.unit === "arcsec" ? "_arcsec" : "_um";

/** An element: attributes, then children (text or nodes; null is left out). */
function el(tag, attributes, ...children) {
  const node = document.createElement(tag);
  for (const [key, value] of Object.entries(attributes || {})) if (value !== null && value !== undefined) node.setAttribute(key, value);
  for (const child of children.flat(9)) if (child !== null && child !== undefined) node.append(child);
  return node;
}

const known = (value) => typeof value === "number" && Number.isFinite(value);
const minus = (text) => text.replace(/^-(?=[0.]*$)/, "").replace(/^-/, "−").replace(/e-/, "e−");
const kSuperscript = { "-": "⁻", 0: "⁰", 1: "¹", 2: "²", 3: "³", 4: "⁴", 5: "⁵", 6: "⁶", 7: "⁷", 8: "⁸", 9: "⁹" };
const power = (exponent) => "10" + [...String(exponent)].map((c) => kSuperscript[c]).join("");

/** A number with so many significant digits, without exponent where that is readable. */
function num(value, digits = 3) {
  if (!known(value)) return "–";
  if (value === 0) return "0";
  const size = Math.floor(Math.log10(Math.abs(Number(value.toPrecision(digits)))));
  if (size < -4 || size > 6) {
    const [mantissa, exponent] = value.toExponential(Math.max(0, digits - 1)).split("e");
    return minus(mantissa) + " × " + power(Number(exponent));
  }
  return minus(value.toFixed(Math.max(0, digits - 1 - size)));
}
const withUnit = (text, unit) => (text === "–" || !unitText(unit) ? text : text + " " + unitText(unit));
const length = (value, digits = 3) => withUnit(num(value, digits), data.unit);

/** A number rounded to so many significant digits, large ones too, without exponent. */
const digits = (value, count) => { const x = Number(value.toPrecision(count)); return Math.abs(x) >= 10 ** (count - 1) ? minus(x.toFixed(0)) : num(x, count); };

/** Value ± expanded uncertainty (k = 2, twice `std`), this with two digits. */
function plusMinus(value, std, unit) {
  if (!known(value)) return "–";
  if (!known(std) || std <= 0) return withUnit(num(value, 5), unit);
  const wide = 2 * std;
  const size = Math.floor(Math.log10(Math.max(Math.abs(value), wide)));
  if (size < -4 || size > 6) {
    const decimals = Math.min(12, Math.max(0, size + 1 - Math.floor(Math.log10(wide))));
    const scaled = (x) => minus((x / 10 ** size).toFixed(decimals));
    return withUnit("(" + scaled(value) + " ± " + scaled(wide) + ") × " + power(size), unit);
  }
  const place = Math.floor(Math.log10(wide)) - 1; // of the last digit
  const rounded = (x) => minus((place > 0 ? Math.round(x / 10 ** place) * 10 ** place : x).toFixed(Math.min(12, Math.max(0, -place))));
  return withUnit(rounded(value) + " ± " + rounded(wide), unit);
}

/** Value ± expanded uncertainty, this with one digit, or two where it begins with 1 or 2. */
function expanded(value, std, unit) {
  if (!known(value)) return "–";
  if (!known(std) || std <= 0) return withUnit(num(value), unit);
  const wide = 2 * std;
  let place = Math.floor(Math.log10(wide));
  if (wide / 10 ** place >= 9.5) ++place;
  const decimals = (wide / 10 ** place < 2.95 ? 1 : 0) - place;
  if (decimals > 6 || Math.abs(value) >= 1e7) return plusMinus(value, std, unit) + " (k = 2)";
  const rounded = (x) => minus((Math.abs(x) < 0.5 * 10 ** -decimals ? 0 : x).toFixed(Math.max(0, decimals)));
  return withUnit(rounded(value) + " ± " + rounded(wide), unit) + " (k = 2)";
}

function pValue(p) {
  if (!known(p)) return "–";
  if (p >= 0.995) return "1";
  if (p >= 0.001) return p.toFixed(p < 0.1 ? 3 : 2);
  if (p < 1e-10) return "< " + power(-10);
  const [mantissa, exponent] = p.toExponential(0).split("e");
  return mantissa + " × " + power(Number(exponent));
}
/** Uncertainty of an RMS of n independent normal residuals. */
const rmsStd = (rms, n = data.residuals) => (known(rms) && n > 0 ? rms / Math.sqrt(2 * n) : null);
/** An RMS ± its uncertainty, in the unit of the page. */
const rmsText = (rms, n) => plusMinus(rms, rmsStd(rms, n), data.unit);
const bare = (value, std) => plusMinus(value, std, "1");

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
const fixed = (value) => (known(value) ? minus(value.toFixed(2)) : "–");
const percent = (share, digits = 0) => (known(share) ? (100 * share).toFixed(digits) + " %" : "–");

/** A sentence of the diagnosis with the signs of print. */
const said = (text) => text.replace(/(?<![\w-])um\b/g, "µm").replace(/\bdegC\b/g, "°C").replace(/->/g, "→").replace(/(^|[ (])-(?=\d)/g, "$1−");
/** A time in the unit that reads best. */
const duration = (s) => (s < 90 ? num(s, 2) + " s" : s < 5400 ? num(s / 60, 2) + " min" : s < 172800 ? num(s / 3600, 2) + " h" : num(s / 86400, 2) + " days");
/** A variable as formulas call it, for people. */
const variableName = (name, unit) => (name === "t" ? "time" : unit === "degC" ? "temperature " + name : name.replace(/^(.*)_velocity$/, "velocity of $1"));
const sameEffect = (a, b) => JSON.stringify(a) === JSON.stringify(b);

/** Plotly reads a little markup in its texts. */
const plain = (text) => String(text).replace(/&/g, "&amp;").replace(/</g, "&lt;").replace(/>/g, "&gt;");

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
