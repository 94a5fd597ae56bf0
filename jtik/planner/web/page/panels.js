// The panel to edit: target, obstacles, posture, strategy, criteria, limits. Each part sends edits and shows the setup.

import { choice, el, logField, numberField, part, shortNames, slider, toggle, words } from "./dom.js";
import { jog } from "./input.js";
import { obstaclePart } from "./obstacles.js";
import { optionFields, readOptions } from "./options.js";
import { send } from "./socket.js";
import { guided, on, state } from "./state.js";

export function showPanels(host) {
  const parts = [targetPart, obstaclePart, posturePart, weightsPart, strategyPart, criteriaPart, limitsPart];
  on("robot", () => host.replaceChildren(...parts.map((make) => make())));
}

function targetPart() {
  const d = state.setup.robot.dimension;
  const here = () => [...state.frame.position].slice(0, d);
  const fields = ["x", "y", "z"].slice(0, d).map((name, k) =>
    numberField(name, { unit: "m", step: 0.02 * state.setup.robot.reach, change: (value) => send("move_target", { position: here().map((v, i) => (i === k ? value : v)) }) }),
  );
  const speed = slider("speed", { min: 0.02 * state.setup.robot.reach, max: 1.5 * state.setup.robot.reach, unit: "m/s", change: (value) => send("set_target_speed", { speed: value }) });
  const jogs = slider("self-motion", {
    min: -1, max: 1, step: 0.02, change: jog,
    release: (set) => {
      jog(0);
      jogs.input.value = 0;
      set(0);
    },
  });
  jogs.node.classList.add("jog");
  jogs.set(0);
  jogs.node.title = "Moves along the self-motion: the end effector stays where it is";
  const show = () => fields.forEach((field, k) => state.frame && field.set(state.frame.position[k]));
  on("status", show); // ten times a second: figures that change with every picture cannot be read
  on("settings", () => speed.set(state.settings.target_speed[0]));
  const { tasks } = state.settings;
  const chosen = choice(tasks.map(({ name }) => [name, words(name)]), (task) => send("guide", { task }), { "aria-label": "task to guide" });
  on("settings", () => (chosen.value = guided().name));
  const several = el("div", { class: "row", title: "The others are held where their targets are" }, el("span", { class: "note" }, "guide"), chosen);
  return part("Target", [
    ...(tasks.length > 1 ? [several] : []),
    el("div", { class: "row" }, fields.map((field) => field.node)),
    speed.node,
    jogs.node,
    el("div", { class: "row" }, el("button", { onclick: () => send("hold_target", { velocity: Array(d).fill(0) }) }, "Stop")),
  ]);
}

function posturePart() {
  const joints = state.setup.joints.filter(({ scalar }) => scalar);
  const labels = shortNames(joints.map(({ name }) => name));
  const rows = joints.map(({ name, type, lower, upper }, k) =>
    slider(words(labels[k]), { min: lower, max: upper, unit: type === "prismatic" ? "m" : "rad", change: (value) => send("set_preferred", { joint: name, value }) }),
  );
  on("settings", () => rows.forEach((row, k) => row.set(state.settings.preferred[joints[k].index] ?? 0)));
  on("status", () => {
    if (state.frame) rows.forEach((row, k) => row.mark(state.frame.q[joints[k].index]));
  });
  return part("Preferred posture", [
    el("div", { class: "sliders" }, rows.map((row) => row.node)),
    el("div", { class: "row" }, el("button", { onclick: () => send("take_posture") }, "Take the present posture")),
  ]);
}

// Weights are built into a solver, so they are sent when a slider is let go.
function weightsPart() {
  const { joints } = state.setup;
  const labels = shortNames(joints.map(({ name }) => name));
  const rows = joints.map(({ name }, k) =>
    logField(words(labels[k]), { name: `weight of ${name}`, low: -2, high: 3, live: false, change: (weight) => send("set_joint_weights", { weights: { [name]: weight } }) }),
  );
  on("settings", () => rows.forEach((row, k) => row.show(state.settings.joint_weights[joints[k].velocity])));
  const equal = () => send("set_joint_weights", { weights: Object.fromEntries(joints.map(({ name }) => [name, 1])) });
  return part("Joint weights", [
    el("p", { class: "note" }, "A heavy joint moves less for the task."),
    el("div", { class: "weights" }, rows.map((row) => row.node)),
    el("div", { class: "row" }, el("button", { onclick: equal }, "Equal weights")),
  ], false);
}

