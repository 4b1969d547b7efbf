// All there is to know of one arm: itself in 3D, numbers, voxel maps, torques, commands, its URDF.
mobo.Card = class {
  constructor(root, study, { heading = "h3" } = {}) {
    Object.assign(this, { study, heading, row: -1 });
    const { el } = mobo;
    this.head = el("div.cardhead");
    this.numbers = el("dl.numbers");
    this.stage = el("div.stage");
    this.viewer = new mobo.Viewer(this.stage, study);
    this.poses = el("div.poses", { role: "group", "aria-label": "configurations" });
    this.posesNote = el("div.note");
    this.maps = el("div.maps");
    this.voxelMaps = new mobo.VoxelMaps(this.maps, study, { pick: (voxel, centre) => this.#reachFor(voxel, centre) });
    this.mapsNote = el("div.note");
    this.torques = el("div.torques");
    this.files = el("div.files");
    root.append(el("article.card", { tabindex: -1 }, this.head, this.numbers, this.stage, this.poses, this.posesNote, this.maps, this.mapsNote, this.torques, this.files));
    this.root = root.lastElementChild;
  }

  async show(row) {
    if (row === this.row) return;
    this.row = row;
    this.#head();
    this.#numbers();
    this.#files();
    const [text, held, voxels] = await Promise.all([mobo.urdf.of(this.study, row), this.study.held(row), this.study.voxels(row)]);
    if (row !== this.row) return; // another was chosen meanwhile
    this.held = held;
    this.#stage(text, held);
    this.#maps(voxels, held);
    this.#torques(held);
    this.#download(text);
  }
  refresh() { if (this.row >= 0) this.#head(); }

  #head() {
    const { study, row } = this, { el } = mobo, { raw, meta } = study, order = study.order(row);
    const badges = [];
    if (raw.front[row]) badges.push(raw.useful[row] ? "Pareto front" : "raw front");
    for (const one of meta.known) if (study.order(one.row) === order) badges.push(`order of ${one.name}`);
    if (meta.twins[order]) badges.push(`mirror twin of ${meta.twins[order]}`);
    const pinned = study.isPinned(row);
    const sampled = study.orders[raw.sampled[row]];
    this.head.replaceChildren(...[
      el("div.title", {}, el(this.heading, {}, mobo.orderChips(meta, order), el("span.trial", {}, `trial ${raw.trial[row]}`)),
        el("button.pin", { type: "button", "aria-pressed": String(pinned), onclick: () => study.pin(row) }, pinned ? "Pinned" : "Pin")),
      badges.length ? el("div.badges", {}, badges.map((text) => el("span.badge", {}, text))) : null,
      sampled !== order ? el("div.note", {}, `drawn as ${sampled}`) : null].filter(Boolean));
  }

  #numbers() {
    const { study, row } = this, { el, fixed } = mobo, { raw, meta } = study;
    const pair = (name, value, more) => el("div", {}, el("dt", {}, name), el("dd", {}, el("b", {}, value), more ? el("span", {}, ` ${more}`) : null));
    const sure = (se, digits) => (Number.isFinite(se) ? `\u00b1 ${fixed(se, digits)}` : "");
    const steady = meta.steady[raw.trial[row]];
    this.numbers.replaceChildren(
      pair(`reach of ${meta.voxels}`, fixed(raw.reach[row], 2), sure(raw.reach_se[row], 2)),
      pair("torque [N m]", fixed(raw.torque[row], 1), sure(raw.torque_se[row], 1)),
      ...Object.entries(meta.further).map(([name, unit]) => pair(`${name.replaceAll("_", " ")} [${unit}]`, mobo.short(raw[`extra:${name}`][row]))),
      steady !== undefined ? pair("on the front in", `${Math.round(100 * steady)} %`, "of resamples") : pair("evaluated in", `${fixed(raw.seconds[row] * 1000, 0)}`, "ms"),
      el("div.wide", {}, el("dt", {}, "links"), el("dd", {}, mobo.strip(study, row, 330))));
  }

  #stage(text, held) {
    const { study, row } = this, { el } = mobo;
    this.viewer.order = study.order(row);
    this.poses.replaceChildren();
    this.posesNote.textContent = "";
    if (text === null) {
      this.stage.hidden = true;
      this.posesNote.textContent = "The recorded URDF was made by other macros than this mobo has: the command below gives it.";
      return;
    }
    this.stage.hidden = false;
    let robot;
    try { robot = new mobo.Robot(text); } catch { this.stage.hidden = true; this.posesNote.textContent = "The recorded URDF is not readable."; return; }
    this.robot = robot;
    this.voxelMaps.total = robot.total;
    const four = held?.four.length ? held.four : mobo.randomPoses(study, robot, 4);
    this.viewer.show(robot, four[0]?.slice());
    const straight = robot.moving.map((_, i) => Math.min(Math.max(0, robot.lower[i]), robot.upper[i]));
    [straight, ...four].forEach((q, i) => {
      const button = el("button.pose", { type: "button", "aria-label": i ? `configuration ${i}` : "straight", onclick: () => this.viewer.pose(q) });
      this.poses.append(button);
      new mobo.Viewer(button, study, { sliders: false, small: true }).show(robot, q);
      button.append(el("span", {}, i ? String(i) : "straight"));
    });
    this.posesNote.textContent = held?.four.length ? "1 to 4: random configurations at which it reaches a pose." : "1 to 4: random configurations free of self-collision (not evaluated again for this page).";
  }

  #maps(voxels, held) {
    const { given } = this.study.meta, none = voxels === null || given;
    this.maps.hidden = none;
    this.mapsNote.textContent = given ? "The poses of this study are given: there are no voxels to show." : none ? "This page has no room for the voxels of this arm; the command below gives them."
      : held?.ofVoxel ? "Click a voxel to see how the arm reaches it." : "";
    if (!none) this.voxelMaps.show(voxels);
  }
  #reachFor(voxel, centre) {
    const q = this.held?.ofVoxel(voxel);
    if (q) this.viewer.pose(q, centre);
    else if (this.held) this.viewer.pose(this.viewer.q.slice(), centre);
  }

  #torques(held) {
    const { el, fixed } = mobo, { study, row } = this, order = study.order(row);
    this.torques.replaceChildren();
    if (!held) {
      this.torques.append(el("p.note", {}, "Torque per joint: evaluated for the front, the best of each order and pinned trials (mobo report --pin N); the command below gives it for this arm."));
      return;
    }
    const most = Math.max(...held.torques.peak.filter(Number.isFinite), 1e-9);
    const bar = (value, kind) => el(`i.${kind}`, { style: `width:${Number.isFinite(value) ? (100 * value) / most : 0}%` });
    this.torques.append(el("table.bars", {},
      el("caption", {}, "Torque each joint holds against gravity [N m], over the poses reached"),
      el("thead", {}, el("tr", {}, ["joint", "mean", "95 %", "peak", ""].map((t, i) => el(i && i < 4 ? "th.n" : "th", { scope: "col" }, t)))),
      el("tbody", {}, held.torques.mean.slice(0, order.length).map((mean, i) => {
        const [fill, ink] = mobo.jointColours(study.meta, order[i]);
        return el("tr", {}, el("td", {}, el("i.jointchip", { style: `background:${fill};color:${ink}` }, order[i])),
          ...[mean, held.torques.p95[i], held.torques.peak[i]].map((v) => el("td.n", {}, fixed(v, 2))),
          el("td.bar", { "aria-hidden": "true" }, bar(held.torques.peak[i], "peak"), bar(held.torques.p95[i], "p95"), bar(mean, "mean")));
      }))));
    if (!held.same) this.torques.append(el("p.note", {}, "Evaluated again, this arm has another reach or torque than was recorded."));
  }

  #files() {
    const { study, row } = this, { el } = mobo, trial = study.raw.trial[row];
    const command = (label, text) => el("div.command", {}, el("span.note", {}, label), el("code", { tabindex: 0 }, text), mobo.copyButton(text));
    this.link = el("button.primary", { type: "button", disabled: true }, "Download URDF");
    this.files.replaceChildren(
      command("Evaluate again", `mobo evaluate ${study.meta.bag} --trial ${trial}`),
      command("Its URDF", `mobo export urdf ${study.meta.bag} --trial ${trial} -o ${this.name()}`), this.link);
  }
  name() { return `${this.study.order(this.row).replace(/[^A-Za-z0-9]/g, "_")}_trial${this.study.raw.trial[this.row]}.urdf`; }
  #download(text) {
    if (text === null) { this.link.hidden = true; return; }
    this.link.disabled = false;
    this.link.addEventListener("click", () => {
      const url = URL.createObjectURL(new Blob([text], { type: "application/xml" }));
      const anchor = mobo.el("a", { href: url, download: this.name() });
      document.body.append(anchor);
      anchor.click();
      anchor.remove();
      setTimeout(() => URL.revokeObjectURL(url), 10000);
    });
  }
};

// Random configurations free of self-collision, the same each time for an arm.
mobo.randomPoses = (study, robot, count) => {
  let seed = (study.raw.trial[study.chosen < 0 ? 0 : study.chosen] * 2654435761 + 12345) >>> 0;
  const draw = () => { // Marsaglia's xorshift
    seed ^= seed << 13; seed >>>= 0; seed ^= seed >>> 17; seed ^= seed << 5; seed >>>= 0;
    return seed / 4294967296;
  };
  const found = [];
  for (let i = 0; i < 200 && found.length < count; i++) {
    const q = robot.lower.map((low, k) => low + draw() * (robot.upper[k] - low));
    if (!robot.colliding(robot.place(q)).size) found.push(q);
  }
  return found;
};
