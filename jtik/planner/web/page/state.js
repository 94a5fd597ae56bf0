// What the page knows: the newest of everything that the planner sent, and what is selected here.

import { place } from "./math.js";

export const state = {
  setup: null, // what stays: the robot, and what can be chosen
  settings: null, // what an operator sets: the scene, gains, the strategy
  frame: null,
  status: null,
  attempts: [],
  selected: { kind: "target" }, // or { kind: "obstacle", name }
  overlays: new Set(),
  attempt: null, // the name of the attempt that the transport works on
  path: { points: [], postures: [], spacing: 0, length: 0 },
  drag: null, // an obstacle that is being changed: { name, obstacle }, ahead of the planner
  connected: false,
};

const listeners = new Map();

export function on(what, listener) {
  for (const each of what.split(" ")) {
    if (!listeners.has(each)) listeners.set(each, []);
    listeners.get(each).push(listener);
  }
}

export function emit(what, detail) {
  for (const listener of listeners.get(what) ?? []) listener(detail);
}

// The setup, with what the views ask most: names of the joints, the links that are drawn, whether the target turns.
export function read(setup) {
  const index = new Map(setup.frames.map((frame, k) => [frame, k]));
  const { joints, bodies } = setup.robot;
  return {
    ...setup,
    index,
    joints: joints.map((joint) => ({ ...joint, at: index.get(joint.frame) ?? -1 })),
    bodies: bodies.map((body) => ({ ...body, at: index.get(body.frame), towards: body.to === undefined ? -1 : index.get(body.to) })),
  };
}

// The bodies of the arm where the frames are: both ends of each capsule.
export function placed(poses) {
  return state.setup.bodies.map((body) => ({
    body,
    start: place(poses, body.at, body.start),
    end: body.towards < 0 ? place(poses, body.at, body.end) : place(poses, body.towards, [0, 0, 0]),
  }));
}

// What the newest status says of a body and of a joint.
export const touches = ({ frame, to }) => (state.status?.violated ?? []).some((each) => each === frame || each === to || each === `${frame}-${to}`);
export const limited = (joint) => (state.status?.active_limits ?? []).includes(joint.name);

export const planar = () => state.setup.robot.dimension === 2;

// The scene as it is seen here: an obstacle that is being dragged is shown where the pointer is.
export function obstacles() {
  return Object.entries(state.settings.scene).map(([name, { gain = 1, ...obstacle }]) => ({
    name,
    gain,
    obstacle: state.drag?.name === name ? state.drag.obstacle : obstacle,
  }));
}

export function select(selected) {
  state.selected = selected;
  emit("selected");
}

// The task that is guided, and the others, whose targets are held.
export const guided = () => state.settings.tasks.find(({ held }) => held === null);
export const heldTargets = () => state.settings.tasks.flatMap(({ held }) => (held === null ? [] : [held]));
export const oriented = () => guided().kind !== "position";

export const tip = () => state.setup.index.get(guided().frame) ?? 0;

const MAX_POINTS = 3000;
const MAX_POSTURES = 18;

export function clearPath() {
  state.path = { points: [], postures: [], spacing: state.setup.robot.reach / 30, length: 0 };
  emit("path");
}

// The path walked, and postures at equal distances along it. Both are thinned when there are too many.
export function walk(frame) {
  const path = state.path;
  const at = 7 * tip();
  const here = [frame.poses[at], frame.poses[at + 1], frame.poses[at + 2]];
  const last = path.points.at(-1);
  if (last) {
    const moved = Math.hypot(here[0] - last[0], here[1] - last[1], here[2] - last[2]);
    if (moved < 1e-3 * state.setup.robot.reach) return;
    path.length += moved;
  }
  path.points.push(here);
  if (path.points.length > MAX_POINTS) path.points = path.points.filter((_, k) => k % 2 === 0);
  if (path.length >= path.spacing * path.postures.length) path.postures.push(frame.poses);
  if (path.postures.length > MAX_POSTURES) {
    path.postures = path.postures.filter((_, k) => k % 2 === 0);
    path.spacing *= 2;
  }
}
