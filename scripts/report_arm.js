// The arm as a moving picture. Force is drawn where it acts, an arrow a metre long for the largest of the run.
"use strict";

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
  const [left, bottom] = scene.low;
  const [right, top] = scene.high;
  const svg = get("arm-view");
  svg.setAttribute("viewBox", `${left} ${-top} ${right - left} ${top - bottom}`);
  const slider = get("arm-time");
  slider.max = scene.frames - 1;
  get("arm-plane").textContent = scene.plane;

  function at(frame, point) {
    const place = 2 * (frame * scene.count + point);
    return [points[place], -points[place + 1]];
  }

  function path(frame, from, to) {
    const places = [];
    for (let i = from; i < to; i++) places.push(at(frame, i).join(","));
    return places.join(" ");
  }

  function draw(frame) {
    get("arm-base").setAttribute("points", path(frame, 0, 4));
    get("arm-links").setAttribute("points", path(frame, 4, scene.count));
    for (const [i, circle] of [...get("arm-joints").children].entries()) {
      const [x, y] = at(frame, 4 + i);
      circle.setAttribute("cx", x);
      circle.setAttribute("cy", y);
    }
    const [x, y] = at(frame, scene.count - 1);
    const length = largest_N > 0 ? -force[frame] / largest_N : 0;
    const arrow = get("arm-force");
    arrow.setAttribute("x1", x);
    arrow.setAttribute("y1", y);
    arrow.setAttribute("x2", x + length * scene.direction[0]);
    arrow.setAttribute("y2", y - length * scene.direction[1]);
    get("arm-clock").textContent =
      `${(scene.start_s + frame * scene.step_s).toFixed(1)} s, ${force[frame].toFixed(1)} N`;
    slider.value = frame;
  }

  const joint = get("arm-joints").firstElementChild;
  for (let i = 5; i < scene.count; i++) get("arm-joints").append(joint.cloneNode());
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
  draw(0);
})();
