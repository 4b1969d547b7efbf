// An arm in a few lines: as text, as a tip, its joints, its links.
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
mobo.strip = (study, row, width = 250) => mobo.stripOf(study.meta, study.order(row), study.lengths(row), width);
mobo.stripOf = (meta, order, found, width = 250) => {
  const { el } = mobo, lengths = found.map((length) => length || 0);
  const total = lengths.reduce((a, b) => a + b, 0) || 1, right = 12, step = 13;
  const x = (at) => 9 + (at / total) * (width - 9 - right);
  const joints = [];
  let at = 0, last = -Infinity;
  for (let i = 0; i < order.length; i++) {
    const cx = Math.max(x(at), last + step);
    joints.push([cx, order[i]]);
    last = cx;
    at += lengths[i] ?? 0;
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
