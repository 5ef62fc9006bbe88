// The families: what their markers look like, and which of them are shown.

function drawLegend() {
  const here = new Set(shownGroups().flatMap(({ rows }) => rows.map(({ family }) => family)));
  byId("families").replaceChildren(...families.filter(({ name }) => here.has(name)).map(entry));
  const best = drawing("line", { x1: 0, x2: 18, y1: 7, y2: 7, stroke: BEST, "stroke-width": 1.8 });
  const reference = drawing("line", { x1: 0, x2: 18, y1: 7, y2: 7, stroke: INK, "stroke-dasharray": "5,4" });
  const lines = [
    [best, "Pareto frontier"],
    [reference, "exact reference"],
  ];
  const item = ([mark, said]) =>
    element("li", {}, drawing("svg", { width: 18, height: 14, "aria-hidden": "true" }, mark), said);
  byId("lines").replaceChildren(...lines.map(item), element("li", { class: "faint" }, "Better is left and down."));
}

function entry(family) {
  const box = element("input", { type: "checkbox", value: family.name });
  box.checked = !state.without.includes(family.name);
  const drawn = points.some(({ row }) => row.family === family.name);
  const label = element(
    "label",
    { class: drawn ? null : "faint" },
    box,
    markerIcon(family),
    element("span", {}, family.name),
  );
  label.addEventListener("pointerenter", () => dim(family.name));
  label.addEventListener("pointerleave", () => dim(null));
  return label;
}

// Leaves one family as it is and makes the others faint.
function dim(name) {
  sheet
    .querySelectorAll(".point")
    .forEach((mark) => mark.classList.toggle("dim", name !== null && mark.dataset.family !== name));
}

function toggle(name, shown) {
  const without = state.without.filter((other) => other !== name);
  change({ without: shown ? without : [...without, name] });
}

byId("families").addEventListener("change", ({ target }) => {
  toggle(target.value, target.checked);
  // The list was drawn anew.
  [...byId("families").querySelectorAll("input")].find((box) => box.value === target.value)?.focus();
});
byId("every").addEventListener("click", () => change({ without: [] }));
byId("none").addEventListener("click", () => change({ without: families.map(({ name }) => name) }));
