// Any column against any other, coloured by a third: sixteen thousand points, drawn by hand on uPlot's canvas.

import { h } from "preact";
import { useEffect, useMemo, useRef } from "preact/hooks";
import { Chart, axis } from "./chart.js";
import { shown, unitOf } from "./units.js";

// Okabe and Ito's colours: told apart with any colour vision, on white and on black.
const kWords = ["#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00", "#999999", "#b8a800"];
/** Colours of words, told apart by whoever sees few of them; the first is the theme's own blue. */
export const wordColours = (c) => [c.blue, ...kWords];
// Cividis: even in lightness for everybody.
const kScale = [[0, 34, 78], [18, 53, 112], [59, 73, 108], [87, 93, 109], [112, 113, 115], [138, 134, 120], [165, 156, 116], [195, 179, 105], [225, 204, 85], [254, 232, 56]];
const kLevels = 24;

export function shade(share) {
  const at = Math.min(0.9999, Math.max(0, share)) * (kScale.length - 1), i = Math.floor(at), f = at - i;
  return "rgb(" + kScale[i].map((v, k) => Math.round(v + f * (kScale[i + 1][k] - v))).join(",") + ")";
}

/** Low and high of a column without its farthest hundredth: one wild row shall not take all colours. */
export function rangeOf(values) {
  const sorted = Float64Array.from(values.filter(known)).sort();
  if (!sorted.length) return [0, 1];
  const low = sorted[Math.floor(0.01 * (sorted.length - 1))], high = sorted[Math.ceil(0.99 * (sorted.length - 1))];
  return low < high ? [low, high] : [low - 0.5, low + 0.5];
}

/** Colour of each row, as the number of a colour, and the colours with their names. */
export function colouring(column, c) {
  if (!column) return { of: () => 0, palette: [c.accent], names: [] };
  if (column.words) {
    const all = wordColours(c), palette = column.words.map((w, i) => all[i % all.length]);
    return { of: (r) => column.values[r] ?? palette.length, palette: [...palette, c.line], names: column.words.map((w, i) => [w, palette[i]]) };
  }
  const [low, high] = rangeOf(column.values), factor = shown(column.unit)[0];
  const palette = Array.from({ length: kLevels }, (x, i) => shade(i / (kLevels - 1)));
  const of = (r) => (known(column.values[r]) ? Math.min(kLevels - 1, Math.max(0, Math.floor(((column.values[r] - low) / (high - low)) * kLevels))) : kLevels);
  return { of, palette: [...palette, c.line], scale: [low * factor, high * factor, unitOf(column.unit)], names: [] };
}

// A fixed scatter about a word's place, the same for a row whenever it is drawn.
const aside = (r) => (((r * 2654435761) >>> 8) % 1000) / 1000 - 0.5;

const kOrders = new WeakMap();
/** The rows in the order of a column, and where each is drawn; worked out once a column. */
function orderOf(column) {
  let order = kOrders.get(column.values);
  if (order) return order;
  const rows = column.values.map((v, r) => r).filter((r) => known(column.values[r]));
  const place = column.words ? column.values.map((v, r) => v + 0.6 * aside(r)) : column.values;
  rows.sort((a, b) => place[a] - place[b]);
  order = { rows, at: rows.map((r) => place[r]) };
  kOrders.set(column.values, order);
  return order;
}

/** Mean of y, twice its standard error, in so many classes of x, which ascends, with about as many rows each; or in those of words. */
export function classes(x, y, words, count = Math.max(4, Math.min(24, Math.floor(Math.sqrt(x.length) / 2)))) {
  const bins = [];
  if (words) {
    words.forEach((w, i) => bins.push({ at: i, y: [] }));
    x.forEach((v, k) => bins[Math.round(v)] && bins[Math.round(v)].y.push(y[k]));
  } else {
    for (let b = 0; b < count; ++b) {
      const from = Math.floor((b * x.length) / count), to = Math.floor(((b + 1) * x.length) / count);
      if (to - from < 3) continue;
      let sum = 0;
      for (let k = from; k < to; ++k) sum += x[k];
      bins.push({ at: sum / (to - from), y: y.slice(from, to) });
    }
  }
  return bins.filter((b) => b.y.length > 2).map((b) => {
    const mean = b.y.reduce((s, v) => s + v, 0) / b.y.length;
    const variance = b.y.reduce((s, v) => s + (v - mean) ** 2, 0) / (b.y.length - 1);
    return { at: b.at, mean, half: 2 * Math.sqrt(variance / b.y.length), count: b.y.length };
  });
}

