// The page: views, panels and controls are made when the planner has described the robot.

import { actions, commitDialog, showDock } from "./attempts.js";
import { byId, download, el, setText } from "./dom.js";
import { listen, pollGamepad } from "./input.js";
import { removeSelected } from "./obstacles.js";
import { meshSwitch } from "./meshes.js";
import { readColours } from "./palette.js";
import { showPanels } from "./panels.js";
import { PlanarView } from "./planar.js";
import { steerPlanar } from "./planar_pointer.js";
import { drawPlots, showFigures } from "./plots.js";
import { connect, send, sendRaw } from "./socket.js";
import { SpatialView } from "./spatial.js";
import { steerSpatial } from "./spatial_pointer.js";
import { clearPath, emit, on, planar, select, state } from "./state.js";

window.planner = { state, send, select }; // for scripts and tests that drive the page

let view = null;
let dirty = true;
let last = 0; // when a picture was drawn [ms]
const REST = 300; // after which nothing is said to move [ms]
const redraw = () => (dirty = true);
const host = byId("view");

function draw(now) {
  pollGamepad(view);
  if (view && !dirty && now - last > REST) view.rest?.();
  if (view && dirty) {
    dirty = false;
    last = now;
    view.draw();
    state.drawn = (state.drawn ?? 0) + 1;
  }
  drawPlots();
  requestAnimationFrame(draw);
}

function resize() {
  if (!view) return;
  const { clientWidth, clientHeight } = host;
  if (clientWidth > 0 && clientHeight > 0) view.resize(clientWidth, clientHeight);
  redraw();
}

on("robot", () => {
  const { robot } = state.setup;
  byId("robot").textContent = `${robot.name} · ${robot.joints.length} joints`;
  document.title = `${robot.name} - jtik plan`;
  try {
    view = planar() ? new PlanarView(host) : new SpatialView(host);
  } catch (error) {
    host.replaceChildren(el("p", { class: "empty" }, error.message));
    return;
  }
  (planar() ? steerPlanar : steerSpatial)(view, redraw);
  window.planner.view = view;
  byId("tools").replaceChildren(
    ...(planar() ? [] : [meshSwitch(view, redraw)]),
    el("button", { onclick: fit, title: "Show everything" }, "Fit"),
    ...(planar() ? [] : [["Top", -Math.PI / 2, 1.54], ["Front", 0, 0.05], ["Side", -Math.PI / 2, 0.05]].map(([name, yaw, pitch]) => el("button", { onclick: () => { Object.assign(view, { yaw, pitch }); redraw(); } }, name))),
    el("button", { onclick: clearPath, title: "Forget the path walked" }, "Clear path"),
  );
  byId("hint").textContent = planar()
    ? "Drag the target · arrow keys or WASD · drag obstacles and their handles"
    : "Drag an arrow, a square or a ring · click an obstacle to move it · drag the ground to orbit";
});

function fit() {
  view.fit();
  redraw();
}

let fitted = false;
on("frame", () => {
  if (!fitted && view) {
    fitted = true;
    resize();
    fit();
  }
  redraw();
});
on("settings selected path overlays dragged attempts", redraw);

// Texts come 10 times a second, apart from the frames, so that they never go stale.
let heard = 0;
let marked = ""; // bodies and joints that are marked in the view
on("status", () => {
  heard = performance.now();
  const text = byId("status");
  const { words, rebuilding, violated, active_limits } = state.status;
  setText(text, violated?.length ? `${words}; too near: ${violated.slice(0, 3).join(", ")}${violated.length > 3 ? " ..." : ""}` : words);
  text.className = `status ${violated?.length ? "bad" : words.startsWith("at rest") ? "rest" : ""}`;
  byId("rebuilding").hidden = !rebuilding;
  const marks = JSON.stringify([violated, active_limits]);
  if (marks !== marked) redraw();
  marked = marks;
});

function showLink() {
  const alive = state.connected && performance.now() - heard < 1500;
  const link = byId("link");
  setText(link, alive ? "connected" : state.connected ? "waiting" : "offline");
  link.className = alive ? "link" : "link off";
}
on("connection", showLink);
setInterval(showLink, 500);

