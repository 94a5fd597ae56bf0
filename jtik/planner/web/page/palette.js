// Colours of the views. They are the figures' colours, read from the style sheet, so that there is one palette.

const RAMP = ["#ffffd9", "#edf8b1", "#c7e9b4", "#7fcdbb", "#41b6c4", "#1d91c0", "#225ea8", "#253494", "#081d58"];
const NAMES = ["bg", "ink", "muted", "grid", "axis", "obstacle", "obstacle-edge", "alarm", "limit", "accent", "arm", "target", "panel"];

export const colours = { dark: false };

const channels = (text) => {
  const value = parseInt(text.trim().slice(1), 16);
  return [(value >> 16) & 255, (value >> 8) & 255, value & 255].map((channel) => channel / 255);
};

export function readColours() {
  const style = getComputedStyle(document.documentElement);
  for (const name of NAMES) colours[name] = style.getPropertyValue(`--${name}`).trim();
  colours.dark = style.getPropertyValue("--dark").trim() === "1";
}

// Colours of a sequence: from pale (share 0) to strong (share 1) on the present background.
export function shade(share) {
  const from = colours.dark ? 0.8 : 0.26;
  const to = colours.dark ? 0.2 : 0.92;
  const at = Math.min(0.9999, Math.max(0, from + (to - from) * share)) * (RAMP.length - 1);
  const low = channels(RAMP[Math.floor(at)]);
  const high = channels(RAMP[Math.floor(at) + 1]);
  return low.map((value, k) => value + (high[k] - value) * (at % 1));
}

export const css = (rgb, alpha = 1) => `rgb(${rgb.map((value) => Math.round(255 * value)).join(" ")} / ${alpha})`;
export const rgb = (name) => channels(colours[name]);

// One colour for each attempt in overlays, far apart and readable on both backgrounds.
const ATTEMPTS = ["#1d91c0", "#bf7a3a", "#3f9c75", "#8a62b5", "#c25d86", "#7d8a2e", "#5c79c9", "#a0653c"];
export const attemptColour = (index) => ATTEMPTS[index % ATTEMPTS.length];
export const attemptRgb = (index) => channels(attemptColour(index));
