// Player of the frames: one canvas for each engine, all with the same time, position and magnification.
"use strict";
(async () => {
  const root = document.getElementById("viewer");
  const source = document.getElementById("frames");
  if (!root || !source) return;
  const data = JSON.parse(source.textContent);
  const packed = Uint8Array.from(atob(data.packed), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());

  // Where each frame begins; frames are unpacked in order, as places are those of the frame before and what they changed by.
  let offset = 0;
  const take = (count) => bytes.subarray(offset, (offset += count));
  const reels = data.frames.map((frames) => {
    let before = null;
    return frames.map((frame) => {
      if (!frame) return null;
      const places = (old) => {
        const [high, low] = [take(frame.n), take(frame.n)];
        return Uint16Array.from({ length: frame.n }, (_, i) => (old ? old[i] : 0) + high[i] * 256 + low[i]);
      };
      const x = places(frame.after ? before.x : null);
      const y = places(frame.after ? before.y : null);
      return (before = { ...frame, x, y, direction: take(frame.n), pace: take(frame.n), size: frame.sized ? take(frame.n) : null, met: frame.told ? take(frame.n) : null });
    });
  });

  const ramp = [[68, 1, 84], [65, 68, 135], [42, 120, 142], [34, 168, 132], [122, 209, 81], [253, 231, 37]];
  const viridis = (share) => {
    const place = Math.max(0, Math.min(1, share)) * (ramp.length - 1);
    const i = Math.min(ramp.length - 2, Math.floor(place));
    return `rgb(${ramp[i].map((c, k) => Math.round(c + (place - i) * (ramp[i + 1][k] - c))).join(" ")})`;
  };
  const STEPS = 64;
  const UNKNOWN = STEPS; // the colour of what is not known
  const palette = {
    direction: Array.from({ length: STEPS }, (_, i) => `hsl(${(i * 360) / STEPS} 72% 52%)`),
    other: [...Array.from({ length: STEPS }, (_, i) => viridis(i / (STEPS - 1))), "#b0b0b0"],
  };
  const MET = ["partner", "impact"]; // colourings by the last collision
  const CHUNK = 4096; // particles that are sorted by colour before they are drawn
  const DENSEST = 3; // local density of the brightest colour, in units of the mean

  const view = { scale: 1, x: 0.5, y: 0.5 }; // centre in units of the sides
  let [time, colouring, pending, playing, last] = [data.times.length - 1, "direction", false, false, 0];

  // Particles within cells that hold six on average, over that average, smoothed over the neighbours.
  const density = (frame) => {
    if (frame.density) return frame.density;
    const [w, h] = frame.sides;
    const cell = Math.sqrt((6 * w * h) / Math.max(1, frame.n));
    const [nx, ny] = [Math.max(1, Math.round(w / cell)), Math.max(1, Math.round(h / cell))];
    const at = (i) => Math.min(nx - 1, Math.floor((frame.x[i] * nx) / 65536)) + nx * Math.min(ny - 1, Math.floor((frame.y[i] * ny) / 65536));
    const [count, vx, vy] = [new Float32Array(nx * ny), new Float32Array(nx * ny), new Float32Array(nx * ny)];
    for (let i = 0; i < frame.n; i++) {
      const angle = (frame.direction[i] * 2 * Math.PI) / 256;
      count[at(i)]++;
      vx[at(i)] += frame.pace[i] * Math.cos(angle);
      vy[at(i)] += frame.pace[i] * Math.sin(angle);
    }
    const wrap = (k, n, periodic) => (periodic ? (k + n) % n : Math.max(0, Math.min(n - 1, k)));
    const smooth = (of) => of.map((_, at) => {
      let sum = 0;
      for (let dy = -1; dy <= 1; dy++)
        for (let dx = -1; dx <= 1; dx++)
          sum += of[wrap((at % nx) + dx, nx, frame.periodic[0]) + nx * wrap(Math.floor(at / nx) + dy, ny, frame.periodic[1])];
      return sum / 9;
    });
    const [mean, values] = [frame.n / (nx * ny), smooth(count)];
    frame.density = { nx, ny, at, values: values.map((value) => value / mean), count: values, vx: smooth(vx), vy: smooth(vy) };
    return frame.density;
  };

  // Colour of each particle, as a step of the palette.
  const steps = (frame) => {
    frame.steps = frame.steps || {};
    if (frame.steps[colouring]) return frame.steps[colouring];
    const crowd = colouring === "density" ? density(frame) : null;
    const met = (bits) => (i) => {
      const found = frame.met ? (frame.met[i] >> bits) & 15 : 0;
      return found ? ((found - 1) * (STEPS - 1)) / (data.steps - 1) : UNKNOWN;
    };
    const step = {
      direction: (i) => (frame.direction[i] * STEPS) / 256,
      speed: (i) => (frame.pace[i] * data.fastest / 255 / 2) * (STEPS - 1),
      density: (i) => (crowd.values[crowd.at(i)] / DENSEST) * (STEPS - 1),
      partner: met(4),
      impact: met(0),
    }[colouring];
    const most = MET.includes(colouring) ? UNKNOWN : STEPS - 1;
    frame.steps[colouring] = Uint8Array.from({ length: frame.n }, (_, i) => Math.min(most, Math.round(step(i)) % (colouring === "direction" ? STEPS : 256)));
    return frame.steps[colouring];
  };

  const panels = data.engines.map((name, column) => {
    const canvas = document.createElement("canvas");
    const title = document.createElement("h4");
    const note = document.createElement("p");
    const figure = document.createElement("div");
    [figure.className, title.textContent, canvas.tabIndex] = ["screen", name, 0];
    canvas.setAttribute("role", "img");
    figure.append(title, canvas, note);
    root.append(figure);
    return { canvas, column, name, note };
  });

  const field = (pen, frame, place, unit) => {
    const { nx, ny, values, count, vx, vy } = density(frame);
    const [dx, dy] = [(frame.sides[0] / nx) * unit, (frame.sides[1] / ny) * unit];
    for (let i = 0; i < nx * ny; i++) {
      const [px, py] = place((i % nx) / nx, Math.floor(i / nx) / ny);
      pen.fillStyle = viridis(values[i] / DENSEST);
      pen.fillRect(px - 0.3, py - dy - 0.3, dx + 0.6, dy + 0.6);
    }
    // Mean velocities of every few cells, a cell long at the root mean square speed.
    const stride = Math.max(1, Math.ceil(14 / dx));
    pen.strokeStyle = "#fff";
    pen.lineWidth = 1.2;
    pen.beginPath();
    for (let i = 0; i < nx * ny; i++) {
      if (i % nx % stride || Math.floor(i / nx) % stride || !count[i]) continue;
      const [px, py] = place(((i % nx) + 0.5) / nx, (Math.floor(i / nx) + 0.5) / ny);
      const long = (stride * dx * data.fastest) / 255 / count[i];
      const [ex, ey] = [vx[i] * long, -vy[i] * long];
      pen.moveTo(px, py);
      pen.lineTo(px + ex, py + ey);
      for (const turn of [0.8, -0.8]) {
        const [c, s] = [Math.cos(turn) * 0.35, Math.sin(turn) * 0.35];
        pen.moveTo(px + ex, py + ey);
        pen.lineTo(px + ex - (ex * c - ey * s), py + ey - (ex * s + ey * c));
      }
    }
    pen.stroke();
  };

  const particles = (pen, frame, place, unit, [width, height]) => {
    const colours = palette[colouring === "direction" ? "direction" : "other"];
    const step = steps(frame);
    const disk = (px, py, r) => {
      if (px < -r || py < -r || px > width + r || py > height + r) return;
      if (r < 0.8) {
        const side = Math.max(1, 2 * r);
        pen.rect(px - side / 2, py - side / 2, side, side);
      } else {
        pen.moveTo(px + r, py);
        pen.arc(px, py, r, 0, 2 * Math.PI);
      }
    };
    const [w, h] = frame.sides;
    // The order of a frame is random, so that no colour lies above others; within a chunk particles are sorted by colour.
    for (let from = 0; from < frame.n; from += CHUNK) {
      const until = Math.min(frame.n, from + CHUNK);
      const order = Uint32Array.from({ length: until - from }, (_, k) => step[from + k] * CHUNK + k).sort();
      let now = -1;
      for (const key of order) {
        const i = from + (key % CHUNK);
        if (step[i] !== now) {
          if (now >= 0) pen.fill();
          now = step[i];
          pen.fillStyle = colours[now];
          pen.beginPath();
        }
        const radius = frame.size ? (frame.size[i] / 255) * frame.radius : frame.radius;
        const r = radius * unit;
        const [x, y] = [frame.x[i] / 65536, frame.y[i] / 65536];
        // A disk that crosses the edge of the period is drawn on the other side as well.
        const over = (share, side, periodic) => (!periodic ? 0 : share * side < radius ? 1 : (1 - share) * side < radius ? -1 : 0);
        const [dx, dy] = [over(x, w, frame.periodic[0]), over(y, h, frame.periodic[1])];
        disk(...place(x, y), r);
        if (dx) disk(...place(x + dx, y), r);
        if (dy) disk(...place(x, y + dy), r);
        if (dx && dy) disk(...place(x + dx, y + dy), r);
      }
      if (now >= 0) pen.fill();
    }
  };

  // Colours as the bytes of a pixel.
  const inks = {};
  const inked = (name) => {
    if (inks[name]) return inks[name];
    const pen = document.createElement("canvas").getContext("2d");
    const ink = (colour) => {
      pen.fillStyle = colour; // read back as #rrggbb
      const rgb = parseInt(pen.fillStyle.slice(1), 16);
      return (255 << 24) | ((rgb & 255) << 16) | (rgb & 0xff00) | (rgb >> 16);
    };
    return (inks[name] = Int32Array.from(palette[name], ink));
  };

  // Particles of a pixel or two are written as pixels, which is ten times as fast as drawing them.
  const pixels = (pen, frame, place, side) => {
    const { width, height } = pen.canvas;
    const ratio = window.devicePixelRatio || 1;
    const image = pen.createImageData(width, height);
    const buffer = new Int32Array(image.data.buffer).fill(-1);
    const [step, ink] = [steps(frame), inked(colouring === "direction" ? "direction" : "other")];
    const [[left, top], [right, bottom]] = [place(0, 0), place(1, 1)].map((corner) => corner.map((at) => at * ratio));
    for (let i = 0; i < frame.n; i++) {
      const x = Math.floor(left + ((right - left) * frame.x[i]) / 65536 - 0.5 * (side - 1));
      const y = Math.floor(top + ((bottom - top) * frame.y[i]) / 65536 - 0.5 * (side - 1));
      for (let v = Math.max(0, y); v < Math.min(height, y + side); v++)
        for (let u = Math.max(0, x); u < Math.min(width, x + side); u++) buffer[v * width + u] = ink[step[i]];
    }
    pen.putImageData(image, 0, 0);
  };

  const obstacles = (pen, frame, place, unit) => {
    pen.fillStyle = "#555";
    pen.strokeStyle = "#333";
    pen.lineWidth = 2;
    const corner = ([x, y]) => place(x / frame.sides[0], y / frame.sides[1]);
    for (const { circle, polyline, polygon } of data.obstacles) {
      pen.beginPath();
      if (circle) pen.arc(...corner(circle.centre), circle.radius * unit, 0, 2 * Math.PI);
      (polyline || polygon || []).forEach((point, i) => pen[i ? "lineTo" : "moveTo"](...corner(point)));
      if (polygon) pen.closePath();
      if (!polyline) pen.fill();
      pen.stroke();
    }
  };

  const draw = ({ canvas, column, name, note }) => {
    const frame = reels[column][time];
    const ratio = window.devicePixelRatio || 1;
    const width = canvas.clientWidth;
    const aspect = frame ? Math.min(2, Math.max(0.25, frame.sides[1] / frame.sides[0])) : 1;
    const height = Math.round(width * aspect);
    canvas.style.height = `${height}px`;
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    canvas.setAttribute("aria-label", `${name} at ${data.times[time]}`);
    const pen = canvas.getContext("2d");
    pen.scale(ratio, ratio);
    pen.fillStyle = "#fff";
    pen.fillRect(0, 0, width, height);
    note.textContent = !frame ? "no frame at this time"
      : frame.share > 1.001 ? `${frame.n} of ${frame.all} particles`
      : frame.n === frame.all ? `${frame.n} particles` : `a fair sample of the simulators: ${frame.n}`;
    if (frame && MET.includes(colouring) && !frame.met) note.textContent += "; grey, as this engine does not tell equal particles apart";
    else if (frame && MET.includes(colouring) && frame.met.includes(0)) note.textContent += "; grey: no collision yet";
    if (!frame) return;
    const [w, h] = frame.sides;
    const unit = Math.min(width / w, height / h) * view.scale; // pixels for each unit of length
    const left = width / 2 - view.x * w * unit;
    const top = height / 2 + view.y * h * unit; // the ordinate points upwards
    const place = (x, y) => [left + x * w * unit, top - y * h * unit];
    pen.save();
    pen.beginPath();
    pen.rect(left, top - h * unit, w * unit, h * unit);
    pen.clip();
    if (colouring === "field") field(pen, frame, place, unit);
    else if (2 * frame.radius * unit < 2) pixels(pen, frame, place, Math.max(1, Math.round(2 * frame.radius * unit * ratio)));
    else particles(pen, frame, place, unit, [width, height]);
    obstacles(pen, frame, place, unit);
    pen.restore();
    pen.strokeStyle = "#888";
    pen.strokeRect(left, top - h * unit, w * unit, h * unit);
  };

  const redraw = () => {
    if (pending) return;
    pending = true;
    requestAnimationFrame(() => {
      pending = false;
      panels.forEach(draw);
    });
  };

  const clampView = () => {
    view.scale = Math.min(200, Math.max(1, view.scale));
    const half = 0.5 / view.scale;
    view.x = Math.min(1 - half, Math.max(half, view.x));
    view.y = Math.min(1 - half, Math.max(half, view.y));
  };

  panels.forEach(({ canvas }) => {
    let held = null;
    canvas.addEventListener("pointerdown", (event) => {
      held = [event.clientX, event.clientY];
      canvas.focus({ preventScroll: true });
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!held) return;
      view.x -= (event.clientX - held[0]) / (canvas.clientWidth * view.scale);
      view.y += (event.clientY - held[1]) / (canvas.clientHeight * view.scale);
      held = [event.clientX, event.clientY];
      clampView();
      redraw();
    });
    const release = () => (held = null);
    canvas.addEventListener("pointerup", release);
    canvas.addEventListener("pointercancel", release);
    canvas.addEventListener("wheel", (event) => {
      if (document.activeElement !== canvas) return; // let the page scroll past
      event.preventDefault();
      const box = canvas.getBoundingClientRect();
      const away = [(event.clientX - box.left) / box.width - 0.5, 0.5 - (event.clientY - box.top) / box.height];
      const before = view.scale;
      view.scale = Math.min(200, Math.max(1, before * Math.exp(-event.deltaY * 0.0015)));
      // The point under the pointer stays where it is.
      view.x += away[0] * (1 / before - 1 / view.scale);
      view.y += away[1] * (1 / before - 1 / view.scale);
      clampView();
      redraw();
    }, { passive: false });
    canvas.addEventListener("dblclick", () => home());
  });

  const home = () => {
    Object.assign(view, { scale: 1, x: 0.5, y: 0.5 });
    redraw();
  };
  const control = (name) => document.getElementById(`viewer-${name}`);
  const [slider, play, speed, colours, label] = ["time", "play", "speed", "colour", "label"].map(control);
  const show = (frame) => {
    time = (frame + data.times.length) % data.times.length;
    label.textContent = data.times[time];
    if (slider) slider.value = String(time);
    redraw();
  };
  const tick = (now) => {
    if (!playing) return;
    if (now - last >= 1000 / Number(speed.value)) {
      last = now;
      show(time + 1);
    }
    requestAnimationFrame(tick);
  };
  const pause = (on) => {
    playing = !on;
    play.textContent = playing ? "pause" : "play";
    play.setAttribute("aria-pressed", String(playing));
    if (playing) requestAnimationFrame(tick);
  };
  if (slider) {
    slider.addEventListener("input", () => {
      pause(true);
      show(Number(slider.value));
    });
    play.addEventListener("click", () => pause(playing));
  }
  colours.addEventListener("change", () => {
    colouring = colours.value;
    document.querySelectorAll("[data-key]").forEach((key) => (key.hidden = !key.dataset.key.split(" ").includes(colouring)));
    redraw();
  });
  const zoom = (factor) => () => {
    view.scale *= factor;
    clampView();
    redraw();
  };
  control("closer").addEventListener("click", zoom(1.6));
  control("farther").addEventListener("click", zoom(1 / 1.6));
  control("home").addEventListener("click", home);
  show(time);
  window.addEventListener("resize", redraw);
  panels.forEach(draw);
  control("controls").hidden = false;
  root.dataset.ready = "yes";
})();
