// A scatter of all shown arms. Its points are pressed into an image pixel by pixel: some milliseconds for 20,000,
// with no graphics card. Drag to move, wheel or two fingers to zoom; with the keyboard arrows step from arm to arm.
mobo.Scatter = class {
  constructor(root, study, { x, y, known = false, small = false, title }) {
    Object.assign(this, { study, xName: x, yName: y, known, small });
    this.canvas = mobo.el("canvas.points", { tabindex: 0, role: "application", "aria-label": title,
      "aria-roledescription": "scatter; arrows step from arm to arm, Enter opens one, plus and minus zoom, 0 shows all" });
    this.tip = mobo.el("div.tip", { hidden: true });
    this.root = mobo.el(small ? "div.scatter.small" : "div.scatter", {}, this.canvas, this.tip);
    // Measured with software GL: lines and letters cost the graphics process thrice what one opaque image does. So all
    // is drawn in memory, and the screen gets the image.
    this.context = mobo.el("canvas").getContext("2d", { alpha: false, willReadFrequently: true });
    this.screen = this.canvas.getContext("2d", { alpha: false, desynchronized: true });
    root.append(this.root);
    this.hover = -1;
    this.view = null;
    this.draw = mobo.atNextFrame(() => this.paint());
    this.drawOver = mobo.atNextFrame(() => this.paintOver());
    study.on("filter", this.draw);
    study.on("choose", this.drawOver);
    study.on("pin", this.drawOver);
    mobo.theme.changed.on("change", () => { this.stamps = null; this.draw(); });
    new ResizeObserver(() => this.#resize()).observe(this.root);
    mobo.listenTo(this);
    this.#resize();
  }

  setAxes(x, y) { this.xName = x; this.yName = y; this.view = null; this.draw(); }
  get x() { return this.study.columns.get(this.xName); }
  get y() { return this.study.columns.get(this.yName); }

  #resize() {
    const box = this.root.getBoundingClientRect();
    if (!(box.width > 0 && box.height > 0)) return;
    this.dpr = Math.min(devicePixelRatio || 1, 2);
    [this.width, this.height] = [Math.round(box.width), Math.round(box.height)];
    for (const canvas of [this.canvas, this.context.canvas])
      [canvas.width, canvas.height] = [Math.round(this.width * this.dpr), Math.round(this.height * this.dpr)];
    this.frame = { left: this.small ? 54 : 58, top: 12, right: 14, bottom: this.small ? 38 : 46 };
    this.draw();
  }

  get inner() {
    const { left, top, right, bottom } = this.frame;
    return { left, top, width: this.width - left - right, height: this.height - top - bottom };
  }

  fitted() {
    const range = (name, values) => {
      let low = Infinity, high = -Infinity;
      const more = this.known ? this.study.realArms.map((arm) => arm.values[name] ?? NaN) : [];
      for (const all of [values, more]) for (const v of all) if (Number.isFinite(v)) { if (v < low) low = v; if (v > high) high = v; }
      if (!(low <= high)) return [0, 1];
      if (low >= 0 && low < 0.3 * high) low = 0;
      const pad = (this.small ? 0.07 : 0.04) * (high - low) || 0.5; // so that marks at the ends stay whole
      return [low - (low === 0 ? 0.4 : 1) * pad, high + pad];
    };
    return { x: range(this.xName, this.x.values), y: range(this.yName, this.y.values) };
  }

  toX(value) { const { left, width } = this.inner, [a, b] = this.view.x; return left + ((value - a) / (b - a)) * width; }
  toY(value) { const { top, height } = this.inner, [a, b] = this.view.y; return top + (1 - (value - a) / (b - a)) * height; }

  #stamps() {
    const dark = mobo.theme.dark, paper = mobo.rgb(mobo.theme.colour("plot")), ink = dark ? paper : [20, 24, 28];
    const r = (this.n <= 1000 ? 4.6 : this.compact ? 2.6 : 3.3) * this.dpr;
    const own = this.study.meta.styles.map((style) => {
      const fill = mobo.rgb(dark ? style.dark : style.colour);
      return mobo.marks.stamp(style.marker, r, fill, mobo.mixed(fill, ink, dark ? 0.75 : 0.45), 0.7 * this.dpr);
    });
    const grey = mobo.rgb(mobo.theme.colour("others"));
    const ring = (name, width) => mobo.marks.circle((this.compact ? 4.6 : 6.2) * this.dpr, width * this.dpr, mobo.rgb(mobo.theme.colour(name)));
    this.rings = [ring("faint", 0.9), ring("ink", 1.5)]; // below the reach floor, and above
    return [...own, mobo.marks.stamp("o", 0.62 * r, grey, grey, 0)];
  }
  get n() { return this.study.n; }
  get compact() { return this.small || this.width < 480; }

  paint() {
    if (!this.width) return;
    this.view ??= this.fitted();
    const began = performance.now();
    const drawnFor = `${this.dpr} ${this.compact}`;
    if (!this.stamps || this.stampsFor !== drawnFor) [this.stamps, this.stampsFor] = [this.#stamps(), drawnFor];
    const { context } = this, { width, height } = this.canvas;
    if (!this.image || this.image.width !== width || this.image.height !== height) {
      this.image = context.createImageData(width, height);
      this.pixels = new Uint32Array(this.image.data.buffer);
    }
    const [r, g, b] = mobo.rgb(mobo.theme.colour("plot"));
    this.pixels.fill(0xff000000 | (b << 16) | (g << 8) | r);
    mobo.scatterGrid(this);
    const { shown, style } = this.study, xs = this.x.values, ys = this.y.values;
    const inner = this.inner, d = this.dpr, [x0, x1] = this.view.x, [y0, y1] = this.view.y;
    const ax = (d * inner.width) / (x1 - x0), bx = d * inner.left - x0 * ax;
    const ay = (-d * inner.height) / (y1 - y0), by = d * (inner.top + inner.height) - y0 * ay;
    // Those without a colour of their own below, then the named ones, the first on top.
    if (!this.byStyle) {
      const others = this.study.meta.styles.length, lists = Array.from({ length: others + 1 }, () => []);
      for (let row = 0; row < this.n; row++) lists[style[row]].push(row);
      this.byStyle = lists.map((rows) => Uint32Array.from(rows));
    }
    const low = { x: d * inner.left, y: d * inner.top };
    const high = { x: d * (inner.left + inner.width), y: d * (inner.top + inner.height) };
    const press = (row, stamp) => {
      if (!shown[row]) return;
      const px = (ax * xs[row] + bx) | 0, py = (ay * ys[row] + by) | 0;
      if (px >= low.x && px <= high.x && py >= low.y && py <= high.y) mobo.marks.press(this.pixels, width, height, stamp, px, py);
    };
    for (let k = this.byStyle.length - 1; k >= 0; k--) for (const row of this.byStyle[k]) press(row, this.stamps[k]);
    for (const row of this.study.meta.front) press(row, this.rings[this.study.raw.useful[row]]);
    this.paintOver();
    this.lastMs = performance.now() - began;
    this.frames = (this.frames ?? 0) + 1;
  }

  paintOver() {
    if (this.view && this.width && this.image) mobo.scatterOver(this);
  }

  // The shown arm nearest to a place in the plot, within so many pixels; -1 if there is none.
  nearest(px, py, within = 18) {
    const { shown, raw } = this.study, xs = this.x.values, ys = this.y.values;
    const { left, top, width, height } = this.inner, [x0, x1] = this.view.x, [y0, y1] = this.view.y;
    let best = -1, least = within * within;
    for (let row = 0; row < this.n; row++) {
      if (!shown[row]) continue;
      const dx = left + ((xs[row] - x0) / (x1 - x0)) * width - px, dy = top + (1 - (ys[row] - y0) / (y1 - y0)) * height - py;
      const d = (dx * dx + dy * dy) * (raw.front[row] ? 0.4 : 1); // the front is easier to hit
      if (d < least) [best, least] = [row, d];
    }
    return best;
  }

  // The next shown arm from `row` towards (dx, dy): near, and little aside.
  next(row, dx, dy) {
    const { shown } = this.study, inner = this.inner, fx = this.toX(this.x.values[row]), fy = this.toY(this.y.values[row]);
    let best = row, least = Infinity;
    for (let other = 0; other < this.n; other++) {
      if (!shown[other] || other === row) continue;
      const x = this.toX(this.x.values[other]), y = this.toY(this.y.values[other]);
      if (x < inner.left || x > inner.left + inner.width || y < inner.top || y > inner.top + inner.height) continue;
      const along = (x - fx) * dx + (y - fy) * dy, aside = Math.abs((x - fx) * dy) + Math.abs((y - fy) * dx);
      if (along < 3) continue;
      const cost = along + 3 * aside;
      if (cost < least) [best, least] = [other, cost];
    }
    return best;
  }

  zoom(factor, px, py) {
    const { left, top, width, height } = this.inner;
    const u = (Math.min(Math.max(px, left), left + width) - left) / width;
    const v = 1 - (Math.min(Math.max(py, top), top + height) - top) / height;
    const about = ([a, b], share) => { const m = a + share * (b - a); return [m + (a - m) * factor, m + (b - m) * factor]; };
    this.view = { x: about(this.view.x, u), y: about(this.view.y, v) };
    this.draw();
  }
  move(dx, dy) {
    const { width, height } = this.inner, [x0, x1] = this.view.x, [y0, y1] = this.view.y;
    const sx = (dx / width) * (x1 - x0), sy = (dy / height) * (y1 - y0);
    this.view = { x: [x0 - sx, x1 - sx], y: [y0 + sy, y1 + sy] };
    this.draw();
  }
  reset() { this.view = this.fitted(); this.draw(); }

  // Show what arm is pointed at; none if row is -1.
  point(row, px, py) {
    if (row !== this.hover) { this.hover = row; this.drawOver(); }
    if (row < 0) { this.tip.hidden = true; this.canvas.style.cursor = ""; return; }
    this.canvas.style.cursor = "pointer";
    this.show(mobo.brief(this.study, row), px, py);
  }

  // Show what real arm is pointed at.
  pointKnown(arm, px, py) {
    this.point(-1);
    this.show(mobo.knownBrief(this.study, arm), px, py);
  }

  show(content, px, py) {
    this.tip.replaceChildren(content);
    this.tip.hidden = false;
    const right = px > this.width * 0.55, below = py < this.height * 0.45;
    this.tip.style.left = right ? "" : `${px + 16}px`;
    this.tip.style.right = right ? `${this.width - px + 16}px` : "";
    this.tip.style.top = below ? `${py + 12}px` : "";
    this.tip.style.bottom = below ? "" : `${this.height - py + 12}px`;
  }
};
