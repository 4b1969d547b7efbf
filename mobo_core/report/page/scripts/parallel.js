// Parallel coordinates: a line for each shown arm; drag along an axis to keep the arms within, click it to keep all.
mobo.parallel = (root, study, names) => {
  const { el } = mobo, columns = names.map((name) => study.columns.get(name)).filter(Boolean);
  const canvas = el("canvas.parallel", { role: "img", "aria-label": "parallel coordinates of objectives and lengths; ranges can be set above too" });
  root.append(el("div.parallelbox", {}, canvas), el("p.note", {}, "Drag along an axis to keep the arms within; click it to keep all again."));
  const ends = columns.map(({ values }) => {
    let low = Infinity, high = -Infinity;
    for (const v of values) { if (v < low) low = v; if (v > high) high = v; }
    return [low, high > low ? high : low + 1];
  });
  const brushes = columns.map(() => null);
  const top = 34, bottom = 26, side = 44;
  const x = (k) => side + (k * (canvas.clientWidth - 2 * side)) / Math.max(columns.length - 1, 1);
  const y = (k, v) => top + (1 - (v - ends[k][0]) / (ends[k][1] - ends[k][0])) * (canvas.clientHeight - top - bottom);
  const draw = mobo.atNextFrame(() => {
    const dpr = Math.min(devicePixelRatio || 1, 2), context = canvas.getContext("2d");
    [canvas.width, canvas.height] = [canvas.clientWidth * dpr, canvas.clientHeight * dpr];
    context.scale(dpr, dpr);
    const rows = [];
    for (let row = 0; row < study.n; row++) if (study.shown[row]) rows.push(row);
    const every = Math.max(1, Math.ceil(rows.length / 2500)), styles = study.meta.styles, dark = mobo.theme.dark;
    const line = (row) => { context.beginPath(); columns.forEach((column, k) => { const py = y(k, column.values[row]); k ? context.lineTo(x(k), py) : context.moveTo(x(k), py); }); context.stroke(); };
    context.globalAlpha = Math.min(0.5, 40 / Math.sqrt(rows.length / every + 1) / 10);
    context.lineWidth = 1;
    rows.forEach((row, i) => {
      if (i % every && !study.raw.front[row]) return;
      const style = styles[study.style[row]];
      context.strokeStyle = style ? (dark ? style.dark : style.colour) : mobo.theme.colour("others");
      line(row);
    });
    context.globalAlpha = 1;
    for (const [row, colour] of [...study.pins.map((row) => [row, "pin"]), [study.chosen, "accent"]])
      if (row >= 0) { context.lineWidth = 2.5; context.strokeStyle = mobo.theme.colour(colour); line(row); }
    context.font = `12px ${mobo.theme.colour("font")}`;
    columns.forEach((column, k) => {
      context.strokeStyle = mobo.theme.colour("ink"); context.lineWidth = 1;
      context.beginPath(); context.moveTo(x(k), top); context.lineTo(x(k), canvas.clientHeight - bottom); context.stroke();
      context.fillStyle = mobo.theme.colour("ink"); context.textAlign = "center";
      context.fillText(column.label, x(k), 13);
      context.fillStyle = mobo.theme.colour("faint");
      const [low, high] = ends[k], text = (v) => mobo.tickText(v, 10 ** Math.floor(Math.log10((high - low) / 100)));
      context.fillText(Number.isInteger(high) ? mobo.short(high) : text(high), x(k), 28);
      context.fillText(Number.isInteger(low) ? mobo.short(low) : text(low), x(k), canvas.clientHeight - 9);
      if (brushes[k]) {
        const [a, b] = brushes[k].map((v) => y(k, v));
        context.fillStyle = mobo.theme.colour("accent"); context.globalAlpha = 0.35;
        context.fillRect(x(k) - 9, Math.min(a, b), 18, Math.abs(b - a));
        context.globalAlpha = 1;
      }
    });
  });
  for (const name of ["filter", "choose", "pin"]) study.on(name, draw);
  mobo.theme.changed.on("change", draw);
  new ResizeObserver(draw).observe(canvas);
  let brush = null;
  const value = (k, py) => { const share = 1 - (py - top) / (canvas.clientHeight - top - bottom); return ends[k][0] + Math.min(Math.max(share, 0), 1) * (ends[k][1] - ends[k][0]); };
  canvas.addEventListener("pointerdown", (event) => {
    const k = columns.map((_, i) => [Math.abs(x(i) - event.offsetX), i]).sort((a, b) => a[0] - b[0])[0][1];
    brush = { k, from: event.offsetY, to: event.offsetY };
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!brush) return;
    brush.to = event.offsetY;
    brushes[brush.k] = [value(brush.k, brush.from), value(brush.k, brush.to)].sort((a, b) => a - b);
    draw();
  });
  canvas.addEventListener("pointerup", () => {
    if (!brush) return;
    const { k, from, to } = brush, name = columns[k].name, { [name]: _, ...ranges } = study.filter.ranges;
    brush = null;
    if (Math.abs(from - to) < 4) brushes[k] = null;
    study.setFilter({ ranges: brushes[k] ? { ...ranges, [name]: brushes[k] } : ranges });
  });
  study.on("filter", () => columns.forEach((column, k) => { if (brushes[k] && !study.filter.ranges[column.name]) brushes[k] = null; }));
};
