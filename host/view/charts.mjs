// Curves of the force over time and over depth, with a cursor where the pointer is.
import { roundUp } from "./colours.mjs";

/** Time that the curve over time shows [s], and points that are kept: a point each 4 ms. */
const SPAN_S = 5;
const POINTS = 5000;

export class Charts {
  constructor(overTime, overDepth) {
    this.points = [];
    this.charts = [
      { canvas: overTime, x: (point) => point.timeS, unit: "s", digits: 2, line: 1.6 },
      { canvas: overDepth, x: (point) => 1e3 * point.depthM, unit: "mm", digits: 1, line: 1.2 },
    ];
    for (const chart of this.charts) {
      chart.canvas.addEventListener("pointermove", (event) => {
        chart.pointer = event.offsetX;
        this.isNew = true;
      });
      chart.canvas.addEventListener("pointerleave", () => {
        chart.pointer = null;
        this.isNew = true;
      });
    }
    this.isNew = true;
  }

  add(trail) {
    if (trail.length === 0) return;
    const last = this.points[this.points.length - 1];
    if (last && trail[0].timeS < last.timeS) this.points = [];
    this.points.push(...trail);
    if (this.points.length > 1.2 * POINTS) this.points = this.points.slice(-POINTS);
    this.isNew = true;
  }

  clear() {
    this.points = [];
    this.isNew = true;
  }

  draw() {
    if (!this.isNew) return;
    this.isNew = false;
    const end = this.points.length ? this.points[this.points.length - 1].timeS : 0;
    const recent = this.points.filter((point) => point.timeS > end - SPAN_S);
    const most = roundUp(Math.max(0.1, ...recent.map((point) => point.forceN)));
    const known = recent.filter((point) => !Number.isNaN(point.depthM));
    const deepest = roundUp(Math.max(2, ...known.map((point) => 1e3 * point.depthM)));
    this.#chart(this.charts[0], recent, [end - SPAN_S, end], most);
    const touching = known.filter((point) => point.depthM !== 0 || point.forceN > 0);
    this.#chart(this.charts[1], touching, [0, deepest], most);
  }

  #chart(chart, points, [from, to], most) {
    const { canvas } = chart;
    const ratio = globalThis.devicePixelRatio || 1;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (canvas.width !== Math.round(width * ratio)) canvas.width = Math.round(width * ratio);
    if (canvas.height !== Math.round(height * ratio)) canvas.height = Math.round(height * ratio);
    const pen = canvas.getContext("2d");
    const style = getComputedStyle(canvas);
    const colour = (name) => style.getPropertyValue(name);
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, width, height);
    const [left, right, top, bottom] = [30, width - 8, 10, height - 18];
    const x = (value) => left + ((value - from) / (to - from)) * (right - left);
    const y = (forceN) => bottom - (forceN / most) * (bottom - top);
    pen.font = "11px system-ui, sans-serif";
    this.#grid(pen, { left, right, top, bottom, from, to, most, unit: chart.unit, ink: colour("--faint"), line: colour("--line") });
    pen.save();
    pen.beginPath();
    pen.rect(left, 0, right - left + 6, height);
    pen.clip();
    this.#band(pen, chart, points, { x, y, fill: colour("--force") });
    pen.strokeStyle = colour("--force");
    pen.lineWidth = chart.line;
    pen.lineJoin = "round";
    pen.beginPath();
    points.forEach((point, index) => (index && !isGap(points, index) ? pen.lineTo(x(chart.x(point)), y(point.forceN)) : pen.moveTo(x(chart.x(point)), y(point.forceN))));
    pen.stroke();
    const last = points[points.length - 1];
    if (last) this.#dot(pen, x(chart.x(last)), y(last.forceN), colour("--force"));
    pen.restore();
    if (chart.pointer != null && points.length) this.#cursor(pen, chart, points, { x, y, top, bottom, left, right, ink: colour("--ink"), paper: colour("--panel") });
  }

  /** The estimated error around the curve: a piece between two points next to each other that both have one. */
  #band(pen, chart, points, { x, y, fill }) {
    pen.fillStyle = fill;
    pen.globalAlpha = 0.22;
    pen.beginPath();
    points.forEach((point, index) => {
      const before = points[index - 1];
      if (!before || !(before.errorN >= 0 && point.errorN >= 0) || isGap(points, index)) return;
      const [left, right] = [x(chart.x(before)), x(chart.x(point))];
      pen.moveTo(left, y(before.forceN + before.errorN));
      pen.lineTo(right, y(point.forceN + point.errorN));
      pen.lineTo(right, y(Math.max(0, point.forceN - point.errorN)));
      pen.lineTo(left, y(Math.max(0, before.forceN - before.errorN)));
      pen.closePath();
    });
    pen.fill();
    pen.globalAlpha = 1;
  }

  #grid(pen, { left, right, top, bottom, from, to, most, unit, ink, line }) {
    pen.strokeStyle = line;
    pen.fillStyle = ink;
    pen.lineWidth = 1;
    pen.beginPath();
    for (const share of [0, 0.5, 1]) {
      const y = Math.round(bottom - share * (bottom - top)) + 0.5;
      pen.moveTo(left, y);
      pen.lineTo(right, y);
    }
    pen.stroke();
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const share of [0, 1]) pen.fillText(String(Number((share * most).toPrecision(2))), left - 5, bottom - share * (bottom - top));
    pen.textBaseline = "alphabetic";
    const shown = (value) => (unit === "s" ? (value <= 0 ? "" : value.toFixed(1)) : String(value));
    pen.fillText(`${shown(to)} ${unit}`, right, bottom + 14);
    pen.textAlign = "left";
    pen.fillText(shown(from), left, bottom + 14);
  }

  #dot(pen, x, y, colour) {
    pen.fillStyle = colour;
    pen.beginPath();
    pen.arc(x, y, 3.2, 0, 2 * Math.PI);
    pen.fill();
  }

  /** The point nearest to the pointer, with its numbers. */
  #cursor(pen, chart, points, { x, y, top, bottom, left, right, ink, paper }) {
    const distance = (point) => Math.abs(x(chart.x(point)) - chart.pointer);
    const nearest = points.reduce((best, point) => (distance(point) <= distance(best) ? point : best));
    const [px, py] = [x(chart.x(nearest)), y(nearest.forceN)];
    pen.strokeStyle = ink;
    pen.lineWidth = 1;
    pen.beginPath();
    pen.moveTo(px, top);
    pen.lineTo(px, bottom);
    pen.stroke();
    this.#dot(pen, px, py, ink);
    const error = nearest.errorN >= 0 ? ` ± ${nearest.errorN.toFixed(3)}` : "";
    const text = `${nearest.forceN.toFixed(3)}${error} N at ${chart.x(nearest).toFixed(chart.digits)} ${chart.unit}`;
    const width = pen.measureText(text).width + 10;
    const start = Math.max(left, Math.min(px - width / 2, right - width));
    pen.fillStyle = paper;
    pen.fillRect(start, 0, width, 16);
    pen.fillStyle = ink;
    pen.textAlign = "left";
    pen.fillText(text, start + 5, 12);
  }
}

/** Whether the curve is broken before a point: time has gone by without one. */
function isGap(points, index) {
  return points[index].timeS - points[index - 1].timeS > 0.05;
}
