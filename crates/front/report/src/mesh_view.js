"use strict";
// Shows closed meshes in `root`: turned by drag or touch, zoomed by wheel or two fingers, coloured by a value per vertex; scenes
// with frames are played.
function viewMeshes(root, data) {
  const find = name => root.querySelector(name);
  const canvas = find("canvas"), sceneMenu = find(".scene"), colourMenu = find(".colouring"), legend = find(".legend");
  const gl = canvas.getContext("webgl2", { antialias: true, preserveDrawingBuffer: true });
  if (!gl) {
    canvas.remove();
    legend.textContent = "This browser shows no WebGL 2, which the picture of the bodies needs.";
    return;
  }
  const BODY_COLOURS = ["#6f9fd8", "#e39a5b", "#6fbf9a", "#c78fb6", "#c9b458", "#8fc7dd", "#9a9a9a"];
  const rgb = hex => [1, 3, 5].map(at => parseInt(hex.slice(at, at + 2), 16) / 255);

  const program = gl.createProgram();
  const sources = [[gl.VERTEX_SHADER, `#version 300 es
    layout(location = 0) in vec3 place; layout(location = 1) in vec3 normal; layout(location = 2) in float value;
    uniform vec3 low, at, centre; uniform float span, away, radius; uniform vec4 pose; uniform mat3 turn; uniform vec2 scale;
    out vec3 toward; out float shown;
    vec3 turned(vec3 v) { return v + 2.0 * cross(pose.yzw, cross(pose.yzw, v) + pose.x * v); }
    void main() {
      vec3 eye = turn * (turned(low + span * place) + at - centre);
      toward = turn * turned(normal);
      shown = value;
      float near = max(away - 1.05 * radius, 0.02 * radius), far = away + 1.05 * radius, z = eye.z - away;
      gl_Position = vec4(scale * eye.xy, (far + near) / (near - far) * z + 2.0 * far * near / (near - far), -z);
    }`], [gl.FRAGMENT_SHADER, `#version 300 es
    precision highp float;
    in vec3 toward; in float shown; uniform vec3 colours[3], plain; out vec4 pixel;
    void main() {
      float t = (shown * 255.0 - 1.0) / 254.0;
      vec3 scaled = t < 0.5 ? mix(colours[0], colours[1], 2.0 * t) : mix(colours[1], colours[2], 2.0 * t - 1.0);
      vec3 n = normalize(gl_FrontFacing ? toward : -toward);
      float light = 0.38 + 0.62 * max(dot(n, normalize(vec3(0.35, 0.45, 0.9))), 0.0);
      pixel = vec4((shown < 0.5 / 255.0 ? plain : scaled) * light, 1.0);
    }`]];
  for (const [kind, source] of sources) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  gl.useProgram(program);
  const uniform = name => gl.getUniformLocation(program, name);
  const [low, at, centre, span, far, radius, pose, turnAt, scale, colours, plain] =
    ["low", "at", "centre", "span", "away", "radius", "pose", "turn", "scale", "colours", "plain"].map(uniform);

  const bytes = text => Uint8Array.from(atob(text), letter => letter.charCodeAt(0));
  const buffer = (target, values) => {
    const made = gl.createBuffer();
    gl.bindBuffer(target, made);
    gl.bufferData(target, values, gl.STATIC_DRAW);
    return made;
  };
  const attribute = (place, size, type, normalised) => {
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, size, type, normalised, 0, 0);
  };

  // The mean of the normals of the triangles around each vertex, by their areas.
  function normals(places, corners) {
    const sum = new Float32Array(places.length);
    for (let i = 0; i < corners.length; i += 3) {
      const [a, b, c] = [3 * corners[i], 3 * corners[i + 1], 3 * corners[i + 2]];
      const u = [0, 1, 2].map(k => places[b + k] - places[a + k]), v = [0, 1, 2].map(k => places[c + k] - places[a + k]);
      for (let k = 0; k < 3; k++) {
        const n = u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
        sum[a + k] += n;
        sum[b + k] += n;
        sum[c + k] += n;
      }
    }
    return sum;
  }

  const meshes = data.meshes.map(mesh => {
    const places = new Uint16Array(bytes(mesh.places).buffer), packed = bytes(mesh.corners).buffer;
    const corners = mesh.wide ? new Uint32Array(packed) : new Uint16Array(packed);
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    buffer(gl.ARRAY_BUFFER, places);
    attribute(0, 3, gl.UNSIGNED_SHORT, true);
    buffer(gl.ARRAY_BUFFER, normals(places, corners));
    attribute(1, 3, gl.FLOAT, false);
    const values = mesh.values.map(text => buffer(gl.ARRAY_BUFFER, bytes(text)));
    buffer(gl.ELEMENT_ARRAY_BUFFER, corners);
    return { ...mesh, array, values, count: corners.length, type: mesh.wide ? gl.UNSIGNED_INT : gl.UNSIGNED_SHORT };
  });

  // The edges of a box about the origin.
  function edges(lengths) {
    const points = [];
    for (let axis = 0; axis < 3; axis++) {
      for (const [a, b] of [[-1, -1], [-1, 1], [1, -1], [1, 1]]) {
        for (const end of [-1, 1]) {
          const sides = [];
          [sides[axis], sides[(axis + 1) % 3], sides[(axis + 2) % 3]] = [end, a, b];
          points.push(...sides.map((side, k) => 0.5 * side * lengths[k]));
        }
      }
    }
    return points;
  }
  const boxes = data.scenes.map(scene => {
    if (!scene.box) return null;
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    buffer(gl.ARRAY_BUFFER, new Float32Array(edges(scene.box)));
    attribute(0, 3, gl.FLOAT, false);
    return array;
  });
  function outline(array) {
    gl.bindVertexArray(array);
    gl.vertexAttrib3f(1, 0, 0, 1);
    gl.vertexAttrib1f(2, 0);
    gl.uniform3f(low, 0, 0, 0);
    gl.uniform3f(at, 0, 0, 0);
    gl.uniform1f(span, 1);
    gl.uniform4f(pose, 1, 0, 0, 0);
    gl.uniform3f(plain, 0.55, 0.55, 0.55);
    gl.drawArrays(gl.LINES, 0, 24);
  }

  const film = find(".film"), playing = film.querySelector("button"), place = film.querySelector("input");
  const FRAME_MS = 80;
  let turn = [1, 0, 0, 0, 1, 0, 0, 0, 1], zoom = 1, waiting = false, clock = null;

  // The bodies of a scene, or of the frame of it that is shown.
  const bodiesOf = scene => scene.frames
    ? scene.bodies.map(([number], k) => [number, ...scene.frames[place.value][k]])
    : scene.bodies;

  function draw() {
    waiting = false;
    const ratio = window.devicePixelRatio || 1, scene = data.scenes[sceneMenu.value];
    canvas.width = Math.max(1, Math.round(canvas.clientWidth * ratio));
    canvas.height = Math.max(1, Math.round(canvas.clientHeight * ratio));
    const colouring = data.colourings[colourMenu.value], aspect = canvas.width / canvas.height, focus = 3.7;
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.uniform1f(radius, scene.radius);
    gl.uniform1f(far, 1.05 * focus * scene.radius * zoom);
    gl.uniform2f(scale, focus * Math.min(1, 1 / aspect), focus * Math.min(1, aspect));
    gl.uniform3fv(centre, scene.centre);
    gl.uniformMatrix3fv(turnAt, false, turn);
    if (colouring) gl.uniform3fv(colours, colouring.colours.flatMap(rgb));
    if (boxes[sceneMenu.value]) outline(boxes[sceneMenu.value]);
    for (const [number, x, y, z, ...orientation] of bodiesOf(scene)) {
      const mesh = meshes[number];
      gl.bindVertexArray(mesh.array);
      if (colouring) {
        gl.bindBuffer(gl.ARRAY_BUFFER, mesh.values[colourMenu.value]);
        attribute(2, 1, gl.UNSIGNED_BYTE, true);
      } else {
        gl.disableVertexAttribArray(2);
        gl.vertexAttrib1f(2, 0);
      }
      gl.uniform3fv(plain, colouring ? [0.7, 0.7, 0.7] : rgb(BODY_COLOURS[number % BODY_COLOURS.length]));
      gl.uniform3fv(low, mesh.low);
      gl.uniform1f(span, mesh.span);
      gl.uniform3f(at, x, y, z);
      gl.uniform4fv(pose, orientation);
      gl.drawElements(gl.TRIANGLES, mesh.count, mesh.type, 0);
    }
    canvas.dataset.drawn = scene.bodies.length;
  }

  function redraw() {
    if (!waiting) window.requestAnimationFrame(draw);
    waiting = true;
  }

  function show(frame) {
    const labels = data.scenes[sceneMenu.value].labels;
    place.value = frame % labels.length;
    film.querySelector("output").textContent = labels[place.value];
    canvas.dataset.frame = place.value;
    redraw();
  }
  function pause() {
    clearInterval(clock);
    clock = null;
    playing.textContent = "Play";
  }
  playing.onclick = () => {
    if (clock !== null) return pause();
    clock = setInterval(() => show(Number(place.value) + 1), FRAME_MS);
    playing.textContent = "Pause";
  };
  place.oninput = () => {
    pause();
    show(Number(place.value));
  };

  function explain() {
    const colouring = data.colourings[colourMenu.value], add = (tag, name, text) => {
      const made = document.createElement(tag);
      made.className = name;
      made.textContent = text;
      return legend.appendChild(made);
    };
    legend.textContent = "";
    if (colouring) {
      add("div", "bar", "").style.background = `linear-gradient(to right, ${colouring.colours.join(",")})`;
      for (const text of colouring.labels) add("span", "", text);
      add("div", "unit", colouring.unit);
    } else {
      const keys = add("div", "keys", "");
      data.meshes.forEach((mesh, number) => {
        const key = keys.appendChild(document.createElement("span"));
        key.appendChild(document.createElement("i")).style.background = BODY_COLOURS[number % BODY_COLOURS.length];
        key.append(mesh.name);
      });
    }
    redraw();
  }

  // Turns about the axes of the screen, radians; matrices column after column.
  function rotate(right, down) {
    const [c, s, d, t] = [Math.cos(right), Math.sin(right), Math.cos(down), Math.sin(down)];
    const by = [c, s * t, -s * d, 0, d, t, s, -c * t, c * d];
    turn = turn.map((_, i) => [0, 1, 2].reduce((sum, k) => sum + by[3 * k + i % 3] * turn[3 * Math.floor(i / 3) + k], 0));
    redraw();
  }
  function magnify(by) {
    zoom = Math.min(4, Math.max(0.08, zoom * by));
    redraw();
  }

  const fingers = new Map();
  const apart = () => {
    const [a, b] = [...fingers.values()];
    return Math.hypot(a[0] - b[0], a[1] - b[1]);
  };
  canvas.onpointerdown = event => {
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, [event.clientX, event.clientY]);
  };
  canvas.onpointermove = event => {
    const last = fingers.get(event.pointerId), now = [event.clientX, event.clientY];
    if (!last) return;
    const before = fingers.size === 2 ? apart() : 0;
    fingers.set(event.pointerId, now);
    if (before > 0) magnify(before / Math.max(apart(), 1));
    else if (fingers.size === 1) rotate(0.01 * (now[0] - last[0]), 0.01 * (now[1] - last[1]));
  };
  canvas.onpointerup = canvas.onpointercancel = event => fingers.delete(event.pointerId);
  canvas.addEventListener("wheel", event => {
    event.preventDefault();
    magnify(Math.exp(0.0015 * event.deltaY));
  }, { passive: false });
  canvas.onkeydown = event => {
    const step = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] }[event.key];
    const by = { "+": 0.9, "=": 0.9, "-": 1 / 0.9 }[event.key];
    if (step) rotate(...step);
    if (by) magnify(by);
    if (step || by) event.preventDefault();
  };
  find(".reset").onclick = () => {
    [turn, zoom] = [start, 1];
    redraw();
  };
  data.scenes.forEach((scene, number) => sceneMenu.add(new Option(scene.name, number)));
  data.colourings.forEach((colouring, number) => colourMenu.add(new Option(colouring.name, number)));
  colourMenu.add(new Option("body", data.colourings.length));
  // A scene may have its own colours.
  sceneMenu.onchange = () => {
    const scene = data.scenes[sceneMenu.value];
    colourMenu.value = scene.colouring ?? colourMenu.value;
    pause();
    film.hidden = !scene.frames;
    if (scene.frames) {
      place.max = scene.frames.length - 1;
      show(0);
    }
    explain();
  };
  colourMenu.onchange = explain;
  new ResizeObserver(redraw).observe(canvas);
  // Rings lie flat in their files: a little from one side, they have depth.
  rotate(-0.3, 0.4);
  const start = turn;
  explain();
  draw();
}
