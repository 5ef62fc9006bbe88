// What methods look like: beside the reference, where they differ from it, and while the light turns.

const withMethods = (group) => ({ ...group, pictures: group.pictures.filter(({ shown }) => shown.length) });
const pictured = groups.map(withMethods).filter(({ pictures }) => pictures.length);

// The matrix, light and method whose picture is seen; of what a link does not say, that of the chart or the first.
function seen() {
  const named = (name) => pictured.find(({ unique }) => unique === name);
  const group = named(state.seen) ?? named(state.matrix) ?? pictured[0];
  const under = group.pictures.find(({ light }) => light === state.light) ?? group.pictures[0];
  const method = under.shown.find(({ method: name }) => name === state.picture) ?? under.shown[0];
  return { group, under, method };
}

function fillPictures() {
  byId("pictures").hidden = false;
  choices(
    byId("picture-matrix"),
    pictured.map(({ unique, title }) => [unique, title]),
  );
  byId("picture-matrix").addEventListener("change", ({ target }) => change({ seen: target.value }));
  byId("picture-light").addEventListener("change", ({ target }) => change({ light: target.value }));
  byId("picture-split").addEventListener("input", split);
  byId("picture-controls").addEventListener("submit", (event) => event.preventDefault());
}

let drawnPicture = null;

function drawPictures() {
  const { group, under, method } = seen();
  if (method === drawnPicture) return;
  drawnPicture = method;
  choices(
    byId("picture-light"),
    group.pictures.map(({ light }) => [light, light]),
  );
  byId("picture-matrix").value = group.unique;
  byId("picture-light").value = under.light;
  const budget = scaled(under.budget_bytes, BYTES);
  byId("picture-budget").textContent = `${group.title}, lit by ${under.light}: every method at about ${budget}.`;
  compare(under, method);
  strips(under, method);
  const focused = document.activeElement.closest?.("#thumbnails button")?.value;
  byId("thumbnails").replaceChildren(...under.shown.map((one) => thumbnail(one, one === method)));
  [...byId("thumbnails").children].find(({ value }) => value === focused)?.focus();
}

// Reference and picture in one frame, the error beside it, and its figures.
function compare(under, method) {
  byId("picture-reference").src = under.reference;
  Object.assign(byId("picture-method"), { src: method.picture, alt: `picture of ${method.method}` });
  Object.assign(byId("picture-error"), { src: method.error_map, alt: `error of ${method.method}` });
  byId("picture-name").textContent = method.method;
  byId("picture-title").replaceChildren(markerIcon(familyOf(method)), method.method);
  const terms = pictureFigures(method).flatMap(([term, said]) => [element("dt", {}, term), element("dd", {}, said)]);
  byId("picture-figures").replaceChildren(...terms);
  split();
}

function pictureFigures(method) {
  const figure = (value) => (isNumber(value) ? short(value) : "–");
  return [
    ["PSNR", isNumber(method.psnr_db) ? `${short(method.psnr_db)} dB` : "–"],
    ["FLIP", figure(method.flip)],
    ["squared error", figure(method.relative_squared_error)],
    ["flicker", figure(method.flicker)],
    ["memory", scaled(method.resident_bytes, BYTES)],
    ["file", scaled(method.file_bytes, BYTES)],
  ];
}

// The reference from the left to the slider, the picture from there on.
function split() {
  const part = byId("picture-split").value;
  byId("picture-method").style.clipPath = `inset(0 0 0 ${part}%)`;
  byId("picture-edge").style.left = `${part}%`;
}

function strips(under, method) {
  const strip = (src, said) =>
    src &&
    element(
      "figure",
      {},
      element("img", { src, alt: `${said} while the light turns` }),
      element("figcaption", {}, `${said}, while the light turns`),
    );
  byId("strips").replaceChildren(
    ...[strip(under.reference_strip, "reference"), strip(method.strip, method.method)].filter(Boolean),
  );
}

function thumbnail(one, chosen) {
  const said = `FLIP ${short(one.flip)} · ${scaled(one.resident_bytes, BYTES)}`;
  const button = element(
    "button",
    { type: "button", value: one.method, "aria-pressed": String(chosen) },
    element("img", { src: one.picture, alt: "" }),
    element("span", { class: "name" }, markerIcon(familyOf(one)), one.method),
    element("span", { class: "faint" }, said),
  );
  button.addEventListener("click", () => change({ picture: one.method }));
  return button;
}
