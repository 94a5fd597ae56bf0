// The dock below the view: record, play, scrub, undo and branch; the attempts side by side; check, commit and export.

import { ask, choice, download, el, figure, words } from "./dom.js";
import { attemptColour } from "./palette.js";
import { send } from "./socket.js";
import { emit, on, state } from "./state.js";

// key, heading, unit, whether a small value is the better one, what it means
const MEASURES = [
  ["duration", "time", "s", true, "duration of the attempt"],
  ["path_length", "path", "m", true, "length of the path of the end effector"],
  ["joint_length", "joints", "rad", true, "length of the path of the joints"],
  ["smoothness", "rms acc.", "rad/s²", true, "root mean square of the joint accelerations: small is smooth"],
  ["clearance", "clearance", "m", false, "smallest clearance, between the samples too"],
  ["limit_margin", "margin", "rad", false, "smallest distance of a joint from a limit"],
  ["condition", "condition", "", true, "largest condition number of the Jacobian"],
  ["closing_error", "closing", "rad", true, "distance between the first and the last posture of a closed path"],
];

const FORMATS = [["csv", "CSV"], ["json", "JSON"], ["npz", "NumPy (.npz)"], ["ros2.json", "ROS 2 JSON"], ["ros2.yaml", "ROS 2 YAML"], ["png", "Figure (.png)"], ["gif", "Animation (.gif)"]];

const measured = (attempt, key) => (key === "duration" ? attempt.duration : attempt.measures?.[key]);
const tone = (key, value, best) => (key === "clearance" && value < 0 ? "bad" : value === best ? "best" : "");
const current = () => state.attempts.find(({ name }) => name === state.attempt) ?? null;
const mode = () => state.frame?.mode ?? "live";

export const actions = {
  record: () => (state.frame?.recording ? send("stop_recording") : send("record")),
  play: () => {
    if (mode() === "playing") send("pause");
    else if (current()) send("play", { attempt: current().name });
  },
};

export function showDock(host) {
  const record = el("button", { id: "record", class: "record", onclick: actions.record }, "Record");
  const play = el("button", { id: "play", onclick: actions.play }, "Play");
  const bar = el("input", { id: "scrub", type: "range", min: 0, max: 1, step: 0.001, value: 0, "aria-label": "time in the attempt" });
  const clock = el("output", { class: "clock" });
  const undo = el("button", { id: "undo", title: "Go on guiding from this posture; the attempt stays", onclick: () => send("undo", at()) }, "Undo to here");
  const branch = el("button", { id: "branch", title: "Start a new attempt that shares the way up to here", onclick: () => send("branch", at()) }, "Branch here");
  const live = el("button", { id: "live", title: "Leave the attempt, and go on guiding", onclick: () => send("live") }, "Guide");
  const named = el("span", { class: "current" });
  const choose = el("button", { id: "choose", title: "Mark it as the one to carry out", onclick: () => send("choose", { attempt: current().name }) }, "Choose");
  const resolve = choice([["", "Resolve with"], ...state.setup.strategies.map((each) => [each.name, words(each.name)])], (strategy) => {
    if (strategy) {
      state.recorded = false; // the attempt may have come before the frame that said that the recording has ended
      send("resolve", { attempt: current().name, strategy });
    }
    resolve.value = "";
  }, { id: "resolve", "aria-label": "resolve the attempt with another strategy", title: "Follow the same targets with another strategy" });
  const commit = el("button", { id: "commit", class: "primary", title: "Check it, and export it", onclick: () => commitDialog(current().name) }, "Commit");
  const table = el("div", { class: "attempts" });
  host.append(
    el("div", { class: "transport" }, record, play, el("span", { class: "track" }, bar), clock, live),
    el("div", { class: "transport second" }, named, undo, branch, choose, resolve, commit),
    table,
  );

  const at = () => ({ attempt: current()?.name, time: bar.valueAsNumber });
  let scrubbing = false;
  bar.addEventListener("input", () => {
    scrubbing = true;
    fill();
    send("scrub", at());
  });
  bar.addEventListener("change", () => (scrubbing = false));
  let since = null; // when the recording began [ms]
  const fill = () => {
    bar.style.setProperty("--share", `${(100 * bar.value) / Math.max(1e-9, bar.max)}%`);
    if (since !== null) clock.textContent = `recording ${((performance.now() - since) / 1000).toFixed(1)} s`;
    else clock.textContent = `${Number(bar.value).toFixed(2)} / ${Number(bar.max).toFixed(2)} s`;
  };

  function refresh() {
    const attempt = current();
    const { recording } = state.frame ?? {};
    record.textContent = recording ? "Stop" : "Record";
    record.classList.toggle("on", Boolean(recording));
    play.textContent = mode() === "playing" ? "Pause" : "Play";
    for (const node of [play, bar, undo, branch, choose, resolve, commit]) node.disabled = attempt === null || Boolean(recording);
    named.textContent = attempt?.name ?? "no attempt";
    choose.disabled ||= Boolean(attempt?.chosen);
    live.hidden = mode() === "live";
    since = recording ? since ?? performance.now() : null;
    bar.max = attempt?.duration ?? 0;
    if (attempt?.name !== shown && mode() === "live") bar.value = bar.max; // the arm is where it ends, or was last
    shown = attempt?.name;
    fill();
  }
  let shown = null;
  on("mode attempts", refresh);
  on("status", () => since !== null && fill());
  on("frame", () => {
    if (!scrubbing && state.frame.shown >= 0) bar.value = state.frame.shown;
    if (mode() !== "live") fill();
  });
  on("attempts robot", () => table.replaceChildren(attemptTable()));
  on("chosen-attempt", () => {
    refresh();
    table.replaceChildren(attemptTable());
  });
  table.replaceChildren(attemptTable());
  refresh();
}

