// All figures of a point, beside it.

const tooltip = byId("tooltip");

function showTooltip({ group, row, best, marker: place }) {
  const title = element("p", { class: "title" }, markerIcon(familyOf(row)), row.method);
  const where = [
    state.matrix === ALL ? group.unique.replace(" ", " · ") : null,
    best ? "on the frontier" : null,
  ].filter(Boolean);
  const reference = referenceOf(group);
  const lines = quantities
    .filter(({ key }) => isNumber(row[key]))
    .map((quantity) => tooltipLine(row, quantity, reference));
  const table = element("table", {}, element("tbody", {}, ...lines));
  tooltip.replaceChildren(title, where.length ? element("p", { class: "faint" }, where.join(", ")) : "", table);
  tooltip.hidden = false;
  beside(place.getBoundingClientRect());
}

function hideTooltip() {
  tooltip.hidden = true;
}

// The figure, what it is of the exact sparse matrix's, and how far its runs lay apart where that was far.
function tooltipLine(row, quantity, reference) {
  const chosen = [state.up, state.across].includes(quantity.key);
  const compared = reference && reference !== row && quantity.role === "cost" && reference[quantity.key] > 0;
  const part = compared ? `${ratio(row[quantity.key] / reference[quantity.key])} × csr` : "";
  const apart = isUnsteady(row, quantity) ? `± ${percent(spreadOf(row, quantity))}` : "";
  return element(
    "tr",
    { class: chosen ? "chosen" : null },
    element("th", { scope: "row" }, quantity.head),
    element("td", {}, figureText(row, quantity)),
    element("td", { class: "apart-by" }, apart),
    element("td", { class: "faint" }, part),
  );
}

// To the right of the marker, or to the left, or wherever the window has room.
function beside(place) {
  const { offsetWidth: width, offsetHeight: height } = tooltip;
  const [wide, high] = [document.documentElement.clientWidth, innerHeight];
  const right = place.right + 12;
  const left = place.left - 12 - width;
  const x = right + width < wide ? right : left > 0 ? left : Math.max(wide - width - 4, 4);
  const y = Math.min(Math.max(place.top - height / 3, 4), Math.max(high - height - 4, 4));
  tooltip.style.left = `${x + scrollX}px`;
  tooltip.style.top = `${y + scrollY}px`;
}
