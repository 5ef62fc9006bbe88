// Numbers as a person reads them.

// Three significant digits, two where there is an exponent: 0, 1.5e-3, 0.0331, 12.3, 4520.
function short(value) {
  const size = Math.abs(value);
  if (value === 0) return "0";
  if (size < 1e-2 || size >= 1e5) return value.toExponential(1).replace("e+", "e");
  // Rounded first, since 9.999 has three digits as 10.0.
  const rounded = Number(value.toExponential(2));
  const digits = Math.floor(Math.log10(Math.abs(rounded)));
  return rounded.toFixed(Math.max(2 - digits, 0));
}

const BYTES = [" B", " kB", " MB", " GB", " TB"];
const COUNTS = ["", "k", "M", "G", "T"];

// With the decimal unit that leaves up to three digits before the point.
function scaled(count, units) {
  let [value, unit] = [count, 0];
  while (value >= 999.5 && unit + 1 < units.length) {
    value /= 1e3;
    unit += 1;
  }
  return (unit ? short(value) : String(count)) + units[unit];
}

const percent = (part) => `${(100 * part).toFixed(0)} %`;

// How often the one goes into the other: 0.17, 5.6, 133.
const ratio = (value) => (value >= 99.5 ? value.toFixed(0) : String(Number(value.toPrecision(2))));

// 1, 2 or 5 times a power of ten, as a mark on an axis says it; plain where all marks of the axis can be.
function tickText(decade, digit, format, plain) {
  const units = { bytes: BYTES, count: COUNTS }[format];
  if (units && decade >= 0) {
    const unit = Math.min(Math.floor(decade / 3), units.length - 1);
    return digit * 10 ** (decade - 3 * unit) + units[unit];
  }
  if (decade === 0) return String(digit);
  if (plain) return (digit * 10 ** decade).toFixed(Math.max(-decade, 0));
  return (digit === 1 ? "" : `${digit}·`) + "10" + superscript(decade);
}

const superscript = (decade) => String(decade).replace(/./g, (c) => (c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[Number(c)]));
