// What a reader would see wrong on a page, as a list of sentences; none where all is well.
(async () => {
  const wrong = [];
  const wide = document.documentElement.scrollWidth - innerWidth;
  if (wide > 0) wrong.push(`the page is ${wide} px wider than the screen`);
  for (const table of document.querySelectorAll(".cards")) {
    const hidden = table.scrollWidth - table.clientWidth;
    if (hidden > 1) wrong.push(`${hidden} px of the table ${table.firstElementChild.id || table.firstElementChild.className} are hidden`);
  }

  // Where a text is cut by a box that scrolls sideways, only what is inside of it is seen.
  function seen(element, box) {
    let { left, right, top, bottom } = box;
    for (let one = element; one; one = one.parentElement) {
      if (getComputedStyle(one).overflowX === "auto") {
        const outer = one.getBoundingClientRect();
        [left, right] = [Math.max(left, outer.left), Math.min(right, outer.right)];
      }
    }
    return { left, right, top, bottom };
  }

  const texts = [];
  function add(element, box, text) {
    const found = seen(element, box);
    const edge = 1.5; // a line box is a little higher than its letters
    if (found.right - found.left < 3 * edge || found.bottom - found.top < 3 * edge) return;
    texts.push({ left: found.left + edge, right: found.right - edge, top: found.top + edge, bottom: found.bottom - edge, text });
  }
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) {
    const node = walker.currentNode;
    const parent = node.parentElement;
    if (!node.textContent.trim() || parent.closest("script, style, svg, [hidden]") || !parent.checkVisibility()) continue;
    const range = document.createRange();
    range.selectNodeContents(node);
    for (const box of range.getClientRects()) add(parent, box, node.textContent.trim());
  }
  for (const element of document.querySelectorAll("svg text")) {
    if (!element.textContent.trim() || !element.checkVisibility({ opacityProperty: true, visibilityProperty: true })) continue;
    const box = element.getBoundingClientRect();
    const frame = element.closest("svg").getBoundingClientRect();
    if (box.left < frame.left - 1 || box.right > frame.right + 1 || box.top < frame.top - 1 || box.bottom > frame.bottom + 1)
      wrong.push(`"${element.textContent}" is cut off`);
    add(element, box, element.textContent);
  }
  texts.sort((a, b) => a.top - b.top);
  texts.forEach((one, i) => {
    for (let j = i + 1; j < texts.length && texts[j].top < one.bottom; j++) {
      const other = texts[j];
      if (other.left < one.right && one.left < other.right) wrong.push(`"${one.text}" lies on "${other.text}"`);
    }
  });

  const hasUnit = (title) => /\([^()]+\)/.test(title || "");
  const plots = [...document.querySelectorAll(".js-plotly-plot")];
  if (plots.length === 0) wrong.push("there is no plot");
  for (const plot of plots) {
    const name = plot.id || plot.closest("section").id;
    const layout = plot._fullLayout;
    const axes = Object.keys(layout).filter((key) => /^[xy]axis\d*$/.test(key)).map((key) => layout[key])
      .filter((axis) => axis.type !== "category")
      .concat(layout._subplots.gl3d.flatMap((scene) => ["xaxis", "yaxis", "zaxis"].map((key) => layout[scene][key])));
    for (const axis of axes)
      if (!hasUnit(axis.title.text)) wrong.push(`${name}: the axis "${axis.title.text}" has no unit`);
    for (const bar of plot._fullData.filter((trace) => trace.showscale && trace.colorbar))
      if (!hasUnit(bar.colorbar.title.text)) wrong.push(`${name}: the colours have no unit`);

    const box = plot.getBoundingClientRect();
    if (box.height < 120 || box.width < 250) wrong.push(`${name}: only ${box.width} x ${box.height} px`);
    const isFull = (trace) => (trace.z || trace.y || []).some((value) => value !== null);
    const wanted = plot.data.filter((trace) => trace.visible !== false && isFull(trace)).length;
    const count = (selector) => plot.querySelectorAll(selector).length;
    const drawn = count(".trace.scatter") + count(".barlayer .trace") + count(".cartesianlayer .contour, .cartesianlayer .hm")
      + (count(".gl-container canvas") ? plot.data.filter((trace) => /surface|3d/.test(trace.type) && isFull(trace)).length : 0);
    if (wanted === 0 || drawn < wanted) wrong.push(`${name}: ${drawn} of ${wanted} traces are drawn`);
  }
  return wrong;
})()
