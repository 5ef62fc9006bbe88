// One chart in its frame: ground, frontier, reference, markers and labels.

const MARKER = 5;

// `charts` share their axes.
function drawChart(chart, frame, layout, charts) {
  const ground = new Plane(frame, layout, charts);
  const steps = stepsOf(chart.best, ground);
  const reference = ground.reference(referenceOf(chart.group), layout.single);
  put(chart.points, ground);
  // What is on the frontier lies above the rest.
  const order = [...chart.points].sort((a, b) => a.best - b.best);
  return drawing(
    "g",
    { class: "chart", "data-group": chart.group.index },
    ground.drawn(),
    drawing("polyline", { points: steps.join(" "), fill: "none", stroke: BEST, "stroke-width": 1.8 }),
    ...reference.flatMap((line) => line.shapes),
    ...order.map((point) => marker(point, layout)),
    ...(layout.single ? labelled(chart, steps, reference, frame, layout.narrow) : []),
    ...(chart.points.length ? [] : [nothing(frame)]),
  );
}

// The least of one that the other can be had for: level from a method to the next worse one, then down to it.
function stepsOf(best, { x, y, frame }) {
  const steps = [];
  for (const point of best) {
    const [px, py] = [x.pixel(point.x), y.pixel(point.y)];
    if (steps.length) steps.push([px, steps.at(-1)[1]]);
    steps.push([px, py]);
  }
  if (steps.length) steps.push([frame[2], steps.at(-1)[1]]);
  return steps;
}

// Gives each point its pixel; those of a strip beside each other.
function put(points, { x, y }) {
  points.forEach((point) => Object.assign(point, { px: x.pixel(point.x), py: y.pixel(point.y) }));
  const room = (strip) => Math.abs(strip[1] - strip[0]) / 2 - 7;
  const among = (key) => points.filter((point) => point[key] === 0);
  if (x.strip) setApart(among("x"), "py", "px", room(x.strip));
  if (y.strip) setApart(among("y"), "px", "py", room(y.strip));
}

function marker(point, { quantities, single }) {
  const family = familyOf(point.row);
  const said = quantities.map((quantity) => `${quantity.head} ${figureText(point.row, quantity)}`).join(", ");
  point.marker = drawing("path", {
    class: point.best ? "point on-frontier" : "point",
    d: family.outline,
    transform: `translate(${point.px.toFixed(2)} ${point.py.toFixed(2)}) scale(${single ? 1 : 0.8})`,
    fill: family.colour,
    stroke: "#ffffff",
    role: "img",
    "aria-label": `${point.row.method}: ${said}`,
    "data-row": point.index,
    "data-family": family.name,
  });
  return point.marker;
}

// Labels of the frontier, then of the other points, as far as there is room.
function labelled({ points }, steps, reference, frame, narrow) {
  const markers = points.map(({ px, py }) => boxAround(px, py, MARKER, MARKER));
  const lines = steps.slice(1).map((step, i) => lineBox(steps[i], step));
  const obstacles = [...markers, ...lines, ...reference.flatMap(({ boxes }) => boxes)];
  const order = points.filter(({ best }) => best || !narrow).sort((a, b) => b.best - a.best);
  const texts = ({ row, best }) => (best ? [row.method, row.label] : [row.label]);
  const wanted = order.map((point) => ({ ...point, texts: texts(point) }));
  return labels(wanted, 11, frame, obstacles).flatMap((label, i) => {
    const style = { class: "label", fill: order[i].best ? INK : FAINT };
    return label ? [text(label.text, label.x, label.y + 4, 11, style)] : [];
  });
}

function nothing([left, top, right, bottom]) {
  const style = { fill: FAINT, "text-anchor": "middle" };
  return text("no method has both figures", (left + right) / 2, (top + bottom) / 2, 12, style);
}
