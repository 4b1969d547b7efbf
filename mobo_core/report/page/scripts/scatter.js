// A scatter of all shown arms. Its points are pressed into an image pixel by pixel: some milliseconds for 20,000,
// with no graphics card. Drag to move, wheel or two fingers to zoom; with the keyboard arrows step from arm to arm.
mobo.Scatter = class {
  constructor(root, study, { x, y, known = false, small = false, title }) {
    Object.assign(this, { study, xName: x, yName: y, known, small });
    this.canvas = mobo.el("canvas.points", { tabindex: 0, role: "application", "aria-label": title,
      "aria-roledescription": "scatter; arrows step from arm to arm, Enter opens one, plus and minus zoom, 0 shows all" });
    this.tip = mobo.el("div.tip", { hidden: true });
    this.root = mobo.el(small ? "div.scatter.small" : "div.scatter", {}, this.canvas, this.tip);
    // Measured with software GL: opaque, and not held back for the rest of the page, it shows thrice the frames.
    this.context = this.canvas.getContext("2d", { alpha: false, desynchronized: true });
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
    this.#listen();
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
    [this.canvas.width, this.canvas.height] = [Math.round(this.width * this.dpr), Math.round(this.height * this.dpr)];
    this.frame = { left: this.small ? 46 : 58, top: 12, right: 14, bottom: this.small ? 38 : 46 };
    this.draw();
  }

  get inner() {
    const { left, top, right, bottom } = this.frame;
    return { left, top, width: this.width - left - right, height: this.height - top - bottom };
  }

  fitted() {
    const range = (values) => {
      let low = Infinity, high = -Infinity;
      for (const v of values) if (Number.isFinite(v)) { if (v < low) low = v; if (v > high) high = v; }
      if (!(low <= high)) return [0, 1];
      if (low >= 0 && low < 0.3 * high) low = 0;
      const pad = 0.04 * (high - low) || 0.5;
      return [low - (low === 0 ? 0.4 : 1) * pad, high + pad];
    };
    return { x: range(this.x.values), y: range(this.y.values) };
  }

  toX(value) { const { left, width } = this.inner, [a, b] = this.view.x; return left + ((value - a) / (b - a)) * width; }
  toY(value) { const { top, height } = this.inner, [a, b] = this.view.y; return top + (1 - (value - a) / (b - a)) * height; }

  #stamps() {
    const dark = mobo.theme.dark, paper = mobo.rgb(mobo.theme.colour("plot")), ink = dark ? paper : [20, 24, 28];
    const r = (this.n <= 1000 ? 4.6 : this.small ? 2.6 : 3.3) * this.dpr;
    const own = this.study.meta.styles.map((style) => {
      const fill = mobo.rgb(dark ? style.dark : style.colour);
      return mobo.marks.stamp(style.marker, r, fill, mobo.mixed(fill, ink, dark ? 0.75 : 0.45), 0.7 * this.dpr);
    });
    const grey = mobo.rgb(mobo.theme.colour("others"));
    const ring = (name, width) => mobo.marks.circle((this.small ? 4.6 : 6.2) * this.dpr, width * this.dpr, mobo.rgb(mobo.theme.colour(name)));
    this.rings = [ring("faint", 0.9), ring("ink", 1.5)]; // below the reach floor, and above
    return [...own, mobo.marks.stamp("o", 0.62 * r, grey, grey, 0)];
  }
  get n() { return this.study.n; }

  paint() {
    if (!this.width) return;
    this.view ??= this.fitted();
    const began = performance.now();
    if (!this.stamps || this.stampDpr !== this.dpr) [this.stamps, this.stampDpr] = [this.#stamps(), this.dpr];
    const { context } = this, { width, height } = this.canvas;
    if (!this.image || this.image.width !== width || this.image.height !== height) {
      this.image = context.createImageData(width, height);
      this.pixels = new Uint32Array(this.image.data.buffer);
    }
    const [r, g, b] = mobo.rgb(mobo.theme.colour("plot"));
    this.pixels.fill(0xff000000 | (b << 16) | (g << 8) | r);
    this.#grid();
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

  #grid() {
    const { left, top, width, height } = this.inner, d = this.dpr, W = this.canvas.width;
    const [r, g, b] = mobo.rgb(mobo.theme.colour("grid")), colour = 0xff000000 | (b << 16) | (g << 8) | r;
    const many = Math.max(2, Math.round(width / (this.small ? 70 : 95)));
    this.xTicks = mobo.ticks(...this.view.x, many);
    this.yTicks = mobo.ticks(...this.view.y, Math.max(2, Math.round(height / 60)));
    const y0 = Math.round(d * top), y1 = Math.round(d * (top + height)), x0 = Math.round(d * left), x1 = Math.round(d * (left + width));
    for (const value of this.xTicks.values) {
      const x = Math.round(d * this.toX(value));
      for (let y = y0; y < y1; y++) this.pixels[y * W + x] = colour;
    }
    for (const value of this.yTicks.values) {
      const y = Math.round(d * this.toY(value));
      this.pixels.fill(colour, y * W + x0, y * W + x1);
    }
  }

  #axes(context) {
    const { left, top, width, height } = this.inner;
    context.save();
    context.fillStyle = mobo.theme.colour("faint");
    context.font = `12px ${mobo.theme.colour("font")}`;
    context.textAlign = "center";
    for (const value of this.xTicks.values) context.fillText(mobo.tickText(value, this.xTicks.step), this.toX(value), top + height + 16);
    context.textAlign = "right";
    for (const value of this.yTicks.values) context.fillText(mobo.tickText(value, this.yTicks.step), left - 7, this.toY(value) + 4);
    const name = (column) => (column.unit ? `${column.label}  [${column.unit}]` : column.label);
    const shortName = (column) => (column.unit && column.unit.length < 5 ? `${column.label} [${column.unit}]` : column.label);
    const text = this.small || this.width < 480 ? shortName : name;
    context.fillStyle = mobo.theme.colour("ink");
    context.font = `12.5px ${mobo.theme.colour("font")}`;
    context.textAlign = "center";
    context.fillText(text(this.x), left + width / 2, this.height - 7);
    context.translate(13, top + height / 2);
    context.rotate(-Math.PI / 2);
    context.fillText(text(this.y), 0, 0);
    context.restore();
  }

  // What changes without the points: known arms, what is pointed at, chosen, pinned.
  paintOver() {
    if (!this.view || !this.width || !this.image) return;
    const { context, study } = this;
    context.putImageData(this.image, 0, 0);
    context.setTransform(this.dpr, 0, 0, this.dpr, 0, 0);
    this.#axes(context);
    context.save();
    const { left, top, width, height } = this.inner;
    context.beginPath();
    context.rect(left, top, width, height);
    context.clip();
    const ink = mobo.theme.colour("ink");
    const at = (row) => [this.toX(this.x.values[row]), this.toY(this.y.values[row])];
    const circle = (row, radius, colour, line) => {
      const [x, y] = at(row);
      context.beginPath();
      context.arc(x, y, radius, 0, 2 * Math.PI);
      context.lineWidth = line;
      context.strokeStyle = colour;
      context.stroke();
    };
    const floor = study.meta.floor;
    if (this.xName === "reach") {
      const x = this.toX(floor);
      context.setLineDash([4, 4]);
      context.strokeStyle = mobo.theme.colour("faint");
      context.lineWidth = 1;
      context.beginPath(); context.moveTo(x, top); context.lineTo(x, top + height); context.stroke();
      context.setLineDash([]);
      if (!this.small) {
        context.fillStyle = mobo.theme.colour("faint");
        context.font = `11px ${mobo.theme.colour("font")}`;
        context.fillText(`floor ${mobo.short(floor)}`, x + 4, top + 11);
      }
    }
    if (this.known) this.#names(context, at);
    for (const row of study.pins) circle(row, 9, mobo.theme.colour("pin"), 2.5);
    if (study.chosen >= 0) {
      circle(study.chosen, 8.5, mobo.theme.colour("plot"), 6);
      circle(study.chosen, 8.5, mobo.theme.colour("accent"), 3);
    }
    if (this.hover >= 0) circle(this.hover, 7, ink, 2);
    context.restore();
  }

  #names(context, at) {
    const { left, top, width, height } = this.inner, taken = [];
    context.font = `600 11.5px ${mobo.theme.colour("font")}`;
    context.textAlign = "left";
    for (const { row, name } of this.study.meta.known) {
      if (!this.study.shown[row]) continue;
      const [x, y] = at(row);
      if (x < left || x > left + width || y < top || y > top + height) continue;
      const w = context.measureText(name).width + 10, h = 19;
      let best = null;
      for (let k = 0; k < 40; k++) {
        const a = (k % 10) * 0.628 - 1.2, d = 26 + 22 * Math.floor(k / 10);
        const bx = x + d * Math.cos(a) - (Math.cos(a) < 0 ? w : 0), by = y + d * Math.sin(a) - h / 2;
        const out = bx < left + 2 || bx + w > left + width - 2 || by < top + 2 || by + h > top + height - 2;
        if (out || taken.some(([tx, ty, tw]) => bx < tx + tw + 3 && bx + w + 3 > tx && by < ty + h + 2 && by + h + 2 > ty)) continue;
        best = [bx, by, w];
        break;
      }
      context.strokeStyle = mobo.theme.colour("ink");
      context.lineWidth = 1.2;
      if (best) {
        const [bx, by] = best, cx = Math.min(Math.max(x, bx), bx + w), cy = by + h / 2;
        context.beginPath(); context.moveTo(x, y); context.lineTo(cx, cy); context.stroke();
        context.fillStyle = mobo.theme.colour("plot");
        context.globalAlpha = 0.92;
        context.beginPath(); context.roundRect(bx, by, w, h, 4); context.fill();
        context.globalAlpha = 1;
        context.strokeStyle = mobo.theme.colour("line");
        context.stroke();
        context.fillStyle = mobo.theme.colour("ink");
        context.fillText(name, bx + 5, by + 13.5);
        taken.push(best);
      }
      context.strokeStyle = mobo.theme.colour("ink");
      context.lineWidth = 1.8;
      context.beginPath();
      context.moveTo(x - 5, y); context.lineTo(x + 5, y); context.moveTo(x, y - 5); context.lineTo(x, y + 5);
      context.stroke();
    }
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

  #point(row, px, py) {
    if (row !== this.hover) { this.hover = row; this.drawOver(); }
    if (row < 0) { this.tip.hidden = true; this.canvas.style.cursor = ""; return; }
    this.canvas.style.cursor = "pointer";
    this.tip.replaceChildren(mobo.brief(this.study, row));
    this.tip.hidden = false;
    const right = px > this.width * 0.55, below = py < this.height * 0.45;
    this.tip.style.left = right ? "" : `${px + 16}px`;
    this.tip.style.right = right ? `${this.width - px + 16}px` : "";
    this.tip.style.top = below ? `${py + 12}px` : "";
    this.tip.style.bottom = below ? "" : `${this.height - py + 12}px`;
  }

  #listen() {
    const over = this.canvas, fingers = new Map();
    let moved = 0;
    const place = (event) => { const box = over.getBoundingClientRect(); return [event.clientX - box.left, event.clientY - box.top]; };
    over.addEventListener("pointerdown", (event) => {
      over.setPointerCapture(event.pointerId);
      fingers.set(event.pointerId, place(event));
      moved = 0;
    });
    over.addEventListener("pointermove", (event) => {
      const now = place(event), before = fingers.get(event.pointerId);
      if (!before) { if (event.pointerType !== "touch") this.#point(this.nearest(...now), ...now); return; }
      if (fingers.size === 1) {
        moved += Math.hypot(now[0] - before[0], now[1] - before[1]);
        if (moved > 4) { this.#point(-1); this.move(now[0] - before[0], now[1] - before[1]); }
        else return;
      } else {
        const [other] = [...fingers].filter(([id]) => id !== event.pointerId).map(([, p]) => p);
        const far = (p) => Math.hypot(p[0] - other[0], p[1] - other[1]) || 1;
        moved = 99;
        this.zoom(far(before) / far(now), (now[0] + other[0]) / 2, (now[1] + other[1]) / 2);
      }
      fingers.set(event.pointerId, now);
    });
    const end = (event) => {
      const began = fingers.get(event.pointerId);
      fingers.delete(event.pointerId);
      if (began && event.type === "pointerup" && moved <= 4) {
        const row = this.nearest(...place(event), event.pointerType === "touch" ? 26 : 18);
        if (row >= 0) this.study.choose(row, { reveal: event.pointerType === "touch" });
      }
    };
    over.addEventListener("pointerup", end);
    over.addEventListener("pointercancel", end);
    over.addEventListener("pointerleave", () => this.#point(-1));
    over.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.#point(-1);
      this.zoom(Math.exp(Math.max(-0.5, Math.min(0.5, event.deltaY * 0.0016))), ...place(event));
    }, { passive: false });
    over.addEventListener("dblclick", () => this.reset());
    over.addEventListener("keydown", (event) => {
      const steps = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
      const middle = [this.width / 2, this.height / 2];
      if (steps[event.key] && event.shiftKey) this.move(-60 * steps[event.key][0], -60 * steps[event.key][1]);
      else if (steps[event.key]) {
        const from = this.hover >= 0 ? this.hover : this.study.chosen >= 0 ? this.study.chosen : this.nearest(...middle, 1e4);
        if (from < 0) return;
        const to = this.next(from, ...steps[event.key]);
        this.#point(to, this.toX(this.x.values[to]), this.toY(this.y.values[to]));
        mobo.say(mobo.briefText(this.study, to));
      } else if (event.key === "Enter" || event.key === " ") {
        if (this.hover >= 0) this.study.choose(this.hover, { reveal: true });
      } else if (event.key === "p" && this.hover >= 0) this.study.pin(this.hover);
      else if (event.key === "+" || event.key === "=") this.zoom(0.8, ...middle);
      else if (event.key === "-") this.zoom(1.25, ...middle);
      else if (event.key === "0") this.reset();
      else if (event.key === "Escape") this.#point(-1);
      else return;
      event.preventDefault();
    });
    over.addEventListener("blur", () => this.#point(-1));
  }
};

