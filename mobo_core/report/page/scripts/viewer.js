// One arm in 3D: drag to turn, a slider for each joint; links that touch are red; what the joints hold, as they stand.
mobo.shapesOf = (robot, placed, meta, { hit = new Set() } = {}) => {
  const dark = mobo.theme.dark, link = dark ? [176, 184, 192] : [150, 158, 167], red = [226, 40, 40];
  const shapes = [];
  let k = 0, joint = -1;
  for (const { link: body, frame, joint: above } of placed) {
    if (above && !above.fixed) joint++;
    const touching = body.collisions.some((_, i) => hit.has(k + i));
    k += body.collisions.length;
    for (const shape of body.visuals) {
      const own = shape.material !== "link" && meta.material_colours[shape.material];
      shapes.push({ ...shape, frame: mobo.compose(frame, shape.frame), round: !own, colour: touching ? red : own ? mobo.rgb(own) : link });
    }
  }
  return shapes;
};

// What stands around: the edges of the workspace's floor, the axes at the base.
mobo.surroundings = (meta) => {
  const [low, high] = [meta.workspace_min, meta.workspace_max], z = low[2], grey = mobo.rgb(mobo.theme.colour("others"));
  const bar = (a, b, colour = grey, radius = 0.0018) => {
    const d = b.map((v, i) => v - a[i]), L = Math.hypot(...d), u = d.map((v) => v / L);
    const s = Math.abs(u[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0];
    const x = [s[1] * u[2] - s[2] * u[1], s[2] * u[0] - s[0] * u[2], s[0] * u[1] - s[1] * u[0]], n = Math.hypot(...x);
    const e = x.map((v) => v / n), f = [u[1] * e[2] - u[2] * e[1], u[2] * e[0] - u[0] * e[2], u[0] * e[1] - u[1] * e[0]];
    return { kind: "cylinder", radius, length: L, colour, flat: true, frame: [[e[0], f[0], u[0], e[1], f[1], u[1], e[2], f[2], u[2]], a.map((v, i) => (v + b[i]) / 2)] };
  };
  const shapes = [], step = meta.voxel_size, many = Math.max(...[0, 1].map((k) => (high[k] - low[k]) / step)) > 30;
  for (const k of [0, 1])
    for (let v = low[k]; v <= high[k] + 1e-9; v += many ? high[k] - low[k] : step) {
      const a = [low[0], low[1], z], b = [high[0], high[1], z];
      a[k] = b[k] = v;
      shapes.push(bar(a, b));
    }
  return shapes;
};

mobo.Viewer = class {
  static view = { azimuth: -0.9, elevation: 0.28 }; // shared, so that arms side by side are seen from one side

  constructor(root, study, { sliders = true, small = false } = {}) {
    Object.assign(this, { study, small, robot: null, q: [], mark: null });
    const { el } = mobo;
    this.canvas = el("canvas.arm3d", small ? { "aria-hidden": "true" } : { tabindex: 0, role: "img", "aria-label": "the arm in 3D; arrows turn it, plus and minus zoom" });
    this.state = el("div.state", { role: "status" });
    this.box = el(small ? "div.viewer.small" : "div.viewer", {}, this.canvas, small ? null : this.state);
    root.append(this.box);
    this.sliders = sliders ? el("div.sliders") : null;
    if (this.sliders) root.append(this.sliders);
    this.zoom = 1;
    this.draw = mobo.atNextFrame(() => this.paint());
    new ResizeObserver(() => this.draw()).observe(this.box);
    mobo.theme.changed.on("change", this.draw);
    if (!small) this.#listen();
    mobo.Viewer.all.add(this);
  }

  show(robot, q = null) {
    this.robot = robot;
    this.mark = null;
    this.q = q ?? robot.moving.map((_, i) => Math.min(Math.max(0, robot.lower[i]), robot.upper[i]));
    if (this.sliders) this.#makeSliders();
    this.draw();
  }
  pose(q, mark = null) {
    if (!this.robot) return;
    this.mark = mark;
    const from = this.q.slice(), began = performance.now(), still = matchMedia("(prefers-reduced-motion: reduce)").matches;
    const step = () => {
      const t = still ? 1 : Math.min((performance.now() - began) / 350, 1), s = t * t * (3 - 2 * t);
      this.q = from.map((v, i) => v + s * (q[i] - v));
      this.#showSliders();
      this.paint();
      if (t < 1 && this.moving === step) requestAnimationFrame(step);
    };
    this.moving = step;
    step();
  }

  #makeSliders() {
    const { el } = mobo, { robot, study } = this, order = [...this.letters()];
    this.inputs = robot.moving.map((joint, i) => {
      const input = el("input", { type: "range", min: joint.lower.toFixed(4), max: joint.upper.toFixed(4), step: joint.slides ? 0.001 : 0.005, "aria-label": `${joint.slides ? "way" : "angle"} of joint ${i + 1}, ${order[i] ?? ""}` });
      input.addEventListener("input", () => { this.moving = null; this.mark = null; this.q[i] = Number(input.value); this.#showSliders(i); this.draw(); });
      return input;
    });
    this.angles = robot.moving.map(() => el("output"));
    this.holds = robot.moving.map(() => el("span.holds"));
    this.sliders.replaceChildren(
      el("div.sliderrow.head", {}, el("span", {}, "joint"), el("span", {}, robot.moving.some((joint) => joint.slides) ? "angle, way" : "angle"), el("span"), el("span", {}, "holds")),
      ...robot.moving.map((_, i) => {
        const [fill, ink] = mobo.jointColours(study.meta, order[i]);
        return el("div.sliderrow", {}, el("i.jointchip", { style: `background:${fill};color:${ink}` }, order[i] ?? String(i + 1)), this.inputs[i], this.angles[i], this.holds[i]);
      }));
    this.#showSliders();
  }
  letters() { return this.order ?? ""; }
  #showSliders(except = -1) {
    if (!this.inputs || !this.sliders) return;
    this.q.forEach((v, i) => {
      if (i !== except) this.inputs[i].value = v;
      const slides = this.robot.moving[i].slides, shown = Math.round(slides ? v * 1000 : (v * 180) / Math.PI) + 0;
      this.angles[i].textContent = `${mobo.fixed(shown, 0)}${slides ? " mm" : "\u00b0"}`;
    });
  }

  paint() {
    const { robot, study, canvas } = this, box = this.box.getBoundingClientRect();
    if (!robot || !(box.width > 0)) return;
    const dpr = Math.min(devicePixelRatio || 1, 2), [w, h] = [Math.round(box.width * dpr), Math.round(box.height * dpr)];
    if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
    const placed = robot.place(this.q), hit = study.meta.self_collision ? robot.colliding(placed) : new Set();
    const meta = study.meta, shapes = mobo.shapesOf(robot, placed, meta, { hit });
    if (this.mark) {
      const h2 = meta.voxel_size / 2, [x, y, z] = this.mark, grey = mobo.rgb(mobo.theme.colour("accent"));
      for (const k of [0, 1, 2]) for (const a of [-h2, h2]) for (const b of [-h2, h2]) {
        const R = [[0, 0, 1, 0, 1, 0, -1, 0, 0], [1, 0, 0, 0, 0, 1, 0, -1, 0], [1, 0, 0, 0, 1, 0, 0, 0, 1]][k], p = [x, y, z];
        p[(k + 1) % 3] += a; p[(k + 2) % 3] += b;
        shapes.push({ kind: "cylinder", radius: 0.0018, length: 2 * h2, frame: [R, p], colour: grey, flat: true });
      }
    }
    const reach = Math.max(robot.total, 0.05), floor = this.small ? null : meta.workspace_min[2];
    const view = { ...mobo.Viewer.view, distance: 3.3 * reach / this.zoom, target: [0, 0, 0.26 * reach] };
    if (this.small) { // as large as it will go
      const points = placed.map(({ frame }) => frame[1]), ends = [0, 1, 2].map((k) => [Math.min(...points.map((p) => p[k])), Math.max(...points.map((p) => p[k]))]);
      view.target = ends.map(([a, b]) => 0.5 * (a + b));
      view.distance = 4 * Math.max(0.5 * Math.hypot(...ends.map(([a, b]) => b - a)), 0.3 * reach);
    }
    if (!this.small) shapes.push(...mobo.surroundings(meta));
    mobo.scene.draw(canvas, view, shapes, { floor, shadow: mobo.rgb(mobo.theme.colour("shadow")) });
    if (this.small) return;
    this.state.textContent = hit.size ? "in self-collision" : "";
    this.state.classList.toggle("bad", hit.size > 0);
    if (this.holds) {
      const torques = robot.torques(placed, meta.gravity, meta.payload_kg);
      torques.forEach((t, i) => {
        const { slides, radius } = robot.moving[i];
        this.holds[i].textContent = `${mobo.fixed(Math.abs(t), 2)} N m`;
        if (slides) this.holds[i].title = `${mobo.fixed(Math.abs(t) / radius, 1)} N, at a pinion of ${radius} m`;
      });
    }
  }

  #listen() {
    const { canvas } = this, all = () => { for (const viewer of mobo.Viewer.all) if (viewer.box.isConnected) viewer.draw(); };
    const turn = (dx, dy) => {
      const view = mobo.Viewer.view;
      view.azimuth -= dx;
      view.elevation = Math.min(Math.max(view.elevation + dy, -1.5), 1.5);
      all();
    };
    let last = null;
    canvas.addEventListener("pointerdown", (event) => { last = [event.clientX, event.clientY]; canvas.setPointerCapture(event.pointerId); });
    canvas.addEventListener("pointermove", (event) => {
      if (!last) return;
      turn((event.clientX - last[0]) * 0.01, (event.clientY - last[1]) * 0.01);
      last = [event.clientX, event.clientY];
    });
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => { last = null; });
    const zoom = (factor) => { this.zoom = Math.min(Math.max(this.zoom * factor, 0.4), 6); this.draw(); };
    canvas.addEventListener("wheel", (event) => {
      if (document.activeElement !== canvas) return; // the page scrolls on until the arm has been clicked
      event.preventDefault();
      zoom(Math.exp(-event.deltaY * 0.0015));
    }, { passive: false });
    canvas.addEventListener("keydown", (event) => {
      const turns = { ArrowLeft: [-0.12, 0], ArrowRight: [0.12, 0], ArrowUp: [0, 0.12], ArrowDown: [0, -0.12] };
      if (turns[event.key]) turn(...turns[event.key]);
      else if (event.key === "+" || event.key === "=") zoom(1.2);
      else if (event.key === "-") zoom(1 / 1.2);
      else return;
      event.preventDefault();
    });
  }
};
mobo.Viewer.all = new Set();
