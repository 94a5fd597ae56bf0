// The connection to the planner: texts and frames come in, edits go out. It is opened again when it is lost.

import { clearPath, emit, read, state, walk } from "./state.js";

const MODES = ["live", "playing", "scrubbing", "paused"];
const HEADER = 8;

let socket = null;
let wait = 250;
let known = ""; // the robot, as text

export function send(edit, fields = {}) {
  if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify({ edit, ...fields }));
}

export function sendRaw(document) {
  if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify(document));
}

export function connect() {
  const scheme = location.protocol === "https:" ? "wss" : "ws";
  socket = new WebSocket(`${scheme}://${location.host}/socket`);
  socket.binaryType = "arraybuffer";
  socket.onopen = () => {
    wait = 250;
    setConnected(true);
    sendRaw({ type: "hello" });
  };
  socket.onmessage = ({ data }) => (typeof data === "string" ? readText(JSON.parse(data)) : readFrame(data));
  socket.onclose = () => {
    setConnected(false);
    setTimeout(connect, wait);
    wait = Math.min(4000, 2 * wait);
  };
}

function setConnected(connected) {
  state.connected = connected;
  emit("connection");
}

function readText(document) {
  if (document.type === "setup") {
    readSetup(document);
  } else if (document.type === "settings") {
    readSettings(document);
  } else if (document.type === "status") {
    state.status = document;
    emit("status");
  } else if (document.type === "attempts") {
    const before = new Set(state.attempts.map(({ name }) => name));
    state.attempts = document.attempts;
    const added = state.attempts.filter(({ name }) => before.size > 0 && !before.has(name));
    // What was just recorded is the one to work on; what was resolved meanwhile takes nobody's choice away.
    if (added.length && (state.recorded || state.frame?.recording)) state.attempt = added.at(-1).name;
    if (added.length) state.recorded = false;
    const names = state.attempts.map((attempt) => attempt.name);
    if (!names.includes(state.attempt)) state.attempt = names.at(-1) ?? null;
    for (const name of state.overlays) if (!names.includes(name)) state.overlays.delete(name);
    emit("attempts");
  } else if (document.type === "sessions") {
    emit("sessions", document.sessions);
  } else if (document.type === "message") {
    emit("message", document);
  }
}

// The panels are made when both are here. Another robot is another page.
function readSetup(document) {
  const text = JSON.stringify(document.robot);
  if (state.setup !== null && text !== known) return location.reload();
  known = text;
  state.setup = read(document);
}

function readSettings(settings) {
  const first = state.settings === null;
  state.settings = settings;
  if (first) {
    clearPath();
    emit("robot");
  }
  emit("settings");
}

// Float32: tick, time, mode, recording, d, nq, frames, time shown; target (7); q; poses (frames, 7).
function readFrame(buffer) {
  if (state.settings === null) return;
  const data = new Float32Array(buffer);
  const [tick, time, mode, recording, , nq, frames, shown] = data;
  const q = HEADER + 7;
  if (frames !== state.setup.frames.length) return;
  const before = state.frame;
  state.frame = {
    tick,
    time,
    mode: MODES[mode],
    recording: recording > 0,
    shown,
    position: data.subarray(HEADER, HEADER + 3),
    orientation: data.subarray(HEADER + 3, HEADER + 7),
    q: data.subarray(q, q + nq),
    poses: data.subarray(q + nq, q + nq + 7 * frames),
    received: performance.now(),
  };
  const another = before !== null && tick < before.tick; // session, of a planner that was started again
  if (another || (state.frame.recording && !before?.recording)) clearPath();
  if (before?.recording && !state.frame.recording) state.recorded = true;
  if (state.frame.mode === "live") walk(state.frame);
  if (before?.mode !== state.frame.mode || before?.recording !== state.frame.recording) emit("mode");
  emit("frame");
}
