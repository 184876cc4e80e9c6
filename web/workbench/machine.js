// The machine and what was measured on it, in three dimensions. Turned by drag or arrow keys, nearer with the wheel or + and −.

import { h } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import { colours, useTheme } from "./parts.js";
import { useDocument } from "./server.js";
import { text } from "./units.js";

const kMillimetre = 1000;
let THREE = null, readMeshes = null; // fetched when something is to be drawn: the other views are there sooner without it

const numbers = (text, count) => { const list = (text || "").trim().split(/\s+/).map(Number); return list.length === count && list.every(Number.isFinite) ? list : Array(count).fill(0); };

/** A URDF as a tree of three's objects, lengths in mm. A mesh that could not be read is not drawn. */
export function readMachine(urdf, c, meshes) {
  const xml = new DOMParser().parseFromString(urdf, "application/xml");
  const links = new Map(), moving = new Map(), children = new Set();
  const place = (node, element) => {
    const origin = element && element.querySelector(":scope > origin");
    const xyz = numbers(origin && origin.getAttribute("xyz"), 3), [roll, pitch, yaw] = numbers(origin && origin.getAttribute("rpy"), 3);
    node.position.set(...xyz.map((v) => v * kMillimetre));
    node.quaternion.setFromEuler(new THREE.Euler(roll, pitch, yaw, "ZYX"));
  };
  for (const link of xml.querySelectorAll("robot > link")) {
    const group = new THREE.Group();
    for (const visual of link.querySelectorAll(":scope > visual")) {
      const shape = shapeOf(visual, meshes);
      if (!shape) continue;
      const rgba = numbers((visual.querySelector("material > color") || { getAttribute: () => "" }).getAttribute("rgba"), 4);
      const mesh = new THREE.Mesh(shape, new THREE.MeshLambertMaterial({ color: rgba[3] ? new THREE.Color(rgba[0], rgba[1], rgba[2]) : new THREE.Color(c.soft), side: THREE.DoubleSide })); // a mesh may be mirrored
      place(mesh, visual);
      if (visual.querySelector("cylinder")) mesh.quaternion.multiply(new THREE.Quaternion().setFromAxisAngle(new THREE.Vector3(1, 0, 0), Math.PI / 2));
      group.add(mesh);
    }
    links.set(link.getAttribute("name"), group);
  }
  for (const joint of xml.querySelectorAll("robot > joint")) {
    const parent = links.get(joint.querySelector("parent")?.getAttribute("link")), child = links.get(joint.querySelector("child")?.getAttribute("link"));
    if (!parent || !child) continue;
    const fixed = new THREE.Group(), frame = new THREE.Group();
    place(fixed, joint);
    fixed.add(frame);
    frame.add(child);
    parent.add(fixed);
    children.add(child);
    const axis = new THREE.Vector3(...numbers(joint.querySelector("axis")?.getAttribute("xyz") || "1 0 0", 3)).normalize();
    moving.set(joint.getAttribute("name"), { frame, axis, prismatic: joint.getAttribute("type") === "prismatic" });
  }
  const root = new THREE.Group();
  for (const link of links.values()) if (!children.has(link)) root.add(link);
  const set = (joint, reading) => { // mm or deg
    const m = moving.get(joint);
    if (!m || !known(reading)) return;
    if (m.prismatic) m.frame.position.copy(m.axis).multiplyScalar(reading);
    else m.frame.quaternion.setFromAxisAngle(m.axis, (reading * Math.PI) / 180);
  };
  // what belongs to the workpiece moves with it
  const settle = () => {
    const workpiece = links.get("workpiece");
    root.updateMatrixWorld(true);
    if (!workpiece) return;
    root.matrixAutoUpdate = false;
    root.matrix.premultiply(workpiece.matrixWorld.clone().invert());
    root.updateMatrixWorld(true);
  };
  return { root, set, settle };
}

