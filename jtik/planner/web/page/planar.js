// A planar robot, seen from above, on a 2-D canvas.

import { attemptColour, colours, css, shade } from "./palette.js";
import { centre, handles, rotationOf } from "./shapes.js";
import { heldTargets, limited, obstacles, oriented, placed, state, touches } from "./state.js";

export class PlanarView {
  constructor(host) {
    this.canvas = document.createElement("canvas");
    host.replaceChildren(this.canvas);
    this.pen = this.canvas.getContext("2d", { alpha: false });
    this.below = document.createElement("canvas"); // what lies below the arm, which seldom changes
    this.shown = []; // what it was drawn from
    this.walkedTo = 0; // how many points of the path are on it
    this.middle = [0, 0];
    this.zoom = 50; // [pixel/m]
    this.size = [1, 1];
  }

  resize(width, height) {
    const ratio = Math.min(2, devicePixelRatio || 1);
    const first = this.size[0] === 1;
    for (const canvas of [this.canvas, this.below]) {
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
    }
    this.shown = [];
    Object.assign(this.canvas.style, { width: `${width}px`, height: `${height}px` });
    this.ratio = ratio;
    this.size = [width, height];
    if (first) this.fit();
  }

  // Shows the reach of the arm and all obstacles, or as much of them as is legible.
  fit() {
    if (state.settings === null || state.frame === null) return;
    const points = [];
    for (const { start, end } of placed(state.frame.poses)) points.push(start, end);
    for (const { obstacle } of obstacles()) if (!obstacle.normal) points.push(...corners(obstacle));
    points.push([state.frame.position[0], state.frame.position[1]]);
    const [x, y] = [0, 1].map((k) => points.map((point) => point[k]));
    const [left, right, low, high] = [Math.min(...x), Math.max(...x), Math.min(...y), Math.max(...y)];
    const pad = 0.12 * Math.max(right - left, high - low, 0.3 * state.setup.robot.reach);
    this.middle = [(left + right) / 2, (low + high) / 2];
    this.zoom = Math.min(this.size[0] / (right - left + 2 * pad), this.size[1] / (high - low + 2 * pad));
  }

  toScreen = ([x, y]) => [this.size[0] / 2 + (x - this.middle[0]) * this.zoom, this.size[1] / 2 - (y - this.middle[1]) * this.zoom];
  toWorld = ([u, v]) => [this.middle[0] + (u - this.size[0] / 2) / this.zoom, this.middle[1] - (v - this.size[1] / 2) / this.zoom];

  zoomAt(pixel, factor) {
    const before = this.toWorld(pixel);
    this.zoom = Math.min(5000, Math.max(2, this.zoom * factor));
    const after = this.toWorld(pixel);
    this.middle = this.middle.map((value, k) => value + before[k] - after[k]);
  }

  draw() {
    const { pen, ratio, below } = this;
    this.pen = below.getContext("2d", { alpha: false });
    this.pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.drawBelow();
    this.pen = pen;
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.drawImage(below, 0, 0);
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    if (state.frame) {
      this.arm(state.frame.poses);
      this.target();
    }
    this.selection();
  }

  // All of it where something else has changed, else what the path has grown by.
  drawBelow() {
    const { points, postures } = state.path;
    const now = [...this.middle, this.zoom, colours.bg, state.settings, state.drag, state.selected, state.attempts, [...state.overlays].join("\n"), points, postures, postures.length];
    if (now.length !== this.shown.length || now.some((value, k) => value !== this.shown[k])) {
      this.shown = now;
      this.walkedTo = 0;
      this.pen.fillStyle = colours.bg;
      this.pen.fillRect(0, 0, ...this.size);
      this.grid();
      for (const each of obstacles()) this.obstacle(each);
      this.overlays();
      this.postures();
    }
    this.polyline(points.slice(Math.max(0, this.walkedTo - 1)), colours.accent, 2);
    this.walkedTo = points.length;
  }

