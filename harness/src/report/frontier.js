// The Pareto frontier.

// Indices of the points that no other one beats: none has less of one at no more of the other. Of equal points the first
// is kept. The result ascends in x and descends in y.
function frontier(points) {
  const order = points.map((_, i) => i);
  order.sort((a, b) => points[a].x - points[b].x || points[a].y - points[b].y || a - b);
  const kept = [];
  for (const i of order) {
    if (!kept.length || points[i].y < points[kept.at(-1)].y) kept.push(i);
  }
  return kept;
}
