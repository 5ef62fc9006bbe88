// A logarithmic axis, and beside it a strip for what is 0.

// Air between the outermost values and the ends, in decades and as a part of their distance.
const [MARGIN, SHARE] = [0.15, 0.03];
// An axis is at least this long, in decades: a chart of near equals must not look like a landslide.
const LEAST = 1;
// Powers of ten alone are named on an axis that is longer, where they need exponents.
const CROWDED = 2.5;
// Between the strip and the axis, pixels.
const GAP = 12;

class Axis {
  // From pixel `from` to pixel `to`. `apart` is the least distance of two texts along it, `strip` the width of the strip.
  constructor(quantity, values, from, to, apart, strip) {
    Object.assign(this, { quantity, from, to, apart });
    const positive = values.filter((value) => value > 0);
    const zeros = positive.length < values.length;
    const towards = Math.sign(to - from);
    this.logFrom = zeros ? from + towards * (strip + GAP) : from;
    // Without any other value the strip is all there is.
    this.strip = zeros ? [from, positive.length ? from + towards * strip : to] : null;
    if (positive.length) this.range(positive.map(Math.log10));
  }

  range(exponents) {
    const [low, high] = [Math.min(...exponents), Math.max(...exponents)];
    const air = Math.max(MARGIN, SHARE * (high - low), (LEAST - high + low) / 2);
    Object.assign(this, { low: low - air, high: high + air });
  }

  get span() {
    return this.high - this.low;
  }

  pixel(value) {
    if (value === 0) return (this.strip[0] + this.strip[1]) / 2;
    return this.logFrom + ((Math.log10(value) - this.low) / this.span) * (this.to - this.logFrom);
  }

  // Whether the value has a place.
  holds(value) {
    if (value === 0) return this.strip !== null;
    return this.low !== undefined && Math.log10(value) >= this.low && Math.log10(value) <= this.high;
  }

  // What is said of the strip.
  get zero() {
    return this.quantity.role === "error" ? "exact" : "0";
  }

  // Marks at 1 to 9 of every decade, where there is room; texts at 1, at 2 and 5 too where there is more.
  ticks() {
    if (this.low === undefined) return [];
    const decade = Math.abs(this.to - this.logFrom) / this.span;
    const stride = Math.max(Math.ceil(this.apart / decade), 1);
    // One notation on one axis.
    const plain = this.low >= -4 && this.high < 5;
    const crowded = 0.3 * decade < this.apart || (!plain && this.span > CROWDED);
    const marks = [];
    for (let power = Math.floor(this.low); power <= this.high; power++) {
      for (let digit = 1; digit <= (decade < 40 ? 1 : 9); digit++) {
        const value = digit * 10 ** power;
        if (!this.holds(value)) continue;
        const said = digit === 1 ? power % stride === 0 : !crowded && (digit === 2 || digit === 5);
        marks.push({
          pixel: this.pixel(value),
          words: said ? tickText(power, digit, this.quantity.format, plain) : null,
        });
      }
    }
    return marks;
  }
}
