// A spatial robot in perspective: capsules, obstacles, the ground, the path walked. The camera orbits.

import { drawAxes, drawGizmo } from "./gizmo.js";
import { FIELD, project, Renderer } from "./gl.js";
import { add, cross, dot, lookAt, multiply, norm, perspective, rigid, rotate, scale, sub, transposed, unit } from "./math.js";
import { drawMeshes } from "./meshes.js";
import { attemptRgb, rgb, shade } from "./palette.js";
import { centre, rotationOf, turns, upTo } from "./shapes.js";
import { heldTargets, limited, obstacles, oriented, placed, state, touches } from "./state.js";

const GIZMO = 74; // length of an arrow [pixel]

export class SpatialView {
  constructor(host) {
    this.canvas = document.createElement("canvas");
    host.replaceChildren(this.canvas);
    this.renderer = new Renderer(this.canvas);
    this.yaw = 0.75;
    this.pitch = 0.42;
    this.distance = 3;
    this.middle = [0, 0, 0.3];
    this.size = [1, 1];
    this.hot = null;
    this.meshes = null; // what `showMeshes` has loaded, while it is shown
    this.resting = false; // whether the picture has twice the pixels
  }

  resize(width, height) {
    const first = this.size[0] === 1;
    this.size = [width, height];
    this.setPixels(false);
    if (first) this.fit();
  }

  setPixels(resting) {
    const [width, height] = this.size;
    const ratio = (resting ? 2 : 1) * Math.min(2, devicePixelRatio || 1);
    this.resting = resting;
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
    Object.assign(this.canvas.style, { width: `${width}px`, height: `${height}px` });
  }

  // Nothing moves: draws the picture with twice the pixels where the processor draws, which has no time to smooth edges
  // while something moves.
  rest() {
    if (this.resting || !this.renderer.software || (devicePixelRatio || 1) > 1) return;
    this.setPixels(true);
    this.picture();
  }

  draw() {
    if (this.resting) this.setPixels(false);
    this.picture();
  }

  fit() {
    if (state.settings === null || state.frame === null) return;
    const points = placed(state.frame.poses).flatMap(({ start, end }) => [start, end]);
    points.push([...state.frame.position]);
    for (const { obstacle } of obstacles()) if (!obstacle.normal) points.push(centre(obstacle));
    const low = [0, 1, 2].map((k) => Math.min(...points.map((point) => point[k])));
    const high = [0, 1, 2].map((k) => Math.max(...points.map((point) => point[k])));
    this.middle = scale(add(low, high), 0.5);
    const aspect = Math.min(1, this.size[0] / this.size[1]);
    this.distance = (0.62 * norm(sub(high, low)) + 0.1 * state.setup.robot.reach) / Math.tan(FIELD / 2) / aspect;
  }

  eye() {
    const { yaw, pitch, distance } = this;
    return add(this.middle, scale([Math.cos(pitch) * Math.cos(yaw), Math.cos(pitch) * Math.sin(yaw), Math.sin(pitch)], distance));
  }

  forward = () => unit(sub(this.middle, this.eye()));
  right = () => unit(cross(this.forward(), [0, 0, 1]));
  camera() {
    const near = 0.02 * this.distance;
    const projection = perspective(FIELD, this.size[0] / this.size[1], near, 60 * this.distance);
    return multiply(projection, lookAt(this.eye(), this.middle, [0, 0, 1]));
  }

  toScreen = (point) => project(this.camera(), point, ...this.size).slice(0, 2);

  ray([u, v]) {
    const slope = Math.tan(FIELD / 2);
    const forward = this.forward();
    const right = this.right();
    const up = cross(right, forward);
    const [x, y] = [((2 * u) / this.size[0] - 1) * slope * (this.size[0] / this.size[1]), (1 - (2 * v) / this.size[1]) * slope];
    return { from: this.eye(), along: unit(add(forward, add(scale(right, x), scale(up, y)))) };
  }

  // Length of a gizmo's arrow at a point [m].
  gizmoSize = (at) => (GIZMO * 2 * Math.tan(FIELD / 2) * Math.max(0.05, dot(sub(at, this.eye()), this.forward()))) / this.size[1];

  // Where the gizmo is, and whether it turns what it moves.
  gizmo() {
    if (state.selected.kind === "obstacle") {
      const chosen = obstacles().find(({ name }) => name === state.selected.name);
      if (chosen) return { at: centre(chosen.obstacle), turning: turns(chosen.obstacle), chosen };
    }
    return { at: [...state.frame.position], turning: oriented(), chosen: null };
  }

