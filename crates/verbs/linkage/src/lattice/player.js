"use strict";
// Plays a lattice in `root`; keys pressed in `keys` steer it.
function playLattice(root, keys, data) {
  const find = name => root.querySelector(name);
  const view = find(".squares"), slider = find(".frame"), play = find(".play"), time = find(".time"), speed = find(".speed");
  const corners = [0, 3 * Math.PI / 4, Math.PI / 4, 5 * Math.PI / 4, -Math.PI / 4];
  let frame = 0, playing = true, last = null, drawn = null;
  slider.max = data.frames.length - 1;

  function colour(angle) {
    const turn = ((angle / (Math.PI / 2)) % 1 + 1) % 1;
    const part = phase => Math.round(165 + 75 * Math.cos(2 * Math.PI * (turn - phase)));
    return `rgb(${part(0)},${part(1 / 3)},${part(2 / 3)})`;
  }

  function draw() {
    const ratio = window.devicePixelRatio || 1;
    const width = Math.round(view.clientWidth * ratio), height = Math.round(view.clientHeight * ratio);
    const state = [Math.floor(frame), width, height].join();
    if (state === drawn) return;
    drawn = state;
    if (view.width !== width || view.height !== height) { view.width = width; view.height = height; }
    const pen = view.getContext("2d"), [left, low, right, up] = data.bounds;
    const scale = Math.min(width / (right - left), height / (up - low));
    const originX = (width - scale * (right - left)) / 2, originY = (height - scale * (up - low)) / 2;
    const s = data.frames[Math.floor(frame)];
    const corner = (p, k) => {
      const angle = s[3 * p + 2] + corners[k];
      return [s[3 * p] + data.size[p] * Math.cos(angle), s[3 * p + 1] + data.size[p] * Math.sin(angle)];
    };
    const place = ([x, y]) => [originX + scale * (x - left), originY + scale * (up - y)];
    pen.clearRect(0, 0, width, height);
    pen.lineWidth = Math.max(0.5, 0.02 * scale);
    pen.strokeStyle = "#333";
    for (let p = 0; p < data.size.length; p++) {
      pen.beginPath();
      for (const k of [1, 2, 4, 3]) pen.lineTo(...place(corner(p, k)));
      pen.closePath();
      pen.fillStyle = colour(s[3 * p + 2]);
      pen.fill();
      pen.stroke();
    }
    pen.lineWidth = Math.max(1, 0.05 * scale);
    pen.strokeStyle = "#111";
    pen.lineCap = "round";
    pen.beginPath();
    // A fixed cell is listed once.
    const [xx, yy, xy] = data.cells[Math.min(Math.floor(frame), data.cells.length - 1)];
    for (const [p, k, q, l, right, up] of data.rods) {
      const [x, y] = corner(q, l);
      pen.moveTo(...place(corner(p, k)));
      pen.lineTo(...place([x + right * xx + up * xy, y + up * yy]));
    }
    pen.stroke();
    slider.value = Math.floor(frame);
    time.textContent = `t = ${data.times[Math.floor(frame)].toFixed(3)}`;
  }

  function tick(now) {
    if (playing && last !== null) {
      frame += (now - last) / 1000 * 25 * Number(speed.value);
      if (frame >= data.frames.length) frame = 0;
    }
    last = now;
    draw();
    window.requestAnimationFrame(tick);
  }

  function setPlaying(on) { playing = on; play.textContent = on ? "Pause" : "Play"; }
  play.onclick = () => setPlaying(!playing);
  slider.oninput = () => { setPlaying(false); frame = Number(slider.value); };
  keys.onkeydown = event => {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (event.key === " " && event.target !== play) { setPlaying(!playing); event.preventDefault(); }
    if (step && event.target !== slider) {
      setPlaying(false);
      frame = Math.min(data.frames.length - 1, Math.max(0, Math.floor(frame) + step));
    }
  };
  if (window.matchMedia("(prefers-reduced-motion: reduce)").matches) setPlaying(false);
  const wheel = find(".wheel").getContext("2d");
  for (let x = 0; x < 160; x++) { wheel.fillStyle = colour(x / 160 * Math.PI / 2); wheel.fillRect(x, 0, 1, 12); }
  draw();
  window.requestAnimationFrame(tick);
}
