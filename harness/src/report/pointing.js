// The figure on this page: it answers to pointer and keys.

// A pointer this near to a marker means it, pixels.
const NEAR = 24;
const sheet = byId("plane");
// The points of the figure, and the one that is pointed at.
let points = [];
let pointed = null;

function drawFigure(width = Math.max(sheet.clientWidth, 300)) {
  const focused = points.find((point) => point.marker === document.activeElement);
  const made = figure(width);
  points = made.points;
  made.svg.setAttribute("role", "group");
  made.svg.setAttribute("aria-label", "Methods; arrow keys go from one to the next, Enter keeps its figures in sight");
  sheet.replaceChildren(made.svg);
  points.forEach(({ marker: mark }, i) => mark.setAttribute("tabindex", i ? -1 : 0));
  pointed = null;
  const again = focused && points.find((point) => point.row === focused.row);
  if (again) again.marker.focus();
  pointAt(again ?? null);
  explain();
}

// How the figures of both axes were measured.
function explain() {
  const line = (arrow, { axis, how }) => [element("dt", {}, `${arrow} ${axis}`), element("dd", {}, how)];
  byId("how").replaceChildren(...line("↑", quantityOf(state.up)), ...line("→", quantityOf(state.across)));
}

const pinned = () => points.find(({ group, row }) => isPinned(group, row)) ?? null;

// Rings the point, shows its line in the table and, if asked to, its figures; without one, those of the pinned point.
function pointAt(point, figures = true) {
  pointed = point;
  sheet.querySelectorAll(".ring").forEach((ring) => ring.remove());
  const shown = point ?? pinned();
  new Set([point, pinned()].filter(Boolean)).forEach(ring);
  emphasize(shown);
  if (shown && (figures || !point)) showTooltip(shown);
  else hideTooltip();
}

function ring({ marker: mark, px, py }) {
  mark.parentNode.append(
    drawing("circle", { class: "ring", cx: px, cy: py, r: 9, fill: "none", stroke: INK, "stroke-width": 1.5 }),
  );
}

function pin(point) {
  const same = point && isPinned(point.group, point.row);
  change({ pin: point && !same ? pinOf(point.group, point.row) : "" });
}

function nearest({ clientX, clientY }) {
  const distance = ({ marker: mark }) => {
    const box = mark.getBoundingClientRect();
    return Math.hypot((box.left + box.right) / 2 - clientX, (box.top + box.bottom) / 2 - clientY);
  };
  const [best] = points.map((point) => ({ point, far: distance(point) })).sort((a, b) => a.far - b.far);
  return best && best.far < NEAR ? best.point : null;
}

// The neighbour in the direction of an arrow key, in the order of that axis.
function neighbour(point, key) {
  const along = key === "ArrowLeft" || key === "ArrowRight" ? "px" : "py";
  const sign = key === "ArrowRight" || key === "ArrowDown" ? 1 : -1;
  const order = [...points].sort((a, b) => a.group.index - b.group.index || a[along] - b[along] || a.index - b.index);
  return order[order.indexOf(point) + sign] ?? point;
}

function focusOn(point) {
  points.forEach(({ marker: mark }) => mark.setAttribute("tabindex", -1));
  point.marker.setAttribute("tabindex", 0);
  point.marker.focus();
}

const pointOf = (target) => points.find(({ marker: mark }) => mark === target) ?? null;

sheet.addEventListener("pointermove", (event) => {
  const near = nearest(event);
  if (near !== pointed) pointAt(near);
});
sheet.addEventListener("pointerleave", () => pointAt(null));
sheet.addEventListener("click", (event) => {
  if (event.target.closest("a")) return;
  pin(nearest(event));
});
sheet.addEventListener("focusin", ({ target }) => pointAt(pointOf(target)));
sheet.addEventListener("focusout", () => pointAt(null));
sheet.addEventListener("keydown", (event) => {
  const point = pointOf(event.target);
  if (!point) return;
  if (event.key.startsWith("Arrow")) focusOn(neighbour(point, event.key));
  else if (event.key === "Enter" || event.key === " ") pin(point);
  else return;
  event.preventDefault();
});
addEventListener("keydown", ({ key }) => {
  if (key === "Escape") change({ pin: "" });
});
