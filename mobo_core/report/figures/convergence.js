// Hypervolume over the trials told.
mobo.view("hypervolume", (root, data, study) => {
  const { counts, volumes, startup } = data;
  if (!volumes.length) return;
  const n = counts.at(-1), last = volumes.at(-1);
  mobo.drawn(root, (box, width) => {
  const chart = new mobo.Chart(box, { width, height: 280, title: "hypervolume over trials", xLabel: "trials told", yLabel: "hypervolume [share of the box]", x: [0, n], y: [0, 1.12 * last || 1] });
  chart.svg.append(mobo.el("rect", { x: chart.toX(0), y: chart.inner.top, width: chart.toX(Math.min(startup, n)) - chart.toX(0), height: chart.inner.height, fill: "var(--soft)" }));
  chart.axes().line([[0, 0], ...counts.map((count, i) => [count, volumes[i]])], "var(--accent)", { step: true, area: true });
  chart.text(chart.toX(n) - 4, chart.toY(last) - 7, last.toFixed(4), { anchor: "end" });
  });
  root.append(mobo.el("p.note", {}, `Shaded: the ${Math.min(startup, n)} trials drawn at random.`));
});
