// Interactive figures: each static chart gets a chart of uPlot in its place, from the numbers behind it. Axes, lines and zooming
// are uPlot's; marks, error bars, bands and reference lines are drawn over them. What is printed stays the static chart.
"use strict";
(() => {
  const MARKS = 60; // points of a curve in view that are drawn as marks
  const root = document.documentElement;
  const element = (name, properties = {}, ...children) => {
    const made = Object.assign(document.createElement(name), properties);
    made.append(...children);
    return made;
  };
  const css = (name) => getComputedStyle(root).getPropertyValue(name).trim();
  const colour = (value) => value.replace(/^var\((--[\w-]+)\)$/, (_, name) => css(name));

  // Numbers as the page writes them.
  const raised = (exponent) => "10" + [...String(exponent)].map((c) => (c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[c])).join("");
  const trimmed = (text) => (text.includes(".") ? text.replace(/\.?0+$/, "") : text);
  const number = (value, digits = 5) => {
    if (!Number.isFinite(value)) return "–";
    if (value === 0) return "0";
    const [mantissa, exponent] = value.toExponential(digits - 1).split("e").map(String);
    const power = Number(exponent);
    const plain = power >= -3 && power < 6;
    const text = plain ? trimmed(value.toFixed(Math.max(0, digits - 1 - power))) : trimmed(mantissa);
    const full = plain ? text : text === "1" ? raised(power) : `${text}·${raised(power)}`;
    return full.replace("-", "−");
  };
  const withError = (value, error) => {
    if (!(error > 0) || !Number.isFinite(error)) return number(value);
    const decimals = Math.max(0, 1 - Math.floor(Math.log10(error)));
    if (decimals > 7 || Math.max(Math.abs(value), error) >= 1e6) {
      // As many digits of the value as reach the second of the error.
      const digits = Math.floor(Math.log10(Math.abs(value) / error)) + 2;
      return `${number(value, Math.min(17, Math.max(5, digits)))} ± ${number(Number(error.toExponential(1)), 2)}`;
    }
    // What is rounded to zero has no sign.
    const text = value.toFixed(decimals).replace(/^-(?=[0.]*$)/, "");
    return `${text} ± ${error.toFixed(decimals)}`.replace("-", "−");
  };
  const save = (blob, name) => {
    const link = element("a", { href: URL.createObjectURL(blob), download: name });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
  };

  // Points of a curve as they are drawn now.
  const pointsOf = (curve, ratio) => {
    const all = [];
    (curve.x || []).forEach((x, i) => {
      const theory = curve.theory ? curve.theory[i] : null;
      if (ratio && !theory) return;
      const unit = ratio ? theory : 1;
      const error = curve.error && curve.error[i] !== null ? curve.error[i] / Math.abs(unit) : null;
      const end = curve.end && curve.end[i] !== null ? curve.end[i] : x;
      all.push({ x, end, y: curve.y[i] / unit, error, theory });
    });
    return all;
  };

  // Least and largest of some values with a little room.
  const around = (values, logarithmic) => {
    const shown = values.filter((value) => Number.isFinite(value) && (!logarithmic || value > 0));
    if (!shown.length) return logarithmic ? [0.1, 10] : [0, 1];
    const low = shown.reduce((a, b) => Math.min(a, b));
    const high = shown.reduce((a, b) => Math.max(a, b));
    if (logarithmic) {
      const room = Math.max(1.1, (high / low) ** 0.04);
      return [low / room, high * room];
    }
    const span = Math.max(high - low, 1e-6 * Math.abs(high), Number.MIN_VALUE * 1e10) || 1;
    return [low - 0.06 * span, high + 0.06 * span];
  };

  class Figure {
    constructor(host) {
      const behind = JSON.parse(host.querySelector("script").textContent);
      Object.assign(this, { host, title: behind.title, number: behind.number, common: behind.common });
      this.hidden = new Set();
      this.ratio = false;
      this.bands = false;
      this.panels = [...host.querySelectorAll(".panel")].map((place, i) => ({
        place,
        title: behind.panels[i].title,
        plot: behind.panels[i].plot,
        still: place.querySelector("svg.plot"),
      }));
      this.charts = this.panels.filter((panel) => !panel.plot.map);
      const first = this.charts.length ? this.charts[0].plot : null;
      this.logarithmic = first ? { x: first.x.logarithmic, y: first.y.logarithmic } : {};
      this.bar();
      this.legend();
      this.panels.filter((panel) => panel.plot.map).forEach((panel) => this.map(panel));
      if (!first) return;
      // Charts that are far down are made when they come into view.
      const seen = new IntersectionObserver((entries) => {
        if (entries.some((entry) => entry.isIntersecting)) {
          seen.disconnect();
          this.start();
        }
      }, { rootMargin: "600px" });
      seen.observe(host);
    }

    start() {
      // Maps are drawings, and have no charts to be made.
      if (this.started || !this.charts.length) return;
      this.started = true;
      this.reset();
      let width = 0;
      new ResizeObserver(() => {
        const now = this.charts[0].place.clientWidth;
        if (now && now !== width) {
          width = now;
          this.charts.forEach((panel) => panel.chart.setSize(this.size(panel)));
        }
      }).observe(this.charts[0].place);
      matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.build());
    }

    size(panel) {
      const width = Math.max(200, panel.place.clientWidth);
      return { width, height: Math.round(Math.max(210, Math.min(400, width * 0.7))) };
    }

    curves(panel) {
      return panel.plot.curves.filter((curve) => !this.ratio || curve.theory);
    }

    shown(panel) {
      return this.curves(panel).filter((curve) => !this.hidden.has(curve.label));
    }

    lines(panel) {
      if (this.ratio) return [{ label: "theory", y: 1 }];
      return panel.plot.lines.filter((line) => !this.hidden.has(line.label));
    }

    // Ranges that show everything; those of the static chart as long as scales are its own.
    reset() {
      const ranges = this.charts.map((panel) => {
        const { x, y } = panel.plot;
        const own = (axis) => this.logarithmic[axis] === panel.plot[axis].logarithmic;
        if (own("x") && own("y") && !this.ratio) return { x: x.range, y: y.range };
        const all = this.curves(panel).flatMap((curve) => pointsOf(curve, this.ratio));
        const reach = (p) => [p.y, p.y - (p.error || 0), p.y + (p.error || 0)];
        const finite = all.filter((p) => !this.logarithmic.y || p.y > 0);
        const upwards = around(
          finite.flatMap((p) => (p.error > Math.abs(p.y) ? [p.y] : reach(p))).concat(this.lines(panel).map((line) => line.y)),
          this.logarithmic.y);
        const across = own("x") ? x.range : around(all.flatMap((p) => [p.x, p.end]), this.logarithmic.x);
        return { x: across, y: upwards };
      });
      const unite = (axis) => [Math.min(...ranges.map((r) => r[axis][0])), Math.max(...ranges.map((r) => r[axis][1]))];
      const [x, y] = [unite("x"), unite("y")];
      this.charts.forEach((panel, i) => {
        panel.range = { x: [...x], y: [...(this.common ? y : ranges[i].y)] };
      });
      this.build();
    }

    // Makes all charts anew, as they are to be seen now.
    build() {
      if (!this.started) return;
      this.charts.forEach((panel) => {
        if (panel.chart) panel.chart.destroy();
        panel.place.classList.add("live");
        panel.points = new Map(this.shown(panel).map((curve) => [curve, pointsOf(curve, this.ratio)]));
        panel.chart = new uPlot(this.options(panel), this.columns(panel), panel.place);
        const over = panel.chart.over;
        over.setAttribute("role", "img");
        over.setAttribute("aria-label", panel.still.getAttribute("aria-label"));
        panel.tip = element("div", { className: "tip", hidden: true });
        panel.dot = element("div", { className: "dot", hidden: true });
        over.append(panel.dot, panel.tip);
        over.addEventListener("mouseleave", () => this.hover(panel, null));
      });
    }

    columns(panel) {
      const fits = (value, axis) => (this.logarithmic[axis] && !(value > 0) ? null : value);
      const lines = this.shown(panel).map((curve) => {
        const points = panel.points.get(curve).filter((p) => fits(p.x, "x") !== null);
        const [xs, ys] = [points.map((p) => p.x), points.map((p) => fits(p.y, "y"))];
        const last = points[points.length - 1];
        if (last && last.end > last.x) {
          xs.push(last.end);
          ys.push(ys[ys.length - 1]);
        }
        return [xs, ys];
      });
      return lines.length ? uPlot.join(lines) : [[], []];
    }

    options(panel) {
      const { plot } = panel;
      const [ink, grid, family] = [css("--ink"), css("--grid"), getComputedStyle(document.body).fontFamily];
      const scale = (axis) => ({
        time: false,
        auto: false,
        distr: this.logarithmic[axis] ? 3 : 1,
        min: panel.range[axis][0],
        max: panel.range[axis][1],
        range: (chart, low, high) => (panel.range[axis] = [low, high]),
      });
      const axis = (name, label, size) => {
        const names = plot[name].names || [];
        const step = { stroke: ink, width: 1, size: 4 };
        const made = {
          scale: name, label, size, stroke: ink, font: `12px ${family}`, labelFont: `13px ${family}`, labelSize: 20, gap: 4,
          grid: { stroke: grid, width: 1 }, ticks: step, border: { show: true, stroke: ink, width: 1 },
          values: (chart, splits) => this.texts(splits),
        };
        if (this.logarithmic[name]) {
          const ticks = () => {
            const [low, high] = panel.range[name];
            const four = [0, 1, 2, 3].map((i) => Number((low + ((i + 0.5) * (high - low)) / 4).toPrecision(3)));
            return this.decades(low, high) || four.map((value) => [value, number(value, 3)]);
          };
          made.splits = () => ticks().map((tick) => tick[0]);
          made.values = () => ticks().map((tick) => tick[1]);
          made.filter = (chart, splits) => splits;
        }
        if (names.length) {
          made.splits = names.map((_, i) => i + 1);
          made.values = names;
        }
        return made;
      };
      const series = this.shown(panel).map((curve) => {
        const steps = curve.end !== null && curve.end !== undefined;
        const path = steps ? uPlot.paths.stepped({ align: 1 }) : uPlot.paths.linear();
        const ofMany = (curve.x || []).length > MARKS;
        const wide = { thin: ofMany ? 1.6 : 1, solid: 1.6, dashed: 1.6, bars: 1.1 }[curve.stroke];
        const stroke = colour(curve.colour);
        return {
          stroke, width: wide || 0, paths: wide ? path : () => null, points: { show: false }, spanGaps: true,
          dash: curve.stroke === "dashed" ? [6, 4] : undefined,
          fill: curve.stroke === "bars" ? stroke + "22" : undefined, fillTo: 0,
        };
      });
      const vertical = this.ratio ? `${plot.y.label} over theory` : plot.y.label;
      return {
        ...this.size(panel),
        legend: { show: false },
        padding: [8, 12, 0, 0],
        scales: { x: scale("x"), y: scale("y") },
        axes: [axis("x", plot.x.label, 30), axis("y", vertical, 52)],
        series: [{}, ...(series.length ? series : [{ show: false }])],
        cursor: {
          points: { show: false },
          drag: { x: true, y: true, uni: 20, dist: 5 },
          bind: { dblclick: () => () => this.reset() },
        },
        hooks: { draw: [(chart) => this.over(panel, chart)], setCursor: [(chart) => this.hover(panel, chart)] },
      };
    }

    texts(splits) {
      const step = splits.length > 1 ? Math.abs(splits[1] - splits[0]) : 1;
      // As many as tell neighbours apart: one for steps of 2.5.
      let decimals = 0;
      while (decimals < 6 && Math.abs(step * 10 ** decimals - Math.round(step * 10 ** decimals)) > 1e-6 * step * 10 ** decimals) decimals++;
      return splits.map((value) => {
        const digits = Math.floor(Math.log10(Math.abs(value || step) / step)) + 2;
        return decimals > 4 || Math.abs(value) >= 1e6 ? number(value, Math.max(1, digits)) : value.toFixed(decimals).replace("-", "−");
      });
    }

    // Ticks of a logarithmic axis with their labels; those of uPlot are right only where an axis begins at a whole power.
    decades(low, high) {
      const [first, last] = [Math.log10(low), Math.log10(high)];
      const span = last - first;
      const stride = Math.max(1, Math.ceil(span / 7));
      const plain = first > -2.1 && last < 4.1;
      const labelled = span < 1.1 ? (span > 0.6 ? [1, 2, 3, 4, 5, 6, 8] : [1, 2, 3, 4, 5, 6, 7, 8, 9]) : span < 2.2 ? [1, 2, 5] : [1];
      const ticks = [];
      for (let power = Math.floor(first); power <= last; power++) {
        for (let factor = 1; factor <= (span > 8 ? 1 : 9); factor++) {
          const value = Number(`${factor}e${power}`);
          if (value < low * (1 - 1e-9) || value > high * (1 + 1e-9)) continue;
          const named = labelled.includes(factor) && (factor > 1 || power % stride === 0);
          const text = plain ? number(value, 1) : factor > 1 ? `${factor}·${raised(power)}` : power ? raised(power) : "1";
          ticks.push([value, named ? text : ""]);
        }
      }
      // Within less than a factor there may be none: then those of a linear axis do.
      return ticks.length > 1 ? ticks : null;
    }

    // Error bars or bands, marks, reference lines and words.
    over(panel, chart) {
      const pen = chart.ctx;
      const { left, top, width, height } = chart.bbox;
      const ratio = width / chart.over.clientWidth || 1;
      const across = (x) => chart.valToPos(x, "x", true);
      const up = (y) => (this.logarithmic.y && !(y > 0) ? top + height : chart.valToPos(y, "y", true));
      const near = (value) => Math.max(-1e5, Math.min(1e5, value));
      pen.save();
      pen.beginPath();
      pen.rect(left, top, width, height);
      pen.clip();
      for (const line of this.lines(panel)) {
        pen.setLineDash([6 * ratio, 4 * ratio]);
        pen.lineWidth = 1.2 * ratio;
        pen.strokeStyle = css("--ink");
        pen.beginPath();
        pen.moveTo(left, near(up(line.y)));
        pen.lineTo(left + width, near(up(line.y)));
        pen.stroke();
      }
      pen.setLineDash([]);
      for (const [curve, all] of panel.points) {
        const fits = all.filter((p) => (!this.logarithmic.x || p.x > 0) && (!this.logarithmic.y || p.y > 0));
        const points = fits.filter((p) => p.end >= panel.range.x[0] && p.x <= panel.range.x[1]);
        const known = points.filter((p) => p.error > 0);
        const middle = (p) => 0.5 * (across(p.x) + across(p.end));
        pen.strokeStyle = pen.fillStyle = colour(curve.colour);
        if (this.bands && known.length) {
          pen.globalAlpha = 0.22;
          pen.beginPath();
          const steps = known.some((p) => p.end > p.x);
          const edge = (p, y) => {
            pen.lineTo(near(across(p.x)), near(up(y)));
            if (steps) pen.lineTo(near(across(p.end)), near(up(y)));
          };
          known.forEach((p) => edge(p, p.y + p.error));
          [...known].reverse().forEach((p) => {
            if (steps) pen.lineTo(near(across(p.end)), near(up(p.y - p.error)));
            pen.lineTo(near(across(p.x)), near(up(p.y - p.error)));
          });
          pen.fill();
          pen.globalAlpha = 1;
        } else if (known.length) {
          pen.lineWidth = 1.1 * ratio;
          pen.beginPath();
          const stride = Math.ceil(known.length / MARKS);
          known.filter((_, i) => i % stride === 0).forEach((p) => {
            pen.moveTo(middle(p), near(up(p.y - p.error)));
            pen.lineTo(middle(p), near(up(p.y + p.error)));
          });
          pen.stroke();
        }
        if (curve.marker && (points.length <= MARKS || !curve.stroke)) {
          pen.beginPath();
          points.forEach((p) => this.mark(pen, curve.marker, across(p.x), up(p.y), ratio));
          pen.fill();
        }
      }
      pen.fillStyle = css("--ink");
      pen.font = `${11 * ratio}px ${getComputedStyle(document.body).fontFamily}`;
      pen.textAlign = "center";
      if (!this.ratio) panel.plot.words.forEach((word) => pen.fillText(word.text, across(word.x), up(word.y)));
      pen.restore();
    }

    mark(pen, name, x, y, ratio) {
      const polygon = (...corners) => {
        corners.forEach(([dx, dy], i) => pen[i ? "lineTo" : "moveTo"](x + dx * ratio, y + dy * ratio));
        pen.closePath();
      };
      if (name === "square") polygon([-2.6, -2.6], [2.6, -2.6], [2.6, 2.6], [-2.6, 2.6]);
      else if (name === "triangle") polygon([0, -3.8], [3.4, 2.2], [-3.4, 2.2]);
      else if (name === "diamond") polygon([0, -3.6], [3.6, 0], [0, 3.6], [-3.6, 0]);
      else if (name === "inverted") polygon([0, 3.8], [3.4, -2.2], [-3.4, -2.2]);
      else {
        pen.moveTo(x + 3 * ratio, y);
        pen.arc(x, y, 3 * ratio, 0, 2 * Math.PI);
      }
    }

    // The point next to the pointer: all curves at its abscissa, with errors and theory.
    hover(panel, chart) {
      const { tip, dot } = panel;
      if (!tip) return;
      const [px, py] = chart ? [chart.cursor.left, chart.cursor.top] : [-10, -10];
      let best = null;
      if (px >= 0 && py >= 0) {
        for (const [curve, all] of panel.points) {
          for (const p of all) {
            const [x, end, y] = [chart.valToPos(p.x, "x"), chart.valToPos(p.end, "x"), chart.valToPos(p.y, "y")];
            const dx = px < x ? x - px : px > end ? px - end : 0;
            const distance = Math.hypot(dx, y - py);
            if (distance < (best ? best.distance : 40)) best = { curve, p, distance, x: 0.5 * (x + end), y };
          }
        }
      }
      tip.hidden = dot.hidden = !best;
      if (!best) return;
      dot.style.transform = `translate(${best.x}px, ${best.y}px)`;
      const { x, y } = panel.plot;
      const place = x.names && x.names.length ? x.names[best.p.x - 1]
        : best.p.end > best.p.x ? `${number(best.p.x)} to ${number(best.p.end)}` : number(best.p.x);
      const rows = [...panel.points].flatMap(([curve, all]) => {
        const p = curve === best.curve ? best.p : all.find((one) => one.x === best.p.x);
        if (!p) return [];
        const sign = element("i");
        sign.style.background = colour(curve.colour);
        const value = element("td", { textContent: withError(p.y, p.error) });
        return [element("tr", { className: curve === best.curve ? "next" : "" },
          element("td", {}, sign, curve.label || y.label), value,
          element("td", { textContent: this.ratio || !Number.isFinite(p.theory) || p.theory === null ? "" : `theory ${number(p.theory)}` }))];
      });
      const [next, rest] = [rows.filter((row) => row.className), rows.filter((row) => !row.className)];
      tip.replaceChildren(
        element("b", { textContent: `${x.label}: ${place}` }),
        element("table", {}, element("tbody", {}, ...next, ...rest.slice(0, 7))));
      const room = chart.over.clientWidth;
      tip.style.left = `${Math.max(-50, Math.min(best.x + 14, room - tip.offsetWidth))}px`;
      tip.style.top = best.y > chart.over.clientHeight / 2 ? `${best.y - tip.offsetHeight - 12}px` : `${best.y + 14}px`;
    }

    map(panel) {
      const { plot, still, place } = panel;
      const [left, top, width, height] = plot.frame;
      const tip = element("div", { className: "tip", hidden: true });
      place.append(tip);
      place.addEventListener("mousemove", (event) => {
        const box = still.getBoundingClientRect();
        const unit = still.viewBox.baseVal.width / box.width;
        const [fx, fy] = [((event.clientX - box.left) * unit - left) / width, 1 - ((event.clientY - box.top) * unit - top) / height];
        tip.hidden = !(fx >= 0 && fx <= 1 && fy >= 0 && fy <= 1);
        if (tip.hidden) return;
        const at = (axis, share) => axis.range[0] + share * (axis.range[1] - axis.range[0]);
        const [x, y] = [at(plot.x, fx), at(plot.y, fy)];
        const [xs, ys, values] = plot.cells;
        let best = 0;
        const far = (i) => Math.hypot(xs[i] - x, ys[i] - y);
        xs.forEach((_, i) => far(i) < far(best) && (best = i));
        tip.textContent = `${plot.x.label} ${number(xs[best], 4)}, ${plot.y.label} ${number(ys[best], 4)}: ${plot.value} ${number(values[best])}`;
        const inside = place.getBoundingClientRect();
        tip.style.left = `${Math.min(event.clientX - inside.left + 12, inside.width - tip.offsetWidth)}px`;
        tip.style.top = `${event.clientY - inside.top + 14}px`;
      });
      place.addEventListener("mouseleave", () => (tip.hidden = true));
    }

    legend() {
      this.host.querySelectorAll(".legend span").forEach((item) => {
        const label = item.dataset.curve;
        const button = element("button", { type: "button", title: "show or hide; with Shift: only this one" });
        button.setAttribute("aria-pressed", "true");
        button.dataset.curve = label;
        button.append(...item.childNodes);
        item.replaceWith(button);
        button.addEventListener("click", (event) => {
          const all = [...this.host.querySelectorAll(".legend button")].map((one) => one.dataset.curve);
          const alone = this.hidden.size === all.length - 1 && !this.hidden.has(label);
          if (event.shiftKey) this.hidden = new Set(alone ? [] : all.filter((one) => one !== label));
          else if (!this.hidden.delete(label)) this.hidden.add(label);
          this.host.querySelectorAll(".legend button").forEach((one) =>
            one.setAttribute("aria-pressed", String(!this.hidden.has(one.dataset.curve))));
          this.start();
          this.build();
        });
      });
    }

    // The buttons above a figure.
    bar() {
      const bar = element("div", { className: "bar" });
      const add = (text, title, action, pressed) => {
        const button = element("button", { type: "button", textContent: text, title });
        if (pressed !== undefined) button.setAttribute("aria-pressed", String(pressed));
        button.addEventListener("click", () => {
          this.start();
          if (pressed !== undefined) {
            pressed = !pressed;
            button.setAttribute("aria-pressed", String(pressed));
          }
          action(pressed);
        });
        bar.append(button);
      };
      const curves = this.charts.flatMap((panel) => panel.plot.curves);
      if (this.charts.length) {
        const { x } = this.charts[0].plot;
        const positive = (axis) => curves.some((curve) => (curve[axis] || []).some((value) => value > 0));
        const log = (axis) => (on) => {
          this.logarithmic[axis] = on;
          this.reset();
        };
        if (!x.names.length && positive("x")) add("log x", "logarithmic horizontal axis", log("x"), this.logarithmic.x);
        if (positive("y")) add("log y", "logarithmic vertical axis", log("y"), this.logarithmic.y);
        if (curves.some((curve) => (curve.theory || []).some((value) => value))) {
          add("ratio", "ratio to theory", (on) => {
            this.ratio = on;
            if (on) this.logarithmic.y = false;
            else this.logarithmic.y = this.charts[0].plot.y.logarithmic;
            [...bar.children].filter((one) => one.textContent === "log y").forEach((one) => (one.disabled = on));
            this.reset();
          }, false);
        }
        if (curves.some((curve) => curve.error)) {
          add("bands", "errors as bands", (on) => {
            this.bands = on;
            this.build();
          }, false);
        }
        const zoom = (factor) => () => {
          this.charts.forEach((panel) => ["x", "y"].forEach((axis) => {
            const log = this.logarithmic[axis];
            const [low, high] = panel.range[axis].map((value) => (log ? Math.log(value) : value));
            const half = 0.5 * (high - low) * factor;
            const ends = [0.5 * (low + high) - half, 0.5 * (low + high) + half];
            panel.range[axis] = log ? ends.map(Math.exp) : ends;
          }));
          this.build();
        };
        add("+", "magnify; or draw a box in the chart", zoom(0.6));
        add("−", "show more", zoom(1 / 0.6));
        add("reset", "show everything; or double-click the chart", () => this.reset());
      }
      add("SVG", "save the figure as a drawing for print", () => this.saveDrawing());
      add("PNG", "save the figure as it is seen now", () => this.savePicture());
      add("CSV", "save the numbers behind the figure", () => this.saveNumbers());
      this.host.querySelector(".panels").after(bar);
    }

    name(ending) {
      const words = this.title.toLowerCase().replace(/[^a-z0-9]+/g, "-").replace(/^-|-$/g, "");
      return `figure-${this.number}-${words}.${ending}`;
    }

    saveNumbers() {
      const quoted = (text) => `"${String(text).replaceAll('"', '""')}"`;
      const rows = [];
      this.panels.forEach(({ title, plot }) => {
        if (plot.map) {
          if (!rows.length) rows.push(["panel", plot.x.label, plot.y.label, plot.value].map(quoted).join(","));
          plot.cells[0].forEach((x, i) => rows.push([quoted(title), x, plot.cells[1][i], plot.cells[2][i]].join(",")));
          return;
        }
        const head = ["panel", "curve", plot.x.label, "end", plot.y.label, "standard error", "theory"];
        if (!rows.length) rows.push(head.map(quoted).join(","));
        plot.curves.forEach((curve) => (curve.x || []).forEach((x, i) => {
          const cell = (column) => (curve[column] && curve[column][i] !== null ? curve[column][i] : "");
          const place = plot.x.names.length ? quoted(plot.x.names[x - 1]) : x;
          rows.push([quoted(title), quoted(curve.label), place, cell("end"), cell("y"), cell("error"), cell("theory")].join(","));
        }));
      });
      save(new Blob([rows.join("\n") + "\n"], { type: "text/csv" }), this.name("csv"));
    }

    // A drawing or picture around the panels: places, titles, and the legend above them.
    sheet(size) {
      const columns = this.panels.length === 1 ? 1 : [2, 4].includes(this.panels.length) ? 2 : 3;
      const sizes = this.panels.map(size);
      const [w, h] = [Math.max(...sizes.map((s) => s[0])), Math.max(...sizes.map((s) => s[1]))];
      const keys = [...this.host.querySelectorAll(".legend button")].filter((one) => one.ariaPressed !== "false");
      const width = columns * w;
      let [x, y] = [8, 8];
      const legend = keys.map((key) => {
        const wide = 52 + 6.8 * key.textContent.length;
        if (x > 8 && x + wide > width) [x, y] = [8, y + 20];
        const place = { key, x, y };
        x += wide;
        return place;
      });
      const above = keys.length ? y + 22 : 4;
      const titled = this.panels.some((panel) => panel.title) ? 20 : 0;
      const places = this.panels.map((_, i) => [(i % columns) * w, above + Math.floor(i / columns) * (h + titled) + titled]);
      return { width, height: above + Math.ceil(this.panels.length / columns) * (h + titled), legend, places, w };
    }

    drawing() {
      const { width, height, legend, places, w } = this.sheet(({ still }) => [still.viewBox.baseVal.width, still.viewBox.baseVal.height]);
      const copy = (svg, x, y, wide, high) => {
        const made = svg.cloneNode(true);
        Object.entries({ x, y, width: wide, height: high }).forEach(([name, value]) => made.setAttribute(name, value));
        return new XMLSerializer().serializeToString(made);
      };
      const safe = (text) => text.replace(/[&<>]/g, (c) => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;" })[c]);
      const parts = legend.map(({ key, x, y }) => copy(key.querySelector("svg"), x, y, 34, 12)
        + `<text x="${x + 39}" y="${y + 10}" font-size="12">${safe(key.textContent)}</text>`);
      this.panels.forEach(({ still, title }, i) => {
        const [x, y] = places[i];
        parts.push(`<text x="${x + w / 2}" y="${y - 5}" font-size="13" font-weight="600" text-anchor="middle">${safe(title)}</text>`);
        parts.push(copy(still, x, y, still.viewBox.baseVal.width, still.viewBox.baseVal.height));
      });
      const style = document.getElementById("drawing").textContent;
      const text = `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${width} ${height}" width="${width}" height="${height}" `
        + `font-family="system-ui, 'Noto Sans', 'DejaVu Sans', sans-serif" fill="var(--ink)"><style>${style}</style>`
        + `<rect width="100%" height="100%" fill="var(--paper)"/>${parts.join("")}</svg>`;
      return { text, width, height };
    }

    saveDrawing() {
      // On paper colours are those of paper.
      root.classList.add("paper");
      const text = this.drawing().text.replace(/var\((--[\w-]+)\)/g, (_, name) => css(name));
      root.classList.remove("paper");
      save(new Blob([text], { type: "image/svg+xml" }), this.name("svg"));
    }

    async savePicture() {
      const scale = 2;
      const picture = async (text, width, height) => {
        const image = new Image(width * scale, height * scale);
        const coloured = text.replace(/var\((--[\w-]+)\)/g, (_, name) => css(name));
        image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(coloured)}`;
        await image.decode();
        return image;
      };
      const maps = !this.charts.length && this.drawing();
      const plan = maps || this.sheet(({ chart }) => [chart.width, chart.height]);
      const canvas = element("canvas", { width: plan.width * scale, height: plan.height * scale });
      const pen = canvas.getContext("2d");
      pen.scale(scale, scale);
      if (maps) {
        pen.drawImage(await picture(maps.text, plan.width, plan.height), 0, 0, plan.width, plan.height);
      } else {
        const family = getComputedStyle(document.body).fontFamily;
        pen.fillStyle = css("--paper");
        pen.fillRect(0, 0, plan.width, plan.height);
        const style = document.getElementById("drawing").textContent;
        for (const { key, x, y } of plan.legend) {
          const sign = new XMLSerializer().serializeToString(key.querySelector("svg"))
            .replace(">", `  width="34" height="12"><style>${style}</style>`);
          pen.drawImage(await picture(sign, 34, 12), x, y, 34, 12);
          pen.fillStyle = css("--ink");
          pen.font = `12px ${family}`;
          pen.fillText(key.textContent, x + 39, y + 10);
        }
        this.panels.forEach((panel, i) => {
          const [x, y] = plan.places[i];
          pen.font = `600 13px ${family}`;
          pen.textAlign = "center";
          pen.fillStyle = css("--ink");
          pen.fillText(panel.title, x + plan.w / 2, y - 5);
          pen.drawImage(panel.chart.ctx.canvas, x, y, panel.chart.width, panel.chart.height);
        });
      }
      canvas.toBlob((blob) => save(blob, this.name("png")), "image/png");
    }
  }

  document.querySelectorAll("figure.interactive").forEach((host) => new Figure(host));
})();
