/* The page of all kept runs: its head, and the script behind the rows. */
#ifndef SIM_HAL_CLI_RUN_INDEX_PAGE_H
#define SIM_HAL_CLI_RUN_INDEX_PAGE_H

namespace berth
{

constexpr const char *run_index_head = R"page(<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>berth: runs</title>
<style>
:root { color-scheme: light dark; --line: light-dark(#DCE0E3, #333B42); --quiet: light-dark(#555E66, #A3ACB4); }
body { font: 15px/1.5 system-ui, "Segoe UI", "Liberation Sans", "DejaVu Sans", sans-serif; margin: 1.5rem auto;
  max-width: 75rem; padding: 0 1rem; color: light-dark(#1B2025, #E4E8EB); background: light-dark(#FFFFFF, #14181C); }
h1 { font-size: 28px; font-weight: 600; margin: 0; }
h2 { font-size: 18px; font-weight: 600; margin: 34px 0 4px; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; }
#runs { width: 100%; }
th, td { border-bottom: 1px solid var(--line); padding: .3rem .6rem; text-align: left; }
th, #difference td:first-child { color: var(--quiet); font-weight: 600; }
#runs td { white-space: nowrap; }
#runs .number { font-variant-numeric: tabular-nums; text-align: right; }
#difference td:nth-child(n+2) { overflow-wrap: anywhere; min-width: 6em; }
#difference th, #difference td { vertical-align: top; }
.stable { color: light-dark(#00629B, #5FB4EA); font-weight: 600; }
.unstable { color: light-dark(#B84A00, #F38B4A); font-weight: 600; }
a { color: inherit; }
pre { background: light-dark(#F4F6F7, #1C2227); border: 1px solid var(--line); padding: 10px 14px; white-space: pre-wrap;
  overflow-wrap: anywhere; }
#filter { font: inherit; width: min(28rem, 100%); box-sizing: border-box; padding: 4px 8px; }
#runs .differs { white-space: normal; overflow-wrap: anywhere; min-width: 9rem; }
@media (max-width: 1100px) { /* a run is a card: each cell says what it is */
  #runs thead { display: none; }
  #runs tr:not([hidden]) { display: flex; flex-wrap: wrap; gap: 0 14px; border-bottom: 1px solid var(--line); padding: 6px 0; }
  #runs td { border: 0; padding: 2px 0; white-space: normal; }
  #runs td:empty { display: none; }
  #runs td[data-title]::before { content: attr(data-title) " "; color: var(--quiet); }
}
</style>
<h1>Runs</h1>
<p>Tick two runs to see how they differ; a third takes the place of the first.</p>
<p><input id="filter" type="search" placeholder="filter: words of rig, verdict, settings"
  aria-label="words of rig, time, verdict or settings; runs that hold all of them are shown"></p>
<section id="difference" aria-live="polite"></section>
<div class="wide"><table id="runs"><thead><tr><th></th><th>rig</th><th>start</th><th>verdict</th>
<th>what differs</th>
<th class="number">growth (1/s)</th><th class="number">peak force (N)</th><th>commit</th><th>files</th></tr></thead>
<tbody></tbody></table></div>
<script>
)page";

constexpr const char *run_index_script = R"page(
const body = document.querySelector("#runs tbody");
const difference = document.querySelector("#difference");

function element(name, text, className) {
  const made = document.createElement(name);
  made.textContent = text ?? "";
  if (className) made.className = className;
  return made;
}

/* Four digits and no exponent, as `berth run` prints forces. */
function number(value) {
  if (value === null) return "\u2013";
  if (Math.abs(value) < 1e-4 || Math.abs(value) >= 1e7) return value === 0 ? "0" : value.toPrecision(4);
  const rounded = Number(value.toPrecision(4));
  return rounded.toFixed(Math.max(0, 3 - Math.floor(Math.log10(Math.abs(rounded))))).replace("-", "\u2212");
}

/* Measured, or what the eigenvalues say of a run that does not show it. */
function growth(run) {
  const told = run.growth;
  return !told ? "none" : (told.origin === "predicted" ? "predicted " : "") + number(told.growth_per_s);
}

function link(text, address) {
  const made = element("a", text);
  made.href = address.split("/").map(encodeURIComponent).join("/");
  return made;
}

/* 2026-11-29T23-40-05-2 is the second run of that second. */
function start(run) {
  return run.time.replace(/T(\d+)-(\d+)-(\d+)(?:-(\d+))?/,
    (_, h, m, s, n) => ` ${h}:${m}:${s}${n ? ` (${n})` : ""}`);
}

function quoted(path) {
  return /^[\w./-]+$/.test(path) ? path : `'${path.replaceAll("'", "'\\''")}'`;
}

/* Sums and products of one number may differ in their last digit. */
function isSame(a, b) {
  return a === b || Math.abs(a - b) <= 1e-12 * Math.max(Math.abs(a), Math.abs(b));
}

/* Six digits of numbers, unless they differ beyond them. */
function sixDigits(text) {
  return isNaN(text) ? text : String(Number(Number(text).toPrecision(6)));
}

function shortened(a, b) {
  const short = [sixDigits(a), sixDigits(b)];
  return short[0] === short[1] ? [a, b] : short;
}

/* Ticked boxes, the oldest tick first. */
let ticks = [];

function tick(box) {
  ticks = ticks.filter(other => other !== box);
  if (box.checked) ticks.push(box);
  while (ticks.length > 2) ticks.shift().checked = false;
  compare();
}

function compare() {
  const ticked = ticks.map(box => Number(box.value)).sort((a, b) => a - b).map(i => runs[i]);
  difference.replaceChildren();
  if (ticked.length !== 2) return;
  const [b, a] = ticked;
  const log = run => quoted(`${root}/${run.folder}/${run.rig}.ulg`);
  const rows = [["verdict", a.verdict, b.verdict],
                ["growth (1/s)", growth(a), growth(b)],
                ["peak force (N)", number(a.peak_force_N), number(b.peak_force_N)]];
  const measured = rows.length;
  for (const key of [...new Set([...Object.keys(a.settings), ...Object.keys(b.settings)])].sort()) {
    const [left, right] = [a.settings[key] ?? defaults[key], b.settings[key] ?? defaults[key]];
    if (!isSame(left, right)) rows.push([key, ...shortened(left, right)]);
  }
  const table = document.createElement("table");
  const head = table.createTHead().insertRow();
  ["", `${a.rig} ${start(a)}`, `${b.rig} ${start(b)}`].forEach(text => head.append(element("th", text)));
  const lines = table.createTBody();
  for (const cells of rows) {
    const row = lines.insertRow();
    cells.forEach((text, i) => row.append(element("td", i ? text : text.replace(/[._]/g, "$&\u200b"))));
  }
  const wide = element("div", "", "wide");
  wide.append(table);
  difference.append(element("h2", "Difference"), wide);
  if (rows.length === measured) difference.append(element("p", a.config_hash === b.config_hash ? "No parameter differs."
    : "Axes, orders or the arm differ; berth compare says which."));
  difference.append(element("p", "This command draws their curves over each other:"),
    element("pre", `berth compare ${log(a)} ${log(b)} --page ${quoted(`${root}/compare.html`)}`));
}

function setting(run, key) {
  return run.settings[key] ?? defaults[key];
}

/* Keys that are not the same in all runs of this rig that are shown: what tells the runs of a sweep apart. */
function differingKeys(shown) {
  const keys = [...new Set(shown.flatMap(run => Object.keys(run.settings)))].sort();
  return keys.filter(key => shown.some(run => !isSame(setting(run, key), setting(shown[0], key))));
}

function differsText(run, keys) {
  return keys.map(key => `${key} = ${sixDigits(setting(run, key))}`).join(", ");
}

/* Rows whose words hold every word of the filter; what differs is found among them anew. */
function show() {
  const words = document.querySelector("#filter").value.toLowerCase().split(/\s+/).filter(word => word);
  const texts = run => [run.rig, start(run), run.verdict, run.version,
    ...Object.entries(run.settings).map(([key, value]) => `${key} = ${value} ${key}=${value}`)].join(" ").toLowerCase();
  const isShown = runs.map(run => words.every(word => texts(run).includes(word)));
  const keysOf = {};
  runs.forEach((run, i) => {
    const shown = runs.filter((other, j) => isShown[j] && other.rig === run.rig);
    body.rows[i].hidden = !isShown[i];
    keysOf[run.rig] ??= differingKeys(shown);
    body.rows[i].querySelector(".differs").textContent = differsText(run, keysOf[run.rig]);
  });
}

runs.forEach((run, index) => {
  const row = body.insertRow();
  const box = document.createElement("input");
  box.type = "checkbox";
  box.value = index;
  box.setAttribute("aria-label", `compare ${run.rig} ${run.time}`);
  box.addEventListener("change", () => tick(box));
  row.insertCell().append(box);
  const cell = (text, title, className) => {
    const made = element("td", text, className);
    if (title) made.dataset.title = title;
    row.append(made);
  };
  cell(run.rig);
  cell(start(run));
  cell(run.verdict, "", { true: "stable", false: "unstable" }[run.stable]);
  cell("", "differs:", "differs");
  cell(growth(run), "growth (1/s)", "number");
  cell(number(run.peak_force_N), "peak force (N)", "number");
  cell(run.version, "commit");
  const files = row.insertCell();
  files.append(link("log", `${run.folder}/${run.rig}.ulg`));
  if (run.report) files.append(" ", link("report", `${run.folder}/${run.report}`));
});
document.querySelector("#filter").addEventListener("input", show);
show();
</script>
</html>
)page";

} // namespace berth

#endif