  picture() {
    const { renderer, canvas } = this;
    renderer.begin(canvas.width, canvas.height, this.size[1], this.resting || !renderer.software, rgb("bg"), this.camera(), this.eye());
    if (state.frame === null) return;
    this.arm(state.frame.poses);
    for (const each of obstacles()) if (each.gain > 0) this.obstacle(each);
    this.ground();
    this.walked();
    for (const each of obstacles()) if (!(each.gain > 0)) this.obstacle(each);
    renderer.onTop();
    const R = transposed([[1, 0, 0], [0, 1, 0], [0, 0, 1]].map((e) => rotate(state.frame.orientation, e)));
    const position = [...state.frame.position];
    if (state.selected.kind !== "target") renderer.draw("capsule", rigid(R, position), Array(3).fill(0.1 * this.gizmoSize(position)), rgb("target"), { lit: 0.5 });
    if (oriented()) drawAxes(renderer, R, position, 0.62 * this.gizmoSize(position));
    for (const held of heldTargets()) renderer.draw("capsule", rigid([[1, 0, 0], [0, 1, 0], [0, 0, 1]], held), Array(3).fill(0.1 * this.gizmoSize(held)), rgb("target"), { lit: 0.5, alpha: 0.6 });
    const { at, turning } = this.gizmo();
    drawGizmo(renderer, at, this.gizmoSize(at), { turning, hot: this.hot });
  }

  ground() {
    const { renderer } = this;
    const reach = Math.max(state.setup.robot.reach, 0.6 * this.distance);
    const step = [0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10].find((value) => reach / value <= 12) ?? 20;
    const count = Math.ceil((1.6 * reach) / step);
    const end = count * step;
    const lines = [];
    for (let k = -count; k <= count; k++) {
      const half = Math.sqrt(Math.max(0, end * end - k * k * step * step)); // they fade out on a circle
      if (k !== 0 && half > 0) lines.push([[-half, k * step, 0], [half, k * step, 0]], [[k * step, -half, 0], [k * step, half, 0]]);
    }
    renderer.lines(lines, rgb("grid"), 1.2, { alpha: 0.99, fade: 1.3 * reach });
    renderer.lines([[[-end, 0, 0], [0, 0, 0]], [[0, 0, 0], [end, 0, 0]], [[0, -end, 0], [0, 0, 0]], [[0, 0, 0], [0, end, 0]]], rgb("axis"), 1.6, { alpha: 0.99, fade: 1.3 * reach });
    const size = 0.12 * state.setup.robot.reach;
    drawAxes(renderer, [[1, 0, 0], [0, 1, 0], [0, 0, 1]], [0, 0, 0.001], size);
  }

  arm(poses) {
    if (this.meshes) drawMeshes(this.renderer, this.meshes, poses);
    for (const { start, end, body } of placed(poses)) {
      if (this.meshes?.hides(body)) continue;
      const touched = touches(body);
      this.capsule(start, end, touched ? 1.01 * body.radius : body.radius, rgb(touched ? "alarm" : "arm"));
    }
    for (const joint of state.setup.joints) {
      if (!limited(joint) || joint.at < 0) continue;
      const at = [...poses.subarray(7 * joint.at, 7 * joint.at + 3)];
      const radius = Math.max(...state.setup.bodies.filter((body) => body.at === joint.at).map((body) => body.radius), 0.03 * state.setup.robot.reach);
      this.capsule(at, at, 1.2 * radius, rgb("limit"));
    }
  }

  capsule(start, end, radius, colour, options = {}) {
    const along = sub(end, start);
    const R = norm(along) > 0 ? upTo(along) : [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
    this.renderer.draw("capsule", rigid(R, start), [radius, radius, radius], colour, { stretch: norm(along), ...options });
  }

  obstacle({ name, obstacle: o, gain }) {
    const { renderer } = this;
    const chosen = state.selected.kind === "obstacle" && state.selected.name === name;
    const colour = rgb(chosen ? "obstacle-edge" : "obstacle");
    const options = { alpha: gain > 0 ? 1 : 0.25 };
    if (o.half) renderer.draw("box", rigid(rotationOf(o), o.center), o.half, colour, options);
    else if (o.center) this.capsule(o.center, o.center, o.radius || 0.01 * state.setup.robot.reach, colour, options);
    else if (o.start && o.shape !== "cylinder") this.capsule(o.start, o.end, o.radius, colour, options);
    else if (o.start) {
      const along = sub(o.end, o.start);
      renderer.draw("cylinder", rigid(upTo(along), o.start), [o.radius, o.radius, 1], colour, { stretch: norm(along), ...options });
    } else if (o.normal) {
      const reach = 1.2 * state.setup.robot.reach;
      renderer.draw("box", rigid(upTo(o.normal), o.point), [reach, reach, 0.001], colour, { alpha: gain > 0 ? 0.35 : 0.12 });
    }
  }

  walked() {
    const { renderer } = this;
    const pairs = (points) => points.slice(1).map((point, k) => [points[k], point]);
    const { postures, points } = state.path;
    postures.forEach((poses, k) => {
      const origin = (frame) => [...poses.subarray(7 * state.setup.index.get(frame), 7 * state.setup.index.get(frame) + 3)];
      const skeleton = state.setup.robot.links.map(({ start, end }) => [origin(start), origin(end)]);
      renderer.lines(skeleton, shade((0.8 * k) / Math.max(1, postures.length)), 3, { alpha: 0.55 });
    });
    renderer.lines(pairs(points), rgb("accent"), 3);
    state.attempts.forEach((attempt, index) => {
      if (!state.overlays.has(attempt.name)) return;
      for (const posture of attempt.postures ?? []) for (const link of posture) renderer.lines(pairs(link), attemptRgb(index), 2, { alpha: 0.4 });
      renderer.lines(pairs(attempt.path ?? []), attemptRgb(index), 3.5);
    });
  }
}
