// The sampling picture: all arms, what is shown of them, and for three objectives every pair of them, and all at once.
mobo.view("sampling", (root, data, study) => {
  const { el } = mobo, { meta } = study;
  const objectives = meta.objectives;
  study.realArms = data ?? [];

  // ---- which arms are shown
  const counts = new Array(meta.styles.length + 1).fill(0);
  for (const style of study.style) counts[style]++;
  const names = [...meta.styles.map((style) => style.prefix), "others"];
  const chips = names.map((name, i) => {
    const style = meta.styles[i];
    const icon = () => mobo.marks.icon(style?.marker ?? "o", style ? (mobo.theme.dark ? style.dark : style.colour) : "var(--others)");
    const button = el("button.chip", { type: "button", "aria-pressed": "true", title: style ? "first four joints; click to hide, double-click to show only these" : "all other first joints" },
      icon(), el("span", {}, name), el("small", {}, mobo.count(counts[i])));
    mobo.theme.changed.on("change", () => button.firstElementChild.replaceWith(icon()));
    const show = () => chips.forEach((chip, k) => chip.setAttribute("aria-pressed", String(!study.filter.hidden.has(k))));
    button.addEventListener("click", () => {
      const hidden = new Set(study.filter.hidden);
      hidden.has(i) ? hidden.delete(i) : hidden.add(i);
      study.setFilter({ hidden });
    });
    button.addEventListener("dblclick", () => study.setFilter({ hidden: new Set(names.keys()).difference?.(new Set([i])) ?? new Set([...names.keys()].filter((k) => k !== i)) }));
    study.on("filter", show);
    button.hidden = !counts[i];
    return button;
  });
  const toggle = (label, name) => {
    const box = el("input", { type: "checkbox", onchange: () => study.setFilter({ [name]: box.checked }) });
    study.on("filter", () => { box.checked = study.filter[name]; });
    return el("label.check", {}, box, label);
  };
  const real = el("label.check", { title: "diamonds: real arms' twins in the study's space, hollow where no source says their masses" },
    el("input", { type: "checkbox", checked: true, onchange: (event) => {
      for (const scatter of mobo.scatters ?? [mobo.mainScatter]) { scatter.known = event.target.checked; scatter.drawOver(); }
    } }), "real arms");
  const order = el("input.order", { type: "search", placeholder: "PRRY, *PYP, Y?P*", "aria-label": "joint order begins with, or a pattern of * and ?", autocapitalize: "characters", spellcheck: "false" });
  order.addEventListener("input", () => study.setFilter({ order: order.value.trim() }));

  const rangesBox = el("div.ranges");
  const options = (chosen) => [...study.columns.values()].map((column) => el("option", { value: column.name, selected: column.name === chosen }, column.label));
  const addRange = (name) => {
    const column = study.columns.get(name);
    let low = Infinity, high = -Infinity;
    for (const v of column.values) if (Number.isFinite(v)) { low = Math.min(low, v); high = Math.max(high, v); }
    const field = (value, which) => el("input", { type: "number", step: "any", value: Number(value.toPrecision(6)), "aria-label": `${which} ${column.label}` });
    const [from, to] = [field(Math.floor(low * 1e4) / 1e4, "least"), field(Math.ceil(high * 1e4) / 1e4, "most")];
    const set = () => study.setFilter({ ranges: { ...study.filter.ranges, [name]: [from.value === "" ? -Infinity : Number(from.value), to.value === "" ? Infinity : Number(to.value)] } });
    for (const one of [from, to]) one.addEventListener("input", set);
    const line = el("div.range", {}, el("span", {}, column.label), from, el("span", {}, "to"), to, el("span.note", {}, column.unit.split(",")[0]),
      el("button.small", { type: "button", "aria-label": `no range of ${column.label}`, onclick: () => { line.remove(); const { [name]: _, ...ranges } = study.filter.ranges; study.setFilter({ ranges }); } }, "\u00d7"));
    line.dataset.column = name;
    for (const old of rangesBox.children) if (old.dataset.column === name) old.remove();
    rangesBox.append(line);
    from.focus();
  };
  const more = el("select", { "aria-label": "add a range of" }, el("option", { value: "" }, "range of \u2026"), options());
  more.addEventListener("change", () => { if (more.value) addRange(more.value); more.value = ""; });
  const shown = el("output.shown", { role: "status" });
  const all = el("button.small", { type: "button", onclick: () => {
    order.value = "";
    rangesBox.replaceChildren();
    study.setFilter({ hidden: new Set(), order: "", front: false, useful: false, ranges: {} });
  } }, "Show all");
  const tell = () => {
    shown.textContent = study.nShown === study.n ? `${mobo.count(study.n)} arms` : `${mobo.count(study.nShown)} of ${mobo.count(study.n)} arms`;
    all.hidden = study.nShown === study.n;
  };
  study.on("filter", tell);
  tell();
  root.append(
    el("div.legend", { role: "group", "aria-label": "first four joints" }, chips),
    el("div.filters", {}, el("label.field", {}, "order ", order), more, toggle("front only", "front"), toggle("above the reach floor", "useful"), study.realArms.length ? real : null, shown, all),
    rangesBox);

  // ---- the pictures
  const plot = el("div.plot");
  root.append(plot);
  const keys = () => el("p.note.keys", {}, "Drag to move, scroll or pinch to zoom, click a dot for its arm. Keys: arrows from arm to arm, Enter opens, P pins, + \u2212 0 zoom." + (objectives.join() === "reach,torque" ? " Better is to the lower right." : ""));
  if (objectives.length === 2) {
    const x = el("select", { "aria-label": "across" }, options(objectives[0])), y = el("select", { "aria-label": "up" }, options(objectives[1]));
    const scatter = mobo.mainScatter = new mobo.Scatter(plot, study, { x: objectives[0], y: objectives[1], known: true, title: "all arms by their objectives" });
    for (const one of [x, y]) one.addEventListener("change", () => scatter.setAxes(x.value, y.value));
    plot.append(el("div.tools", {}, el("label.field", {}, "across ", x), el("label.field", {}, "up ", y),
      el("span.grow"),
      el("button.small", { type: "button", "aria-label": "zoom in", onclick: () => scatter.zoom(0.75, scatter.width / 2, scatter.height / 2) }, "+"),
      el("button.small", { type: "button", "aria-label": "zoom out", onclick: () => scatter.zoom(1.33, scatter.width / 2, scatter.height / 2) }, "\u2212"),
      el("button.small", { type: "button", onclick: () => scatter.reset() }, "Whole")));
    root.append(keys());
  } else {
    const matrix = el("div.matrix");
    plot.append(matrix);
    const pairs = [[0, 1], [0, 2], [1, 2]];
    mobo.scatters = pairs.map(([a, b]) => new mobo.Scatter(matrix, study, { x: objectives[a], y: objectives[b], known: study.realArms.length > 0, small: true, title: `all arms by ${objectives[a]} and ${objectives[b]}` }));
    mobo.mainScatter = mobo.scatters[0];
    mobo.parallel(plot, study, [...objectives, ...Array.from({ length: study.joints }, (_, i) => `length_${i + 1}`)]);
    root.append(keys());
  }
});
