// Maps of an arm's voxels, a square for each layer of the workspace, low to high, in the paper's colours.
mobo.VoxelMaps = class {
  constructor(root, study, { pick = null, alone = true } = {}) {
    Object.assign(this, { study, pick, kind: "reach", values: null, at: -1 });
    const { el } = mobo;
    this.kinds = {
      reach: ["Reach", "share of the poses reached", (v) => mobo.fixed(v, 2)],
      torque: ["Torque", "N m, mean over the poses reached", (v) => mobo.fixed(v, 1)],
      not_converged: ["Not converged", "share of the poses for which no solution was found", (v) => mobo.fixed(v, 2)],
      in_collision: ["Collision", "share of the poses whose solutions collide", (v) => mobo.fixed(v, 2)],
      out_of_range: ["Out of range", "share of the poses beyond the stretched arm", (v) => mobo.fixed(v, 2)],
    };
    this.tabs = el("div.tabs", { role: "group", "aria-label": "what the maps show" }, Object.entries(this.kinds).map(([kind, [name]]) =>
      el("button", { type: "button", "data-kind": kind, "aria-pressed": String(kind === this.kind), onclick: () => this.choose(kind) }, name)));
    this.canvas = el("canvas.voxels", { tabindex: 0, role: "application", "aria-label": "voxel maps; arrows go from voxel to voxel, page up and down from layer to layer, Enter puts the arm there" });
    this.said = el("div.note.voxelsaid", { role: "status" });
    this.key = el("div.voxelkey");
    root.append(...(alone ? [this.tabs, this.canvas, this.key] : [this.canvas]), this.said);
    this.draw = mobo.atNextFrame(() => this.paint());
    new ResizeObserver(() => this.draw()).observe(this.canvas);
    mobo.theme.changed.on("change", this.draw);
    this.#listen();
  }

  show(values) { this.values = values; this.draw(); }

  choose(kind) {
    this.kind = kind;
    for (const tab of this.tabs.children) tab.setAttribute("aria-pressed", String(tab.dataset.kind === kind));
    this.draw();
  }

  // Places of the layers: up to as many side by side as are at least 90 pixels wide.
  layout(width) {
    const [nx, ny, nz] = this.study.meta.shape, gap = 10, head = 18;
    const across = Math.max(1, Math.min(nz, 6, Math.floor((width + gap) / (90 + gap))));
    const side = (width - gap * (across - 1)) / across, cell = Math.min(side / nx, 34), w = cell * nx, h = cell * ny;
    const layers = Array.from({ length: nz }, (_, iz) => ({ iz, x: (iz % across) * (side + gap), y: Math.floor(iz / across) * (h + gap + head) + head }));
    return { layers, cell, w, h, height: Math.ceil(nz / across) * (h + gap + head), nx, ny, nz };
  }
  index(ix, iy, iz) { const [, ny, nz] = this.study.meta.shape; return (ix * ny + iy) * nz + iz; }
  centre(v) {
    const { meta } = this.study, [, ny, nz] = meta.shape, i = [Math.floor(v / (ny * nz)), Math.floor(v / nz) % ny, v % nz];
    return i.map((k, a) => meta.workspace_min[a] + (k + 0.5) * meta.voxel_size);
  }

  paint() {
    const { canvas, values, study } = this, width = canvas.getBoundingClientRect().width;
    if (!values || !(width > 0)) return;
    const plan = this.plan = this.layout(width), dpr = Math.min(devicePixelRatio || 1, 2);
    canvas.style.height = `${plan.height}px`;
    [canvas.width, canvas.height] = [Math.round(width * dpr), Math.round(plan.height * dpr)];
    const context = canvas.getContext("2d"), font = mobo.theme.colour("font");
    context.scale(dpr, dpr);
    const shown = values[this.kind], scale = this.#scale(), digits = this.kind === "torque" ? 1 : 2;
    const empty = mobo.theme.colour("grid"), faint = mobo.theme.colour("faint");
    for (const { iz, x, y } of plan.layers) {
      context.fillStyle = faint;
      context.font = `11.5px ${font}`;
      context.textAlign = "left";
      context.fillText(`z = ${mobo.fixed(this.centre(iz)[2], 2)} m`, x, y - 5);
      for (let ix = 0; ix < plan.nx; ix++)
        for (let iy = 0; iy < plan.ny; iy++) {
          const v = this.index(ix, iy, iz), value = shown[v], cx = x + ix * plan.cell, cy = y + (plan.ny - 1 - iy) * plan.cell, s = plan.cell - (plan.cell > 6 ? 1 : 0);
          const none = this.kind === "torque" ? !Number.isFinite(value) : this.kind === "reach" && value === 0;
          if (none) { // hatched: nothing reached
            const red = this.kind === "reach";
            context.fillStyle = red ? `rgb(${scale(0).join(",")})` : empty;
            context.fillRect(cx, cy, s, s);
            context.save();
            context.beginPath(); context.rect(cx, cy, s, s); context.clip();
            context.strokeStyle = red ? "#fff" : faint; context.globalAlpha = 0.55; context.lineWidth = 0.9;
            context.beginPath();
            for (let d = -s; d < s; d += 5) { context.moveTo(cx + d, cy + s); context.lineTo(cx + d + s, cy); }
            context.stroke();
            context.restore();
            continue;
          }
          const colour = scale(value);
          context.fillStyle = `rgb(${colour.join(",")})`;
          context.fillRect(cx, cy, s, s);
          if (plan.cell >= 21) {
            context.fillStyle = mobo.darkTextOn(colour) ? "#111" : "#fff";
            context.font = `${plan.cell >= 27 ? 10.5 : 9}px ${font}`;
            context.textAlign = "center";
            const text = value.toFixed(digits);
            context.fillText(plan.cell < 27 && text.startsWith("0.") ? text.slice(1) : text, cx + s / 2, cy + s / 2 + 3.5);
          }
        }
      this.#limit(context, x, y, iz);
    }
    if (this.at >= 0) this.#mark(context);
    this.#keyOf(scale);
  }

  // How far the stretched arm goes at this height.
  #limit(context, x, y, iz) {
    const { plan, study } = this, z = this.centre(iz)[2] - (this.height ?? 0), L = this.total;
    if (!L || Math.abs(z) >= L) return;
    const [x0, y0] = study.meta.workspace_min, size = study.meta.voxel_size, r = (Math.sqrt(L * L - z * z) / size) * plan.cell;
    context.save();
    context.beginPath(); context.rect(x, y, plan.w, plan.h); context.clip();
    context.setLineDash([4, 3]);
    context.strokeStyle = mobo.theme.colour("ink"); context.globalAlpha = 0.7; context.lineWidth = 1;
    context.beginPath();
    context.arc(x + (-x0 / size) * plan.cell, y + plan.h + (y0 / size) * plan.cell, r, 0, 2 * Math.PI);
    context.stroke();
    context.restore();
  }

  #mark(context) {
    const [, ny, nz] = this.study.meta.shape, { plan } = this, iz = this.at % nz, iy = Math.floor(this.at / nz) % ny, ix = Math.floor(this.at / (ny * nz));
    const { x, y } = plan.layers[iz];
    context.strokeStyle = mobo.theme.colour("accent");
    context.lineWidth = 3;
    context.strokeRect(x + ix * plan.cell - 1, y + (plan.ny - 1 - iy) * plan.cell - 1, plan.cell + 1, plan.cell + 1);
  }

  #scale() {
    const { meta } = this.study, green = mobo.gradation(meta.gradation), grey = [236, 236, 236], black = [60, 30, 90];
    if (this.kind === "reach") return (v) => green(v);
    if (this.kind === "torque") return (v) => green((meta.torque_ends[1] - v) / (meta.torque_ends[1] - meta.torque_ends[0]));
    return (v) => mobo.mixed(grey, black, v);
  }
  #keyOf(scale) {
    const [, text] = this.kinds[this.kind], [low, high] = this.kind === "torque" ? this.study.meta.torque_ends : [0, 1];
    const stops = Array.from({ length: 9 }, (_, i) => `rgb(${scale(low + (i / 8) * (high - low)).join(",")})`);
    const hatched = this.kind === "reach" || this.kind === "torque" ? "; hatched: none reached" : "";
    this.key.replaceChildren(mobo.el("span", {}, String(low)), mobo.el("i", { style: `background:linear-gradient(90deg,${stops.join(",")})` }),
      mobo.el("span", {}, this.kind === "torque" ? `${high} or more` : String(high)), mobo.el("span.note", {}, `${text}${hatched}; dashed: how far the stretched arm goes`));
  }

  #say(v) {
    this.at = v;
    const { values } = this, at = this.centre(v).map((c) => mobo.fixed(c, 2)).join(", ");
    const pct = (x) => `${Math.round(100 * x)} %`;
    const parts = [`reached ${pct(values.reach[v])}`];
    if (Number.isFinite(values.torque[v])) parts.push(`${mobo.fixed(values.torque[v], 2)} N m`);
    for (const kind of ["not_converged", "in_collision", "out_of_range"]) if (values[kind][v] > 0) parts.push(`${this.kinds[kind][0].toLowerCase()} ${pct(values[kind][v])}`);
    this.said.textContent = `voxel ${v} at (${at}) m: ${parts.join(", ")}`;
    this.draw();
  }
  #take() { if (this.at >= 0 && this.pick) this.pick(this.at, this.centre(this.at)); }

  #listen() {
    const { canvas } = this;
    const find = (event) => {
      if (!this.plan) return -1;
      const box = canvas.getBoundingClientRect(), px = event.clientX - box.left, py = event.clientY - box.top, { plan } = this;
      for (const { iz, x, y } of plan.layers)
        if (px >= x && px < x + plan.w && py >= y && py < y + plan.h)
          return this.index(Math.floor((px - x) / plan.cell), plan.ny - 1 - Math.floor((py - y) / plan.cell), iz);
      return -1;
    };
    canvas.addEventListener("pointermove", (event) => { const v = find(event); if (v >= 0 && v !== this.at && this.values) this.#say(v); });
    canvas.addEventListener("click", (event) => { const v = find(event); if (v >= 0 && this.values) { this.#say(v); this.#take(); } });
    canvas.addEventListener("keydown", (event) => {
      const [nx, ny, nz] = this.study.meta.shape, by = { ArrowLeft: -ny * nz, ArrowRight: ny * nz, ArrowUp: nz, ArrowDown: -nz, PageUp: 1, PageDown: -1 }[event.key];
      if (by && this.values) { const next = (this.at < 0 ? this.index(nx >> 1, ny >> 1, 0) : this.at) + by; if (next >= 0 && next < nx * ny * nz) this.#say(next); }
      else if (event.key === "Enter" || event.key === " ") this.#take();
      else return;
      event.preventDefault();
    });
  }
};
