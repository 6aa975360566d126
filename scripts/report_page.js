// Draws the panels and links their time axes. A curve is drawn with the lowest and highest sample of each stretch as
// long as the screen could not show more, and with every sample once the visible part is short enough.
"use strict";

const POINTS_MAX = 4000;
const PRINT_WIDTH_PX = 700;

const data = JSON.parse(document.getElementById("data").textContent);

function decode(text, Type) {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  return new Type(bytes.buffer);
}

function decodeClock(clock) {
  if ("samples" in clock) {
    const samples = decode(clock.samples, Float64Array);
    return { count: samples.length, at: (i) => samples[i] };
  }
  return { count: clock.count, at: (i) => clock.start + i * clock.step };
}

const clocks = data.clocks.map(decodeClock);

// Index of the first sample at or after time_s.
function firstFrom(clock, time_s) {
  let low = 0;
  let high = clock.count;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (clock.at(middle) < time_s) low = middle + 1;
    else high = middle;
  }
  return low;
}

// Indices of the lowest and highest sample of a stretch, in their order; missing samples (NaN) stay gaps.
function extremesOf(values, from, to) {
  let low = from;
  let high = from;
  let gap = -1;
  for (let i = from; i < to; i++) {
    if (Number.isNaN(values[i])) gap = i;
    if (!(values[i] >= values[low])) low = i;
    if (!(values[i] <= values[high])) high = i;
  }
  const picked = gap >= 0 ? [low, gap, high] : [low, high];
  return [...new Set(picked)].sort((a, b) => a - b);
}

// What of a curve to draw between two times: one sample beyond either end, so that the line leaves the plot.
function visible(curve, [from_s, to_s]) {
  const clock = clocks[curve.clock];
  const first = Math.max(0, firstFrom(clock, from_s) - 1);
  const end = Math.min(clock.count, firstFrom(clock, to_s) + 1);
  const stretch = end - first > POINTS_MAX ? Math.ceil((2 * (end - first)) / POINTS_MAX) : 1;
  const x = [];
  const y = [];
  for (let i = first; i < end; i += stretch) {
    const picked = stretch === 1 ? [i] : extremesOf(curve.values, i, Math.min(i + stretch, end));
    for (const j of picked) {
      x.push(clock.at(j));
      y.push(Number.isNaN(curve.values[j]) ? null : curve.values[j]);
    }
  }
  return { x, y };
}

// The bars of a band: one trace, each bar from its start to its end.
function barTrace(bars) {
  return {
    type: "bar", orientation: "h",
    base: bars.map((b) => b.start), x: bars.map((b) => b.end - b.start), y: bars.map((b) => b.row),
    text: bars.map((b) => b.label), textposition: "inside", insidetextanchor: "middle", textangle: 0,
    insidetextfont: { color: "#111111" },
    marker: { color: bars.map((b) => b.colour), line: { color: bars.map((b) => b.colour), width: 1 } },
    customdata: bars.map((b) => [b.label, b.start, b.end]),
    hovertemplate: "%{y} %{customdata[0]}<br>%{customdata[1]:.6~g} s to %{customdata[2]:.6~g} s<extra></extra>",
  };
}

// Ranges are copied, since plotly changes the arrays that it is given.
function layoutOf(panel) {
  return {
    height: panel.height,
    margin: { l: 128, r: 80, t: 34, b: 44 },
    font: { family: "system-ui, Segoe UI, Liberation Sans, DejaVu Sans, sans-serif", size: 13, color: "#222" },
    hovermode: "x unified", dragmode: "zoom",
    legend: { orientation: "h", x: 0, y: 1, xanchor: "left", yanchor: "bottom" },
    showlegend: true,
    ...panel.layout,
    yaxis: { ...panel.layout.yaxis, automargin: false },
    xaxis: { ...data.axis, title: { text: "time (s)" }, range: [...panel.whole], hoverformat: ".6~g" },
  };
}

const panels = [];

function makePanel(panel) {
  const section = document.createElement("section");
  section.className = "panel";
  section.id = panel.name;
  const title = section.appendChild(document.createElement("h2"));
  title.textContent = panel.title;
  const note = section.appendChild(document.createElement("p"));
  note.textContent = panel.note;
  panel.plot = section.appendChild(document.createElement("div"));
  document.getElementById("panels").appendChild(section);

  panel.whole = panel.range || data.range;
  for (const curve of panel.curves) curve.values = decode(curve.samples, Float32Array);
  const traces = panel.curves.map((curve) => ({ ...curve.trace, ...visible(curve, panel.whole) }));
  if (panel.bars.length) traces.push(barTrace(panel.bars));
  Plotly.newPlot(panel.plot, traces, layoutOf(panel), {
    displaylogo: false, responsive: true, modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"],
    toImageButtonOptions: { format: "svg", filename: panel.name },
  });
  panel.plot.on("plotly_relayout", (change) => onRelayout(panel, change));
  panels.push(panel);
}

// The time range that a change asks for; undefined if it concerns something else.
function rangeOf(panel, change) {
  if (change["xaxis.autorange"]) return panel.whole;
  if (change["xaxis.range"]) return change["xaxis.range"];
  if ("xaxis.range[0]" in change) return [change["xaxis.range[0]"], change["xaxis.range[1]"]];
  return undefined;
}

let isLinking = false;

function show(panel, range) {
  const drawn = panel.curves.map((curve) => visible(curve, range));
  const traces = panel.curves.map((_, i) => i);
  if (traces.length === 0) return Plotly.relayout(panel.plot, { "xaxis.range": [...range] });
  return Plotly.update(panel.plot, { x: drawn.map((d) => d.x), y: drawn.map((d) => d.y) }, { "xaxis.range": [...range] }, traces);
}

async function onRelayout(panel, change) {
  const range = rangeOf(panel, change);
  if (isLinking || !range) return;
  isLinking = true;
  try {
    const others = panel.linked ? panels.filter((p) => p.linked && p !== panel) : [];
    await Promise.all([panel, ...others].map((p) => show(p, [...range])));
  } finally {
    isLinking = false;
  }
}

// Paper is narrower than the screen and shows what is folded away.
function fitTo(width_px) {
  for (const panel of panels) Plotly.relayout(panel.plot, width_px ? { width: width_px } : { width: null, autosize: true });
  for (const details of document.querySelectorAll("details")) details.open = Boolean(width_px);
}

data.panels.forEach(makePanel);
window.addEventListener("beforeprint", () => fitTo(PRINT_WIDTH_PX));
window.addEventListener("afterprint", () => fitTo(0));
