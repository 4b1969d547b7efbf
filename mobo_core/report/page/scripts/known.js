// The known arms of a scatter: a mark at each, and its name where there is room. They are real arms, a diamond each at
// their twins' values, hollow if no source says their masses; without those, a cross at the best arm of each known order.
mobo.knownMarks = (scatter) => {
  const { study, xName, yName } = scatter;
  const at = (x, y) => ({ x: scatter.toX(x), y: scatter.toY(y) });
  if (study.realArms.length)
    return study.realArms.filter((arm) => xName in arm.values && yName in arm.values)
      .map((arm) => ({ arm, names: arm.names, ...at(arm.values[xName], arm.values[yName]) }));
  return study.meta.known.filter(({ row }) => study.shown[row])
    .map(({ row, name }) => ({ names: name.split(", "), ...at(scatter.x.values[row], scatter.y.values[row]) }));
};

// The real arm at a place in the plot; null if there is none.
mobo.knownAt = (scatter, px, py, within = 7) => {
  if (!scatter.known || !scatter.view) return null;
  const far = (mark) => Math.hypot(mark.x - px, mark.y - py);
  const near = mobo.knownMarks(scatter).filter((mark) => mark.arm && far(mark) < within);
  return near.length ? near.reduce((a, b) => (far(b) < far(a) ? b : a)).arm : null;
};

mobo.knownBrief = (study, arm) => {
  const { el, fixed } = mobo;
  return el("div", {},
    el("div.tiphead", {}, mobo.orderChips(study.meta, arm.joints), el("span", {}, arm.names.slice(0, 4).join(", ") + (arm.names.length > 4 ? ` +${arm.names.length - 4}` : ""))),
    el("div.pair", {}, el("span", {}, "reach"), el("b", {}, `${fixed(arm.values.reach, 2)} of ${study.meta.voxels}`)),
    el("div.pair", {}, el("span", {}, "torque"), el("b", {}, `${fixed(arm.values.torque, 1)} N m`)),
    mobo.stripOf(study.meta, arm.joints, Array.from(arm.joints, (_, i) => arm.values[`length_${i + 1}`])),
    el("div.note", {}, `${arm.names.length > 1 ? "their" : "its"} twin: joint order and ratio of lengths in the study's space`));
};

mobo.nameKnown = (scatter, context) => {
  const { left, top, width, height } = scatter.inner, ink = mobo.theme.colour("ink"), plot = mobo.theme.colour("plot");
  const inside = ({ x, y }) => x >= left && x <= left + width && y >= top && y <= top + height;
  const marks = mobo.knownMarks(scatter).filter(inside), groups = [];
  for (const mark of scatter.small ? [] : marks) { // what stands together has one name
    const group = groups.find(([first]) => Math.hypot(first.x - mark.x, first.y - mark.y) < 24);
    group ? group.push(mark) : groups.push([mark]);
  }
  const taken = [];
  context.font = `600 11.5px ${mobo.theme.colour("font")}`;
  context.textAlign = "left";
  for (const group of groups) {
    const { x, y } = group[0], names = group.flatMap((mark) => mark.names), all = names.join(", ");
    const name = names.length > 1 && context.measureText(all).width > 0.25 * width ? `${names[0]} +${names.length - 1}` : all;
    const w = context.measureText(name).width + 10, h = 19;
    for (let k = 0; k < 40; k++) {
      const a = (k % 10) * 0.628 - 1.2, d = 26 + 22 * Math.floor(k / 10);
      const bx = x + d * Math.cos(a) - (Math.cos(a) < 0 ? w : 0), by = y + d * Math.sin(a) - h / 2;
      const out = bx < left + 2 || bx + w > left + width - 2 || by < top + 2 || by + h > top + height - 2;
      if (out || taken.some(([tx, ty, tw]) => bx < tx + tw + 3 && bx + w + 3 > tx && by < ty + h + 2 && by + h + 2 > ty)) continue;
      context.strokeStyle = ink;
      context.lineWidth = 1.2;
      context.beginPath(); context.moveTo(x, y); context.lineTo(Math.min(Math.max(x, bx), bx + w), by + h / 2); context.stroke();
      context.fillStyle = plot;
      context.globalAlpha = 0.92;
      context.beginPath(); context.roundRect(bx, by, w, h, 4); context.fill();
      context.globalAlpha = 1;
      context.strokeStyle = mobo.theme.colour("line");
      context.stroke();
      context.fillStyle = ink;
      context.fillText(name, bx + 5, by + 13.5);
      taken.push([bx, by, w]);
      break;
    }
  }
  context.strokeStyle = ink;
  for (const { arm, x, y } of marks) {
    const r = scatter.compact ? 3.6 : 5;
    context.beginPath();
    if (arm) {
      context.moveTo(x - r, y); context.lineTo(x, y - r); context.lineTo(x + r, y); context.lineTo(x, y + r); context.closePath();
      context.fillStyle = arm.hollow ? plot : ink;
      context.fill();
    } else { context.moveTo(x - 5, y); context.lineTo(x + 5, y); context.moveTo(x, y - 5); context.lineTo(x, y + 5); }
    context.lineWidth = arm ? 1.3 : 1.8;
    context.stroke();
  }
};
