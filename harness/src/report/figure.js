// A figure: one chart, or a small one of each matrix with the same axes.

const PAPER = { width: 960, height: 600, legend: 204 };

// The figure of what is shown, so many pixels wide; on paper with what stands around it on this page.
function figure(width, paper = false) {
  const quantities = [quantityOf(state.across), quantityOf(state.up)];
  const charts = shownGroups().map((group) => ({ group, ...pointsOf(group, quantities) }));
  const layout = { ...(charts.length > 1 ? many : one)(charts.length, width, paper), width, quantities };
  const { height } = layout;
  const svg = drawing(
    "svg",
    { xmlns: "http://www.w3.org/2000/svg", width, height, viewBox: `0 0 ${width} ${height}`, "font-family": FONT },
    drawing("rect", { width, height, fill: "#ffffff" }),
    ...charts.map((chart, i) => drawChart(chart, layout.frames[i], layout, charts)),
    ...(layout.single ? [] : charts.map(({ group }, i) => heading(group, layout.frames[i]))),
    ...names(layout),
    ...(paper ? surroundings(charts, layout) : []),
  );
  return { svg, points: charts.flatMap(({ points }) => points) };
}

// What paper takes above, at the right and below.
const around = (paper) => (paper ? [48, PAPER.legend, 30] : [0, 0, 0]);

// Where the frame of a single chart is.
function one(_, width, paper) {
  const [top, right, below] = around(paper);
  const inner = width - right;
  const narrow = inner < 560;
  const height = paper ? PAPER.height : Math.round(Math.min(Math.max(0.62 * inner, 330), 540));
  const frame = [narrow ? 52 : 66, top + 32, inner - 10, height - below - 54];
  return { inner, height, narrow, top, frames: [frame], single: true };
}

// Where the frames of small ones are.
function many(count, width, paper) {
  const [above, right, below] = around(paper);
  const inner = width - right;
  const columns = Math.max(Math.floor(inner / 300), 1);
  const [across, down] = [inner / columns, 270];
  const frames = Array.from({ length: count }, (_, i) => {
    const [x, y] = [across * (i % columns), above + 22 + down * Math.floor(i / columns)];
    return [x + 56, y + 30, x + across - 10, y + down - 34];
  });
  const height = above + 48 + down * Math.ceil(count / columns) + below;
  return {
    inner,
    height: paper ? Math.max(height, PAPER.height) : height,
    narrow: true,
    top: above,
    frames,
    single: false,
  };
}

// The matrix over a small chart, as a link to its large one.
function heading(group, [left, top, right]) {
  let title = group.unique.replace(" ", " · ");
  while (textWidth(title, 12) > right - left) title = `${title.replace(/…$/, "").slice(0, -1)}…`;
  const href = `#${new URLSearchParams({ ...linked(), matrix: group.unique })}`;
  return drawing("a", { href }, text(title, left, top - 9, 12));
}

// What both axes are called: over the upright one, and under the middle of the level one, as far as the page is wide.
function names({ quantities: [across, up], frames, inner, top, narrow, single }) {
  const size = narrow ? 11 : 12;
  const [left, right] = single ? [frames[0][0], frames[0][2]] : [2, inner];
  const bottom = Math.max(...frames.map((frame) => frame[3]));
  const half = textWidth(across.axis, size) / 2;
  const middle = Math.max(Math.min((left + right) / 2, inner - half), half);
  const start = Math.max(Math.min(left, inner - textWidth(up.axis, size) - 4), 2);
  return [
    text(up.axis, start, top + 15, size),
    text(across.axis, middle, bottom + 44, size, { "text-anchor": "middle" }),
  ];
}