on("message", ({ level, text }) => {
  const note = el("p", { class: `toast ${level}` }, text);
  const node = byId("toasts");
  node.append(note);
  while (node.childElementCount > 4) node.firstChild.remove();
  setTimeout(() => note.remove(), level === "info" ? 5000 : 12000);
});

// Sessions that were not ended: the latest is offered.
on("sessions", ([latest]) => {
  const offer = byId("offer");
  offer.hidden = latest === undefined;
  if (!latest) return;
  const ended = new Date(1000 * latest.ended).toLocaleString();
  offer.replaceChildren(
    el("span", {}, `A session was not ended. Last written: ${ended}.`),
    el("button", { class: "primary", onclick: () => replacing(() => { send("recover", { session: latest.name }); offer.hidden = true; }) }, "Recover it"),
    el("button", { onclick: () => (offer.hidden = true) }, "Not now"),
  );
});

listen(host, () => view, {
  Space: actions.play,
  KeyR: actions.record,
  KeyF: () => fit(),
  Delete: removeSelected,
  Escape: () => send("hold_target", { velocity: Array(state.setup.robot.dimension).fill(0) }),
});

byId("save").onclick = () => download("plan.json").catch((error) => emit("message", { level: "error", text: error.message }));
byId("load").onclick = () => byId("file").click();
byId("file").onchange = async ({ target }) => {
  const [file] = target.files;
  if (file) {
    const text = await file.text();
    replacing(() => sendRaw({ type: "load_plan", name: file.name, text }));
  }
  target.value = "";
};

// Do what replaces the attempts, once the operator has agreed where there are any.
function replacing(act) {
  if (state.attempts.length === 0) return act();
  const dialog = byId("dialog");
  const agreed = () => {
    dialog.close();
    act();
  };
  dialog.replaceChildren(
    el("h2", {}, "Replace the attempts?"),
    el("p", { class: "note" }, `The plan has ${state.attempts.length} of them. Save it first to keep them.`),
    el("div", { class: "row" }, el("button", { class: "primary", id: "replace", onclick: agreed }, "Replace them"), el("button", { onclick: () => dialog.close() }, "Keep them")));
  dialog.showModal();
}

const KEYS = [
  ["← ↑ → ↓, W A S D", "move the target while a key is down"], ["Q E, Page keys", "move it down and up (spatial robots)"],
  ["[ ]", "move along the self-motion; the end effector stays"], ["R", "record, stop"], ["Space", "play, pause"], ["F", "show everything"],
  ["Delete", "delete the obstacle that is selected"], ["Esc", "stop the target"],
  ["Gamepad", "left stick: the target; right stick: self-motion, and up and down"], ["Wheel, drag the ground", "zoom; pan (plane), orbit (space; with Shift: pan)"],
];
byId("help").onclick = () => {
  const dialog = byId("dialog");
  dialog.replaceChildren(
    el("h2", {}, "Keys and gamepad"), el("p", { class: "note" }, "Keys act while the view has the focus: click into it once."),
    el("table", { class: "keys" }, KEYS.map(([keys, does]) => el("tr", {}, el("th", {}, keys), el("td", {}, does)))),
    el("div", { class: "row" }, el("button", { onclick: () => dialog.close() }, "Close")));
  dialog.showModal();
};

// Dark or light: as the system says, until the switch is used.
const system = matchMedia("(prefers-color-scheme: dark)");
function theme() {
  const dark = localStorage.theme ? localStorage.theme === "dark" : system.matches;
  document.documentElement.dataset.theme = dark ? "dark" : "light";
  byId("theme").textContent = dark ? "Light" : "Dark";
  readColours();
  redraw();
}
byId("theme").onclick = () => {
  localStorage.theme = document.documentElement.dataset.theme === "dark" ? "light" : "dark";
  theme();
};
system.addEventListener("change", theme);

theme();
showPanels(byId("edit"));
showFigures(byId("see"));
on("robot", () => showDock(byId("dock")));
new ResizeObserver(resize).observe(host);
connect();
requestAnimationFrame(draw);
host.focus();
Object.assign(window.planner, { commitDialog, emit });
