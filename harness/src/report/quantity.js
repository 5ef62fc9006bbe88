// The figures of a row.

const written = { number: short, bytes: (value) => scaled(value, BYTES), count: (value) => scaled(value, COUNTS) };

const isNumber = (value) => typeof value === "number" && Number.isFinite(value);

// The figure as a person reads it; a dash where there is none.
function figureText(row, quantity) {
  const value = row[quantity.key];
  return isNumber(value) ? written[quantity.format](value) : "–";
}

// The distance between the quartiles as a part of the median; none for what was not measured several times.
function spreadOf(row, quantity) {
  const [spread, median] = [row[quantity.spread], row[quantity.key]];
  return isNumber(spread) && median > 0 ? spread / median : null;
}

const isUnsteady = (row, quantity) => spreadOf(row, quantity) > data.unsteady;

// What an axis can show.
const axes = (role) => quantities.filter((quantity) => quantity.role === role);
const axisKeys = () => [...axes("error"), ...axes("cost")].map(({ key }) => key);
