// Units of the page. Everything comes in um, mm, arcsec and deg; people choose what they read.

const kDeviation = { um: [1, "µm"], mm: [1e-3, "mm"], in: [1 / 25.4, "mil"] }; // thousandths of an inch
const kLength = { um: [1, "mm"], mm: [1, "mm"], in: [1 / 25.4, "in"] };
const kAngle = { arcsec: [1, "″"], deg: [1 / 3600, "°"] };

const listeners = new Set();
const chosen = { deviation: localStorage.getItem("mm-deviation") || "um", angle: localStorage.getItem("mm-angle") || "arcsec" };
if (!(chosen.deviation in kDeviation)) chosen.deviation = "um";
if (!(chosen.angle in kAngle)) chosen.angle = "arcsec";

export const units = {
  get deviation() { return chosen.deviation; },
  get angle() { return chosen.angle; },
  choose(kind, value) {
    chosen[kind] = value;
    localStorage.setItem("mm-" + kind, value);
    for (const tell of listeners) tell();
  },
  listen(tell) { listeners.add(tell); return () => listeners.delete(tell); },
};

/** Factor and text of a unit of the server as it is shown. */
export function shown(unit) {
  if (unit === "um") return kDeviation[chosen.deviation];
  if (unit === "mm") return kLength[chosen.deviation];
  if (unit === "mm/s") return [kLength[chosen.deviation][0], kLength[chosen.deviation][1] + "/s"];
  if (unit === "arcsec") return kAngle[chosen.angle];
  const compound = /^um\/(.*)$/.exec(unit || "");
  if (compound) return [kDeviation[chosen.deviation][0], kDeviation[chosen.deviation][1] + "/" + unitText(compound[1])];
  return [1, unitText(unit)];
}

export const unitOf = (unit) => shown(unit)[1];
export const value = (x, unit) => (known(x) ? x * shown(unit)[0] : x);
/** "0.843 µm" */
export const text = (x, unit, digits = 3) => (known(x) ? withUnit(num(value(x, unit), digits), unitOf(unit)) : "–");
/** "2.98 ± 0.09 µm": the expanded uncertainty, k = 2. */
export const measured = (x, std, unit) => (known(x) ? plusMinus(value(x, unit), known(std) ? std * Math.abs(shown(unit)[0]) : null, unitOf(unit)) : "–");
/** An RMS of n residuals with its expanded uncertainty, as of independent normal ones. */
export const rms = (x, n, unit) => measured(x, rmsStd(x, n), unit);