function shapeOf(visual, meshes) {
  const file = visual.querySelector("geometry > mesh"), found = file && meshes.get(file.getAttribute("filename"));
  if (found && found.corners) {
    const scale = file.hasAttribute("scale") ? numbers(file.getAttribute("scale"), 3) : [1, 1, 1], geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(found.corners.map((v, i) => v * scale[i % 3] * kMillimetre), 3));
    geometry.computeVertexNormals();
    return geometry;
  }
  const box = visual.querySelector("geometry > box"), cylinder = visual.querySelector("geometry > cylinder"), sphere = visual.querySelector("geometry > sphere");
  if (box) return new THREE.BoxGeometry(...numbers(box.getAttribute("size"), 3).map((v) => v * kMillimetre));
  if (cylinder) return new THREE.CylinderGeometry(...[0, 1].map(() => Number(cylinder.getAttribute("radius")) * kMillimetre), Number(cylinder.getAttribute("length")) * kMillimetre, 20);
  if (sphere) return new THREE.SphereGeometry(Number(sphere.getAttribute("radius")) * kMillimetre, 20, 12);
  return null;
}

/** A word in the picture, of the same size however far it is. */
function word(text, at, c) {
  const canvas = document.createElement("canvas"), pen = canvas.getContext("2d"), font = "600 36px system-ui, sans-serif";
  pen.font = font;
  canvas.width = Math.ceil(pen.measureText(text).width) + 16;
  canvas.height = 52;
  pen.font = font;
  pen.fillStyle = c.card;
  pen.globalAlpha = 0.75;
  pen.fillRect(0, 0, canvas.width, canvas.height);
  pen.globalAlpha = 1;
  pen.fillStyle = c.ink;
  pen.textBaseline = "middle";
  pen.fillText(text, 8, 27);
  const sprite = new THREE.Sprite(new THREE.SpriteMaterial({ map: new THREE.CanvasTexture(canvas), sizeAttenuation: false, depthTest: false }));
  sprite.material.map.colorSpace = THREE.SRGBColorSpace;
  sprite.scale.set((0.032 * canvas.width) / canvas.height, 0.032, 1);
  sprite.position.set(...at);
  return sprite;
}

function discard(object) {
  if (object.geometry) object.geometry.dispose();
  if (!object.material) return;
  if (object.material.map) object.material.map.dispose();
  object.material.dispose();
}

/** Points: { at: [x…, y…, z…] interleaved, colours: rgb interleaved 0…1 }; lines: the same, two ends each. A ball with `label` has
 * its name beside it. `mark`: where a tip stands now, { at, radius_mm }. */
