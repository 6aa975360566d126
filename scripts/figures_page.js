// Draws every plot of the page; `allDrawn` is kept once all are done.
"use strict";

const plots = JSON.parse(document.getElementById("plots").textContent);
const options = { displaylogo: false, responsive: true, modeBarButtonsToRemove: ["select2d", "lasso2d"] };

async function drawAll() {
  for (const plot of plots) await Plotly.newPlot(plot.id, plot.data, plot.layout, options);
}

const allDrawn = drawAll();
