// Viewer of the snapshots: one canvas for each engine, all with the same time, position and magnification.
"use strict";
(() => {
  const root = document.getElementById("viewer");
  const source = document.getElementById("frames");
  if (!root || !source) return;
  const data = JSON.parse(source.textContent);
  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));

  // Unpacks a frame once, when it is first shown. Disks are sorted by direction, so a colour is set only once.
  const unpack = (frame) => {
    if (!frame || frame.x) return frame;
    const place = new Uint16Array(bytes(frame.p).buffer);
    const hue = bytes(frame.v);
    const size = frame.s ? bytes(frame.s) : null;
    const order = Uint32Array.from(hue.keys()).sort((a, b) => hue[a] - hue[b] || a - b);
    frame.x = Float32Array.from(order, (i) => (place[2 * i] / 65536) * frame.w);
    frame.y = Float32Array.from(order, (i) => (place[2 * i + 1] / 65536) * frame.h);
    frame.hue = Uint8Array.from(order, (i) => hue[i]);
    frame.size = size ? Float32Array.from(order, (i) => (size[i] / 255) * frame.r) : null;
    return frame;
  };

  const colour = Array.from({ length: 256 }, (_, i) => `hsl(${(i * 360) / 256} 72% 52%)`);
  const view = { scale: 1, x: 0.5, y: 0.5 }; // centre in units of the sides
  let time = data.times.length - 1;
  let pending = false;

  const panels = data.engines.map((name, column) => {
    const figure = document.createElement("div");
    figure.className = "screen";
    const title = document.createElement("h4");
    title.textContent = name;
    const canvas = document.createElement("canvas");
    canvas.setAttribute("role", "img");
    canvas.tabIndex = 0;
    figure.append(title, canvas);
    root.append(figure);
    return { canvas, column, name };
  });

  const draw = (panel) => {
    const { canvas, column, name } = panel;
    const frame = unpack(data.frames[time][column]);
    const ratio = window.devicePixelRatio || 1;
    const width = canvas.clientWidth;
    const aspect = frame ? Math.min(2, Math.max(0.25, frame.h / frame.w)) : 1;
    const height = Math.round(width * aspect);
    canvas.style.height = `${height}px`;
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    canvas.setAttribute("aria-label", `${name} at ${data.times[time]}`);
    const pen = canvas.getContext("2d");
    pen.scale(ratio, ratio);
    pen.fillStyle = "#fff";
    pen.fillRect(0, 0, width, height);
    if (!frame) {
      pen.fillStyle = "#555";
      pen.fillText("no snapshot at this time", 12, 20);
      return;
    }
    const unit = Math.min(width / frame.w, height / frame.h) * view.scale; // pixels for each unit of length
    const left = width / 2 - view.x * frame.w * unit;
    const top = height / 2 + view.y * frame.h * unit; // the ordinate points upwards
    pen.save();
    pen.beginPath();
    pen.rect(left, top - frame.h * unit, frame.w * unit, frame.h * unit);
    pen.clip();
    let last = -1;
    const disk = (x, y, r) => {
      const px = left + x * unit;
      const py = top - y * unit;
      if (px < -r || py < -r || px > width + r || py > height + r) return;
      if (r < 0.8) {
        const side = Math.max(1, 2 * r);
        pen.rect(px - side / 2, py - side / 2, side, side);
      } else {
        pen.moveTo(px + r, py);
        pen.arc(px, py, r, 0, 2 * Math.PI);
      }
    };
    for (let i = 0; i < frame.x.length; i++) {
      if (frame.hue[i] !== last) {
        if (last >= 0) pen.fill();
        last = frame.hue[i];
        pen.fillStyle = colour[last];
        pen.beginPath();
      }
      const x = frame.x[i];
      const y = frame.y[i];
      const radius = frame.size ? frame.size[i] : frame.r;
      const r = radius * unit;
      // A disk that crosses the edge of the period is drawn on the other side as well.
      const dx = x < radius ? frame.w : x > frame.w - radius ? -frame.w : 0;
      const dy = y < radius ? frame.h : y > frame.h - radius ? -frame.h : 0;
      disk(x, y, r);
      if (dx) disk(x + dx, y, r);
      if (dy) disk(x, y + dy, r);
      if (dx && dy) disk(x + dx, y + dy, r);
    }
    if (last >= 0) pen.fill();
    pen.restore();
    pen.strokeStyle = "#888";
    pen.strokeRect(left, top - frame.h * unit, frame.w * unit, frame.h * unit);
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
    canvas.addEventListener("dblclick", () => {
      Object.assign(view, { scale: 1, x: 0.5, y: 0.5 });
      redraw();
    });
  });

  const slider = document.getElementById("viewer-time");
  const label = document.getElementById("viewer-label");
  const showTime = () => (label.textContent = data.times[time]);
  if (slider) {
    slider.value = String(time);
    slider.addEventListener("input", () => {
      time = Number(slider.value);
      showTime();
      redraw();
    });
  }
  showTime();
  window.addEventListener("resize", redraw);
  panels.forEach(draw);
})();
