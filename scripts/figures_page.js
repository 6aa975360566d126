// Draws every plot of the page; "drawn" on the root element says how many are done.
"use strict";

const plots = JSON.parse(document.getElementById("data").textContent);
const options = { displaylogo: false, responsive: true, modeBarButtonsToRemove: ["select2d", "lasso2d"] };

async function drawAll() {
  let drawn = 0;
  for (const plot of plots) {
    await Plotly.newPlot(plot.id, plot.data, plot.layout, options);
    drawn += 1;
    document.documentElement.dataset.drawn = String(drawn);
  }
}

drawAll();