export function Space({ urdf, joints, readings, points, lines, balls, mark, label, note }) {
  const place = useRef(null), world = useRef(null);
  const [without, setWithout] = useState(false), [arrow, setArrow] = useState(null), [ready, setReady] = useState(THREE !== null);
  const theme = useTheme(), file = useDocument("meshes"), [meshes, setMeshes] = useState(new Map());
  useEffect(() => {
    let here = true;
    if (!ready) Promise.all([import("three"), import("./meshes.js")]).then(([library, reading]) => { THREE = library; readMeshes = reading.readMeshes; if (here) setReady(true); });
    return () => { here = false; };
  }, []);
  useEffect(() => {
    let here = true;
    if (ready) readMeshes(file).then((read) => { if (here) setMeshes(read); });
    return () => { here = false; };
  }, [file, ready]);

  useEffect(() => {
    if (!ready) return undefined;
    let renderer;
    try {
      renderer = new THREE.WebGLRenderer({ antialias: true, alpha: true, preserveDrawingBuffer: true });
    } catch (error) {
      setWithout(true);
      return undefined;
    }
    const c = colours(), scene = new THREE.Scene(), camera = new THREE.PerspectiveCamera(35, 1, 0.5, 20000);
    camera.up.set(0, 0, 1);
    scene.add(new THREE.HemisphereLight(0xffffff, 0x888888, 2.4));
    const sun = new THREE.DirectionalLight(0xffffff, 1.2);
    sun.position.set(1, -2, 3);
    scene.add(sun);
    place.current.prepend(renderer.domElement);
    const view = { turn: -0.6, tilt: 0.45, far: 120, centre: new THREE.Vector3() };
    const w = { renderer, scene, camera, view, c, frame: 0, times: [], machine: null, content: new THREE.Group() };
    scene.add(w.content);
    const drawNow = () => {
      const began = performance.now(), { turn, tilt, far, centre } = view;
      camera.position.set(centre.x + far * Math.cos(tilt) * Math.sin(turn), centre.y - far * Math.cos(tilt) * Math.cos(turn), centre.z + far * Math.sin(tilt));
      camera.lookAt(centre);
      renderer.render(scene, camera);
      w.times.push(performance.now() - began);
      if (w.times.length > 120) w.times.shift();
      if (place.current) place.current.dataset.frameMs = (w.times.reduce((a, b) => a + b, 0) / w.times.length).toFixed(2);
    };
    w.draw = () => {
      if (!w.frame) w.frame = requestAnimationFrame(() => { w.frame = 0; drawNow(); });
    };
    const size = () => {
      if (!place.current) return;
      const width = place.current.clientWidth, height = Math.max(260, Math.min(460, width * 0.62));
      renderer.setPixelRatio(Math.min(2, devicePixelRatio));
      renderer.setSize(width, height);
      camera.aspect = width / height;
      camera.updateProjectionMatrix();
      drawNow(); // another size empties the canvas: nobody shall see it empty
    };
    const watch = new ResizeObserver(size);
    watch.observe(place.current);
    const canvas = renderer.domElement;
    canvas.style.touchAction = "pan-y";
    let from = null;
    canvas.onpointerdown = (e) => { from = [e.clientX, e.clientY]; canvas.setPointerCapture(e.pointerId); };
    canvas.onpointermove = (e) => {
      if (!from) return;
      view.turn -= (e.clientX - from[0]) * 0.008;
      view.tilt = Math.min(1.55, Math.max(-1.55, view.tilt + (e.clientY - from[1]) * 0.008));
      from = [e.clientX, e.clientY];
      w.draw();
    };
    canvas.onpointerup = canvas.onpointercancel = () => { from = null; };
    canvas.addEventListener("wheel", (e) => { if (!e.ctrlKey && !e.metaKey && document.activeElement !== place.current) return; e.preventDefault(); view.far *= Math.exp(e.deltaY * 0.001); w.draw(); }, { passive: false });
    world.current = w;
    size();
    return () => {
      watch.disconnect();
      cancelAnimationFrame(w.frame);
      scene.traverse(discard);
      renderer.dispose();
      canvas.remove();
      world.current = null;
    };
  }, [theme, ready]);

  useEffect(() => { // the machine
    const w = world.current;
    if (!w || !urdf) return;
    if (w.machine) { w.scene.remove(w.machine.root); w.machine.root.traverse(discard); }
    w.machine = readMachine(urdf, w.c, meshes);
    w.scene.add(w.machine.root);
    if (place.current) place.current.dataset.meshes = [...meshes].filter(([name, m]) => m.corners && urdf.includes(name)).length;
    w.machine.settle();
    w.draw();
  }, [urdf, theme, ready, meshes]);

  useEffect(() => {
    const w = world.current;
    if (!w || !w.machine || !readings) return;
    joints.forEach((j, i) => w.machine.set(j.name, readings[i]));
    w.machine.root.matrix.identity();
    w.machine.settle();
    w.draw();
  }, [readings, urdf, theme, ready, meshes]);

  useEffect(() => { // what was measured
    const w = world.current;
    if (!w) return;
    for (const child of [...w.content.children]) { w.content.remove(child); discard(child); }
    const box = new THREE.Box3(), sets = [points, lines].filter((s) => s && s.at.length);
    for (const set of sets) {
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute("position", new THREE.Float32BufferAttribute(set.at, 3));
      geometry.setAttribute("color", new THREE.Float32BufferAttribute(set.colours, 3));
      geometry.computeBoundingBox();
      box.union(geometry.boundingBox);
      w.content.add(set === points ? new THREE.Points(geometry, new THREE.PointsMaterial({ size: 4, sizeAttenuation: false, vertexColors: true })) : new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ vertexColors: true })));
    }
    for (const ball of balls || []) {
      const sphere = new THREE.Mesh(new THREE.SphereGeometry(ball.radius_mm, 24, 16), new THREE.MeshLambertMaterial({ color: w.c.soft, transparent: true, opacity: 0.28, depthWrite: false }));
      sphere.position.set(...ball.centre_mm);
      w.content.add(sphere);
      if (ball.label) w.content.add(word(ball.label, [ball.centre_mm[0], ball.centre_mm[1], ball.centre_mm[2] + 1.6 * ball.radius_mm], w.c));
    }
    if (!box.isEmpty()) {
      const span = box.getSize(new THREE.Vector3()).length() || 1;
      box.getCenter(w.view.centre);
      w.view.far = 1.9 * span;
      const long = roundDown(0.2 * span), frame = new THREE.AxesHelper(long);
      frame.setColors(new THREE.Color("#d55e00"), new THREE.Color("#009e73"), new THREE.Color(w.c.blue));
      const corner = box.min.clone().addScalar(-0.06 * span); // beside what was measured, not in it
      frame.position.copy(corner);
      w.content.add(frame);
      ["x", "y", "z"].forEach((name, k) => w.content.add(word(name, corner.toArray().map((v, i) => v + (i === k ? 1.12 * long : 0)), w.c)));
      setArrow(long);
    }
    w.draw();
  }, [points, lines, balls, theme, ready]);

  useEffect(() => {
    const w = world.current;
    if (!w) return undefined;
    const ball = mark ? new THREE.Mesh(new THREE.SphereGeometry(mark.radius_mm, 20, 14), new THREE.MeshLambertMaterial({ color: new THREE.Color(w.c.accent) })) : null;
    if (ball) { ball.position.set(...mark.at); w.scene.add(ball); }
    w.draw();
    return () => { if (ball) { w.scene.remove(ball); discard(ball); } };
  }, [mark, theme, ready]);

  const missing = urdf ? [...meshes].filter(([name, m]) => m.why && urdf.includes(name)) : [];

  const key = (e) => {
    const w = world.current;
    if (!w) return;
    const turn = { ArrowLeft: [0.12, 0], ArrowRight: [-0.12, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] }[e.key];
    if (turn) { w.view.turn += turn[0]; w.view.tilt = Math.min(1.55, Math.max(-1.55, w.view.tilt + turn[1])); }
    else if (e.key === "+" || e.key === "-") w.view.far *= e.key === "+" ? 0.85 : 1.18;
    else return;
    e.preventDefault();
    w.draw();
  };
  if (without) return h("p", { class: "empty" }, "This browser has no WebGL, so the machine is not drawn; every figure stands in the tables.");
  return h("figure", { class: "space" }, h("div", { class: "canvas", ref: place, tabindex: 0, role: "img", "aria-label": label + ". Arrow keys turn it, plus and minus come nearer.", onKeyDown: key }),
    h("figcaption", null, note ? note + " " : "", arrow ? "The arrows x, y, z are " + text(arrow, "mm", 2) + " long. " : "", "Drag or arrow keys turn it, + and − come nearer.",
      missing.length ? h("span", { class: "missing" }, " Not drawn: " + missing.map(([name, m]) => name + " (" + m.why + ")").join("; ") + ".") : null));
}

/** A colour "#rrggbb" as three of them from 0 to 1, as the screen adds light. */
export const rgb = (css) => [1, 3, 5].map((at) => { const v = parseInt(css.slice(at, at + 2), 16) / 255; return v < 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4; });

const kLow = rgb("#2166ac"), kMiddle = rgb("#b8b8b8"), kHigh = rgb("#c9440e");
/** Blue, grey, orange: a value between −limit and +limit. */
export function diverging(value, limit, out) {
  const share = Math.min(1, Math.max(-1, value / limit)), end = share < 0 ? kLow : kHigh, much = Math.abs(share);
  out.push(...kMiddle.map((v, k) => v + much * (end[k] - v)));
}
