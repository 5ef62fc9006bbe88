// What is shown. It lives in the link, so that a link brings the same view back.

const usual = {
  matrix: groups.length ? groups[0].unique : "",
  up: firstOf(["relight_1_ms", "file_bytes"]),
  across: firstOf(["error", "error_sphere"]),
  show: "all",
  // Names of families that are not shown.
  without: [],
  // Matrix and method of the point whose figures stay in sight.
  pin: "",
  // The column that tables are sorted by, after a minus where the largest figure comes first.
  sort: "",
  more: false,
  // Matrix, light and method of the picture.
  seen: "",
  light: "",
  picture: "",
};
const ALL = "all";
let state = fromLink();
const listeners = [];

function firstOf(keys) {
  return [...keys, ...axisKeys()].find((key) => quantityOf(key));
}

function fromLink() {
  const link = new URLSearchParams(location.hash.slice(1));
  const read = Object.entries(usual).map(([key, standard]) => {
    const text = link.get(key);
    if (text === null) return [key, standard];
    if (Array.isArray(standard)) return [key, text.split(",").filter(Boolean)];
    return [key, typeof standard === "boolean" ? text === "true" : text];
  });
  return valid(Object.fromEntries(read));
}

// A link may be of another report: what this one does not have falls back to what is usual.
function valid(read) {
  const known = (key, values) => (values.includes(read[key]) ? {} : { [key]: usual[key] });
  return {
    ...read,
    ...known("matrix", [ALL, ...groups.map(({ unique }) => unique)]),
    ...known("up", axisKeys()),
    ...known("across", axisKeys()),
    ...known("show", ["all", "lossless", "lossy"]),
  };
}

function toLink() {
  const link = new URLSearchParams(linked());
  const hash = link.size ? `#${link}` : "";
  if (hash !== location.hash) history.replaceState(null, "", location.pathname + location.search + hash);
}

function change(part) {
  state = { ...state, ...part };
  toLink();
  listeners.forEach((listener) => listener());
}

const onChange = (listener) => listeners.push(listener);

addEventListener("hashchange", () => {
  state = fromLink();
  listeners.forEach((listener) => listener());
});

const shownGroups = () => groups.filter(({ unique }) => state.matrix === ALL || state.matrix === unique);
const isPinned = (group, row) => state.pin === pinOf(group, row);
const pinOf = (group, row) => `${group.unique} ${row.method}`;

// What is not usual about the view, as a link says it.
function linked() {
  const unusual = Object.entries(usual).filter(([key, standard]) => String(state[key]) !== String(standard));
  return Object.fromEntries(unusual.map(([key]) => [key, String(state[key])]));
}