  grid() {
    const { pen } = this;
    const step = 10 ** Math.ceil(Math.log10(40 / this.zoom));
    const spacing = [0.2, 0.5, 1].map((share) => share * step).find((value) => value * this.zoom >= 40) ?? step;
    const [left, top] = this.toWorld([0, 0]);
    const [right, low] = this.toWorld(this.size);
    pen.lineWidth = 1;
    pen.font = "11px system-ui, sans-serif";
    const line = (from, to, axis) => {
      pen.strokeStyle = axis ? colours.axis : colours.grid;
      pen.beginPath();
      pen.moveTo(...from.map((value) => Math.round(value) + 0.5));
      pen.lineTo(...to.map((value) => Math.round(value) + 0.5));
      pen.stroke();
    };
    pen.fillStyle = colours.muted;
    const labels = []; // above all lines
    const digits = Math.max(0, -Math.floor(Math.log10(spacing) + 1e-9));
    const number = (value) => value.toFixed(digits).replace("-", "−");
    for (let k = Math.ceil(left / spacing); k * spacing < right; k++) {
      const [u] = this.toScreen([k * spacing, 0]);
      line([u, 0], [u, this.size[1]], k === 0);
      if (u > 40 && u < this.size[0] - 40) labels.push([number(k * spacing), u, this.size[1] - 6, "center"]);
    }
    for (let k = Math.ceil(low / spacing); k * spacing < top; k++) {
      const [, v] = this.toScreen([0, k * spacing]);
      line([0, v], [this.size[0], v], k === 0);
      if (v > 40 && v < this.size[1] - 24) labels.push([number(k * spacing), 6, v - 3, "left"]);
    }
    pen.strokeStyle = colours.bg; // no line goes through them
    pen.lineWidth = 4;
    for (const [text, u, v, align] of [...labels, ["m", 6, this.size[1] - 6, "left"]]) {
      pen.textAlign = align;
      pen.strokeText(text, u, v);
      pen.fillText(text, u, v);
    }
  }

  obstacle({ name, obstacle: o, gain }) {
    const { pen } = this;
    const off = !(gain > 0);
    pen.globalAlpha = off ? 0.35 : 1;
    pen.setLineDash(off ? [5, 4] : []);
    pen.fillStyle = colours.obstacle;
    pen.strokeStyle = colours["obstacle-edge"];
    pen.lineWidth = state.selected.name === name ? 2.5 : 1.4;
    this.outline(o);
    if (!off) pen.fill();
    pen.stroke();
    pen.setLineDash([]);
    pen.globalAlpha = 1;
  }

  outline(o) {
    const { pen } = this;
    const put = (point) => this.toScreen(point);
    pen.beginPath();
    if (o.center && !o.half) {
      pen.arc(...put(o.center), Math.max(3, (o.radius ?? 0) * this.zoom), 0, 7);
    } else if (o.start) {
      const [a, b] = [put(o.start), put(o.end)];
      const angle = Math.atan2(b[1] - a[1], b[0] - a[0]);
      const radius = o.radius * this.zoom;
      pen.arc(...a, radius, angle + Math.PI / 2, angle - Math.PI / 2);
      pen.arc(...b, radius, angle - Math.PI / 2, angle + Math.PI / 2);
      pen.closePath();
    } else {
      const all = o.normal ? this.halfPlane(o) : corners(o);
      all.forEach((corner, k) => (k === 0 ? pen.moveTo(...put(corner)) : pen.lineTo(...put(corner))));
      pen.closePath();
    }
  }

  halfPlane({ point, normal }) {
    const far = (4 * Math.hypot(...this.size)) / this.zoom;
    const along = [-normal[1], normal[0]];
    const at = (a, b) => [point[0] + far * (a * along[0] - b * normal[0]), point[1] + far * (a * along[1] - b * normal[1])];
    return [at(-1, 0), at(1, 0), at(1, 1), at(-1, 1)];
  }

  polyline(points, colour, width, dash = []) {
    if (points.length < 2) return;
    const { pen } = this;
    pen.strokeStyle = colour;
    pen.lineWidth = width;
    pen.lineJoin = pen.lineCap = "round";
    pen.setLineDash(dash);
    pen.beginPath();
    points.forEach((point, k) => (k === 0 ? pen.moveTo(...this.toScreen(point)) : pen.lineTo(...this.toScreen(point))));
    pen.stroke();
    pen.setLineDash([]);
  }

  overlays() {
    state.attempts.forEach((attempt, index) => {
      if (!state.overlays.has(attempt.name)) return;
      const colour = attemptColour(index);
      this.pen.globalAlpha = 0.4;
      for (const posture of attempt.postures ?? []) for (const link of posture) this.polyline(link, colour, 1.5);
      this.pen.globalAlpha = 1;
      this.polyline(attempt.path ?? [], colour, 3);
    });
  }

