// The handles of what is selected in space: arrows along the axes, squares in their planes, rings for the orientation.
// They have a constant size on the screen. A grip is a function of the pointer's rays that gives what it moves.

import { add, cross, dot, norm, rigid, scale, sub, transposed, unit } from "./math.js";
import { rgb } from "./palette.js";

const AXES = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
const COLOURS = [[0.79, 0.29, 0.21], [0.3, 0.6, 0.36], [0.19, 0.44, 0.74]];
const SQUARE = [0.32, 0.52]; // where a plane's square lies, as shares of an arrow
const RING = 0.8;
const NEAR = 9; // [pixel]

const column = (R, k) => R.map((row) => row[k]);
const planeOf = (k) => [AXES[(k + 1) % 3], AXES[(k + 2) % 3]];

export function drawGizmo(renderer, at, size, { turning, hot }) {
  const light = (k, part) => (hot === `${part}${k}` ? rgb("limit") : COLOURS[k]);
  AXES.forEach((axis, k) => {
    const [u, v] = planeOf(k);
    const R = transposed([u, v, axis]);
    renderer.draw("capsule", rigid(R, at), [0.022 * size, 0.022 * size, 0.022 * size], light(k, "axis"), { stretch: size, lit: 0.6 });
    renderer.draw("cone", rigid(R, add(at, scale(axis, size))), [0.075 * size, 0.075 * size, 0.22 * size], light(k, "axis"), { lit: 0.6 });
    const middle = scale(add(u, v), (size * (SQUARE[0] + SQUARE[1])) / 2);
    const half = (size * (SQUARE[1] - SQUARE[0])) / 2;
    renderer.draw("box", rigid(R, add(at, middle)), [half, half, 0.006 * size], light(k, "plane"), { lit: 0.3 });
    if (turning) renderer.draw("ring", rigid(R, at), [RING * size, RING * size, RING * size], light(k, "ring"), { lit: 0.5 });
  });
  renderer.draw("capsule", rigid(AXES, at), [0.07 * size, 0.07 * size, 0.07 * size], hot === "middle" ? rgb("limit") : rgb("target"), { lit: 0.6 });
}

// The frame of the target: three short axes of its orientation.
export function drawAxes(renderer, R, at, size) {
  AXES.forEach((_, k) => renderer.lines([[at, add(at, scale(column(R, k), size))]], COLOURS[k], 3));
}

// What is under the pointer, or null: { name, move(ray) -> {by} or {turn} }.
export function gripAt(view, at, size, pixel, { turning }) {
  const near = (points) => {
    let nearest = Infinity;
    for (let k = 1; k < points.length; k++) nearest = Math.min(nearest, toSegment(pixel, view.toScreen(points[k - 1]), view.toScreen(points[k])));
    return nearest;
  };
  if (norm(sub(view.toScreen(at), pixel)) < NEAR) return { name: "middle", start: (ray) => inPlane(ray, at, view.forward()) };
  for (let k = 0; k < 3; k++) {
    const [u, v] = planeOf(k);
    const [a, b] = SQUARE.map((share) => share * size);
    const square = [[a, a], [b, a], [b, b], [a, b]].map(([s, t]) => view.toScreen(add(at, add(scale(u, s), scale(v, t)))));
    if (inside(pixel, square)) return { name: `plane${k}`, start: (ray) => inPlane(ray, at, AXES[k]) };
  }
  for (let k = 0; k < 3; k++) {
    if (near([at, add(at, scale(AXES[k], 1.2 * size))]) < NEAR) return { name: `axis${k}`, start: (ray) => alongAxis(ray, at, AXES[k]) };
  }
  if (!turning) return null;
  for (let k = 0; k < 3; k++) {
    const [u, v] = planeOf(k);
    const circle = [...Array(49)].map((_, i) => add(at, scale(add(scale(u, Math.cos((i * Math.PI) / 24)), scale(v, Math.sin((i * Math.PI) / 24))), RING * size)));
    if (near(circle) < NEAR) return { name: `ring${k}`, start: (ray) => around(ray, at, AXES[k]) };
  }
  return null;
}

function inPlane(first, at, normal) {
  const meet = ({ from, along }) => {
    const share = dot(sub(at, from), normal) / dot(along, normal);
    return Number.isFinite(share) && share > 0 ? add(from, scale(along, share)) : null;
  };
  const begin = meet(first) ?? at;
  return (ray) => ({ by: sub(meet(ray) ?? begin, begin) });
}

function alongAxis(first, at, axis) {
  const nearest = ({ from, along }) => {
    const offset = sub(at, from);
    const b = dot(axis, along);
    return (b * dot(along, offset) - dot(axis, offset)) / Math.max(1e-4, 1 - b * b);
  };
  const begin = nearest(first);
  return (ray) => ({ by: scale(axis, nearest(ray) - begin) });
}

function around(first, at, axis) {
  const side = unit(cross(axis, Math.abs(axis[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0]));
  const up = cross(axis, side);
  const angle = ({ from, along }) => {
    const share = dot(sub(at, from), axis) / dot(along, axis);
    const point = sub(add(from, scale(along, share)), at);
    return Math.atan2(dot(point, up), dot(point, side));
  };
  const begin = angle(first);
  return (ray) => ({ axis, angle: angle(ray) - begin });
}

function toSegment(p, a, b) {
  const [x, y] = [b[0] - a[0], b[1] - a[1]];
  const share = Math.min(1, Math.max(0, ((p[0] - a[0]) * x + (p[1] - a[1]) * y) / Math.max(1e-9, x * x + y * y)));
  return Math.hypot(p[0] - a[0] - share * x, p[1] - a[1] - share * y);
}

function inside(p, polygon) {
  let odd = false;
  for (let i = 0, j = polygon.length - 1; i < polygon.length; j = i++) {
    const [a, b] = [polygon[i], polygon[j]];
    if (a[1] > p[1] !== b[1] > p[1] && p[0] < ((b[0] - a[0]) * (p[1] - a[1])) / (b[1] - a[1]) + a[0]) odd = !odd;
  }
  return odd;
}
