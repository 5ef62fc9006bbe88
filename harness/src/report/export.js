// What is shown, for papers: a figure with its legend, and the points with their figures.

// Title, legend and machine around a figure.
function surroundings(charts, { inner, top, height }) {
  const title = charts.length === 1 ? charts[0].group.title : "all matrices";
  const entries = paperLegend(charts).map(([mark, words], i) =>
    drawing("g", { transform: `translate(${inner + 14} ${top + 40 + 21 * i})` }, mark, text(words, 26, 4, 12)),
  );
  const better = text("Better is left and down.", inner + 14, top + 52 + 21 * entries.length, 11, { fill: FAINT });
  return [text(title, 16, 32, 16), ...entries, better, text(machineLine(), 16, height - 12, 10, { fill: FAINT })];
}

// Marks and words of what is on the charts.
function paperLegend(charts) {
  const here = new Set(charts.flatMap((chart) => chart.points.map(({ row }) => row.family)));
  const outline = ({ outline: d, colour: fill }) =>
    drawing("path", { d, fill, stroke: "#ffffff", transform: "translate(9 0)" });
  return [
    ...families.filter(({ name }) => here.has(name)).map((family) => [outline(family), family.name]),
    [line([0, 0], [18, 0], { stroke: BEST, "stroke-width": 1.8 }), "Pareto frontier"],
    [line([0, 0], [18, 0], { "stroke-dasharray": "5,4" }), "exact reference"],
  ];
}

const paperSvg = () => new XMLSerializer().serializeToString(figure(PAPER.width, true).svg);

// Twice as many pixels as the figure has units.
async function paperPng() {
  const image = new Image();
  image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(paperSvg())}`;
  await image.decode();
  const canvas = element("canvas", { width: 2 * image.width, height: 2 * image.height });
  canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height);
  return new Promise((resolve) => canvas.toBlob(resolve, "image/png"));
}

function csv() {
  const keys = [...new Set([state.across, state.up])];
  const head = ["scene", "signal", "basis", "method", "family", ...keys, "on_frontier", "machine"];
  const lines = points.map(({ row, best }) => [
    row.scene,
    row.signal,
    row.basis,
    row.method,
    row.family,
    ...keys.map((key) => row[key]),
    best,
    machineLine(),
  ]);
  const cell = (value) => (/[",\n\r]/.test(value) ? `"${String(value).replaceAll('"', '""')}"` : String(value));
  return [head, ...lines].map((list) => list.map(cell).join(",") + "\n").join("");
}

// The file's name says what is on the chart.
function save(blob, extension) {
  const name = `${state.matrix} ${state.up} ${state.across}`.replace(/[^\w.-]+/g, "-");
  const link = element("a", { href: URL.createObjectURL(blob), download: `${name}.${extension}` });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

function say(words) {
  byId("said").value = words;
  setTimeout(() => (byId("said").value = ""), 3000);
}

async function copy(words) {
  try {
    await navigator.clipboard.writeText(words);
    say("copied");
  } catch {
    // No right to the clipboard: a file serves as well.
    save(new Blob([words], { type: "text/csv" }), "csv");
    say("saved");
  }
}

byId("save-svg").addEventListener("click", () => save(new Blob([paperSvg()], { type: "image/svg+xml" }), "svg"));
byId("save-png").addEventListener("click", async () => save(await paperPng(), "png"));
byId("copy-csv").addEventListener("click", () => copy(csv()));
