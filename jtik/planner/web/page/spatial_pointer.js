// The pointer on the spatial view: the gizmo moves what is selected; a click selects; the ground orbits; the wheel zooms.

import { gripAt } from "./gizmo.js";
import { add, cross, norm, quaternionOf, quaternionProduct, scale, sub } from "./math.js";
import { changeObstacle } from "./obstacles.js";
import { follow } from "./pointer.js";
import { moved, rayHit, turned } from "./shapes.js";
import { send } from "./socket.js";
import { obstacles, select, state } from "./state.js";

export function steerSpatial(view, redraw) {
  const { canvas } = view;
  let drag = null;
  const pixel = (event) => [event.offsetX, event.offsetY];

  function grip(at) {
    const { at: where, turning, chosen } = view.gizmo();
    const found = gripAt(view, where, view.gizmoSize(where), at, { turning });
    return found && { ...found, chosen };
  }

  function startGrip(found, at) {
    const move = found.start(view.ray(at));
    const position = [...state.frame.position];
    const orientation = [...state.frame.orientation];
    return (now) => {
      const change = move(view.ray(now));
      if (found.chosen) {
        const { name, obstacle } = found.chosen;
        const changed = change.by ? moved(obstacle, change.by) : turned(obstacle, change.angle, change.axis);
        changeObstacle(name, changed);
      } else if (change.by) send("move_target", { position: add(position, change.by) });
      else send("move_target", { position, orientation: quaternionProduct(quaternionOf(change.axis, change.angle), orientation) });
      redraw();
    };
  }

  function orbit(at) {
    const { yaw, pitch } = view;
    return (now) => {
      view.yaw = yaw - 0.008 * (now[0] - at[0]);
      view.pitch = Math.min(1.54, Math.max(-0.35, pitch + 0.008 * (now[1] - at[1])));
      redraw();
    };
  }

  function pan(at) {
    const { middle } = view;
    const right = view.right();
    const up = cross(right, view.forward());
    const perPixel = (0.73 * view.distance) / view.size[1];
    return (now) => {
      view.middle = add(middle, add(scale(right, (at[0] - now[0]) * perPixel), scale(up, (now[1] - at[1]) * perPixel)));
      redraw();
    };
  }

  function pick(at) {
    const { from, along } = view.ray(at);
    const hits = obstacles().map(({ name, obstacle }) => [rayHit(obstacle, from, along), name]).sort((a, b) => a[0] - b[0]);
    const near = norm(sub(view.toScreen([...state.frame.position]), at)) < 16;
    if (near) select({ kind: "target" });
    else select(hits.length && hits[0][0] < Infinity ? { kind: "obstacle", name: hits[0][1] } : { kind: "target" });
  }

  canvas.addEventListener("pointerdown", (event) => {
    if (state.frame === null) return;
    canvas.setPointerCapture(event.pointerId);
    const at = pixel(event);
    const found = event.button === 0 && !event.shiftKey ? grip(at) : null;
    const shifts = event.shiftKey || event.button !== 0;
    drag = { at, moved: false, gripped: Boolean(found), to: found ? startGrip(found, at) : shifts ? pan(at) : orbit(at) };
  });
  follow(canvas, () => drag !== null, (at) => {
    if (drag) {
      drag.moved ||= norm(sub(at, drag.at)) > 3;
      if (drag.moved) drag.to(at);
    } else if (state.frame) {
      const hot = grip(at)?.name ?? null;
      if (hot !== view.hot) redraw();
      view.hot = hot;
      canvas.style.cursor = hot ? "grab" : "default";
    }
  });
  const end = (event) => {
    if (drag && !drag.moved && !drag.gripped && event.type === "pointerup") pick(drag.at);
    if (event.type === "pointercancel") send("hold_target", { velocity: [0, 0, 0], rotation: [0, 0, 0] });
    drag = null;
  };
  canvas.addEventListener("pointerup", end);
  canvas.addEventListener("pointercancel", end);
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    view.distance = Math.min(200, Math.max(0.1, view.distance * Math.exp(0.0012 * event.deltaY)));
    redraw();
  }, { passive: false });
}
