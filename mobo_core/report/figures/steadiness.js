// How steady the front is: its arms and those near it, larger the more often they are on it.
mobo.view("steadiness", (root, data, study) => {
  const { el, fixed } = mobo;
  const arms = data.arms.map(([trial, share, front]) => ({ row: study.rowOf.get(trial), trial, share, front })).filter((one) => one.row !== undefined);
  const box = el("div.columns"), [left, right] = [el("div"), el("div")];
  box.append(left, right);
  const steady = arms.filter((one) => one.front && one.share >= 0.5).length, front = arms.filter((one) => one.front).length;
  root.append(el("p", {}, `${steady} of the ${front} arms of the front are on it in at least half of ${data.resamples} resamples.`), box);
  const [x, y] = study.meta.objectives.map((name) => study.columns.get(name)), range = (values) => [Math.min(...values), Math.max(...values)];
  const pad = ([a, b]) => [a - 0.05 * (b - a), b + 0.05 * (b - a)];
  mobo.drawn(left, (place, width) => {
  const chart = new mobo.Chart(place, { width, height: 380, title: "arms by how often they are on the front", xLabel: `${x.label}${x.unit ? ` [${x.unit}]` : ""}`, yLabel: `${y.label}${y.unit ? ` [${y.unit.split(",")[0]}]` : ""}`,
    x: pad(range(arms.map((one) => x.values[one.row]))), y: pad(range(arms.map((one) => y.values[one.row]))) }).axes();
  for (const one of arms.slice().sort((a, b) => a.front - b.front)) {
    const [cx, cy, r] = [chart.toX(x.values[one.row]), chart.toY(y.values[one.row]), 1.6 + 6 * Math.sqrt(one.share)];
    // Shape tells the front too, for those who cannot tell the colours.
    const [shape, places] = one.front ? ["circle.dot", { cx, cy, r }] : ["rect.dot", { x: cx - 0.9 * r, y: cy - 0.9 * r, width: 1.8 * r, height: 1.8 * r }];
    const dot = el(shape, { ...places, fill: one.front ? "var(--accent)" : "var(--others)", opacity: 0.8 },
      el("title", {}, `${study.order(one.row)}, trial ${one.trial}: ${Math.round(100 * one.share)} %`));
    dot.addEventListener("click", () => study.choose(one.row, { reveal: true }));
    chart.svg.append(dot);
  }
  }, 640);
  mobo.sortedTable(right, [
    { name: "share", title: "of resamples", number: true, value: (one) => one.share, text: (one) => `${fixed(100 * one.share, 1)} %` },
    { name: "trial", title: "trial", number: true, value: (one) => one.trial, text: (one) => mobo.armButton(study, one.row) },
    { name: "order", title: "joints", value: (one) => study.order(one.row), text: (one) => study.order(one.row) },
    { name: "reach", title: "reach", number: true, value: (one) => study.raw.reach[one.row], text: (one) => `${fixed(study.raw.reach[one.row], 2)} \u00b1 ${fixed(study.raw.reach_se[one.row], 2)}` },
    { name: "torque", title: "torque [N m]", number: true, value: (one) => study.raw.torque[one.row], text: (one) => `${fixed(study.raw.torque[one.row], 1)} \u00b1 ${fixed(study.raw.torque_se[one.row], 1)}` },
    { name: "front", title: "on the front", value: (one) => (one.front ? 1 : 0), text: (one) => (one.front ? "yes" : "near") },
  ], arms, { by: "share", most: 14 });
});
