// Keys on the focused view and gamepads: the target's velocity and the rate along the self-motion.

import { add, cross, norm, scale } from "./math.js";
import { send } from "./socket.js";
import { emit, on, planar, state } from "./state.js";

const MOVES = {
  ArrowLeft: [-1, 0, 0], KeyA: [-1, 0, 0], ArrowRight: [1, 0, 0], KeyD: [1, 0, 0],
  ArrowUp: [0, 1, 0], KeyW: [0, 1, 0], ArrowDown: [0, -1, 0], KeyS: [0, -1, 0],
  PageUp: [0, 0, 1], KeyE: [0, 0, 1], PageDown: [0, 0, -1], KeyQ: [0, 0, -1],
};
const JOGS = { BracketLeft: -1, BracketRight: 1, Comma: -1, Period: 1 };
const JOG_RATE = 0.6; // share of the fastest jog, for a key
const JOG_SPEED = 1; // fastest motion along the self-motion [rad/s]
const DEAD = 0.12; // deflection of a stick that counts as none

const pressed = new Set();
let held = ""; // the last velocity that was sent, as text; empty when it was zero
let jogged = 0;

// A deflection right, up and vertical, as a direction in the world: in the plane, or as the camera sees the ground.
function direction(deflection, view) {
  if (planar()) return deflection.slice(0, 2);
  const right = view.right();
  const ahead = cross([0, 0, 1], right);
  return add(add(scale(right, deflection[0]), scale(ahead, deflection[1])), [0, 0, deflection[2]]);
}

export function hold(deflection, view) {
  const size = Math.max(1, norm(deflection));
  const velocity = scale(direction(scale(deflection, 1 / size), view), state.settings.target_speed[0]);
  const text = norm(velocity) > 0 ? JSON.stringify(velocity) : "";
  if (text === held) return;
  held = text;
  send("hold_target", { velocity });
}

export function jog(share) {
  if (share === jogged) return;
  jogged = share;
  send("jog", { rate: share * JOG_SPEED });
  emit("jogged", share);
}

function stop(view) {
  pressed.clear();
  if (state.settings === null) return;
  hold([0, 0, 0], view);
  jog(0);
}

export function listen(host, view, actions) {
  const act = () => {
    hold([...pressed].map((code) => MOVES[code] ?? [0, 0, 0]).reduce(add, [0, 0, 0]), view());
    const share = [...pressed].map((code) => JOGS[code] ?? 0).reduce((a, b) => a + b, 0);
    jog(JOG_RATE * Math.sign(share));
  };
  host.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || state.settings === null) return;
    if (event.code in MOVES || event.code in JOGS) {
      event.preventDefault();
      if (!event.repeat) {
        pressed.add(event.code);
        act();
      }
    } else if (event.code in actions && !event.repeat) {
      event.preventDefault();
      actions[event.code]();
    }
  });
  host.addEventListener("keyup", (event) => {
    if (pressed.delete(event.code)) act();
  });
  for (const [node, event] of [[host, "blur"], [window, "blur"], [window, "pagehide"]]) node.addEventListener(event, () => stop(view()));
  document.addEventListener("visibilitychange", () => document.hidden && stop(view()));
  on("connection", () => {
    pressed.clear();
    held = "";
    jogged = 0;
  });
}

// Reads the first gamepad once a picture: left stick in the plane, right stick vertical and along the self-motion.
let steers = false;

export function pollGamepad(view) {
  const pad = [...(navigator.getGamepads?.() ?? [])].find((each) => each?.connected);
  if (!pad || state.settings === null) {
    if (steers) stop(view);
    steers = false;
    return false;
  }
  const axis = (k) => (Math.abs(pad.axes[k] ?? 0) < DEAD ? 0 : pad.axes[k]);
  const deflection = [axis(0), -axis(1), planar() ? 0 : -axis(3)];
  const share = axis(2);
  const active = norm(deflection) > 0 || share !== 0;
  if (active || steers) {
    hold(deflection, view);
    jog(share);
  }
  steers = active;
  return true;
}
