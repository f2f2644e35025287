"use strict";
// Plots on canvases. A plot is data in its own units; draw() puts it on the canvas in the colours of the page.

const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();

function ticks(low, high, most) {
  const rough = (high - low) / most, power = Math.pow(10, Math.floor(Math.log10(rough)));
  const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= rough) || 10 * power;
  const all = [];
  for (let k = Math.ceil(low / step); k * step <= high + 1e-9 * step; k++) all.push(k * step);
  return { all, digits: Math.max(0, -Math.floor(Math.log10(step) + 1e-9)) };
}

// The same of logarithms to base 10: by tenfolds, or by 1, 2 and 5 where few of these are seen.
function logarithmicTicks(low, high, most) {
  const factors = high - low < 2 ? [1, 2, 5] : [1], each = Math.max(1, Math.ceil((high - low) / most)), all = [];
  for (let power = Math.floor(low); power <= high; power++) {
    if (power % each) continue;
    for (const factor of factors) {
      const at = power + Math.log10(factor);
      if (at >= low && at <= high) all.push(at);
    }
  }
  return { all };
}

// A power of ten, or two or five of it, in a few letters.
const rounded = (value) => (value >= 0.005 && value < 1e4 ? String(Number(value.toPrecision(1))) : value.toExponential(0));

function extent(series, key) {
  let low = Infinity, high = -Infinity;
  for (const one of series) for (const value of one[key]) {
    if (Number.isFinite(value)) { if (value < low) low = value; if (value > high) high = value; }
  }
  if (!(high >= low)) return [0, 1];
  const pad = high > low ? 0.05 * (high - low) : Math.abs(high) * 0.05 || 1;
  return [low - pad, high + pad];
}

// plot: { title, xLabel, yLabel, series: [{ x, y, kind: "points" | "line", colour, dashed, rings, size }], xRange, yRange, bands, logarithms }
// logarithms: all numbers are logarithms to base 10.
class Figure {
  constructor(canvas, onHover) {
    this.canvas = canvas;
    this.onHover = onHover;
    canvas.addEventListener("pointermove", (event) => this.hover(event));
    canvas.addEventListener("pointerleave", () => { this.near = null; this.draw(); });
    Figure.all.push(this);
  }

  show(plot) { this.plot = plot; this.near = null; this.draw(); }

  draw() {
    const { canvas, plot } = this;
    if (!plot) return;
    const ratio = window.devicePixelRatio || 1, height = Number(canvas.dataset.height || 220);
    const width = canvas.clientWidth || 340;
    canvas.style.height = height + "px";
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    const c = canvas.getContext("2d");
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    c.font = "12px system-ui, sans-serif";
    if (plot.paint) { plot.paint(c, width, height); canvas.dataset.drawn = "yes"; return; }
    const [x0, x1] = plot.xRange || extent(plot.series, "x"), [y0, y1] = plot.yRange || extent(plot.series, "y");
    const box = { left: 52, right: width - 8, top: plot.title ? 22 : 8, bottom: height - 34 };
    const X = (x) => box.left + (box.right - box.left) * (x - x0) / (x1 - x0);
    const Y = (y) => box.bottom - (box.bottom - box.top) * (y - y0) / (y1 - y0);
    this.scale = { X, Y };
    this.axes(c, box, X, Y, [x0, x1], [y0, y1]);
    c.save();
    c.beginPath(); c.rect(box.left, box.top, box.right - box.left, box.bottom - box.top); c.clip();
    for (const [low, high] of plot.bands || []) {
      c.fillStyle = colour("band"); c.fillRect(box.left, Y(high), box.right - box.left, Y(low) - Y(high));
    }
    for (const one of plot.series) one.kind === "line" ? this.line(c, one, X, Y) : this.points(c, one, X, Y);
    if (this.near) {
      c.strokeStyle = colour("text"); c.lineWidth = 2; c.beginPath();
      c.arc(X(this.near.x), Y(this.near.y), 6, 0, 7); c.stroke();
    }
    c.restore();
    canvas.dataset.drawn = "yes";
  }

