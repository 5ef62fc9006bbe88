// What was measured, as the page carries it.

const data = JSON.parse(document.getElementById("data").textContent);
const { families, quantities } = data;

// Every matrix with its place and a name for links: scene and signal, and a number where those are there twice.
const groups = data.groups.map((group, index) => ({ ...group, index, name: groupName(group) }));
groups.forEach((group, i) => {
  const before = groups.slice(0, i).filter((other) => other.name === group.name).length;
  group.unique = before ? `${group.name} ${before + 1}` : group.name;
});

function groupName({ rows, title }) {
  return rows.length ? [rows[0].scene, rows[0].signal].filter(Boolean).join(" ") : title;
}

const quantityOf = (key) => quantities.find((quantity) => quantity.key === key);
const familyOf = (row) => families.find((family) => family.name === row.family);
const isOk = (row) => row.status === "ok";

// The exact sparse matrix, which others are compared with.
const referenceOf = (group) => group.rows.find((row) => row.method === "csr" && isOk(row));

// Where it was measured, in one line.
function machineLine() {
  return document.querySelector("header p").textContent;
}
