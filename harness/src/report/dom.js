// Elements, made of nothing but names and texts, so that no label can become markup.

const byId = (id) => document.getElementById(id);

function element(name, attributes = {}, ...children) {
  return filled(document.createElement(name), attributes, children);
}

function drawing(name, attributes = {}, ...children) {
  return filled(document.createElementNS("http://www.w3.org/2000/svg", name), attributes, children);
}

function filled(made, attributes, children) {
  for (const [key, value] of Object.entries(attributes)) {
    if (value !== null && value !== undefined && value !== false) made.setAttribute(key, value === true ? "" : value);
  }
  made.append(...children.filter((child) => child !== null && child !== undefined));
  return made;
}

// A family's marker within a line of text.
function markerIcon(family) {
  const outline = drawing("path", { d: family.outline, fill: family.colour });
  return drawing("svg", { class: "marker", viewBox: "-7 -7 14 14", "aria-hidden": "true" }, outline);
}

// The choices of a select: values with their texts, under headings where there are any.
function choices(select, options) {
  const option = ([value, text]) => element("option", { value }, text);
  const group = ([label, list]) => (list.length ? [element("optgroup", { label }, ...list.map(option))] : []);
  select.replaceChildren(...(Array.isArray(options) ? options.map(option) : Object.entries(options).flatMap(group)));
}
