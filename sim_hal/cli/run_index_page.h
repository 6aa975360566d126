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
:root { color-scheme: light dark; }
body { font: 15px/1.5 system-ui, sans-serif; margin: 1.5rem auto; max-width: 75rem; padding: 0 1rem; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; }
th, td { border-bottom: 1px solid #8884; padding: .3rem .6rem; text-align: left; white-space: nowrap; }
td.number { font-variant-numeric: tabular-nums; text-align: right; }
.stable { color: light-dark(#1a7f37, #56d364); }
.unstable { color: light-dark(#b42318, #ff7b72); }
code { overflow-wrap: anywhere; }
</style>
<h1>Runs</h1>
<p>Tick two runs to see how they differ. Growth is in 1/s, peak force in N.</p>
<div class="wide"><table id="runs"><thead><tr><th></th><th>rig</th><th>verdict</th><th>growth (1/s)</th><th>time</th>
<th>peak force (N)</th><th>commit</th><th>files</th></tr></thead><tbody></tbody></table></div>
<section id="difference" aria-live="polite"></section>
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

function number(value, digits) {
  return value === null ? "\u2013" : Number(value).toPrecision(digits);
}

/* A run that was stopped too early has the growth that its eigenvalues predict. */
function growth(run) {
  return run.growth_per_s === null && run.predicted_growth_per_s !== null
    ? `predicted ${number(run.predicted_growth_per_s, 4)}` : number(run.growth_per_s, 4);
}

function link(text, address) {
  const made = element("a", text);
  made.href = address;
  return made;
}

function compare() {
  const ticked = [...body.querySelectorAll("input:checked")].map(box => runs[box.value]);
  difference.replaceChildren();
  if (ticked.length !== 2) return;
  const [b, a] = ticked;
  const log = run => `${root}/${run.folder}/${run.rig}.ulg`;
  const rows = [["verdict", a.verdict, b.verdict],
                ["growth (1/s)", growth(a), growth(b)],
                ["peak force (N)", number(a.peak_force_N, 4), number(b.peak_force_N, 4)]];
  for (const key of [...new Set([...Object.keys(a.settings), ...Object.keys(b.settings)])].sort()) {
    const [left, right] = [a.settings[key] ?? "default", b.settings[key] ?? "default"];
    if (left !== right) rows.push([key, left, right]);
  }
  const table = document.createElement("table");
  for (const cells of [["", `${a.rig} ${a.time}`, `${b.rig} ${b.time}`], ...rows]) {
    const row = table.insertRow();
    cells.forEach(text => row.append(element("td", text)));
  }
  const wide = element("div", "", "wide");
  wide.append(table);
  const curves = element("p", "Curves over each other: ");
  curves.append(element("code", `build/berth compare ${log(a)} ${log(b)} --page ${root}/compare.html`));
  difference.append(element("h2", "Difference"), wide, curves);
}

runs.forEach((run, index) => {
  const row = body.insertRow();
  const box = document.createElement("input");
  box.type = "checkbox";
  box.value = index;
  box.setAttribute("aria-label", `compare ${run.rig} ${run.time}`);
  box.addEventListener("change", compare);
  row.insertCell().append(box);
  row.append(element("td", run.rig), element("td", run.verdict, run.verdict), element("td", growth(run), "number"),
             element("td", run.time.replace(/T(\d+)-(\d+)-(\d+)/, " $1:$2:$3")), element("td", number(run.peak_force_N, 4), "number"), element("td", run.version));
  const files = row.insertCell();
  files.append(link("log", `${run.folder}/${run.rig}.ulg`));
  if (run.report) files.append(" ", link("report", `${run.folder}/${run.report}`));
});
</script>
</html>
)page";

} // namespace berth

#endif