/** `rows`: 1 where a row is drawn; `x`, `y`, `colour`: columns, `colour` may be null. */
export function Scatter({ x, y, colour, rows, label, onPick }) {
  const xf = shown(x.unit)[0], yf = shown(y.unit)[0];
  const drawn = useMemo(() => {
    const yv = y.values, order = orderOf(x), xs = [], ys = [], list = [], plain = [];
    for (let k = 0; k < order.rows.length; ++k) {
      const r = order.rows[k];
      if (!rows[r] || !known(yv[r])) continue;
      list.push(r);
      xs.push(order.at[k] * (x.words ? 1 : xf));
      plain.push(x.values[r] * (x.words ? 1 : xf));
      ys.push(yv[r] * yf);
    }
    return { order: list, xs, ys, bins: classes(plain, ys, x.words) };
  }, [x, y, rows, xf, yf]);

  const here = useRef(-1), plot = useRef(null); // the point that was picked, of those that are drawn
  useEffect(() => { here.current = -1; }, [drawn]);
  const take = (i) => {
    here.current = i;
    if (plot.current) plot.current.redraw();
    if (onPick) onPick(i < 0 ? -1 : drawn.order[i]);
  };
  const key = (event) => {
    const count = drawn.xs.length, far = Math.max(1, Math.round(count / 20)), last = here.current;
    const to = { ArrowRight: last + 1, ArrowLeft: last - 1, PageDown: last + far, PageUp: last - far, Home: 0, End: count - 1 }[event.key];
    if (to === undefined || !count) return;
    event.preventDefault();
    take(Math.max(0, Math.min(count - 1, to)));
  };

  const make = (c) => {
    const tint = colouring(colour, c);
    const numbers = drawn.order.map((r) => tint.of(r));
    const points = (u) => {
      const began = performance.now();
      const ctx = u.ctx, size = Math.max(2, Math.min(5, 260 / Math.sqrt(drawn.xs.length + 1))) * devicePixelRatio;
      const { left, top, width, height } = u.bbox, sx = u.scales.x, sy = u.scales.y;
      const kx = width / (sx.max - sx.min), ky = height / (sy.max - sy.min);
      const lists = tint.palette.map(() => []);
      for (let i = 0; i < numbers.length; ++i) lists[numbers[i]].push(i);
      ctx.save();
      ctx.beginPath();
      ctx.rect(left, top, width, height);
      ctx.clip();
      ctx.globalAlpha = drawn.xs.length > 3000 ? 0.55 : 0.8;
      lists.forEach((list, k) => {
        ctx.fillStyle = tint.palette[k];
        for (const i of list) ctx.fillRect(left + (drawn.xs[i] - sx.min) * kx - size / 2, top + (sy.max - drawn.ys[i]) * ky - size / 2, size, size);
      });
      ctx.globalAlpha = 1;
      ctx.strokeStyle = ctx.fillStyle = c.ink;
      ctx.lineWidth = 1.5 * devicePixelRatio;
      for (const b of drawn.bins) {
        const px = left + (b.at - sx.min) * kx, py = top + (sy.max - b.mean) * ky, half = b.half * ky;
        ctx.beginPath();
        ctx.moveTo(px, py - half);
        ctx.lineTo(px, py + half);
        ctx.stroke();
        ctx.beginPath();
        ctx.arc(px, py, 3.2 * devicePixelRatio, 0, 7);
        ctx.fill();
      }
      if (here.current >= 0) {
        ctx.beginPath();
        ctx.arc(left + (drawn.xs[here.current] - sx.min) * kx, top + (sy.max - drawn.ys[here.current]) * ky, 7 * devicePixelRatio, 0, 7);
        ctx.stroke();
      }
      ctx.restore();
      u.root.parentNode.dataset.pointsMs = (performance.now() - began).toFixed(1);
    };
    const pick = (u) => {
      u.over.addEventListener("click", (event) => {
        const px = event.offsetX, py = event.offsetY;
        let best = 144, nearest = -1;
        for (let i = 0; i < drawn.xs.length; ++i) {
          const d = (u.valToPos(drawn.xs[i], "x") - px) ** 2 + (u.valToPos(drawn.ys[i], "y") - py) ** 2;
          if (d < best) { best = d; nearest = i; }
        }
        take(nearest);
      });
    };
    const pad = (u, low, high) => { const span = high - low || 1; return [low - 0.04 * span, high + 0.04 * span]; };
    return [{
      scales: { x: { time: false, range: x.words ? [-0.6, x.words.length - 0.4] : pad }, y: { range: pad } },
      axes: [axis(c, x.name + (x.unit && !x.words ? ", " + unitOf(x.unit) : ""), x.words ? { splits: () => x.words.map((w, i) => i), values: () => x.words } : {}), axis(c, y.name + (/^residual/.test(y.name) ? " (measured \u2212 model)" : "") + ", " + unitOf(y.unit), { size: 62 })],
      series: [{}, { paths: () => null, points: { show: false } }],
      hooks: { draw: [points], ready: [pick] },
    }, [drawn.xs, drawn.ys], drawn.xs.map((v, i) => ({ x: v, y: drawn.ys[i], colour: tint.palette[numbers[i]] })).concat(drawn.bins.map((b) => ({ x: b.at, y: b.mean, half: b.half, colour: c.ink })))];
  };
  return h(Chart, { make, inputs: [drawn, colour, xf, yf], label, tall: true, onReady: (u) => { plot.current = u; }, onKey: key });
}

/** What the colours mean. */
export function Legend({ column, c }) {
  if (!column) return null;
  const tint = colouring(column, c);
  if (column.words) return h("div", { class: "legend" }, h("span", null, column.name + ": "), tint.names.slice(0, 16).map(([word, colour]) => h("span", { key: word }, h("i", { style: { background: colour } }), word)), tint.names.length > 16 ? h("span", null, "and " + (tint.names.length - 16) + " more") : null);
  const [low, high, unit] = tint.scale;
  return h("div", { class: "legend" }, h("span", null, column.name + ": "), h("span", null, num(low)), h("i", { class: "ramp", style: { background: "linear-gradient(to right," + tint.palette.slice(0, -1).join(",") + ")" } }), h("span", null, num(high) + " " + unit));
}
