// What draws itself anew when its place gets wider or narrower, or light turns dark: draw(box, width in pixels).
mobo.drawn = (root, draw, most = 900) => {
  const box = mobo.el("div");
  root.append(box);
  let width = 0;
  const again = () => { if (width) { box.replaceChildren(); draw(box, width); } };
  new ResizeObserver(([seen]) => {
    const next = Math.round(Math.min(seen.contentRect.width, most));
    if (next > 0 && next !== width) { width = next; again(); }
  }).observe(box);
  mobo.theme.changed.on("change", again);
};

// Small charts as SVG: lines, steps, points and bars, in the page's colours.
mobo.Chart = class {
  // series: {points: [[x, y], …], colour, kind: "line" | "step" | "points" | "area", marker, label, row: (i) => arm or -1}
  constructor(root, { width, height = 300, xLabel, yLabel, x, y, title, right = 16 }) {
    Object.assign(this, { width, height, xLabel, yLabel, xRange: x, yRange: y });
    this.svg = mobo.el("svg.chart", { viewBox: `0 0 ${width} ${height}`, width, height, role: "img", "aria-label": title });
    root.append(this.svg);
    this.inner = { left: 54, top: 12, width: width - 54 - right, height: height - 12 - 44 };
  }
  toX(v) { const [a, b] = this.xRange; return this.inner.left + ((v - a) / (b - a || 1)) * this.inner.width; }
  toY(v) { const [a, b] = this.yRange; return this.inner.top + (1 - (v - a) / (b - a || 1)) * this.inner.height; }

  axes() {
    const { el } = mobo, { left, top, width, height } = this.inner, parts = [];
    const xs = mobo.ticks(...this.xRange, Math.max(2, width / 95)), ys = mobo.ticks(...this.yRange, Math.max(2, height / 50));
    for (const v of ys.values) parts.push(el("line.grid", { x1: left, x2: left + width, y1: this.toY(v), y2: this.toY(v) }),
      el("text.tick", { x: left - 7, y: this.toY(v) + 4, "text-anchor": "end" }, mobo.tickText(v, ys.step)));
    for (const v of xs.values) parts.push(el("line.grid", { x1: this.toX(v), x2: this.toX(v), y1: top, y2: top + height }),
      el("text.tick", { x: this.toX(v), y: top + height + 17, "text-anchor": "middle" }, mobo.tickText(v, xs.step)));
    parts.push(el("text.label", { x: left + width / 2, y: this.height - 6, "text-anchor": "middle" }, this.xLabel),
      el("text.label", { transform: `translate(13 ${top + height / 2}) rotate(-90)`, "text-anchor": "middle" }, this.yLabel));
    this.svg.append(...parts);
    return this;
  }

  line(points, colour, { step = false, area = false, width = 2, dash = "" } = {}) {
    if (!points.length) return this;
    let d = "";
    points.forEach(([x, y], i) => {
      const px = this.toX(x).toFixed(1), py = this.toY(y).toFixed(1);
      d += !i ? `M${px} ${py}` : step ? `H${px}V${py}` : `L${px} ${py}`;
    });
    if (area) this.svg.append(mobo.el("path", { d: `${d}V${this.toY(this.yRange[0])}H${this.toX(points[0][0])}Z`, fill: colour, opacity: 0.12 }));
    this.svg.append(mobo.el("path", { d, fill: "none", stroke: colour, "stroke-width": width, "stroke-linejoin": "round", "stroke-dasharray": dash }));
    return this;
  }
  points(points, colour, marker, { size = 4.6, edge = "var(--plot)" } = {}) {
    for (const [x, y] of points) this.svg.append(mobo.el("path", { d: mobo.marks.path(marker, size, this.toX(x), this.toY(y)), fill: colour, stroke: edge, "stroke-width": 0.7 }));
    return this;
  }
  text(x, y, text, { anchor = "start", colour = "var(--ink)" } = {}) {
    this.svg.append(mobo.el("text.said", { x, y, "text-anchor": anchor, fill: colour }, text));
    return this;
  }
};
