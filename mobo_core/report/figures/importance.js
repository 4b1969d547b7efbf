// Importance of the sampler's parameters, for each objective.
mobo.view("importance", (root, data, study) => {
  const box = mobo.el("div.columns");
  root.append(box);
  const most = Math.max(...Object.values(data).flatMap((values) => Object.values(values)));
  for (const [name, values] of Object.entries(data)) {
    const part = mobo.el("div");
    box.append(part);
    mobo.bars(part, Object.entries(values).map(([label, value]) => ({ label, value, text: mobo.fixed(value, 3) })), { title: `for ${name.replaceAll("_", " ")}`, most });
  }
});
