// Fields for the options of a strategy: numbers, switches and choices, as the strategy declares them.

import { choice, el, words } from "./dom.js";

export function optionFields(declared, given) {
  return declared.map((option) => {
      const value = given[option.name] ?? option.value;
      const input = inputFor(option, value);
      return { option, input, node: el("label", { class: "field", title: option.summary ?? "" }, el("span", {}, words(option.name.replace(".", ": "))), input) };
    });
}

function inputFor(option, value) {
  if (option.type === "choice") {
    const input = choice(option.choices.map((each) => [String(each), words(String(each))]), () => {});
    input.value = String(value);
    return input;
  }
  if (option.type === "flag") return el("input", { type: "checkbox", role: "switch", checked: Boolean(value) });
  if (typeof value === "number") return el("input", { type: "number", step: "any", value: value ?? "" });
  return el("input", { type: "text", value: value ?? "" });
}

// The options that were changed from their defaults.
export function readOptions(fields) {
  const read = {};
  for (const { option, input } of fields) {
    const value = input.type === "checkbox" ? input.checked : input.type === "number" ? input.valueAsNumber : input.value;
    const empty = value === "" || Number.isNaN(value);
    if (!empty && value !== option.value) read[option.name] = value;
  }
  return read;
}
