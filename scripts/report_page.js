// Draws the panels and links their time axes. A curve is drawn with the lowest and highest sample of each stretch as
// long as the screen could not show more, and with every sample of the page once the visible part is short enough.

const POINTS_MAX = 2800;
const PRINT_WIDTH_PX = 700;

const data = JSON.parse(document.getElementById("data").textContent);
const KINDS = { u2: Uint16Array, u4: Uint32Array };

function decode(text, Type) {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  return new Type(bytes.buffer);
}

function timesOf(clock) {
  if ("samples" in clock) return decode(clock.samples, Float64Array);
  let steps = 0;
  return Float64Array.from(decode(clock.deltas, KINDS[clock.kind]), (delta) => clock.start + clock.step * (steps += delta));
}

const clocks = data.clocks.map(timesOf);

// Index of the first sample at or after time_s.
function firstFrom(times, time_s) {
  let low = 0;
  let high = times.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] < time_s) low = middle + 1;
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
  const times = clocks[curve.clock];
  const first = Math.max(0, firstFrom(times, from_s) - 1);
  const end = Math.min(times.length, firstFrom(times, to_s) + 1);
  const stretch = end - first > POINTS_MAX ? Math.ceil((2 * (end - first)) / POINTS_MAX) : 1;
  const x = [];
  const y = [];
  for (let i = first; i < end; i += stretch) {
    const picked = stretch === 1 ? [i] : extremesOf(curve.values, i, Math.min(i + stretch, end));
    for (const j of picked) {
      x.push(times[j]);
      y.push(Number.isNaN(curve.values[j]) ? null : curve.values[j]);
    }
  }
  return { x, y };
}

// The bars of a band: one trace, each bar from its start to its end. A label is written where the bar is long enough.
function barTrace(panel) {
  const [from_s, to_s] = panel.shown;
  const width_px = panel.plot.clientWidth - 100;
  const least_s = ((to_s - from_s) / width_px) * 2; // a bar of one tick is seen too
  const isRoomy = (b) => ((Math.min(b.end, to_s) - Math.max(b.start, from_s)) / (to_s - from_s)) * width_px > 8 * b.label.length;
  const bars = panel.bars.map((b) => ({ ...b, from: Math.max(b.start, from_s), to: Math.min(b.end, to_s) }))
    .filter((b) => b.to > b.from);
  return {
    type: "bar", orientation: "h", name: "", showlegend: false,
    base: bars.map((b) => b.from), x: bars.map((b) => Math.max(b.to - b.from, least_s)), y: bars.map((b) => b.row),
    text: bars.map((b) => (isRoomy(b) ? b.label : "")), textposition: "inside", insidetextanchor: "middle", textangle: 0,
    insidetextfont: { color: "#111111" },
    marker: { color: bars.map((b) => b.colour), line: { color: bars.map((b) => b.colour), width: 1 } },
    customdata: bars.map((b) => [b.label, b.start, b.end]),
    hovertemplate: "%{y} %{customdata[0]}<br>%{customdata[1]:.6~g} s to %{customdata[2]:.6~g} s<extra></extra>",
  };
}

// Rows of a band that have a bar in what is shown.
function rowsOf(panel) {
  const [from_s, to_s] = panel.shown;
  const there = new Set(panel.bars.filter((b) => b.end > from_s && b.start < to_s).map((b) => b.row));
  return panel.layout.yaxis.categoryarray.filter((row) => there.has(row));
}

const ROW_FONT_PX = 12;

function widthOf(text, size) {
  const pen = document.createElement("canvas").getContext("2d");
  pen.font = `${size}px ${FONT}`;
  return pen.measureText(text).width;
}

const hasSecondAxis = data.panels.some((panel) => panel.linked && "yaxis2" in panel.layout);
// px: names of the rows stand there in the reader's own font, so all panels begin there.
const BAND_FROM = Math.ceil(Math.max(84, ...data.panels.flatMap((panel) => panel.layout.yaxis.categoryarray || [])
  .map((row) => widthOf(row, ROW_FONT_PX) + 14)));

function tracesOf(panel) {
  const traces = panel.curves.map((curve) => ({ ...curve.trace, ...visible(curve, panel.shown) }));
  if (panel.bars.length) traces.push(barTrace(panel));
  return traces;
}

