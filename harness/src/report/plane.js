// The ground of a chart: strips, grid, both axes with their marks, and the exact reference.

const [INK, FAINT, GRID, STRIP, BEST] = ["#222222", "#6b6b6b", "#e6e6e6", "#f1f4f8", "#8a8a8a"];

function line([x1, y1], [x2, y2], attributes = {}) {
  return drawing("line", { x1, y1, x2, y2, stroke: INK, "stroke-width": 1, ...attributes });
}

function text(content, x, y, size, attributes = {}) {
  return drawing("text", { x, y, "font-size": size, fill: INK, ...attributes }, content);
}

// An axis at its side of a frame [left, top, right, bottom].
class Side {
  constructor(axis, [left, top, right, bottom], size) {
    this.upright = axis.from > axis.to;
    Object.assign(this, { axis, left, bottom, size, extent: this.upright ? right - left : bottom - top });
  }

  // So far along the axis, and out of the frame.
  at(along, out) {
    return this.upright ? [this.left - out, along] : [along, this.bottom + out];
  }

  // Across the frame.
  across(along, attributes) {
    return line(this.at(along, 0), this.at(along, -this.extent), attributes);
  }

  said(words, along) {
    const [x, y] = this.upright ? this.at(along + 4, 9) : this.at(along, 20);
    return text(words, x, y, this.size, { "text-anchor": this.upright ? "end" : "middle" });
  }

  // What is 0 has its strip. The axis is broken there: it is no distance away from the smallest value.
  strip() {
    const { strip, logFrom, to, zero } = this.axis;
    if (!strip) return [];
    const corners = [
      [strip[0], 0],
      [strip[1], 0],
      [strip[1], -this.extent],
      [strip[0], -this.extent],
    ];
    const ground = drawing("polygon", { points: corners.map((corner) => this.at(...corner)).join(" "), fill: STRIP });
    const ends = strip[1] === to ? [] : [strip[1], logFrom];
    const tilt = this.upright ? -3 : 3;
    const breaks = ends.map((along) => line(this.at(along - tilt, 6), this.at(along + tilt, -6)));
    return [
      ground,
      this.said(zero, (strip[0] + strip[1]) / 2),
      line(this.at(strip[0], 0), this.at(strip[1], 0)),
      ...breaks,
    ];
  }

  marks() {
    const { axis } = this;
    const marks = axis
      .ticks()
      .flatMap(({ pixel, words }) => [
        ...(words === null ? [] : [this.across(pixel, { stroke: GRID }), this.said(words, pixel)]),
        line(this.at(pixel, 0), this.at(pixel, words === null ? 3 : 6)),
      ]);
    return marks.length ? [...marks, line(this.at(axis.logFrom, 0), this.at(axis.to, 0))] : [];
  }

  // A dashed line at what the exact sparse matrix costs, its name if asked for, and the boxes that both take.
  reference(row, named) {
    const { axis } = this;
    const cost = costOf(row, axis.quantity);
    if (cost === null || !axis.holds(cost)) return [];
    const [from, to] = [this.at(axis.pixel(cost), 0), this.at(axis.pixel(cost), -this.extent)];
    const [x, y] = this.upright ? [to[0] - 4, to[1] - 5] : [from[0] + 5, from[1] - 8];
    const name = text("csr, exact", x, y, 11, { "text-anchor": this.upright ? "end" : "start" });
    const box = this.upright ? [x - 62, y - 11, x, y + 3] : [x, y - 11, x + 62, y + 3];
    const dashed = line(from, to, { "stroke-dasharray": "5,4" });
    return [
      { shapes: named ? [dashed, name] : [dashed], boxes: named ? [lineBox(from, to), box] : [lineBox(from, to)] },
    ];
  }
}

// The cost of the exact sparse matrix; an error it has none.
const costOf = (row, quantity) => (row && quantity.role === "cost" ? coordinate(row, quantity) : null);

// Both axes of a chart over its frame, wide enough for the points and references of all `charts`.
class Plane {
  constructor(frame, { quantities: [across, up], narrow }, charts) {
    const [left, top, right, bottom] = frame;
    const references = charts.map(({ group }) => referenceOf(group));
    const values = (key, quantity) => [
      ...charts.flatMap(({ points }) => points.map((point) => point[key])),
      ...references.map((row) => costOf(row, quantity)),
    ];
    const axis = (key, quantity, ...place) =>
      new Axis(
        quantity,
        values(key, quantity).filter((v) => v !== null),
        ...place,
      );
    this.frame = frame;
    this.x = axis("x", across, left, right, narrow ? 40 : 48, narrow ? 40 : 84);
    this.y = axis("y", up, bottom, top, 22, narrow ? 30 : 44);
    this.sides = [this.x, this.y].map((one) => new Side(one, frame, narrow ? 11 : 12));
  }

  // Everything behind the points.
  drawn() {
    const shapes = [...this.sides.flatMap((side) => side.strip()), ...this.sides.flatMap((side) => side.marks())];
    return drawing("g", { class: "ground" }, ...shapes);
  }

  reference(row, named) {
    return this.sides.flatMap((side) => side.reference(row, named));
  }
}
