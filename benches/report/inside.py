"""What the check asks inside the page."""

# Sets one axis, then the other to each quantity as a person would, and says what the drawing has then.
EVERY_PAIR = """
const [up, acrosses] = arguments;
const choose = (id, value) => {
  const one = document.getElementById(id);
  one.value = value;
  one.dispatchEvent(new Event("change", { bubbles: true }));
};
const rows = (selector) => [...document.querySelectorAll(selector)].map((mark) => Number(mark.dataset.row));
choose("up", up);
return acrosses.map((across) => {
  choose("across", across);
  const svg = document.querySelector("#plane svg").outerHTML;
  return [up, across, rows("#plane .point"), rows("#plane .on-frontier"), /NaN|Infinity|undefined|null/.test(svg)];
});
"""

# Texts of the drawing that cover each other or leave it.
COLLISIONS = """
const svg = document.querySelector("#plane svg"), frame = svg.getBoundingClientRect();
const texts = [...svg.querySelectorAll("text")].map((text) => [text.textContent, text.getBoundingClientRect()]);
const across = (a, b) => Math.min(a.right, b.right) - Math.max(a.left, b.left);
const upwards = (a, b) => Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
// The box of a text is higher than its letters.
const meet = (a, b) => across(a, b) > 1 && upwards(a, b) > 3;
const outside = (a) => a.left < frame.left - 1 || a.right > frame.right + 1 || a.top < frame.top - 1 || a.bottom > frame.bottom + 1;
return texts.flatMap(([a, box], i) => [
  ...(outside(box) ? [`${a} leaves the drawing`] : []),
  ...texts.slice(i + 1).filter(([, other]) => meet(box, other)).map(([b]) => `${a} and ${b} cover each other`),
]);
"""

# Whether another marker lies exactly on the one that is given.
COVERED = """
const place = (mark) => mark.getAttribute("transform");
return [...document.querySelectorAll("#plane .point")].some((mark) => mark !== arguments[0] && place(mark) === place(arguments[0]));
"""