  postures() {
    const { postures } = state.path;
    postures.forEach((poses, k) => {
      const colour = css(shade((0.75 * k) / Math.max(1, postures.length)), 0.75);
      for (const { start, end, body } of placed(poses)) this.polyline([start, end], colour, Math.max(1.5, 0.55 * this.thickness(body)));
    });
  }

  // Width of a body [pixel]; a link that has no shape of its own is as wide as in the figures.
  thickness(body) {
    const width = body.to === undefined ? 2 * body.radius : 0.009 * state.setup.robot.reach;
    return Math.max(4, width * this.zoom);
  }

  arm(poses) {
    const { pen } = this;
    const drawn = placed(poses);
    for (const { start, end, body } of drawn) this.polyline([start, end], colours.bg, this.thickness(body) + 3);
    for (const { start, end, body } of drawn) {
      this.polyline([start, end], touches(body) ? colours.alarm : css(shade(1)), this.thickness(body));
    }
    const size = drawn.length ? Math.min(...drawn.map(({ body }) => this.thickness(body))) : 6;
    for (const joint of state.setup.joints) {
      if (joint.at < 0) continue;
      const at = this.toScreen([poses[7 * joint.at], poses[7 * joint.at + 1]]);
      pen.beginPath();
      pen.arc(...at, (limited(joint) ? 0.62 : 0.24) * size, 0, 7);
      pen.fillStyle = limited(joint) ? colours.limit : colours.bg;
      pen.fill();
    }
  }

  target() {
    const { pen } = this;
    const { position, orientation } = state.frame;
    const [u, v] = this.toScreen([position[0], position[1]]);
    pen.strokeStyle = colours.bg;
    for (const [colour, width] of [[colours.bg, 5], [colours.target, 2]]) {
      pen.strokeStyle = colour;
      pen.lineWidth = width;
      pen.beginPath();
      pen.arc(u, v, 9, 0, 7);
      for (const [a, b] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
        pen.moveTo(u + 5 * a, v + 5 * b);
        pen.lineTo(u + 15 * a, v + 15 * b);
      }
      pen.stroke();
    }
    for (const [x, y] of heldTargets()) {
      pen.beginPath();
      pen.arc(...this.toScreen([x, y]), 6, 0, 7);
      pen.stroke();
    }
    if (!oriented()) return;
    const angle = 2 * Math.atan2(orientation[3], orientation[0]);
    this.polyline([[position[0], position[1]], this.turnHandle(angle)], colours.target, 2);
    pen.beginPath();
    pen.arc(...this.toScreen(this.turnHandle(angle)), 5, 0, 7);
    pen.fillStyle = colours.target;
    pen.fill();
  }

  turnHandle(angle) {
    const { position } = state.frame;
    return [position[0] + (38 / this.zoom) * Math.cos(angle), position[1] + (38 / this.zoom) * Math.sin(angle)];
  }

  selection() {
    const chosen = obstacles().find(({ name }) => state.selected.kind === "obstacle" && name === state.selected.name);
    if (!chosen) return;
    const { pen } = this;
    for (const [at, , does] of handles(chosen.obstacle, 1 / this.zoom)) {
      if (does === "turn") this.polyline([centre(chosen.obstacle), at], colours["obstacle-edge"], 1, [3, 3]);
      pen.beginPath();
      const [u, v] = this.toScreen(at);
      if (does === "turn") pen.arc(u, v, 5, 0, 7);
      else pen.rect(u - 4.5, v - 4.5, 9, 9);
      pen.fillStyle = colours.bg;
      pen.strokeStyle = colours["obstacle-edge"];
      pen.lineWidth = 1.8;
      pen.fill();
      pen.stroke();
    }
  }
}

// Corners of a plane shape, or of the square around a round one.
function corners(o) {
  if (o.vertices) return o.vertices;
  if (o.half) {
    const R = rotationOf(o);
    return [[1, 1], [-1, 1], [-1, -1], [1, -1]].map((signs) => R.map((row, k) => o.center[k] + row[0] * signs[0] * o.half[0] + row[1] * signs[1] * o.half[1]));
  }
  const radius = o.radius ?? 0;
  return [o.start ?? o.center, o.end ?? o.center].flatMap(([x, y]) => [[x - radius, y - radius], [x + radius, y + radius]]);
}
