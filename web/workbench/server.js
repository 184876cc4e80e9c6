// What the page knows of the server: the live state, the documents that changed, and how to ask for an action.

import { useEffect, useState } from "preact/hooks";

const token = new URLSearchParams(location.search).get("token") || "";
const headers = { "X-Workbench-Token": token };
const address = (path) => path + (path.includes("?") ? "&" : "?") + "token=" + encodeURIComponent(token);

export const state = { connected: false, client: 0, live: null, frames: 0, sequence: 0 };
const documents = new Map(); // name -> { number, value, wanted }
const listeners = new Set();
const ends = new Map(); // number of a task -> who waits for it
const kAskAgain = 500; // ms after a document could not be had
let socket = null, retry = 0, drawn = false;

/** Everybody draws once a frame of the screen, however many states came meanwhile. */
function changed() {
  if (drawn) return;
  drawn = true;
  requestAnimationFrame(() => {
    drawn = false;
    for (const tell of [...listeners]) tell();
  });
}

/** Draws its component again when the live state or a document is new. */
export function useNews() {
  const [, set] = useState(0);
  useEffect(() => {
    const tell = () => set((n) => n + 1);
    listeners.add(tell);
    return () => listeners.delete(tell);
  }, []);
}

/** A document of the server, null as long as there is none. */
export function useDocument(name) {
  useNews();
  let entry = documents.get(name);
  if (!entry) documents.set(name, (entry = { number: 0, value: null, wanted: true, asking: -1 }));
  useEffect(() => { entry.wanted = true; look(name); }, [name]);
  return entry.value;
}

/** Asks for a document that has changed; for one at a time of each name, and after it for what is newer. */
async function look(name) {
  const entry = documents.get(name);
  const number = state.live ? state.live.documents[name] || 0 : 0;
  if (!entry || !entry.wanted || !state.live || entry.number === number || entry.asking >= 0) return;
  if (!number) {
    Object.assign(entry, { number: 0, value: null });
    return changed();
  }
  entry.asking = number;
  let pause = 0;
  try {
    const answer = await fetch(address("/data/" + name), { headers });
    if (!answer.ok && answer.status !== 404) throw new Error("the server answered " + answer.status);
    const type = answer.headers.get("Content-Type") || "";
    const value = !answer.ok ? null : await (type.includes("json") ? answer.json() : type.includes("octet-stream") ? answer.arrayBuffer() : answer.text());
    Object.assign(entry, { number, value });
  } catch (error) {
    pause = kAskAgain; // what is shown stays until then
  }
  changed();
  setTimeout(() => { entry.asking = -1; look(name); }, pause);
}

/** Number of a document that is not read here, 0 as long as there is none. */
export function useNumber(name) {
  useNews();
  return state.live ? state.live.documents[name] || 0 : 0;
}

/** Whether the latest of a document that is read here has come. */
export const isLatest = (name) => { const entry = documents.get(name); return !!entry && !!state.live && entry.number === (state.live.documents[name] || 0); };

/** Address of a document to open or keep. */
export const documentAddress = (name) => address("/data/" + name);
export const downloadAddress = (name) => address("/download/" + name);

export const name = { get: () => localStorage.getItem("mm-who") || "", set: (text) => localStorage.setItem("mm-who", text) };

/** Asks for an action. Resolves with { ok, message } when it has ended. */
export async function act(action, body = {}) {
  const whole = Object.assign({ who: name.get() }, body);
  return finish(await send("/action/" + action, JSON.stringify(whole)));
}

/** Sends a file. */
export async function upload(file) {
  return finish(await send("/upload?name=" + encodeURIComponent(file.name) + "&who=" + encodeURIComponent(name.get()), file));
}

async function finish(answer) {
  if (!answer.number) return answer;
  return new Promise((resolve) => ends.set(answer.number, resolve));
}

async function send(path, body) {
  try {
    const answer = await fetch(address(path), { method: "POST", headers, body });
    const json = await answer.json().catch(() => ({ message: "the server answered " + answer.status }));
    return Object.assign({ ok: answer.ok }, json);
  } catch (error) {
    return { ok: false, message: "the workbench does not answer; is it still running?" };
  }
}

export async function judge(direction, formula, start) {
  return send("/formula", JSON.stringify({ direction, formula, start }));
}

function take(message) {
  const news = JSON.parse(message);
  if (news.client) state.client = news.client;
  if (!news.documents) return;
  state.live = news;
  state.frames += 1;
  state.sequence = news.sequence;
  for (const [number, wait] of ends) {
    const end = news.ended.find((one) => one.number === number);
    if (!end && (number > news.asked || news.pending.includes(number))) continue;
    ends.delete(number);
    // without an end: it came while this page was not connected, and is not told any more
    wait(end || { ok: false, message: "the result was not received; see the log in the view History" });
  }
  for (const name of documents.keys()) look(name);
  changed();
}

export function connect() {
  socket = new WebSocket(address((location.protocol === "https:" ? "wss://" : "ws://") + location.host + "/live"));
  socket.onopen = () => { state.connected = true; retry = 0; changed(); };
  socket.onmessage = (event) => take(event.data);
  socket.onclose = () => {
    state.connected = false;
    changed();
    retry = Math.min(retry + 1, 6);
    setTimeout(connect, 250 * 2 ** retry);
  };
}

// The machine is held by this page as long as this is heard.
setInterval(() => {
  if (state.live && state.live.armed && state.live.armed.client === state.client && socket.readyState === WebSocket.OPEN) socket.send("heartbeat");
}, 250);
