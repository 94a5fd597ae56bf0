// The figures of the present step: a number and a small running plot each.

import { el, figure, part, setText, shortNames, words } from "./dom.js";
import { colours } from "./palette.js";
import { limited, on, state } from "./state.js";

const KEPT = 200; // statuses: 20 s at 10 a second
const FLOOR = 1e-9; // smallest value on a logarithmic plot

const ERROR_UNITS = { position: "m", orientation: "rad" }; // of a pose, metres and radians are in one number

// key, label, unit, read from a status, whether the scale is logarithmic, what it means
const figures = () => [
  ["error", "error", (state.settings.tasks.length > 1 ? "" : ERROR_UNITS[state.setup.task.kind]) ?? "", (s) => s.error, true, "norm of the task error; of a pose, metres and radians together"],
  ["V", "V, task", "", (s) => s.V, true, "Lyapunov function of the task: half the sum of squares of the weighted error"],
  ["H", "H, criteria", "", (s) => s.H, false, "weighted sum of the criteria, which the self-motion makes small"],
  ["joints", "clearance of joints", "m", (s) => s.clearance?.joints, false, "smallest distance of a joint to an obstacle"],
  ["links", "clearance of links", "m", (s) => s.clearance?.links, false, "smallest distance of a link to an obstacle"],
  ["manipulability", "manipulability", "", (s) => s.manipulability, false, "square root of the determinant of J J', of the weighted Jacobian"],
  ["active", "active limits", "", (s) => s.active_limits?.length ?? 0, false, "number of joints at a limit"],
  ["null", "null space", "", (s) => s.null_space, false, "dimension of the null space of the task"],
  ["step", "time a step", "ms", (s) => (s.step_time ?? NaN) * 1000, false, "computing time of the last step"],
];

const stale = new Set(); // plots with a value that is not drawn yet

// Draw some of the plots that have changed: all at once would be a long pause in every sixth picture.
export function drawPlots(most = 2) {
  for (const plot of [...stale].slice(0, most)) {
    stale.delete(plot);
    plot.draw();
  }
}

class Plot {
  constructor([key, label, unit, read, log, meaning]) {
    Object.assign(this, { read, log, unit, values: [] });
    this.canvas = el("canvas", { class: "spark" });
    this.value = el("output", {});
    this.node = el("div", { class: "figure", data: { figure: key }, title: meaning }, el("span", { class: "name" }, label), this.value, el("i", {}, unit), this.canvas);
  }

  take(status) {
    const value = this.read(status);
    const known = typeof value === "number" && Number.isFinite(value);
    this.values.push(known ? value : NaN);
    if (this.values.length > KEPT) this.values.shift();
    setText(this.value, figure(value));
    stale.add(this);
  }

  draw() {
    const ratio = Math.min(2, devicePixelRatio || 1);
    const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight];
    if (width === 0) return;
    if (this.canvas.width !== Math.round(width * ratio)) {
      this.canvas.width = Math.round(width * ratio);
      this.canvas.height = Math.round(height * ratio);
    }
    const pen = this.canvas.getContext("2d");
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, width, height);
    const shown = this.values.map((value) => (this.log ? Math.log10(Math.max(FLOOR, value)) : value));
    const finite = shown.filter((value) => Number.isFinite(value));
    if (finite.length < 2) return;
    let [low, high] = [Math.min(...finite), Math.max(...finite)];
    const flat = Math.max(1e-6, (this.log ? 0.5 : 0.02) * Math.max(Math.abs(low), Math.abs(high)));
    if (high - low < flat) [low, high] = [(low + high - flat) / 2, (low + high + flat) / 2];
    const x = (k) => width - (shown.length - 1 - k) * (width / (KEPT - 1));
    const y = (value) => height - 2.5 - ((value - low) / (high - low)) * (height - 5);
    pen.lineWidth = 1.5;
    pen.lineJoin = "round";
    pen.strokeStyle = colours.accent;
    pen.beginPath();
    let drawing = false;
    shown.forEach((value, k) => {
      if (!Number.isFinite(value)) return (drawing = false);
      drawing ? pen.lineTo(x(k), y(value)) : pen.moveTo(x(k), y(value));
      drawing = true;
    });
    pen.stroke();
    const last = shown.at(-1);
    if (!Number.isFinite(last)) return;
    pen.fillStyle = colours.accent;
    pen.beginPath();
    pen.arc(x(shown.length - 1) - 2, y(last), 2.2, 0, 7);
    pen.fill();
  }
}

export function showFigures(host) {
  let fixed = [];
  const list = el("div", { class: "figures" });
  const own = el("div", { class: "figures" });
  const joints = el("div", { class: "joints" });
  const criteria = new Map();
  host.append(part("Step", [list]), part("Criteria", [own]), part("Joints", [joints]));

  on("robot", () => {
    fixed = figures().map((one) => new Plot(one));
    list.replaceChildren(...fixed.map((plot) => plot.node));
  });
  on("status", () => {
    for (const plot of fixed) plot.take(state.status);
    const values = state.status.criteria ?? {};
    if ([...criteria.keys()].join() !== Object.keys(values).join()) {
      criteria.clear();
      for (const name of Object.keys(values)) criteria.set(name, new Plot([name, words(name), "", (s) => s.criteria?.[name], false, "weighted value of the criterion"]));
      own.replaceChildren(...[...criteria.values()].map((plot) => plot.node));
    }
    for (const plot of criteria.values()) plot.take(state.status);
    showJoints(joints);
  });
}

// The configuration as numbers; a joint at an active limit is marked.
function showJoints(host) {
  if (state.frame === null) return;
  const { joints } = state.setup;
  const names = shortNames(joints.map(({ name }) => name));
  if (host.childElementCount !== joints.length) {
    host.replaceChildren(...names.map((name) => el("div", {}, el("span", { title: name }, name), el("output", {}))));
  }
  joints.forEach((joint, k) => {
    setText(host.children[k].lastChild, joint.scalar ? state.frame.q[joint.index].toFixed(3).replace("-", "−") : joint.type);
    host.children[k].classList.toggle("limited", limited(joint));
  });
}
