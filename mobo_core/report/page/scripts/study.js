// The arms of the study, which of them are shown, chosen and pinned. Arms are named by their row, 0 to n - 1.
mobo.Study = class extends mobo.Events {
  static async read() {
    const meta = mobo.json("meta");
    const columns = await mobo.arrays(mobo.json("columns"));
    return new mobo.Study(meta, columns);
  }

  constructor(meta, columns) {
    super();
    Object.assign(this, { meta, n: columns.trial.length, joints: meta.joints, raw: columns });
    this.orders = meta.orders;
    this.prefixOf = meta.orders.map((order) => order.slice(0, 4));
    this.styleOf = new Map(meta.styles.map((style, i) => [style.prefix, i]));
    this.style = Uint8Array.from(columns.order, (o) => this.styleOf.get(this.prefixOf[o]) ?? meta.styles.length);
    this.rowOf = new Map(Array.from(columns.trial, (trial, row) => [trial, row]));
    this.evaluated = new Map(meta.evaluated.map((row, i) => [row, i]));
    this.columns = this.#columns();
    this.shown = new Uint8Array(this.n).fill(1);
    this.nShown = this.n;
    this.filter = { hidden: new Set(), order: "", front: false, useful: false, ranges: {} };
    this.chosen = -1;
    this.pins = [];
    this.groups = new Map();
    this.realArms = []; // names, joints, values by name of the column, hollow: set by the sampling picture
  }

  order(row) { return this.orders[this.raw.order[row]]; }
  prefix(row) { return this.prefixOf[this.raw.order[row]]; }
  lengths(row) { return Array.from({ length: Math.min(this.order(row).length, this.joints) }, (_, i) => this.raw.lengths[i * this.n + row]); }
  value(name, row) { return this.columns.get(name).values[row]; }

  // Name -> {label, unit, values}: what can be an axis or be filtered by.
  #columns() {
    const { raw, n, meta } = this, found = new Map();
    const add = (name, label, unit, values) => found.set(name, { name, label, unit, values });
    add("reach", "reach", `of ${meta.voxels} voxels`, raw.reach);
    add("torque", "torque", "N m, summed over voxels", raw.torque);
    for (const [name, unit] of Object.entries(meta.further)) add(name, name.replaceAll("_", " "), unit, raw[`extra:${name}`]);
    for (let i = 0; i < this.joints; i++) add(`length_${i + 1}`, `length ${i + 1}`, "m", raw.lengths.subarray(i * n, (i + 1) * n));
    const axes = new Uint8Array(n), zero = new Uint8Array(n);
    for (let row = 0; row < n; row++) {
      for (let i = 0; i < this.joints - 1; i++) zero[row] += raw.lengths[i * n + row] < meta.same_place;
      axes[row] = this.joints - zero[row];
    }
    add("zero", "joints at the place of the next", "", zero);
    if (!found.has("axes")) add("places", "distinct axes", "places", axes);
    for (const name of ["base_height", "base_tilt"])
      if (raw[name]) add(name, name.replace("_", " "), name === "base_tilt" ? "rad" : "m", raw[name]);
    this.meta.centers.forEach((_, i) => {
      const values = raw[`joint_center_${i + 1}`];
      if (values) add(`joint_center_${i + 1}`, `centre of joint ${i + 1}`, "rad", values);
    });
    add("trial", "trial", "", raw.trial);
    add("seconds", "seconds of evaluation", "s", raw.seconds);
    return found;
  }

  setFilter(change) {
    Object.assign(this.filter, change);
    const { hidden, order, front, useful, ranges } = this.filter, { raw, style, shown } = this;
    const wanted = order.toUpperCase();
    const fits = this.orders.map((name) => !wanted || (wanted.includes("*") || wanted.includes("?")
      ? mobo.glob(wanted, name) : name.startsWith(wanted)));
    const others = this.meta.styles.length;
    const out = new Uint8Array(others + 1);
    for (const i of hidden) out[i] = 1;
    const bounds = Object.entries(ranges).map(([name, [low, high]]) => [this.columns.get(name).values, low, high]);
    this.nShown = 0;
    for (let row = 0; row < this.n; row++) {
      let show = !out[style[row]] && fits[raw.order[row]] && (!front || raw.front[row]) && (!useful || raw.useful[row]);
      for (let k = 0; show && k < bounds.length; k++) {
        const value = bounds[k][0][row];
        show = value >= bounds[k][1] && value <= bounds[k][2];
      }
      shown[row] = show ? 1 : 0;
      this.nShown += shown[row];
    }
    this.emit("filter");
    mobo.say(`${mobo.count(this.nShown)} of ${mobo.count(this.n)} arms shown`);
  }

  choose(row, { reveal = false } = {}) {
    if (row < 0 || row >= this.n) return;
    this.chosen = row;
    this.emit("choose", { row, reveal });
    this.#note();
  }

  isPinned(row) { return this.pins.includes(row); }
  pin(row) { // two at most: a third takes the place of the older one
    this.pins = this.isPinned(row) ? this.pins.filter((one) => one !== row) : [...this.pins, row].slice(-2);
    this.emit("pin");
    this.#note();
    mobo.say(this.isPinned(row) ? `trial ${this.raw.trial[row]} pinned` : `trial ${this.raw.trial[row]} taken off`);
  }

  // The address names what is chosen and pinned, so that it can be kept.
  #note() {
    const parts = [];
    if (this.chosen >= 0) parts.push(`arm=${this.raw.trial[this.chosen]}`);
    if (this.pins.length) parts.push(`pins=${this.pins.map((row) => this.raw.trial[row]).join(",")}`);
    try { history.replaceState(null, "", `#${parts.join("&")}`); } catch { /* some browsers refuse it for files */ }
  }
  readAddress() {
    const noted = new URLSearchParams(location.hash.slice(1));
    const rows = (text) => (text || "").split(",").filter(Boolean).map((t) => this.rowOf.get(Number(t))).filter((row) => row !== undefined);
    this.pins = rows(noted.get("pins")).slice(-2);
    const [chosen] = rows(noted.get("arm"));
    return chosen ?? this.meta.first;
  }

  // Voxels of an arm, or null if the page has no room for them.
  async voxels(row) {
    this.places ??= new Map(this.meta.voxel_groups.flatMap((rows, g) => rows.map((one, i) => [one, [g, i]])));
    const place = this.places.get(row);
    if (!place) return null;
    const [g, i] = place;
    if (!this.groups.has(g)) this.groups.set(g, mobo.lateArrays(`voxels-${g}`));
    const found = await this.groups.get(g);
    const V = this.meta.voxels, poses = this.meta.poses;
    const cut = (name) => found[name].subarray(i * V, (i + 1) * V);
    const reach = cut("reach"), low = cut("torque_low"), high = cut("torque_high");
    const out = cut("out_of_range"), hit = cut("in_collision");
    const share = (counts) => Float64Array.from(counts, (c) => c / poses);
    return {
      reach: share(reach),
      torque: Float64Array.from(low, (l, v) => (reach[v] ? (l + 256 * high[v]) * this.meta.torque_step : NaN)),
      out_of_range: share(out),
      in_collision: share(hit),
      not_converged: Float64Array.from(reach, (r, v) => (poses - r - out[v] - hit[v]) / poses),
    };
  }

  // What was evaluated again: torques of the joints and configurations, or null.
  async held(row) {
    const i = this.evaluated.get(row);
    if (i === undefined) return null;
    this.heldArrays ??= mobo.lateArrays("held");
    const found = await this.heldArrays, n = this.joints, V = this.meta.voxels;
    const rows = (name, count) => Array.from({ length: count }, (_, k) =>
      Array.from(found[name].subarray((i * count + k) * n, (i * count + k + 1) * n)));
    const [mean, p95, peak] = rows("torques", 3);
    const stored = i < this.meta.with_voxel_q ? found.voxel_q : null;
    return {
      same: !!found.same[i],
      torques: { mean, p95, peak },
      four: rows("four", 4).filter((q) => q.every(Number.isFinite)),
      ofVoxel: (voxel) => {
        if (!stored) return null;
        const q = Array.from(stored.subarray((i * V + voxel) * n, (i * V + voxel + 1) * n));
        return q[0] === -32768 ? null : q.map((v) => v * this.meta.q_step);
      },
    };
  }
};

mobo.glob = (pattern, text) => {
  const escaped = pattern.replace(/[^A-Z*?]/g, "").replaceAll("*", "[A-Z]*").replaceAll("?", "[A-Z]");
  return new RegExp(`^${escaped}$`).test(text);
};