function attemptTable() {
  if (state.attempts.length === 0) {
    return el("p", { class: "empty" }, "No attempts yet. Press Record, guide the target through the field, and press Stop.");
  }
  const best = Object.fromEntries(MEASURES.map(([key, , , small]) => {
    const values = state.attempts.map((attempt) => measured(attempt, key)).filter((value) => typeof value === "number");
    return [key, values.length > 1 ? (small ? Math.min(...values) : Math.max(...values)) : NaN];
  }));
  const head = el("tr", {}, el("th", {}, "show"), el("th", { class: "left" }, "attempt"), el("th", { class: "left" }, "strategy"),
    MEASURES.map(([, heading, unit, , meaning]) => el("th", { title: meaning }, heading, unit ? el("i", {}, unit) : null)), el("th", {}));
  return el("table", {}, el("thead", {}, head), el("tbody", {}, state.attempts.map((attempt, index) => attemptRow(attempt, index, best))));
}

function attemptRow(attempt, index, best) {
  const { name } = attempt;
  const show = el("input", { type: "checkbox", checked: state.overlays.has(name), "aria-label": `overlay ${name}`, onchange: () => {
    show.checked ? state.overlays.add(name) : state.overlays.delete(name);
    emit("overlays");
  } });
  const pick = el("button", { class: "name", title: "Work on this attempt", onclick: () => {
    state.attempt = name;
    emit("chosen-attempt");
  } }, name);
  const label = el("td", { class: "left" }, pick, attempt.chosen ? el("b", { class: "chip chosen" }, "chosen") : null, attempt.parent ? el("small", {}, `from ${attempt.parent} at ${figure(attempt.branched_at)} s`) : null);
  return el("tr", { class: name === state.attempt ? "current" : "", data: { attempt: name } },
    el("td", {}, el("label", { class: "dot", style: `--dot: ${attemptColour(index)}` }, show, el("span", {}))),
    label,
    el("td", { class: "left" }, words(attempt.strategy ?? "")),
    MEASURES.map(([key]) => el("td", { class: tone(key, measured(attempt, key), best[key]) }, figure(measured(attempt, key)))),
    el("td", {}, el("button", { class: "quiet", title: `Delete ${name}`, "aria-label": `delete ${name}`, onclick: () => send("delete_attempt", { attempt: name }) }, "×")));
}

// The checks of an attempt, asked for when it is opened, and the files that it can be exported as.
export async function commitDialog(name) {
  const dialog = document.getElementById("dialog");
  const findings = el("ul", { class: "findings" }, el("li", {}, "checking"));
  const written = el("div", { id: "exported", class: "exported" });
  const format = choice(FORMATS, () => {}, { "aria-label": "format", id: "format" });
  const button = el("button", { class: "primary", id: "export", onclick: async () => {
    button.disabled = true;
    written.replaceChildren(el("p", { class: "note" }, "Timing, checking and writing"));
    written.replaceChildren(...await exported(name, format.value));
    button.disabled = false;
  } }, "Export");
  dialog.replaceChildren(
    el("h2", {}, `Commit ${name}`),
    el("p", { class: "note" }, "The attempt as it was recorded: limits, speeds, and the clearance between samples."), findings,
    el("p", { class: "note" }, "A file has its path, timed within the limits of the joints, and is checked again."),
    el("div", { class: "row" }, format, button, el("button", { onclick: () => dialog.close() }, "Close")), written);
  dialog.showModal();
  try {
    const answer = await ask(`check/${encodeURIComponent(name)}`);
    findings.replaceChildren(...findingsList(await answer.json(), "Nothing found: the attempt can be committed."));
  } catch (error) {
    findings.replaceChildren(el("li", { class: "bad" }, error.message));
  }
}

const findingsList = (found, none) => (found.length ? found.map((each) => el("li", { class: "bad" }, String(each))) : [el("li", { class: "good" }, none)]);

// Save an attempt as a file; what is reported about it: how it was timed, and what the check of its motion finds.
async function exported(name, format) {
  try {
    const { name: file, answer } = await download(`export/${format}/${encodeURIComponent(name)}`);
    const { about, findings } = JSON.parse(decodeURIComponent(answer.headers.get("Jtik-Export")));
    return [el("p", { class: "note" }, el("b", {}, file), ` ${about}`), el("ul", { class: "findings" }, findingsList(findings, "Nothing found in the motion of this file."))];
  } catch (error) {
    return [el("ul", { class: "findings" }, el("li", { class: "bad" }, error.message))];
  }
}
