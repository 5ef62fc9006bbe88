// The tables that are in the page: sorted, filtered, and tied to the points of the chart.

const tables = [...document.querySelectorAll("section.matrix")].map((section) => {
  const group = groups[section.dataset.group];
  const lines = [...section.querySelectorAll("tbody tr")];
  return {
    section,
    group,
    body: section.querySelector("tbody"),
    lines: lines.map((line) => ({ line, row: group.rows[line.dataset.row] })),
  };
});

// Heads become buttons, so that keys reach them.
function fillTables() {
  document.querySelectorAll(".matrix thead th").forEach((head) => {
    const key = head.dataset.key ?? "method";
    const button = element("button", { type: "button" }, ...head.childNodes);
    button.addEventListener("click", () => sortBy(key));
    head.dataset.key = key;
    head.replaceChildren(button);
  });
  tables.forEach(({ group, lines }) =>
    lines.forEach(({ line, row }) => {
      const point = () => points.find((one) => one.group === group && one.row === row) ?? null;
      line.addEventListener("pointerenter", () => point() && pointAt(point(), false));
      line.addEventListener("pointerleave", () => pointAt(null));
      line.addEventListener("click", () => point() && pin(point()));
    }),
  );
}

// From the smallest, then from the largest, then as measured.
function sortBy(key) {
  const next = { [key]: `-${key}`, [`-${key}`]: "" }[state.sort] ?? key;
  change({ sort: next });
}

function drawTables() {
  const [, minus, key] = state.sort.match(/^(-?)(.*)$/);
  tables.forEach((table) => {
    table.section.hidden = !shownGroups().includes(table.group);
    table.section.classList.toggle("every", state.more);
    table.body.append(...sorted(table.lines, key, minus ? -1 : 1).map(({ line }) => line));
    table.lines.forEach(({ line, row }) => (line.hidden = !isShown(row)));
    table.section.querySelectorAll("thead th").forEach((head) => {
      head.ariaSort = head.dataset.key === key ? (minus ? "descending" : "ascending") : null;
    });
    const best = new Set(points.filter((point) => point.group === table.group && point.best).map(({ row }) => row));
    table.lines.forEach(({ line, row }) => line.classList.toggle("on-frontier", best.has(row)));
  });
  byId("more").checked = state.more;
}

// What has no figure comes last, whatever the direction.
function sorted(lines, key, sign) {
  if (!key) return lines;
  const figure = ({ row }) => (key === "method" ? row.method : isNumber(row[key]) ? row[key] : null);
  const [having, others] = [lines.filter((one) => figure(one) !== null), lines.filter((one) => figure(one) === null)];
  const order = (a, b) => (figure(a) < figure(b) ? -sign : figure(a) > figure(b) ? sign : 0);
  return [...having.sort(order), ...others];
}

// The line of a point, and no other one.
function emphasize(point) {
  tables.forEach(({ group, lines }) =>
    lines.forEach(({ line, row }) => {
      line.classList.toggle("pointed", point !== null && point.group === group && point.row === row);
      line.classList.toggle("pinned", isPinned(group, row));
    }),
  );
}

byId("more").addEventListener("change", ({ target }) => change({ more: target.checked }));
