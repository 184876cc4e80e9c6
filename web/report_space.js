// Residual vectors in space.

const kScale = [["0", "#2166ac"], ["0.5", "#b8b8b8"], ["1", "#b2182b"]], kSize = [["0", "#8fb8de"], ["0.5", "#7a62a8"], ["1", "#b2182b"]];

/** So large that 95 % of the vectors are at most a tenth of the measured volume. */
function exaggerationFor(v, state) {
  const size = quantile(state.vector_um.map((d) => Math.hypot(...d)), 0.95) / 1000;
  return size > 0 ? Math.max(1, roundDown((0.1 * longestSide(v.at_mm)) / size)) : 1000;
}

function spaceSection(v) {
  const own = v.states.map((s) => exaggerationFor(v, s));
  let state = 0, exaggeration = own[0];
  const limit = Math.max(quantile(v.states[0].value_um.map(Math.abs), 0.98) || 0, 1e-3);
  const said = el("p", { class: "note", "aria-live": "polite" });
  const say = () => {
    const values = v.states[state].value_um;
    const rms = Math.sqrt(values.reduce((sum, x) => sum + x * x, 0) / values.length);
    said.textContent = "Vectors are drawn " + drawnLonger(exaggeration) + ": 1 mm in the picture is " + num(1000 / exaggeration) +
      " µm. RMS of those shown: " + num(rms) + " µm, outliers included. Drawn: " + v.at_mm.length + " of " + v.observations +
      " measurements. Colours end at ± " + num(limit) + " µm for every choice.";
  };
  // one ball measured at many places close together: spheres upon spheres would hide everything
  const overlapping = v.balls.some((a, i) => v.balls.some((b, k) => k < i && Math.hypot(...a.centre_mm.map((x, m) => x - b.centre_mm[m])) < 0.9 * (a.radius_mm + b.radius_mm)));
  const label = "Residual vectors in space for " + v.at_mm.length + " measurements";
  const make = (c) => {
    const s = v.states[state], xyz = [[], [], []], colours = [], ends = [[], [], []], texts = [];
    v.at_mm.forEach((p, i) => {
      for (let k = 0; k < 3; ++k) {
        const tip = p[k] + (s.vector_um[i][k] / 1000) * exaggeration;
        xyz[k].push(p[k], tip, null);
        ends[k].push(tip);
      }
      const shade = v.signed ? s.value_um[i] : Math.abs(s.value_um[i]);
      colours.push(shade, shade, shade);
      texts.push((v.feature[i] ? plain(v.feature[i]) + ", " : "") + "row " + v.row[i] + ": " + num(s.value_um[i]) + " µm" + (v.outlier[i] ? " (outlier)" : ""));
    });
    const scale = { cmin: v.signed ? -limit : 0, cmax: limit, colorscale: v.signed ? kScale : kSize };
    const shades = colours.filter((x, i) => i % 3 === 0);
    if (!hasWebGl) {
      return [[{ type: "scatter", mode: "lines", x: xyz[0], y: xyz[1], line: { color: c.accent, width: 1 }, hoverinfo: "skip" },
        { type: "scatter", mode: "markers", x: ends[0], y: ends[1], text: texts, hovertemplate: "%{text}<extra></extra>", marker: Object.assign({ size: 4, color: shades }, scale) }],
      { xaxis: { title: titled("x, mm"), scaleanchor: "y" }, yaxis: { title: titled("y, mm") } }];
    }
    const balls = v.balls.map((b) => ({ type: "scatter3d", mode: "markers", x: [b.centre_mm[0]], y: [b.centre_mm[1]], z: [b.centre_mm[2]], marker: { size: 3, color: c.soft, symbol: "cross" }, text: [plain(b.name)], hovertemplate: "%{text}<extra></extra>" }));
    const spheres = overlapping ? [] : v.balls.map((b) => sphere(b, c));
    const axis = (name) => ({ title: { text: name + ", mm" }, gridcolor: c.line, zerolinecolor: c.line, color: c.ink, backgroundcolor: "rgba(0,0,0,0)" });
    return [[...spheres, ...balls,
      { type: "scatter3d", mode: "lines", x: xyz[0], y: xyz[1], z: xyz[2], line: Object.assign({ width: 4, color: colours }, scale), hoverinfo: "skip" },
      { type: "scatter3d", mode: "markers", x: ends[0], y: ends[1], z: ends[2], text: texts, hovertemplate: "%{text}<extra></extra>",
        marker: Object.assign({ size: 2.5, color: shades, showscale: true, colorbar: Object.assign({ title: { text: "µm" }, thickness: 12, len: 0.7, tickfont: { color: c.ink } }, narrow() ? { orientation: "h", x: 0.5, y: 0, yanchor: "bottom", title: { text: "µm", side: "top" } } : { x: 1 }) }, scale) }],
    { margin: { l: 0, r: 0, t: 0, b: 0 }, uirevision: "keep", scene: { aspectmode: "data", xaxis: axis("x"), yaxis: axis("y"), zaxis: axis("z"), camera: { eye: narrow() ? { x: 1.75, y: -2.1, z: 1.25 } : { x: 1.35, y: -1.6, z: 0.95 }, center: { x: 0, y: 0, z: -0.12 } } } }];
  };
  const fig = figure({ kind: "space", label, make, modeBar: true,
    caption: (v.signed ? "Each line starts at the touched point and runs along the ball's normal: outwards (red) where the machine found the surface too far out, inwards (blue) where too far in. Found minus true has the opposite sign of a residual along an axis (actual \u2212 indicated)." :
      "Each line runs from where the target should be to where the machine found it; found minus true has the opposite sign of a residual along an axis (actual \u2212 indicated).") + (hasWebGl ? (overlapping ? " The balls overlap: only their centres are drawn." : "") + " Drag to turn." : " This browser has no WebGL: seen from above.") });
  const change = () => { say(); fig.draw(); };
  const select = el("select", { id: "exaggeration" });
  for (const value of [...new Set(own)].sort((a, b) => a - b)) select.append(el("option", { value }, value === 1 ? "none" : grouped(value) + " times"));
  select.value = exaggeration;
  select.addEventListener("change", () => { exaggeration = Number(select.value); change(); });
  const radios = v.states.map((s, i) => {
    const input = el("input", { type: "radio", name: "state", id: "state" + i, value: i });
    input.checked = i === 0;
    input.addEventListener("change", () => { state = i; change(); });
    return el("span", {}, input, " ", el("label", { for: "state" + i }, s.name));
  });
  say();
  return [el("div", { class: "controls" }, el("fieldset", {}, el("legend", {}, "Show"), radios),
    own.length > 1 ? el("span", {}, el("label", { for: "exaggeration" }, "Exaggeration "), select) : null), fig.node, said];
}

function sphere(ball, c) {
  const n = 12, x = [], y = [], z = [];
  for (let i = 0; i <= n; ++i) {
    const rows = [[], [], []], polar = (Math.PI * i) / n;
    for (let j = 0; j <= 2 * n; ++j) {
      const turn = (Math.PI * j) / n;
      rows[0].push(ball.centre_mm[0] + ball.radius_mm * Math.sin(polar) * Math.cos(turn));
      rows[1].push(ball.centre_mm[1] + ball.radius_mm * Math.sin(polar) * Math.sin(turn));
      rows[2].push(ball.centre_mm[2] + ball.radius_mm * Math.cos(polar));
    }
    x.push(rows[0]); y.push(rows[1]); z.push(rows[2]);
  }
  return { type: "surface", x, y, z, opacity: 0.25, showscale: false, hoverinfo: "skip", colorscale: [["0", c.soft], ["1", c.soft]], contours: { x: { highlight: false }, y: { highlight: false }, z: { highlight: false } } };
}
