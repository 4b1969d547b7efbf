// Structures: the highest-reach arm of each prefix side by side, the front of each in one picture, and two tables.
mobo.view("structures", (root, data, study) => {
  const { el, fixed } = mobo, { meta } = study;
  const styleOf = (name) => meta.styles[study.styleOf.get(name.slice(0, 4))];
  const mark = (name) => {
    const style = styleOf(name);
    return mobo.marks.icon(style?.marker ?? "o", style ? (mobo.theme.dark ? style.dark : style.colour) : "var(--others)");
  };

  // ---- the best arms
  const gallery = el("div.gallery");
  const shown = [...meta.styles.map((style) => data.prefixes.find((one) => one.name === style.prefix)).filter(Boolean)];
  for (const one of shown) {
    const row = study.rowOf.get(one.best);
    if (row === undefined) continue;
    const button = el("button", { type: "button", title: "show this arm", onclick: () => study.choose(row, { reveal: true }) });
    gallery.append(button);
    const viewer = new mobo.Viewer(button, study, { sliders: false, small: true });
    button.append(el("span.text", {}, mark(one.name), " ", el("b", {}, study.order(row)), el("span.note", {}, `reach ${fixed(study.raw.reach[row], 1)}, ${fixed(study.raw.torque[row], 0)}\u00a0N\u00a0m`)));
    const watch = new IntersectionObserver(async ([seen]) => {
      if (!seen.isIntersecting) return;
      watch.disconnect();
      const [text, held] = await Promise.all([mobo.urdf.of(study, row), study.held(row)]);
      if (text !== null) viewer.show(new mobo.Robot(text), held?.four[0] ?? null);
    }, { rootMargin: "200px" });
    watch.observe(button);
  }
  root.append(el("h3", {}, "The arm of the highest reach of each prefix"), gallery);

  // ---- fronts
  const draw = (picture, width) => {
    const all = data.prefixes.flatMap((one) => one.steps);
    if (!all.length) return;
    const most = (k) => Math.max(...all.map((point) => point[k])), colourOf = (style) => (style ? (mobo.theme.dark ? style.dark : style.colour) : "var(--others)");
    const chart = new mobo.Chart(picture, {
      height: 420, width, right: 62, title: "the least torque of each prefix for a reach", xLabel: `reach [of ${meta.voxels} voxels]`, yLabel: "least torque [N m]",
      x: [Math.min(...all.map((point) => point[0])) - 0.5, 1.02 * most(0)], y: [0, 1.05 * most(1)],
    }).axes();
    for (const one of data.prefixes.slice().reverse()) {
      const style = styleOf(one.name);
      if (!one.steps.length) continue;
      // Along the steps from low reach to high, the torque is that of the next arm.
      const steps = one.steps.flatMap(([x, y], i) => (i ? [[one.steps[i - 1][0], y], [x, y]] : [[x, y]]));
      chart.line(steps, colourOf(style), { width: style ? 2 : 0.8 });
      if (style) chart.points(one.steps.length > 40 ? one.steps.filter((_, i) => i % 3 === 0 || i === one.steps.length - 1) : one.steps, colourOf(style), style.marker);
    }
    // Names in a column at the right, in the order of the ends, a line apart; a thin line leads to each.
    const line = 15, { left, top, width: w, height: h } = chart.inner, ends = shown.filter((one) => one.steps.length)
      .map((one) => ({ one, x: chart.toX(one.steps.at(-1)[0]), y: chart.toY(one.steps.at(-1)[1]) })).sort((a, b) => a.y - b.y);
    ends.forEach((end, i) => { end.at = Math.max(end.y, i ? ends[i - 1].at + line : top + 6); });
    for (let i = ends.length - 1, low = top + h - 2; i >= 0; i--, low -= line) ends[i].at = Math.min(ends[i].at, low);
    for (const { one, x, y, at } of ends) {
      chart.svg.append(el("path", { d: `M${x + 6} ${y}L${left + w + 2} ${at}`, fill: "none", stroke: colourOf(styleOf(one.name)), "stroke-width": 1, "stroke-dasharray": "2 3" }),
        el("path", { d: mobo.marks.path(styleOf(one.name).marker, 4, left + w + 9, at), fill: colourOf(styleOf(one.name)) }));
      chart.text(left + w + 17, at + 4, one.name);
    }
  };
  root.append(el("h3", {}, "The front of each prefix"));
  mobo.drawn(root, draw, 1100);

  // ---- tables
  let wanted = Math.round(0.7 * Math.max(...study.raw.reach));
  const least = new Map(); // name -> least torque of the arms that reach so much
  const count = () => {
    least.clear();
    for (let row = 0; row < study.n; row++) {
      if (study.raw.reach[row] < wanted) continue;
      for (const name of [study.prefix(row), study.order(row)]) least.set(name, Math.min(least.get(name) ?? Infinity, study.raw.torque[row]));
    }
  };
  count();
  const best = (one) => study.rowOf.get(one.best);
  const columns = (what) => [
    { name: "name", title: what, value: (one) => one.name, text: (one) => el("span", {}, mark(one.name), ` ${one.name}`) },
    { name: "arms", title: "arms", number: true, value: (one) => one.arms, text: (one) => mobo.count(one.arms) },
    { name: "reach", title: "best reach", number: true, value: (one) => study.raw.reach[best(one)], text: (one) => fixed(study.raw.reach[best(one)], 2) },
    { name: "trial", title: "trial", number: true, value: (one) => one.best, text: (one) => mobo.armButton(study, best(one)) },
    { name: "least", title: "least torque at that reach", number: true, value: (one) => least.get(one.name) ?? NaN, text: (one) => fixed(least.get(one.name) ?? NaN, 1) },
    { name: "share", title: "share of front", number: true, value: (one) => one.share, text: (one) => (one.share ? `${fixed(100 * one.share, 0)} %` : "\u2013") },
    { name: "contribution", title: "hypervolume only it gives", number: true, value: (one) => one.contribution, text: (one) => (one.contribution ? one.contribution.toFixed(4) : "\u2013") },
    { name: "hypervolume", title: "hypervolume alone", number: true, value: (one) => one.hypervolume, text: (one) => one.hypervolume.toFixed(4) },
    { name: "zero", title: "zero-length links", number: true, value: (one) => one.zero, text: (one) => String(one.zero) },
    { name: "axes", title: "distinct axes", number: true, value: (one) => one.axes, text: (one) => String(one.axes) },
    ...(what === "prefix" ? [] : [{ name: "twin", title: "exact mirror twin", value: (one) => one.twin, text: (one) => one.twin || "" }]),
  ];
  const input = el("input", { type: "number", min: 0, max: meta.voxels, step: 1, value: wanted, "aria-label": "reach for the least torque" });
  root.append(el("h3", {}, "In numbers"), el("p", {}, el("label.field", {}, "least torque of arms that reach ", input, ` of ${meta.voxels} voxels`)),
    el("p.note", {}, "Links and axes are those of the arm of the highest reach; two joints within 1 mm are at one place. Exact mirror twins are each other's reflection, Roll and Pitch exchanged: what they differ in is noise of the poses and of the search."));
  const tables = [];
  tables.push(mobo.sortedTable(root, columns("prefix"), data.prefixes, { by: "reach", tall: true }));
  const more = el("details", {}, el("summary", {}, `All ${data.orders.length} joint orders`));
  root.append(more);
  more.addEventListener("toggle", () => { if (more.open && tables.length === 1) tables.push(mobo.sortedTable(more, columns("joint order"), data.orders, { by: "reach" })); });
  input.addEventListener("input", () => { wanted = Number(input.value) || 0; count(); for (const table of tables) table.show(); });
});