// On a phone the name of a row has two lines.
function heightOf(panel) {
  if (!panel.bars.length) return NARROW.matches ? Math.min(panel.height, 260) : panel.height;
  const rows = Math.max(2, rowsOf(panel).length); // one alone would be lower than its labels
  return NARROW.matches ? 70 + 42 * rows : 80 + 30 * rows;
}

function layoutOf(panel) {
  const base = baseLayout("yaxis2" in panel.layout);
  if (!NARROW.matches) base.margin = { ...base.margin, l: BAND_FROM, r: hasSecondAxis ? 74 : 20 };
  if (NARROW.matches && panel.bars.length) base.margin.l = 84;
  const yaxis = { ...panel.layout.yaxis };
  if (yaxis.categoryarray) yaxis.categoryarray = rowsOf(panel);
  if (NARROW.matches && yaxis.categoryarray) {
    yaxis.tickvals = yaxis.categoryarray;
    yaxis.ticktext = yaxis.categoryarray.map((row) => row.replace(" ", "<br>"));
  }
  return {
    ...base, height: heightOf(panel), hovermode: "x unified", ...panel.layout,
    yaxis,
    xaxis: { ...data.axis, title: { text: "time (s)" }, range: [...panel.shown], hoverformat: ".6~g",
      nticks: NARROW.matches ? 6 : 12 },
  };
}

const panels = [];

async function makePanel(panel) {
  const section = document.createElement("section");
  section.className = "panel";
  section.id = panel.name;
  section.appendChild(document.createElement("h2")).textContent = panel.title;
  section.appendChild(document.createElement("p")).textContent = panel.note;
  panel.legend = section.appendChild(document.createElement("ul"));
  panel.legend.className = "legend";
  panel.plot = section.appendChild(document.createElement("div"));
  document.getElementById("panels").appendChild(section);

  panel.whole = panel.range || data.range;
  panel.shown = panel.range || data.shown;
  for (const curve of panel.curves) curve.values = decode(curve.samples, Float32Array);
  panels.push(panel);
  panel.view = { node: panel.plot, legend: panel.legend, traces: () => tracesOf(panel), layout: () => layoutOf(panel),
    onRelayout: (change) => onRelayout(panel, change) };
  await drawPlot(panel.view);
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
  panel.shown = [...range];
  return drawAgain(panel.view);
}

function tellRange(range) {
  const place = document.getElementById("range");
  const decimals = Math.max(0, 2 - Math.floor(Math.log10(range[1] - range[0]))); // three digits of what is shown
  if (place) place.textContent = `${range.map((time_s) => Number(time_s.toFixed(decimals))).join(" to ")} s`;
}

async function showAll(range, only) {
  isLinking = true;
  try {
    await Promise.all((only || panels.filter((panel) => panel.linked)).map((panel) => show(panel, range)));
    if (!only) tellRange(range);
  } finally {
    isLinking = false;
  }
}

async function onRelayout(panel, change) {
  const range = rangeOf(panel, change);
  if (isLinking || !range) return;
  await showAll([...range], panel.linked ? undefined : [panel]);
}

// Paper is narrower than the screen and shows what is folded away.
function fitTo(width_px) {
  for (const panel of panels) Plotly.relayout(panel.plot, width_px ? { width: width_px } : { width: null, autosize: true });
  for (const details of document.querySelectorAll("details")) details.open = Boolean(width_px);
}

async function drawPanels() {
  if (tellIfMissing(document.getElementById("panels"))) return;
  for (const panel of data.panels) await makePanel(panel);
  tellRange(data.shown);
  const isPart = data.shown[0] > data.range[0] || data.shown[1] < data.range[1];
  const part = document.getElementById("part");
  if (part) {
    part.hidden = !isPart;
    part.addEventListener("click", () => showAll(data.shown));
    document.getElementById("whole").addEventListener("click", () => showAll(data.range));
  }
  window.addEventListener("beforeprint", () => fitTo(PRINT_WIDTH_PX));
  window.addEventListener("afterprint", () => fitTo(0));
}

const panelsDrawn = drawPanels();
