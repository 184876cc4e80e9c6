// The meshes of a machine: files as the server sends them, read by three's loaders. Fetched with three.

import { STLLoader } from "three/loaders/STLLoader.js";
import { OBJLoader } from "three/loaders/OBJLoader.js";
import { ColladaParser } from "three/loaders/ColladaParser.js";
import { ColladaComposer } from "three/loaders/ColladaComposer.js";

/** In m by the file's own unit, in the axes of the file as RViz takes them: three's ColladaLoader would turn it. Without loaders of
 * pictures no other file is asked for. */
function colladaScene(text) {
  const read = new ColladaParser().parse(text);
  if (!read) throw new Error("it is no XML");
  const { scene } = new ColladaComposer(read.library, read.collada).compose();
  scene.scale.multiplyScalar(read.asset.unit);
  return scene;
}

/** Corners of all triangles under an object, three numbers each. */
function cornersOf(object) {
  const parts = [];
  object.updateMatrixWorld(true);
  object.traverse((part) => {
    if (part.isMesh && part.geometry.attributes.position) parts.push(part.geometry.clone().applyMatrix4(part.matrixWorld).attributes.position.array);
  });
  const corners = new Float32Array(parts.reduce((sum, part) => sum + part.length, 0));
  let at = 0;
  for (const part of parts) { corners.set(part, at); at += part.length; }
  return corners;
}

/** Corners in m of a file's triangles, in the axes of the file; of an OBJ without its lines and points, for which three would take the
 * whole object. @param kind ".stl", ".dae" or ".obj". @throw Error: why it is not drawn. */
export function meshCorners(kind, bytes) {
  let corners;
  try {
    if (kind === ".stl") corners = new STLLoader().parse(bytes).attributes.position.array;
    else corners = cornersOf(kind === ".dae" ? colladaScene(new TextDecoder().decode(bytes)) : new OBJLoader().parse(new TextDecoder().decode(bytes).replace(/^\s*[lp]\s.*$/gm, "")));
  } catch (error) {
    throw new Error("is not read: " + error.message);
  }
  if (!corners.length || corners.length % 9) throw new Error("has no triangles");
  if (!corners.every(Number.isFinite)) throw new Error("has a vertex that is not finite");
  return corners;
}

let last = { file: null, meshes: Promise.resolve(new Map()) }; // several views draw the same machine

async function readAll(file) {
  const meshes = new Map();
  if (!file) return meshes;
  const size = new DataView(file).getUint32(0, true), head = JSON.parse(new TextDecoder().decode(new Uint8Array(file, 4, size)));
  for (const m of head.meshes) {
    await new Promise((then) => { setTimeout(then); }); // one at a time: what else the page does must not wait for all of them
    try {
      if (m.why) throw new Error(m.why);
      meshes.set(m.name, { corners: meshCorners(m.kind, file.slice(4 + size + m.first, 4 + size + m.first + m.count)) });
    } catch (error) {
      meshes.set(m.name, { why: error.message });
    }
  }
  return meshes;
}

/** A promise of the meshes that the server found for a URDF: name there → { corners } in m, or { why } there are none. */
export function readMeshes(file) {
  if (file !== last.file) last = { file, meshes: readAll(file) };
  return last.meshes;
}
