// Obstacles as the planner describes them: a shape and its numbers. Every function returns a new description.

import { add, cross, dot, matrixOfRotation, norm, quaternionOf, quaternionProduct, rotate, scale, sub, transposed, unit } from "./math.js";

export const TYPES = {
  2: ["circle", "capsule", "box", "polygon", "half_space", "point"],
  3: ["sphere", "capsule", "box", "cylinder", "half_space", "point"],
};

export function fresh(type, at, size) {
  const d = at.length;
  const along = [size, ...Array(d - 1).fill(0)];
  const up = [...Array(d - 1).fill(0), 1];
  if (type === "circle" || type === "sphere") return { shape: type, center: at, radius: 0.6 * size };
  if (type === "point") return { shape: type, center: at };
  if (type === "capsule" || type === "cylinder") return { shape: type, start: sub(at, along), end: add(at, along), radius: 0.35 * size };
  if (type === "half_space") return { shape: type, point: at, normal: up };
  if (type === "polygon") return { shape: type, vertices: [0, 1, 2, 3, 4].map((k) => turnedUnit(1.2566 * k + 1.5708, size).map((c, i) => c + at[i])) };
  return { shape: type, center: at, half: d === 2 ? [0.8 * size, 0.45 * size] : [0.6 * size, 0.4 * size, 0.4 * size], rotation: d === 2 ? 0 : [1, 0, 0, 0] };
}

const turnedUnit = (angle, size) => [size * Math.cos(angle), size * Math.sin(angle)];

// Rotation matrix of a box.
export function rotationOf(o) {
  const rotation = o.rotation ?? (o.half.length === 2 ? 0 : [1, 0, 0, 0]);
  return typeof rotation === "number" ? planeTurn(rotation) : transposed([[1, 0, 0], [0, 1, 0], [0, 0, 1]].map((e) => rotate(rotation, e)));
}

export function centre(o) {
  if (o.center) return o.center;
  if (o.start) return scale(add(o.start, o.end), 0.5);
  if (o.vertices) return scale(o.vertices.reduce(add), 1 / o.vertices.length);
  return o.point;
}

export function moved(o, by) {
  if (o.center) return { ...o, center: add(o.center, by) };
  if (o.start) return { ...o, start: add(o.start, by), end: add(o.end, by) };
  if (o.vertices) return { ...o, vertices: o.vertices.map((vertex) => add(vertex, by)) };
  return { ...o, point: add(o.point, by) };
}

// Turned about its centre by an angle [rad], in space about an axis.
export function turned(o, angle, axis = null) {
  const c = centre(o);
  const R = axis === null ? planeTurn(angle) : matrixOfRotation(axis, angle);
  const about = (point) => add(c, apply(R, sub(point, c)));
  if (o.half) return { ...o, rotation: axis === null ? (o.rotation ?? 0) + angle : quaternionProduct(quaternionOf(axis, angle), o.rotation ?? [1, 0, 0, 0]) };
  if (o.start) return { ...o, start: about(o.start), end: about(o.end) };
  if (o.vertices) return { ...o, vertices: o.vertices.map(about) };
  if (o.normal) return { ...o, normal: unit(apply(R, o.normal)) };
  return o;
}

export const turns = (o) => Boolean(o.start || o.half || o.vertices || o.normal);
const apply = (R, v) => R.map((row) => dot(row, v));
export const planeTurn = (angle) => [[Math.cos(angle), -Math.sin(angle)], [Math.sin(angle), Math.cos(angle)]];

// The angle [rad] of a plane shape, for its number field.
export function angleOf(o) {
  if (o.half) return o.rotation ?? 0;
  if (o.start) return Math.atan2(o.end[1] - o.start[1], o.end[0] - o.start[0]);
  if (o.normal) return Math.atan2(o.normal[1], o.normal[0]);
  return null;
}

// Sizes with names, for number fields: [label, value, (value) => changed obstacle].
export function sizes(o) {
  const list = [];
  if (o.radius !== undefined) list.push(["radius", o.radius, (radius) => ({ ...o, radius })]);
  if (o.start) {
    const c = centre(o);
    const half = scale(sub(o.end, o.start), 0.5);
    const length = 2 * norm(half);
    list.push(["length", length, (value) => {
      const along = scale(length > 0 ? unit(half) : half.map((_, i) => (i === 0 ? 1 : 0)), value / 2);
      return { ...o, start: sub(c, along), end: add(c, along) };
    }]);
  }
  o.half?.forEach((value, k) => list.push([["width", "depth", "height"][k], 2 * value, (size) => ({ ...o, half: o.half.map((h, i) => (i === k ? size / 2 : h)) })]));
  return list;
}