mobo.briefText = (study, row) =>
  `${study.order(row)}, trial ${study.raw.trial[row]}, reach ${mobo.fixed(study.raw.reach[row], 2)}, torque ${mobo.fixed(study.raw.torque[row], 1)} newton metres`;

// What hovering over an arm shows.
mobo.brief = (study, row) => {
  const { el, fixed } = mobo, { raw, meta } = study;
  const line = (label, value) => el("div.pair", {}, el("span", {}, label), el("b", {}, value));
  const known = meta.known.filter((one) => study.order(one.row) === study.order(row)).map((one) => one.name);
  return el("div", {},
    el("div.tiphead", {}, mobo.orderChips(meta, study.order(row)), el("span", {}, `trial ${raw.trial[row]}`)),
    line("reach", `${fixed(raw.reach[row], 2)} of ${meta.voxels}`),
    line("torque", `${fixed(raw.torque[row], 1)} N m`),
    ...Object.entries(meta.further).map(([name, unit]) => line(name.replaceAll("_", " "), `${mobo.short(raw[`extra:${name}`][row])} ${unit}`)),
    mobo.strip(study, row),
    raw.front[row] ? el("div.note", {}, raw.useful[row] ? "on the Pareto front" : "on the raw front, below the reach floor") : null,
    known.length ? el("div.note", {}, `order of ${known.join("; ")}`) : null);
};

