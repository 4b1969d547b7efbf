// Behind the points of a scatter the grid, beside them its axes, over them what changes without them.
mobo.scatterGrid = (scatter) => {
  const { left, top, width, height } = scatter.inner, d = scatter.dpr, W = scatter.canvas.width;
  const [r, g, b] = mobo.rgb(mobo.theme.colour("grid")), colour = 0xff000000 | (b << 16) | (g << 8) | r;
  const many = Math.max(2, Math.round(width / (scatter.small ? 70 : 95)));
  scatter.xTicks = mobo.ticks(...scatter.view.x, many);
  scatter.yTicks = mobo.ticks(...scatter.view.y, Math.max(2, Math.round(height / (scatter.small ? 48 : 60))));
  const y0 = Math.round(d * top), y1 = Math.round(d * (top + height)), x0 = Math.round(d * left), x1 = Math.round(d * (left + width));
  for (const value of scatter.xTicks.values) {
    const x = Math.round(d * scatter.toX(value));
    for (let y = y0; y < y1; y++) scatter.pixels[y * W + x] = colour;
  }
  for (const value of scatter.yTicks.values) {
    const y = Math.round(d * scatter.toY(value));
    scatter.pixels.fill(colour, y * W + x0, y * W + x1);
  }
};

mobo.scatterAxes = (scatter, context) => {
  const { left, top, width, height } = scatter.inner;
  context.save();
  context.fillStyle = mobo.theme.colour("faint");
  context.font = `12px ${mobo.theme.colour("font")}`;
  context.textAlign = "center";
  for (const value of scatter.xTicks.values) context.fillText(mobo.tickText(value, scatter.xTicks.step), scatter.toX(value), top + height + 16);
  context.textAlign = "right";
  for (const value of scatter.yTicks.values) context.fillText(mobo.tickText(value, scatter.yTicks.step), left - 7, scatter.toY(value) + 4);
  const name = (column) => (column.unit ? `${column.label}  [${column.unit}]` : column.label);
  const shortName = (column) => (column.unit && column.unit.length < 5 ? `${column.label} [${column.unit}]` : column.label);
  const text = scatter.compact ? shortName : name;
  context.fillStyle = mobo.theme.colour("ink");
  context.font = `12.5px ${mobo.theme.colour("font")}`;
  context.textAlign = "center";
  context.fillText(text(scatter.x), left + width / 2, scatter.height - 7);
  context.translate(13, top + height / 2);
  context.rotate(-Math.PI / 2);
  context.fillText(text(scatter.y), 0, 0);
  context.restore();
};

// What changes without the points: known arms, what is pointed at, chosen, pinned.
mobo.scatterOver = (scatter) => {
  const { context, study } = scatter;
  context.putImageData(scatter.image, 0, 0);
  context.setTransform(scatter.dpr, 0, 0, scatter.dpr, 0, 0);
  mobo.scatterAxes(scatter, context);
  context.save();
  const { left, top, width, height } = scatter.inner;
  context.beginPath();
  context.rect(left, top, width, height);
  context.clip();
  const ink = mobo.theme.colour("ink");
  const at = (row) => [scatter.toX(scatter.x.values[row]), scatter.toY(scatter.y.values[row])];
  const circle = (row, radius, colour, line) => {
    const [x, y] = at(row);
    context.beginPath();
    context.arc(x, y, radius, 0, 2 * Math.PI);
    context.lineWidth = line;
    context.strokeStyle = colour;
    context.stroke();
  };
  const floor = study.meta.floor;
  if (scatter.xName === "reach") {
    const x = scatter.toX(floor);
    context.setLineDash([4, 4]);
    context.strokeStyle = mobo.theme.colour("faint");
    context.lineWidth = 1;
    context.beginPath(); context.moveTo(x, top); context.lineTo(x, top + height); context.stroke();
    context.setLineDash([]);
    if (!scatter.small) {
      context.fillStyle = mobo.theme.colour("faint");
      context.font = `11px ${mobo.theme.colour("font")}`;
      context.fillText(`floor ${mobo.short(floor)}`, x + 4, top + 11);
    }
  }
  if (scatter.known) mobo.nameKnown(scatter, context);
  for (const row of study.pins) circle(row, 9, mobo.theme.colour("pin"), 2.5);
  if (study.chosen >= 0) {
    circle(study.chosen, 8.5, mobo.theme.colour("plot"), 6);
    circle(study.chosen, 8.5, mobo.theme.colour("accent"), 3);
  }
  if (scatter.hover >= 0) circle(scatter.hover, 7, ink, 2);
  context.restore();
  scatter.screen.putImageData(context.getImageData(0, 0, scatter.canvas.width, scatter.canvas.height), 0, 0);
};
