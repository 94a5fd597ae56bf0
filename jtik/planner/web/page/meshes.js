// The robot's own meshes in space: loaded once, when the switch is used first; the switch is remembered.

import { ask, toggle } from "./dom.js";
import { rigid, rotate, transposed } from "./math.js";
import { rgb } from "./palette.js";
import { emit, state, touches } from "./state.js";

const AXES = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];

// The switch. Where there is nothing to show, it is off for good and says why.
export function meshSwitch(view, redraw) {
  let loaded = null;
  const show = async (on) => {
    localStorage.meshes = on ? "1" : "0";
    try {
      if (on) loaded ??= load(view.renderer);
      view.meshes = on ? await loaded : null;
    } catch (error) {
      loaded = null;
      box.set(false);
      emit("message", { level: "error", text: error.message });
    }
    if (!box.input.checked) view.meshes = null; // switched off while they were loaded
    redraw();
  };
  const box = toggle("Meshes", show);
  const why = state.setup.robot.no_meshes || (view.renderer.large ? "" : "This browser draws no meshes as large as these.");
  box.node.title = why || "Show the robot's own meshes in place of capsules";
  box.input.disabled = Boolean(why);
  if (!why && localStorage.meshes === "1") {
    box.set(true);
    show(true);
  }
  return box.node;
}

// Words of 32 bits: the number of parts; for each the frame, the numbers of corners c and triangles t, corners with
// normals (c, 6), the corners of the triangles (t, 3).
async function load(renderer) {
  const answer = await ask("meshes");
  const buffer = await answer.arrayBuffer();
  for (const text of JSON.parse(decodeURIComponent(answer.headers.get("Jtik-Notes") ?? "[]"))) emit("message", { level: "warning", text });
  const whole = new Uint32Array(buffer);
  const parts = [];
  let at = 1;
  while (parts.length < whole[0]) {
    const [frame, corners, triangles] = whole.subarray(at, at + 3);
    at += 3;
    const mesh = renderer.indexed(new Float32Array(buffer, 4 * at, 6 * corners), whole.subarray(at + 6 * corners, at + 6 * corners + 3 * triangles));
    at += 6 * corners + 3 * triangles;
    parts.push({ frame, mesh });
  }
  const frames = new Set(parts.map(({ frame }) => frame));
  // A link of the skeleton, from one frame to the next, is hidden by any mesh; a solid by one on its own frame.
  const hides = (body) => frames.has(body.at) || (body.towards >= 0 && frames.size > 0);
  return { parts, hides };
}

export function drawMeshes(renderer, { parts }, poses) {
  for (const { frame, mesh } of parts) {
    const [x, y, z, ...q] = poses.subarray(7 * frame, 7 * frame + 7);
    const touched = state.setup.bodies.some((body) => body.at === frame && touches(body));
    const R = transposed(AXES.map((axis) => rotate(q, axis)));
    renderer.draw(mesh, rigid(R, [x, y, z]), [1, 1, 1], rgb(touched ? "alarm" : "arm"));
  }
}
