// Draws every plot of the page that is not over time; `allDrawn` is kept once all are done.

const plots = JSON.parse(document.getElementById("plots").textContent);

function figureLayout(plot) {
  const base = baseLayout(false);
  const height = NARROW.matches ? Math.min(plot.layout.height, 380) : plot.layout.height;
  return { ...base, ...plot.layout, height, margin: { ...base.margin, ...plot.layout.margin } };
}

async function drawFigures() {
  for (const plot of plots) {
    const node = document.getElementById(plot.id);
    if (tellIfMissing(node)) continue;
    const legend = node.parentElement.querySelector(".legend");
    await drawPlot({ node, legend, traces: () => plot.data, layout: () => figureLayout(plot) });
  }
}

const allDrawn = (typeof panelsDrawn === "undefined" ? Promise.resolve() : panelsDrawn).then(drawFigures);
