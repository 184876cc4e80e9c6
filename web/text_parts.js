"use strict";
// What the report and the workbench say alike: units, numbers, sentences, elements. Nothing here knows of either.

const kUnits = { um: "µm", "um/m": "µm/m", "um/K": "µm/K", degC: "°C", deg: "°", "deg/s": "°/s", percent: "%", "1": "" };
const unitText = (unit) => (unit in kUnits ? kUnits[unit] : (unit || "").replace(/\bum\b/g, "µm").replace(/\bdegC\b/g, "°C"));

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

/** A constant of a cause that a diagnosis found; `std` 0: the session does not determine it. @param show text of a value with its uncertainty. */
const foundSize = (p, show) => p.name + (p.std > 0 ? " = " + show(p.value, p.std, p.unit) : " is not determined by this session");

function pValue(p) {
  if (!known(p)) return "–";
  if (p >= 0.995) return "1";
  if (p >= 0.001) return p.toFixed(p < 0.1 ? 3 : 2);
  if (p < 1e-6) return "< " + power(-6);
  const [mantissa, exponent] = p.toExponential(0).split("e");
  return mantissa + " × " + power(Number(exponent));
}

const bare = (value, std) => plusMinus(value, std, "1");
/** Uncertainty of an RMS of n independent normal residuals. */
const rmsStd = (rms, n) => (known(rms) && n > 0 ? rms / Math.sqrt(2 * n) : null);

const fixed = (value) => (known(value) ? minus(value.toFixed(2)) : "–");
const percent = (share, digits = 0) => (known(share) ? (100 * share).toFixed(digits) + " %" : "–");

/** A sentence of the diagnosis with the signs of print. */
const said = (text) => text.replace(/(?<![\w-])um\b/g, "µm").replace(/\bdegC\b/g, "°C").replace(/->/g, "→").replace(/(^|[ (])-(?=\d)/g, "$1−").replace(/ ± (?=\d)/g, "\u00a0±\u00a0").replace(/\bk = 2\b/g, "k\u00a0=\u00a02");
/** A time in the unit that reads best. */
const duration = (s) => (s < 90 ? num(s, 2) + " s" : s < 5400 ? num(s / 60, 2) + " min" : s < 172800 ? num(s / 3600, 2) + " h" : num(s / 86400, 2) + " days");
/** A variable as formulas call it, for people. */
const variableName = (name, unit) => (name === "t" ? "time" : unit === "degC" ? "temperature " + name : name.replace(/^(.*)_velocity$/, "velocity of $1"));
/** A time of a file (UTC) as it is read. */
const clock = (time, zone = " UTC") => time.replace("T", " ").replace("Z", zone);
/** An effect in words, with its symbol of ISO 230-1 where it has one. */
const withSymbol = (effect) => effect.in_words + (effect.iso230 ? " (" + effect.iso230 + ")" : "");
const sameEffect = (a, b) => JSON.stringify(a) === JSON.stringify(b);

const kVerdicts = {
  question: "A question first", insufficient_data: "Insufficient data", unknown_effect: "Unknown effect", confusable: "Not separated yet",
  missing_effect: "Missing effect", scatter: "Scatter", explained: "Explained",
};
/** What is said of another explanation, behind its name. */
const rivalText = (c) => (c.same ? ": does the same wherever measurements of this kind reach; none separates them" :
  c.not_recorded ? ": cannot be excluded, " + c.not_recorded.replace(/^(the )?/, "the ") + " was not recorded" : ", odds " + c.odds_in_words);

/** The share of a meter that is full, as a width. */
const meterWidth = (share) => (100 * Math.min(1, Math.max(0, share || 0))).toFixed(1) + "%";

/** The largest of 1, 2, 5, 10 … that a value reaches. */
function roundDown(value) {
  const decade = 10 ** Math.floor(Math.log10(value));
  return [5, 2, 1].map((f) => f * decade).find((f) => f <= value * 1.0001);
}
/** "Vectors are drawn …": how much longer than they are. */
const drawnLonger = (times) => (times === 1 ? "to scale" : grouped(times) + " times longer than they are");
/** A whole number with a narrow space before each three digits. */
const grouped = (value) => String(value).replace(/\B(?=(\d{3})+$)/g, "\u202f");
/** Length of the longest side of the box around points. */
const longestSide = (points) => Math.max(...[0, 1, 2].map((k) => Math.max(...points.map((p) => p[k])) - Math.min(...points.map((p) => p[k]))));

/** Plotly reads a little markup in its texts. */
const plain = (text) => String(text).replace(/&/g, "&amp;").replace(/</g, "&lt;").replace(/>/g, "&gt;");
