// Elements of the page: made in one call, and the controls that several panels use.

export function el(tag, properties = {}, ...children) {
  const node = document.createElement(tag);
  for (const [key, value] of Object.entries(properties)) {
    if (key === "class") node.className = value;
    else if (key === "data") Object.assign(node.dataset, value);
    else if (key.startsWith("on")) node.addEventListener(key.slice(2), value);
    else if (key in node) node[key] = value;
    else node.setAttribute(key, value);
  }
  node.append(...children.flat().filter((child) => child !== null && child !== undefined));
  return node;
}

// The text of an element: what stays the same costs no layout.
export function setText(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

export const byId = (id) => document.getElementById(id);

const section = (title, open) => `open ${title}` in localStorage ? localStorage[`open ${title}`] === "1" : open;

// A part of a panel that can be closed; whether it is open is remembered.
export function part(title, body, open = true) {
  const node = el("details", { class: "part", open: section(title, open) }, el("summary", {}, title), ...body);
  node.addEventListener("toggle", () => (localStorage[`open ${title}`] = node.open ? "1" : "0"));
  return node;
}

export const words = (name) => name.replaceAll("_", " ");

// Names without what they all begin with, cut at a separator: panda_joint1 is joint1.
export function shortNames(names) {
  let shared = names.length > 1 ? names[0] : "";
  for (const name of names) while (!name.startsWith(shared)) shared = shared.slice(0, -1);
  const cut = Math.max(shared.lastIndexOf("_"), shared.lastIndexOf("/"), shared.lastIndexOf("-")) + 1;
  return names.map((name) => name.slice(cut));
}

export function figure(value, digits = 3) {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
  if (value === 0) return "0";
  const size = Math.abs(value);
  const text = size >= 1e5 || size < 1e-3 ? value.toExponential(1) : String(Number(value.toPrecision(digits)));
  return text.replace("-", "−").replace("e+", "e");
}

// A labelled number field. `set(value)` changes what it shows unless somebody is typing in it.
export function numberField(label, { unit = "", step = 0.1, min = null, change }) {
  const input = el("input", { type: "number", step: "any", "aria-label": label });
  if (min !== null) input.min = min;
  const apply = () => {
    const value = input.valueAsNumber;
    if (Number.isFinite(value) && (min === null || value >= min)) change(value);
  };
  input.addEventListener("change", apply);
  input.addEventListener("keydown", (event) => {
    if (event.key !== "ArrowUp" && event.key !== "ArrowDown") return;
    event.preventDefault();
    const moved = (input.valueAsNumber || 0) + (event.key === "ArrowUp" ? step : -step);
    input.value = Number((min === null ? moved : Math.max(min, moved)).toFixed(6));
    apply();
  });
  const node = el("label", { class: "field" }, el("span", {}, label), input, unit ? el("i", {}, unit) : null);
  const set = (value) => {
    const text = String(Number(value.toFixed(4)));
    if (document.activeElement !== input && input.value !== text) input.value = text;
  };
  return { node, input, set };
}

// A labelled slider with its value beside it. `mark(value)` shows where the present value is.
export function slider(label, { min, max, step = (max - min) / 400, unit = "", change, release = null, digits = 2 }) {
  const input = el("input", { type: "range", min, max, step, "aria-label": label });
  const shown = el("output", {});
  const here = el("u", {});
  const text = (value) => (shown.textContent = `${Number(value).toFixed(digits)}${unit ? ` ${unit}` : ""}`.replace("-", "−"));
  const fill = () => input.style.setProperty("--share", `${(100 * (input.value - min)) / (max - min)}%`);
  let grabbed = false;
  input.addEventListener("pointerdown", () => (grabbed = true));
  input.addEventListener("input", () => {
    text(input.valueAsNumber);
    fill();
    change(input.valueAsNumber);
  });
  for (const end of ["pointerup", "pointercancel", "blur", "keyup", "change"]) {
    input.addEventListener(end, () => {
      if (end !== "keyup" && end !== "change") grabbed = false;
      if (release !== null) release(set);
    });
  }
  const set = (value) => {
    if (grabbed) return;
    input.value = value;
    text(value);
    fill();
  };
  const mark = (value) => {
    const share = Math.min(1, Math.max(0, (value - min) / (max - min)));
    here.style.left = `calc(${100 * share}% + ${(0.5 - share) * 14}px)`;
    here.style.display = "block";
  };
  const node = el("label", { class: "slide" }, el("span", { title: label }, label), el("span", { class: "track" }, input, here), shown);
  return { node, input, set, mark };
}

// A labelled slider over decades, 10^low to 10^high, with a number field that takes more; with `zero` its left end is 0.
// With `live` a change is sent while the slider moves, else when it is let go.
export function logField(label, { name, low, high, zero = false, live = true, change }) {
  const toValue = (share) => (zero && share <= low ? 0 : Number((10 ** share).toPrecision(2)));
  const input = el("input", { type: "range", min: low, max: high, step: 0.05, "aria-label": name });
  const field = numberField(name, { min: zero ? 0 : 1e-4, change });
  const fill = () => input.style.setProperty("--share", `${(100 * (input.value - low)) / (high - low)}%`);
  const tell = () => change(toValue(input.valueAsNumber));
  input.addEventListener("input", () => {
    field.input.value = toValue(input.valueAsNumber);
    fill();
    if (live) tell();
  });
  if (!live) input.addEventListener("change", tell);
  field.node.firstChild.remove();
  const node = el("div", { class: "gain" }, el("span", { title: label }, label), el("span", { class: "track" }, input), field.node);
  const show = (value) => {
    if (typeof value !== "number" || document.activeElement === input) return;
    field.set(value);
    input.value = value > 0 ? Math.log10(value) : low;
    fill();
  };
  return { node, input, show };
}

export function toggle(label, change) {
  const input = el("input", { type: "checkbox", role: "switch", onchange: () => change(input.checked) });
  const node = el("label", { class: "switch" }, input, el("span", {}, label));
  return { node, input, set: (on) => (input.checked = on) };
}

export function choice(options, change, properties = {}) {
  const input = el("select", { ...properties, onchange: () => change(input.value) });
  for (const [value, text] of options) input.append(el("option", { value }, text));
  return input;
}

// A request to the planner. Throws an Error with what to tell the operator.
export async function ask(url) {
  const answer = await fetch(url).catch(() => {
    throw new Error("The planner does not answer: is it still running?");
  });
  if (!answer.ok) throw new Error((await answer.text()).trim());
  return answer;
}

// Save what the planner makes as a file. Returns its name and the answer; throws as `ask` does.
export async function download(url) {
  const answer = await ask(url);
  const name = /filename="([^"]*)"/.exec(answer.headers.get("Content-Disposition") ?? "")?.[1] ?? "file";
  const blob = URL.createObjectURL(await answer.blob());
  el("a", { href: blob, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(blob), 60_000);
  return { name, answer };
}
