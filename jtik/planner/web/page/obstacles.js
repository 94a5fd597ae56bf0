// The part "Obstacles": a list to add to, switch off and delete from; the numbers of the one that is selected.

import { choice, el, numberField, part, toggle, words } from "./dom.js";
import { add, sub } from "./math.js";
import { angleOf, centre, fresh, moved, sizes, turned, turns, TYPES } from "./shapes.js";
import { send } from "./socket.js";
import { emit, obstacles, on, select, state } from "./state.js";

const remembered = {}; // gains of obstacles that were switched off here

export function addObstacle(type) {
  const names = new Set(Object.keys(state.settings.scene));
  let k = 1;
  while (names.has(`${type}_${k}`)) k++;
  const d = state.setup.robot.dimension;
  const size = 0.09 * state.setup.robot.reach;
  const at = [...state.frame.position].slice(0, d);
  const name = `${type}_${k}`;
  send("add_obstacle", { name, obstacle: fresh(type, add(at, [0, ...Array(d - 2).fill(0), 2 * size]), size) });
  select({ kind: "obstacle", name });
}

// Sends a change. Until the planner has had time to answer, the obstacle is shown as it was asked for here.
const SETTLE = 500; // [ms]
let timer = 0;

export function changeObstacle(name, obstacle) {
  state.drag = { name, obstacle };
  send("change_obstacle", { name, obstacle });
  emit("dragged");
  clearTimeout(timer);
  timer = setTimeout(() => {
    state.drag = null;
    emit("dragged");
  }, SETTLE);
}

export function removeSelected() {
  if (state.selected.kind !== "obstacle") return;
  send("delete_obstacle", { name: state.selected.name });
  select({ kind: "target" });
}

export function obstaclePart() {
  const list = el("div", { class: "list" });
  const types = TYPES[state.setup.robot.dimension];
  const adds = choice([["", "Add an obstacle"], ...types.map((type) => [type, words(type)])], (type) => {
    if (type) addObstacle(type);
    adds.value = "";
  }, { "aria-label": "add an obstacle", id: "add-obstacle" });
  let shown = "";
  const rows = new Map();

  function refresh() {
    const all = obstacles();
    const text = all.map(({ name, obstacle }) => `${name}:${obstacle.shape}`).join() + JSON.stringify(state.selected);
    if (text !== shown) {
      shown = text;
      rows.clear();
      for (const each of all) rows.set(each.name, row(each));
      list.replaceChildren(...[...rows.values()].map(({ node }) => node));
      if (all.length === 0) list.append(el("p", { class: "note" }, "No obstacles. Add one, and drag it in the view."));
    }
    for (const each of all) rows.get(each.name)?.show(each);
  }
  on("settings selected dragged", refresh);
  return part("Obstacles", [list, el("div", { class: "row" }, adds)]);
}

function row({ name, obstacle, gain }) {
  const chosen = state.selected.kind === "obstacle" && state.selected.name === name;
  const on = toggle("", (checked) => {
    const now = state.settings.scene[name]?.gain ?? 1;
    if (!checked) remembered[name] = now;
    send("set_obstacle_gain", { name, gain: checked ? remembered[name] || 1 : 0 });
  });
  on.input.setAttribute("aria-label", `${name} on`);
  const title = el("button", { class: "name", onclick: () => select(chosen ? { kind: "target" } : { kind: "obstacle", name }) }, words(name));
  const remove = el("button", { class: "quiet", title: `Delete ${words(name)}`, "aria-label": `delete ${name}`, onclick: () => {
    send("delete_obstacle", { name });
    if (chosen) select({ kind: "target" });
  } }, "×");
  const body = chosen ? fields(name, obstacle, gain) : null;
  const node = el("div", { class: chosen ? "item chosen" : "item", data: { obstacle: name } }, el("div", { class: "head" }, on.node, title, remove), body?.node);
  return {
    node,
    show(each) {
      on.set(each.gain > 0);
      body?.show(each);
    },
  };
}

function fields(name, first, gain) {
  let now = first;
  const change = (obstacle) => changeObstacle(name, obstacle);
  const d = centre(first).length;
  const step = 0.01 * state.setup.robot.reach;
  const place = ["x", "y", "z"].slice(0, d).map((label, k) =>
    numberField(label, { unit: "m", step, change: (value) => change(moved(now, sub(centre(now).map((v, i) => (i === k ? value : v)), centre(now)))) }),
  );
  const size = sizes(first).map(([label], k) => numberField(label, { unit: "m", step: step / 2, min: 0, change: (value) => change(sizes(now)[k][2](value)) }));
  const turn = d === 2 && angleOf(first) !== null ? [numberField("angle", { unit: "°", step: 5, change: (value) => change(turned(now, (value * Math.PI) / 180 - angleOf(now))) })] : [];
  const spins = d === 3 && turns(first) ? ["x", "y", "z"].map((label, k) => el("button", { title: `Turn by 15° about ${label}`, onclick: () => change(turned(now, Math.PI / 12, [0, 1, 2].map((i) => (i === k ? 1 : 0)))) }, `turn ${label}`)) : [];
  const weight = numberField("gain", { min: 0, step: 0.5, change: (value) => send("set_obstacle_gain", { name, gain: value }) });
  weight.set(gain);
  return {
    node: el("div", { class: "fields" }, [...place, ...size, ...turn, weight].map((field) => field.node), spins),
    show(each) {
      now = each.obstacle;
      place.forEach((field, k) => field.set(centre(now)[k]));
      sizes(now).forEach(([, value], k) => size[k]?.set(value));
      if (turn.length) turn[0].set((angleOf(now) * 180) / Math.PI);
      weight.set(each.gain);
    },
  };
}
