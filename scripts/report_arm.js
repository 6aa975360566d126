// The arm as a moving picture, in metres; what is not to scale (joints, arrow, letters) goes by the width of the view.
"use strict";

const ASPECT = 2.4; // of the picture, width over height

(() => {
  const scene = JSON.parse(document.getElementById("arm-data").textContent);
  if (scene === null) return;
  const floats = (text) => new Float32Array(Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer);
  const points = floats(scene.points);
  const force = floats(scene.force);
  const largest_N = force.reduce((most, value) => Math.max(most, Math.abs(value)), 0);
  const section = document.getElementById("arm");
  section.hidden = false;
  const get = (id) => document.getElementById(id);
  const svg = get("arm-view");
  svg.style.aspectRatio = ASPECT;
  const slider = get("arm-time");
  slider.max = scene.frames - 1;
  get("arm-plane").textContent = scene.plane;
  const target = svg.querySelector(scene.is_block ? "polygon.object" : "polyline.object");
  const has_target = "object" in scene.parts;
  get("arm-object").hidden = !has_target;
  for (const shape of svg.querySelectorAll(".object")) shape.style.display = has_target && shape === target ? "" : "none";
  let view = null;

  function at(frame, point) {
    const place = 2 * (frame * scene.count + point);
    return [points[place], -points[place + 1]];
  }

  function path(frame, part) {
    const places = [];
    const [from, to] = scene.parts[part];
    for (let i = from; i < to; i++) places.push(at(frame, i).join(","));
    return places.join(" ");
  }

  function line(x1, y1, x2, y2) {
    const drawn = document.createElementNS(svg.namespaceURI, "line");
    for (const [name, value] of Object.entries({ x1, y1, x2, y2 })) drawn.setAttribute(name, value);
    return drawn;
  }

  function label(x, y, text, anchor) {
    const drawn = document.createElementNS(svg.namespaceURI, "text");
    for (const [name, value] of Object.entries({ x, y, "text-anchor": anchor, "font-size": 12 * view.pixel_m }))
      drawn.setAttribute(name, value);
    drawn.textContent = text;
    return drawn;
  }

  // The box, made as wide as the picture is, and lines a round number of metres apart.
  function look(box) {
    let [left, low] = box.low;
    const [right, high] = box.high;
    const letter_m = Math.max(right - left, ASPECT * (high - low)) / (svg.clientWidth || 1000);
    low -= 26 * letter_m; // room for the letters at the edges
    left -= 44 * letter_m;
    const width = 1.1 * Math.max(right - left, ASPECT * (high - low));
    const height = width / ASPECT;
    const pixel_m = width / (svg.clientWidth || 1000); // letters are as large on every screen
    view = { left: (left + right - width) / 2, top: (low + high + height) / 2, width, pixel_m };
    const bottom = view.top - height;
    svg.setAttribute("viewBox", `${view.left} ${-view.top} ${width} ${height}`);
    const rough_m = Math.max(width / 12, 36 * pixel_m);
    const power_m = 10 ** Math.floor(Math.log10(rough_m));
    const gap_m = power_m * [1, 2, 5, 10].find((many) => many * power_m >= rough_m);
    const digits = Math.max(0, -Math.floor(Math.log10(gap_m) + 1e-9));
    const metres = (value) => `${value.toFixed(digits).replace("-", "\u2212")} m`;
    const lines = [];
    const labels = [];
    for (let i = Math.ceil(view.left / gap_m); i * gap_m < view.left + width; i++) {
      const x = i * gap_m;
      lines.push(line(x, -view.top, x, -bottom));
      const is_inside = x > view.left + 60 * pixel_m && x < view.left + width - 22 * pixel_m;
      if (is_inside) labels.push(label(x, -bottom - 6 * pixel_m, metres(x), "middle"));
    }
    for (let i = Math.ceil(bottom / gap_m); i * gap_m < view.top; i++) {
      const y = i * gap_m;
      lines.push(line(view.left, -y, view.left + width, -y));
      const is_inside = y > bottom + 22 * pixel_m && y < view.top - 12 * pixel_m;
      if (is_inside) labels.push(label(view.left + 4 * pixel_m, -y, metres(y), "start"));
    }
    get("arm-grid").replaceChildren(...lines);
    get("arm-labels").replaceChildren(...labels);
    for (const circle of get("arm-joints").children) circle.setAttribute("r", 0.008 * width);
  }

  function draw(frame) {
    for (const part of ["base", "mount", "links"]) get(`arm-${part}`).setAttribute("points", path(frame, part));
    if (has_target) target.setAttribute("points", path(frame, "object"));
    const [first, end] = scene.parts.links;
    for (const [i, circle] of [...get("arm-joints").children].entries()) {
      const [x, y] = at(frame, first + i);
      circle.setAttribute("cx", x);
      circle.setAttribute("cy", y);
    }
    const [x, y] = at(frame, end - 1);
    const length = largest_N > 0 ? (-0.12 * view.width * force[frame]) / largest_N : 0;
    const arrow = get("arm-force");
    arrow.style.display = Math.abs(length) > 0.001 * view.width ? "" : "none";
    arrow.setAttribute("x1", x);
    arrow.setAttribute("y1", y);
    arrow.setAttribute("x2", x + length * scene.direction[0]);
    arrow.setAttribute("y2", y - length * scene.direction[1]);
    get("arm-clock").textContent =
      `${(scene.start_s + frame * scene.step_s).toFixed(1)} s, ${force[frame].toFixed(1)} N`;
    slider.value = frame;
  }

  const joint = get("arm-joints").firstElementChild;
  const [first, end] = scene.parts.links;
  for (let i = first + 1; i < end; i++) get("arm-joints").append(joint.cloneNode());
  let playing = false;
  let shown = 0;
  let last_ms = null; // of the picture before; none yet
  function play(now_ms) {
    if (!playing) return;
    const passed_ms = last_ms === null ? 0 : now_ms - last_ms;
    shown += (Number(get("arm-speed").value) * passed_ms) / 1000 / scene.step_s;
    last_ms = now_ms;
    if (shown >= scene.frames - 1) {
      shown = scene.frames - 1;
      playing = false;
      get("arm-play").textContent = "Play";
    }
    draw(Math.floor(shown));
    requestAnimationFrame(play);
  }
  get("arm-play").addEventListener("click", () => {
    playing = !playing;
    get("arm-play").textContent = playing ? "Pause" : "Play";
    if (shown >= scene.frames - 1) shown = 0;
    last_ms = null;
    requestAnimationFrame(play);
  });
  slider.addEventListener("input", () => {
    shown = Number(slider.value);
    draw(shown);
  });
  get("arm-box").addEventListener("change", () => {
    look(scene.boxes[get("arm-box").value]);
    draw(Math.floor(shown));
  });
  look(scene.boxes.whole);
  draw(0);
})();
