// Draws every plot of the page that is not over time; `allDrawn` is kept once all are done.

const plots = JSON.parse(document.getElementById("plots").textContent);
const NO_VALUE = -32768;
const PLACES = 1000;

// A map as it is packed: where each point lies on the scale of levels. Gives that, and the growth itself.
function unpack(map) {
  const bytes = Uint8Array.from(atob(map.places), (c) => c.charCodeAt(0));
  const whole = new Int16Array(bytes.buffer);
  const side = (map.levels.length - 1) / 2;
  const growthAt = (place) => {
    const i = Math.min(Math.max(Math.floor(place), -side), side - 1) + side;
    return map.levels[i] + (place + side - i) * (map.levels[i + 1] - map.levels[i]);
  };
  const rows = (valueOf) => map.y.map((_, row) => map.x.map((__, column) => {
    const found = whole[row * map.x.length + column];
    return found === NO_VALUE ? null : valueOf(found / PLACES);
  }));
  return { x: map.x, y: map.y, place: rows((place) => place), growth: rows(growthAt) };
}

const mapsPlace = document.getElementById("maps");
const maps = mapsPlace ? JSON.parse(mapsPlace.textContent).map(unpack) : [];

// On a phone the colours stand below the map, with every third level.
function barBelow(bar) {
  const side = (bar.tickvals.length - 1) / 2;
  const shown = bar.tickvals.map((_, i) => i).filter((i) => [0, 2, side, 2 * side - 2, 2 * side].includes(i));
  return { ...bar, orientation: "h", y: -0.24, yanchor: "top", title: { text: "growth (1/s)", side: "bottom" },
    tickvals: shown.map((i) => bar.tickvals[i]), ticktext: shown.map((i) => bar.short[i]) };
}

// The traces with the map that they show. A surface is as high as the growth; from above only the colour tells it.
function withMap(trace) {
  if (!("map" in trace)) return trace;
  const { x, y, place, growth } = maps[trace.map];
  const values = trace.type === "surface" ? { z: growth, surfacecolor: place } : { z: place };
  const bar = trace.colorbar && (NARROW.matches ? barBelow(trace.colorbar) : trace.colorbar);
  return { ...trace, x, y, ...values, customdata: growth, ...(bar ? { colorbar: bar } : {}) };
}

// A phone has no room for the whole title of an axis.
function shortened(axis) {
  const text = axis.title.text.replace(/ of the coupled system( without dead time)?/, "");
  return { ...axis, title: { ...axis.title, text } };
}

// A narrow plot cuts the labels at its sides off, unless it is seen from farther away.
function fartherAway(scene) {
  const eye = Object.fromEntries(Object.entries(scene.camera.eye).map(([axis, value]) => [axis, 1.75 * value]));
  return { ...scene, camera: { ...scene.camera, eye } };
}

function figureLayout(plot) {
  const base = baseLayout(false);
  const axes = Object.entries(plot.layout).filter(([name]) => NARROW.matches && /^[xy]axis/.test(name));
  const named = Object.fromEntries(axes.map(([name, axis]) => [name, shortened(axis)]));
  const height = NARROW.matches ? Math.min(plot.layout.height, 400) : plot.layout.height;
  const margin = { ...base.margin, ...plot.layout.margin };
  if (NARROW.matches && plot.data.some((trace) => trace.colorbar)) margin.b = 110;
  if (NARROW.matches && plot.layout.scene) named.scene = fartherAway(plot.layout.scene);
  return { ...base, ...plot.layout, ...named, height, margin };
}

async function drawFigures() {
  for (const plot of plots) {
    const node = document.getElementById(plot.id);
    if (tellIfMissing(node)) continue;
    const legend = node.parentElement.querySelector(".legend");
    const isDeep = "scene" in plot.layout;
    await drawPlot({ node, legend, isDeep, traces: () => plot.data.map(withMap), layout: () => figureLayout(plot) });
  }
}

const allDrawn = (typeof panelsDrawn === "undefined" ? Promise.resolve() : panelsDrawn).then(drawFigures);
