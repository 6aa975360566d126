// What the plots of all pages share: colours of the screen, room at the edges, and a legend beside each plot that wraps.
"use strict";

const NARROW = matchMedia("(max-width: 640px)");
const DARK = matchMedia("(prefers-color-scheme: dark)");
const FONT = "system-ui, Segoe UI, Liberation Sans, DejaVu Sans, sans-serif";

// A colour as it is on white, by its name in the style sheet: what it becomes on this screen.
function coloured(text) {
  const found = getComputedStyle(document.documentElement).getPropertyValue(`--c-${text.slice(1, 7)}`).trim();
  return found ? found + text.slice(7) : text;
}

// Samples are left alone, colour scales too: theirs mean numbers.
const LEFT_ALONE = new Set(["x", "y", "z", "surfacecolor", "colorscale", "customdata"]);

function themed(value, key) {
  if (LEFT_ALONE.has(key)) return value;
  if (typeof value === "string") return /^#[0-9A-Fa-f]{6}/.test(value) ? coloured(value) : value;
  if (Array.isArray(value)) return value.map((one) => themed(one));
  if (value === null || typeof value !== "object" || ArrayBuffer.isView(value)) return value;
  return Object.fromEntries(Object.entries(value).map(([name, one]) => [name, themed(one, name)]));
}

function baseLayout(has_second_axis) {
  return {
    font: { family: FONT, size: NARROW.matches ? 11 : 12.5, color: "#222222" },
    paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", showlegend: false,
    margin: { l: NARROW.matches ? 62 : 84, r: has_second_axis ? (NARROW.matches ? 54 : 74) : 14, t: 12, b: 46 },
    dragmode: matchMedia("(pointer: coarse)").matches ? false : "zoom",
    hoverlabel: { bgcolor: "#FFFFFF", bordercolor: "#999999", font: { color: "#222222" } },
  };
}

const OPTIONS = {
  displaylogo: false, responsive: true, displayModeBar: false, doubleClick: "reset",
};

const PATTERNS = { dash: "6 3", dot: "1.5 3", dashdot: "6 3 1.5 3" };

function svg(name, attributes, parent) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  return parent ? parent.appendChild(made) : made;
}

// A small picture of how a trace is drawn.
function swatch(trace) {
  const picture = svg("svg", { width: 26, height: 12, "aria-hidden": "true" });
  const marker = trace.marker || {};
  if (trace.swatch === "map") svg("rect", { width: 26, height: 12, fill: "#D9D9D9" }, picture); // dark lines, light maps
  if (trace.swatch === "hatch") {
    for (const x of [2, 8, 14, 20]) svg("line", { x1: x, y1: 11, x2: x + 5, y2: 1, stroke: marker.color, "stroke-width": 1.5 }, picture);
  } else if (trace.fill) {
    svg("rect", { width: 26, height: 12, fill: trace.fillcolor }, picture);
  } else if (trace.mode === "markers" && marker.symbol === "star") {
    svg("path", { d: "M13 0L14.6 4.2 19 4.3 15.5 7 16.8 11.3 13 8.8 9.2 11.3 10.5 7 7 4.3 11.4 4.2Z", fill: marker.color }, picture);
  } else if (trace.mode === "markers") {
    const is_open = String(marker.symbol || "").endsWith("-open");
    const edge = is_open ? marker.color : (marker.line && marker.line.color) || "none";
    svg("circle", { cx: 13, cy: 6, r: 4, fill: is_open ? "none" : marker.color, stroke: edge, "stroke-width": 1.5 }, picture);
  } else {
    const line = trace.line || {};
    svg("line", { x1: 0, y1: 6, x2: 26, y2: 6, stroke: line.color, "stroke-width": Math.min(line.width || 2, 8),
      "stroke-dasharray": PATTERNS[line.dash] || "none" }, picture);
  }
  return picture;
}

// The names of a plot's traces; a click hides or shows one.
function fillLegend(plot) {
  const named = plot.traces().map((trace, i) => [themed(trace), i])
    .filter(([trace]) => trace.name && trace.showlegend !== false);
  plot.legend.hidden = plot.hasLegend === false || named.length < 2;
  if (plot.legend.hidden) return;
  plot.legend.replaceChildren(...named.map(([trace, i]) => {
    const item = document.createElement("li");
    const button = item.appendChild(document.createElement("button"));
    button.type = "button";
    button.setAttribute("aria-pressed", String(!plot.hiddenTraces.has(i)));
    button.append(swatch(trace), trace.name);
    button.addEventListener("click", () => {
      plot.hiddenTraces[plot.hiddenTraces.has(i) ? "delete" : "add"](i);
      button.setAttribute("aria-pressed", String(!plot.hiddenTraces.has(i)));
      drawAgain(plot);
    });
    return item;
  }));
}

const allPlots = [];

function tracesShown(plot) {
  return themed(plot.traces()).map((trace, i) => ({ ...trace, visible: !plot.hiddenTraces.has(i) }));
}

function drawAgain(plot) {
  return Plotly.react(plot.node, tracesShown(plot), themed(plot.layout()), OPTIONS);
}

// From nothing: a change of the screen moves colour bars and margins, which plotly does not take back.
async function drawNew(plot) {
  fillLegend(plot);
  await Plotly.newPlot(plot.node, tracesShown(plot), themed(plot.layout()), OPTIONS);
  if (plot.onRelayout) plot.node.on("plotly_relayout", plot.onRelayout);
}

// `traces` and `layout` are functions, since both depend on the screen; `legend` is a list element.
function drawPlot(plot) {
  plot.hiddenTraces = new Set();
  allPlots.push(plot);
  return drawNew(plot);
}

// One after another, and once more if the screen has changed meanwhile.
let drawing = Promise.resolve();
function drawAllAgain() {
  drawing = drawing.then(async () => {
    for (const plot of allPlots) await (plot.isDeep ? drawAgain(plot) : drawNew(plot)); // 3-D ones share few contexts
  });
}

NARROW.addEventListener("change", drawAllAgain);
DARK.addEventListener("change", drawAllAgain);

// A page that was sent without its script file says so.
function tellIfMissing(place) {
  if (typeof Plotly !== "undefined") return false;
  const text = document.createElement("p");
  text.className = "missing";
  text.textContent = `The plots need the file ${document.getElementById("plotly").getAttribute("src")}, as seen from this page. `
    + "It is not there. Copy it from the folder build/assets, or make the page anew.";
  place.replaceChildren(text);
  return true;
}
