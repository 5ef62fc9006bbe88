// Draws the page, and again whenever what is shown changes.

function draw() {
  drawControls();
  drawFigure();
  drawLegend();
  drawTables();
  if (pictured.length) drawPictures();
}

function begin() {
  for (const id of ["chart", "columns", "bold"]) byId(id).hidden = false;
  fillControls();
  fillTables();
  if (pictured.length) fillPictures();
  onChange(draw);
  draw();
  redrawWithWidth();
}

function redrawWithWidth() {
  let width = sheet.clientWidth;
  new ResizeObserver(() => {
    if (sheet.clientWidth === width) return;
    width = sheet.clientWidth;
    drawFigure();
  }).observe(sheet);
  // On paper the figure is as wide as in papers, whatever the window.
  addEventListener("beforeprint", () => drawFigure(PAPER.width - PAPER.legend));
  addEventListener("afterprint", () => drawFigure());
}

// Where nothing was measured there is nothing to draw.
if (groups.length && usual.up) begin();