  axes(c, box, X, Y, [x0, x1], [y0, y1]) {
    const { plot } = this;
    c.lineWidth = 1; c.strokeStyle = colour("line"); c.fillStyle = colour("soft");
    c.textAlign = "center"; c.textBaseline = "top";
    const places = plot.logarithms ? logarithmicTicks : ticks;
    const across = places(x0, x1, Math.max(2, (box.right - box.left) / 70)), up = places(y0, y1, Math.max(2, (box.bottom - box.top) / 40));
    const text = (value, { digits }) => (plot.logarithms ? rounded(Math.pow(10, value)) : value.toFixed(digits));
    for (const x of across.all) {
      c.beginPath(); c.moveTo(X(x), box.top); c.lineTo(X(x), box.bottom); c.stroke();
      c.fillText(text(x, across), X(x), box.bottom + 4);
    }
    c.textAlign = "right"; c.textBaseline = "middle";
    for (const y of up.all) {
      c.beginPath(); c.moveTo(box.left, Y(y)); c.lineTo(box.right, Y(y)); c.stroke();
      c.fillText(text(y, up), box.left - 5, Y(y));
    }
    c.textAlign = "center"; c.textBaseline = "bottom";
    c.fillText(plot.xLabel || "", (box.left + box.right) / 2, box.bottom + 33);
    if (plot.yLabel) {
      c.save(); c.translate(2, (box.top + box.bottom) / 2); c.rotate(-Math.PI / 2); c.textBaseline = "top";
      c.fillText(plot.yLabel, 0, 0); c.restore();
    }
    if (plot.title) { c.textAlign = "left"; c.textBaseline = "top"; c.fillStyle = colour("text"); c.fillText(plot.title, box.left, 3); }
  }

  line(c, one, X, Y) {
    c.strokeStyle = colour(one.colour); c.lineWidth = one.width || 1.8; c.setLineDash(one.dashed ? [5, 4] : []);
    c.beginPath();
    one.x.forEach((x, i) => { i ? c.lineTo(X(x), Y(one.y[i])) : c.moveTo(X(x), Y(one.y[i])); });
    c.stroke(); c.setLineDash([]);
  }

  points(c, one, X, Y) {
    const size = one.size || (one.x.length > 2000 ? 1.6 : 4);
    c.fillStyle = colour(one.colour);
    for (let i = 0; i < one.x.length; i++) c.fillRect(X(one.x[i]) - size / 2, Y(one.y[i]) - size / 2, size, size);
    c.strokeStyle = colour("outlier"); c.lineWidth = 1.5;
    for (const i of one.rings || []) { c.beginPath(); c.arc(X(one.x[i]), Y(one.y[i]), 5, 0, 7); c.stroke(); }
  }

  hover(event) {
    if (!this.plot || !this.onHover) return;
    const area = this.canvas.getBoundingClientRect(), px = event.clientX - area.left, py = event.clientY - area.top;
    if (this.plot.at) { this.onHover(this.plot.at(px, py)); return; }
    let best = null, least = 30 * 30;
    for (const one of this.plot.series) {
      if (!one.poses) continue;
      for (let i = 0; i < one.x.length; i++) {
        const dx = this.scale.X(one.x[i]) - px, dy = this.scale.Y(one.y[i]) - py, d = dx * dx + dy * dy;
        if (d < least) { least = d; best = { x: one.x[i], y: one.y[i], pose: one.poses[i] }; }
      }
    }
    if (best && best.pose !== (this.near && this.near.pose)) { this.near = best; this.draw(); this.onHover(best); }
  }
}
Figure.all = [];

const redraw = () => Figure.all.forEach((figure) => figure.draw());
window.addEventListener("resize", redraw);
window.addEventListener("beforeprint", redraw);
window.addEventListener("afterprint", redraw);
window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
window.matchMedia("print").addEventListener("change", redraw);
