// Time per stage, and how the evaluators shared the trials.
mobo.view("stages", (root, data) => {
  const { el } = mobo, box = el("div.columns"), [left, right] = [el("div"), el("div")];
  box.append(left, right);
  root.append(box);
  const ms = (s) => (s >= 1 ? `${mobo.short(s)} s` : `${mobo.short(1000 * s)} ms`);
  mobo.bars(left, data.stages.map((one) => ({ label: one.name, value: one.median, text: ms(one.median), colour: one.colour })), { title: "median of a trial" });
  left.append(el("dl.meanings", {}, data.stages.flatMap((one) => [el("dt", {}, one.name), el("dd", {}, `${one.meaning}; ${ms(one.total)} in all, of ${mobo.count(one.trials)} trials`)])));
  const all = data.shares.reduce((a, b) => a + b, 0) || 1;
  mobo.bars(right, data.shares.map((count, i) => ({ label: `evaluator ${i + 1}`, value: count, text: `${mobo.count(count)} (${Math.round((100 * count) / all)} %)` })), { title: "trials by evaluator" });
});