mobo.orderChips = (meta, order) =>
  mobo.el("span.order", { role: "img", "aria-label": `joint order ${order}` },
    [...order].map((letter) => {
      const [fill, ink] = mobo.jointColours(meta, letter);
      return mobo.el("i", { style: `background:${fill};color:${ink}` }, letter);
    }));

mobo.jointColours = (meta, letter) => {
  const fill = meta.joint_colours[letter] ?? "#767676";
  return [fill, mobo.darkTextOn(mobo.rgb(fill)) ? "#111111" : "#ffffff"];
};

// The stretched arm with its joints along it, and the length of each link.
mobo.strip = (study, row, width = 250) => {
  const { el } = mobo, lengths = study.lengths(row), order = study.order(row), meta = study.meta;
  const total = lengths.reduce((a, b) => a + b, 0) || 1, right = 12, step = 13;
  const x = (at) => 9 + (at / total) * (width - 9 - right);
  const joints = [];
  let at = 0, last = -Infinity;
  for (let i = 0; i < order.length; i++) {
    const cx = Math.max(x(at), last + step);
    joints.push([cx, order[i]]);
    last = cx;
    at += lengths[i];
  }
  const over = Math.max(0, last - (width - 10));
  const texts = lengths.map((length) => (1000 * length).toFixed(0)).join(" \u00b7 ");
  return el("div.strip", {},
    el("svg", { viewBox: `0 0 ${width} 22`, width: "100%", role: "img", "aria-label": `lengths in millimetres: ${texts}` },
      el("line", { x1: x(0), x2: width - 4, y1: 11, y2: 11, class: "link" }),
      joints.map(([cx, letter]) => el("g", {},
        el("circle", { cx: cx - over * (cx > width / 2), cy: 11, r: 7.5, fill: mobo.jointColours(meta, letter)[0] }),
        el("text", { x: cx - over * (cx > width / 2), y: 14.5, "text-anchor": "middle", class: "onjoint", fill: mobo.jointColours(meta, letter)[1] }, letter)))),
    el("div.note", {}, `${texts} mm`));
};
