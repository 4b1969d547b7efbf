// Lengths: where the joints of the best arms of each prefix sit along the arm, and clusters of proportions.
mobo.view("lengths", (root, data, study) => {
  const { el } = mobo, { meta } = study;
  const draw = (picture, W) => {
    const line = 52, H = line * data.prefixes.length + 34, left = 70, right = W < 480 ? 92 : 150;
    const x = (share) => left + share * (W - left - right);
    const svg = el("svg.chart.joints", { viewBox: `0 0 ${W} ${H}`, width: W, height: H, role: "img", "aria-label": "joint positions along the best arms of each prefix" });
    data.prefixes.forEach((one, i) => {
      const style = meta.styles[study.styleOf.get(one.prefix)], colour = mobo.theme.dark ? style.dark : style.colour, y = 26 + i * line;
      svg.append(el("path", { d: mobo.marks.path(style.marker, 5, 10, y), fill: colour }), el("text.label", { x: 22, y: y + 4 }, one.prefix),
        el("line.rail", { x1: x(0), x2: x(1), y1: y, y2: y }));
      const n = one.places.length, joints = one.places[0].length;
      for (let j = 0; j < joints; j++) {
        one.places.forEach((places, k) => svg.append(el("circle", { cx: x(places[j]), cy: y + (n > 1 ? (k / (n - 1) - 0.5) * 30 : 0), r: 2.4, fill: colour, opacity: 0.7 })));
        const sorted = one.places.map((places) => places[j]).sort((a, b) => a - b), median = sorted[n >> 1];
        svg.append(el("line.median", { x1: x(median), x2: x(median), y1: y - 18, y2: y + 18 }));
      }
      const [text, count] = one.groups[0];
      svg.append(el("text.label", { x: x(1) + 14, y: y }, text.replaceAll("-", "\u2013")), el("text", { x: x(1) + 14, y: y + 14 }, `${count} of ${n} arms`));
    });
    for (const share of [0, 0.25, 0.5, 0.75, 1]) svg.append(el("text", { x: x(share), y: H - 4, "text-anchor": "middle" }, share === 0 ? "base" : share === 1 ? "tool" : `${100 * share} %`));
    picture.append(svg);
  };
  mobo.drawn(root, draw);
  root.append(el("p.note", {}, "To the right: how many joints sit together, from base to tool (2\u20131\u20133: two at the shoulder, one at the elbow, three at the wrist), joints within a tenth of the arm being together."));

  root.append(el("h3", {}, data.clusters.length > 1 ? `${data.clusters.length} clusters of proportions among the study's best arms` : "Proportions of the study's best arms: one cluster"));
  const list = el("div.clusters");
  for (const cluster of data.clusters) {
    const first = study.rowOf.get(cluster.trials[0]);
    list.append(el("div.cluster", {},
      el("div.proportions", { role: "img", "aria-label": cluster.shares.map((s) => `${Math.round(100 * s)} percent`).join(", ") },
        cluster.shares.map((share, i) => el("i", { style: `flex:${share}` }, share >= 0.055 ? `${Math.round(100 * share)}` : ""))),
      el("span.note", {}, `${cluster.trials.length} arms, such as `, first === undefined ? String(cluster.trials[0]) : mobo.armButton(study, first, `${study.order(first)} (trial ${cluster.trials[0]})`))));
  }
  root.append(list, el("p.note", {}, "Links from base to tool in percent of the arm's length, averaged over each cluster (k-means of the twentieth of arms that reaches most)."));
});
