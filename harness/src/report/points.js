// Rows as points of a chart.

// What is left of an exact matrix is the rounding of f32 sums: its place is among the exact ones, not decades away.
const ROUNDING = 1e-12;

const isLossless = (row) => row.error === 0;

// Where a row lies along a quantity; none where it has no figure, or one that a logarithm has no place for.
function coordinate(row, quantity) {
  const value = row[quantity.key];
  if (!isOk(row) || !isNumber(value) || value < 0) return null;
  return quantity.role === "error" && isLossless(row) && value < ROUNDING ? 0 : value;
}

// Failed rows are neither lossless nor lossy.
function isShown(row) {
  if (state.without.includes(row.family)) return false;
  if (state.show === "all") return true;
  return isOk(row) && isLossless(row) === (state.show === "lossless");
}

// The points of a matrix, and which of them no other one beats.
function pointsOf(group, [across, up]) {
  const points = group.rows
    .map((row, index) => ({ group, row, index, x: coordinate(row, across), y: coordinate(row, up), best: false }))
    .filter((point) => isShown(point.row) && point.x !== null && point.y !== null);
  const best = frontier(points).map((i) => points[i]);
  best.forEach((point) => (point.best = true));
  return { points, best };
}
