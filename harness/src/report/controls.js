// Matrix, axes and kinds of methods.

function fillControls() {
  const all = groups.length > 1 ? [[ALL, "all matrices"]] : [];
  choices(byId("matrix"), [...groups.map(({ unique, title }) => [unique, title]), ...all]);
  const named = (role) => axes(role).map(({ key, axis }) => [key, axis]);
  for (const id of ["up", "across"]) choices(byId(id), { errors: named("error"), costs: named("cost") });
}

function drawControls() {
  for (const id of ["matrix", "up", "across"]) byId(id).value = state[id];
  byId("show").querySelector(`[value="${state.show}"]`).checked = true;
}

for (const id of ["up", "across"]) byId(id).addEventListener("change", ({ target }) => change({ [id]: target.value }));
// Pictures follow.
byId("matrix").addEventListener("change", ({ target }) => change({ matrix: target.value, seen: "" }));
byId("swap").addEventListener("click", () => change({ up: state.across, across: state.up }));
byId("show").addEventListener("change", ({ target }) => change({ show: target.value }));
byId("controls").addEventListener("submit", (event) => event.preventDefault());