// Points of a plane shape that are dragged to change it: [position, (pointer) => changed obstacle, what it does].
export function handles(o, pixel) {
  const min = (value) => Math.max(2 * pixel, value);
  if (o.shape === "circle") {
    return [[add(o.center, [o.radius, 0]), (p) => ({ ...o, radius: min(norm(sub(p, o.center))) }), "resize"]];
  }
  if (o.start) {
    const c = centre(o);
    const side = unit([o.start[1] - o.end[1], o.end[0] - o.start[0]]);
    return [
      [o.start, (p) => ({ ...o, start: p }), "move this end"],
      [o.end, (p) => ({ ...o, end: p }), "move this end"],
      [add(c, scale(side, o.radius)), (p) => ({ ...o, radius: min(Math.abs(dot(sub(p, c), side))) }), "resize"],
    ];
  }
  if (o.half) {
    const R = rotationOf(o);
    const at = o.center;
    const axes = transposed(R);
    const arm = o.half[0] + 26 * pixel;
    return [
      [add(at, apply(R, o.half)), (p) => ({ ...o, half: axes.map((axis) => min(Math.abs(dot(sub(p, at), axis)))) }), "resize"],
      [add(at, scale(axes[0], arm)), (p) => ({ ...o, rotation: Math.atan2(p[1] - at[1], p[0] - at[0]) }), "turn"],
    ];
  }
  if (o.vertices) {
    const c = centre(o);
    const away = (vertex) => unit(sub(vertex, c));
    const first = o.vertices[0];
    const arm = add(first, scale(away(first), 26 * pixel));
    const angle = (p) => Math.atan2(p[1] - c[1], p[0] - c[0]);
    return [
      ...o.vertices.map((vertex, k) => [vertex, (p) => convex({ ...o, vertices: o.vertices.map((v, i) => (i === k ? p : v)) }, o), "move this corner"]),
      [arm, (p) => turned(o, angle(p) - angle(arm)), "turn"],
    ];
  }
  if (o.normal) {
    return [[add(o.point, scale(o.normal, 40 * pixel)), (p) => ({ ...o, normal: unit(sub(p, o.point)) }), "turn"]];
  }
  return [];
}

// The changed polygon if it is convex, else the one before.
function convex(changed, before) {
  const v = changed.vertices;
  const corner = (k) => {
    const [a, b, c] = [v[k], v[(k + 1) % v.length], v[(k + 2) % v.length]];
    return (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0]);
  };
  const signs = v.map((_, k) => Math.sign(corner(k)));
  return signs.every((sign) => sign === signs[0] && sign !== 0) ? changed : before;
}

// Distance [m] of a point from a plane shape, negative inside; near enough to tell what the pointer is on.
export function distance(o, p) {
  if (o.half) {
    const local = apply(transposed(rotationOf(o)), sub(p, o.center));
    const over = local.map((value, k) => Math.abs(value) - o.half[k]);
    return Math.max(...over) < 0 ? Math.max(...over) : norm(over.map((value) => Math.max(0, value)));
  }
  if (o.center) return norm(sub(p, o.center)) - (o.radius ?? 0);
  if (o.start) return segmentDistance(p, o.start, o.end) - o.radius;
  if (o.vertices) {
    const v = o.vertices;
    let inside = false;
    let nearest = Infinity;
    for (let i = 0, j = v.length - 1; i < v.length; j = i++) {
      nearest = Math.min(nearest, segmentDistance(p, v[i], v[j]));
      if (v[i][1] > p[1] !== v[j][1] > p[1] && p[0] < ((v[j][0] - v[i][0]) * (p[1] - v[i][1])) / (v[j][1] - v[i][1]) + v[i][0]) inside = !inside;
    }
    return inside ? -nearest : nearest;
  }
  return dot(sub(p, o.point), o.normal);
}

function segmentDistance(p, a, b) {
  const along = sub(b, a);
  const share = Math.min(1, Math.max(0, dot(sub(p, a), along) / Math.max(1e-12, dot(along, along))));
  return norm(sub(p, add(a, scale(along, share))));
}

// Where a ray meets a spatial shape, as a distance along it, or Infinity. A half-space is not picked.
export function rayHit(o, from, along) {
  if (o.center && !o.half) return raySphere(from, along, o.center, Math.max(o.radius ?? 0, 0.015));
  if (o.start) return rayCapsule(from, along, o.start, o.end, o.radius);
  if (!o.half) return Infinity;
  const R = transposed(rotationOf(o));
  const f = apply(R, sub(from, o.center));
  const v = apply(R, along);
  let [near, far] = [0, Infinity];
  for (let k = 0; k < 3; k++) {
    const [a, b] = [(-o.half[k] - f[k]) / v[k], (o.half[k] - f[k]) / v[k]];
    near = Math.max(near, Math.min(a, b));
    far = Math.min(far, Math.max(a, b));
  }
  return near <= far ? near : Infinity;
}

function raySphere(from, along, c, radius) {
  const offset = sub(from, c);
  const b = dot(offset, along);
  const inside = b * b - dot(offset, offset) + radius * radius;
  return inside >= 0 && -b - Math.sqrt(inside) > 0 ? -b - Math.sqrt(inside) : Infinity;
}

function rayCapsule(from, along, a, b, radius) {
  const count = 24; // spheres along it: near enough for a pointer
  let nearest = Infinity;
  for (let k = 0; k <= count; k++) nearest = Math.min(nearest, raySphere(from, along, add(a, scale(sub(b, a), k / count)), radius));
  return nearest;
}

// Rotation matrix (3, 3) that takes z to a direction.
export function upTo(direction) {
  const z = unit(direction);
  const side = Math.abs(z[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0];
  const x = unit(cross(side, z));
  return transposed([x, cross(z, x), z]);
}

