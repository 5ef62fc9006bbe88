// Places labels beside their points, where they cover nothing.

const FONT = "'Helvetica Neue', Arial, 'Liberation Sans', sans-serif";
const ruler = document.createElement("canvas").getContext("2d");

function textWidth(text, size) {
  ruler.font = `${size}px ${FONT}`;
  return ruler.measureText(text).width;
}

const boxAround = (x, y, halfWidth, halfHeight) => [x - halfWidth, y - halfHeight, x + halfWidth, y + halfHeight];
const meet = (a, b) => a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3];
const inside = (a, b) => a[0] >= b[0] && a[1] >= b[1] && a[2] <= b[2] && a[3] <= b[3];

// The box around a line between two points that are level or upright to each other.
const lineBox = ([x1, y1], [x2, y2]) => [
  Math.min(x1, x2) - 1,
  Math.min(y1, y2) - 1,
  Math.max(x1, x2) + 1,
  Math.max(y1, y2) + 1,
];

// For each point of {px, py, texts} the middle left of its first text that has a place; none where no text has one.
function labels(points, size, frame, obstacles) {
  const taken = [...obstacles];
  return points.map(({ px, py, texts }) => {
    for (const text of texts) {
      const box = candidates(px, py, textWidth(text, size) / 2, size / 2).find(
        (candidate) => inside(candidate, frame) && !taken.some((other) => meet(other, candidate)),
      );
      if (box) {
        taken.push(box);
        return { text, x: box[0], y: (box[1] + box[3]) / 2 };
      }
    }
    return null;
  });
}

// Right, left, above, below, then the corners: the first is the best.
function candidates(x, y, halfWidth, halfHeight) {
  const [dx, dy] = [halfWidth + 9, halfHeight + 8];
  const sides = [
    [dx, 0],
    [-dx, 0],
    [0, -dy],
    [0, dy],
  ];
  const corners = [
    [dx - 4, -dy],
    [-dx + 4, -dy],
    [dx - 4, dy],
    [-dx + 4, dy],
  ];
  return [...sides, ...corners].map(([right, down]) => boxAround(x + right, y + down, halfWidth, halfHeight));
}

// Moves the points of a strip apart, across it, where their markers would cover each other: there is no axis that way.
function setApart(points, along, across, room) {
  const placed = [];
  for (const point of [...points].sort((a, b) => a[along] - b[along])) {
    const offsets = [0, 11, -11, 22, -22, 33, -33].filter((offset) => Math.abs(offset) <= room);
    const free = (offset) =>
      placed.every((p) => Math.hypot(p[along] - point[along], p[across] - point[across] - offset) >= 11);
    point[across] += offsets.find(free) ?? 0;
    placed.push(point);
  }
}
