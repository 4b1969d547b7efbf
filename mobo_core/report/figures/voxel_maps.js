// Voxel maps of the highest-reach arm of each prefix, all of one kind, which can be changed.
mobo.view("voxels", (root, data, study) => {
  const { el, fixed } = mobo, { meta } = study, { tabs, key } = new mobo.VoxelMaps(el("div"), study), all = [];
  const grid = el("div.maparms");
  for (const tab of tabs.children) tab.addEventListener("click", () => { for (const maps of all) maps.choose(tab.dataset.kind); });
  for (const [prefix, trial] of data.arms) {
    const row = study.rowOf.get(trial), style = meta.styles[study.styleOf.get(prefix)];
    if (row === undefined) continue;
    const icon = () => mobo.marks.icon(style?.marker ?? "o", style ? (mobo.theme.dark ? style.dark : style.colour) : "var(--others)");
    const head = el("div.maphead", {}, icon(), mobo.armButton(study, row, study.order(row)),
      el("span.note", {}, `reach ${fixed(study.raw.reach[row], 1)}, ${fixed(study.raw.torque[row], 0)}\u00a0N\u00a0m`));
    mobo.theme.changed.on("change", () => head.firstElementChild.replaceWith(icon()));
    const box = el("div.maparm", {}, head, mobo.strip(study, row, 330)), maps = new mobo.VoxelMaps(box, study, { alone: false });
    maps.total = study.lengths(row).reduce((a, b) => a + b, 0);
    if (all.length === 0) maps.key = key; // one for all of them
    all.push(maps);
    grid.append(box);
    const watch = new IntersectionObserver(async ([seen]) => {
      if (!seen.isIntersecting) return;
      watch.disconnect();
      const values = await study.voxels(row);
      if (values) maps.show(values); else box.append(el("p.note", {}, "This page has no room for its voxels."));
    }, { rootMargin: "200px" });
    watch.observe(box);
  }
  root.append(tabs, grid, key);
});
