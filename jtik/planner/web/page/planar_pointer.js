// The pointer on the planar view: the target, obstacles and their handles are dragged; the wheel zooms; the ground pans.

import { add, norm, sub } from "./math.js";
import { changeObstacle } from "./obstacles.js";
import { follow } from "./pointer.js";
import { distance, handles, moved } from "./shapes.js";
import { send } from "./socket.js";
import { obstacles, oriented, select, state } from "./state.js";

const NEAR = 16; // [pixel]

export function steerPlanar(view, redraw) {
  const { canvas } = view;
  let drag = null;

  const pixel = (event) => [event.offsetX, event.offsetY];
  const near = (point, at) => norm(sub(view.toScreen(point), at)) < NEAR;

  // What is under the pointer: a function of the pointer's positions that drags it.
  function grab(at) {
    const here = view.toWorld(at);
    const { position, orientation } = state.frame;
    const target = [position[0], position[1]];
    if (oriented() && near(view.turnHandle(2 * Math.atan2(orientation[3], orientation[0])), at)) {
      return { cursor: "grab", chosen: { kind: "target" }, to: (p) => turnTarget(target, p) };
    }
    if (near(target, at)) {
      return { cursor: "grab", chosen: { kind: "target" }, to: (p) => send("move_target", { position: add(target, sub(p, here)) }) };
    }
    const all = obstacles();
    const chosen = all.find(({ name }) => state.selected.kind === "obstacle" && name === state.selected.name);
    for (const [point, change, does] of chosen ? handles(chosen.obstacle, 1 / view.zoom) : []) {
      if (norm(sub(view.toScreen(point), at)) < 9) {
        return { cursor: does === "resize" ? "nwse-resize" : "grab", hint: does, chosen: state.selected, to: (p) => changeObstacle(chosen.name, change(p)) };
      }
    }
    const reach = 6 / view.zoom;
    const hit = all.filter(({ obstacle }) => distance(obstacle, here) < reach).sort((a, b) => distance(b.obstacle, here) - distance(a.obstacle, here));
    const top = hit.find(({ obstacle }) => !obstacle.normal) ?? hit.find(({ obstacle }) => Math.abs(distance(obstacle, here)) < 2 * reach);
    if (top) {
      return { cursor: "move", chosen: { kind: "obstacle", name: top.name }, to: (p) => changeObstacle(top.name, moved(top.obstacle, sub(p, here))) };
    }
    return null;
  }

  function turnTarget(target, p) {
    const angle = Math.atan2(p[1] - target[1], p[0] - target[0]);
    send("move_target", { position: target, orientation: [Math.cos(angle / 2), 0, 0, Math.sin(angle / 2)] });
  }

  canvas.addEventListener("pointerdown", (event) => {
    if (state.frame === null || event.button === 2) return;
    canvas.setPointerCapture(event.pointerId);
    const at = pixel(event);
    const found = event.button === 0 && !event.shiftKey ? grab(at) : null;
    if (found) select(found.chosen);
    const middle = view.middle;
    drag = found ?? {
      pan: true,
      to: (_, now) => {
        view.middle = add(middle, [(at[0] - now[0]) / view.zoom, (now[1] - at[1]) / view.zoom]);
        redraw();
      },
    };
    drag.from = at;
  });

  follow(canvas, () => drag !== null, (at) => {
    if (drag) drag.to(view.toWorld(at), at);
    else if (state.frame) canvas.style.cursor = grab(at)?.cursor ?? "default";
  });

  const end = (event) => {
    if (drag?.pan && norm(sub(pixel(event), drag.from)) < 3) select({ kind: "target" });
    if (event.type === "pointercancel") send("hold_target", { velocity: [0, 0] });
    drag = null;
  };
  canvas.addEventListener("pointerup", end);
  canvas.addEventListener("pointercancel", end);
  canvas.addEventListener("dblclick", (event) => send("move_target", { position: view.toWorld(pixel(event)) }));
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    view.zoomAt(pixel(event), Math.exp(-0.0015 * event.deltaY));
    redraw();
  }, { passive: false });
}