function strategyPart() {
  const summary = el("p", { class: "note" });
  const box = el("div", { class: "options" });
  let fields = [];
  const chosen = choice(state.setup.strategies.map(({ name }) => [name, words(name)]), (name) => {
    send("set_strategy", { name, options: {} });
  }, { "aria-label": "strategy" });
  let shown = "";
  on("settings", () => {
    const { name, options } = state.settings.strategy;
    const text = JSON.stringify([name, options]);
    if (text === shown) return;
    shown = text;
    chosen.value = name;
    const known = state.setup.strategies.find((each) => each.name === name);
    summary.textContent = known?.summary ?? "";
    fields = optionFields(known?.options ?? [], options);
    box.replaceChildren(...fields.map((field) => field.node));
    apply.hidden = fields.length === 0;
  });
  const apply = el("button", { onclick: () => send("set_strategy", { name: chosen.value, options: readOptions(fields) }) }, "Apply the options");
  return part("Strategy", [el("div", { class: "row" }, chosen), summary, box, el("div", { class: "row" }, apply)]);
}

function criteriaPart() {
  const list = el("div", { class: "criteria" });
  let shown = "";
  on("settings", () => {
    const text = JSON.stringify([state.settings.criteria, Object.keys(state.settings.gains)]);
    if (text !== shown) {
      shown = text;
      list.replaceChildren(...state.setup.criteria.map(criterionRow));
    }
    for (const field of list.querySelectorAll("[data-gain]")) field.show?.(state.settings.gains[field.dataset.gain]);
  });
  return part("Criteria", [list]);
}

function criterionRow({ name, summary }) {
  const chosen = state.settings.criteria.includes(name);
  // the switches as they stand: the settings may not have caught up with the last click
  const box = toggle(words(name), () => {
    const switches = [...document.querySelectorAll(".criterion > .switch input")];
    send("set_criteria", { names: switches.filter((each) => each.checked).map((each) => each.dataset.criterion) });
  });
  box.input.dataset.criterion = name;
  box.set(chosen);
  box.node.title = summary ?? "";
  const gains = Object.keys(state.settings.gains).filter((parameter) => parameter.startsWith(`${name}.`) && typeof state.settings.gains[parameter] === "number");
  return el("div", { class: "criterion" }, box.node, chosen ? gains.map((parameter) => gainField(parameter, name)) : null);
}

// A gain over seven decades: the left end of the slider is zero.
function gainField(parameter, criterion) {
  const label = words(parameter.slice(criterion.length + 1));
  const field = logField(label, { name: `${criterion}: ${label}`, low: -4, high: 3, zero: true, change: (value) => send("set_gain", { parameter, value }) });
  Object.assign(field.node, { title: parameter, show: field.show });
  field.node.dataset.gain = parameter;
  field.show(state.settings.gains[parameter]);
  return field.node;
}

function limitsPart() {
  const limits = toggle("joint limits", (on) => send("set_limits", { on }));
  const clearance = toggle("clearance", (on) => send("set_clearance", { on, safe: safe.input.valueAsNumber || 0 }));
  const safe = numberField("safe distance", { unit: "m", min: 0, step: 0.01, change: (value) => send("set_clearance", { on: clearance.input.checked, safe: value }) });
  clearance.node.title = "No step brings a body nearer to an obstacle than the safe distance";
  on("settings", () => {
    limits.set(state.settings.limits);
    clearance.set(state.settings.clearance);
    safe.set(state.settings.safe);
  });
  return part("Limits and clearance", [limits.node, clearance.node, el("div", { class: "row" }, safe.node)]);
}
