// The known arms of a scatter: a cross at each, and its name where there is room.
mobo.nameKnown = (scatter, context, at) => {
  const { left, top, width, height } = scatter.inner, taken = [];
  context.font = `600 11.5px ${mobo.theme.colour("font")}`;
  context.textAlign = "left";
  for (const { row, name: all } of scatter.study.meta.known) {
    if (!scatter.study.shown[row]) continue;
    const [x, y] = at(row);
    if (x < left || x > left + width || y < top || y > top + height) continue;
    const [first, ...others] = all.split(", ");
    const name = others.length && context.measureText(all).width > 0.45 * width ? `${first} +${others.length}` : all;
    const w = context.measureText(name).width + 10, h = 19;
    let best = null;
    for (let k = 0; k < 40; k++) {
      const a = (k % 10) * 0.628 - 1.2, d = 26 + 22 * Math.floor(k / 10);
      const bx = x + d * Math.cos(a) - (Math.cos(a) < 0 ? w : 0), by = y + d * Math.sin(a) - h / 2;
      const out = bx < left + 2 || bx + w > left + width - 2 || by < top + 2 || by + h > top + height - 2;
      if (out || taken.some(([tx, ty, tw]) => bx < tx + tw + 3 && bx + w + 3 > tx && by < ty + h + 2 && by + h + 2 > ty)) continue;
      best = [bx, by, w];
      break;
    }
    context.strokeStyle = mobo.theme.colour("ink");
    context.lineWidth = 1.2;
    if (best) {
      const [bx, by] = best, cx = Math.min(Math.max(x, bx), bx + w), cy = by + h / 2;
      context.beginPath(); context.moveTo(x, y); context.lineTo(cx, cy); context.stroke();
      context.fillStyle = mobo.theme.colour("plot");
      context.globalAlpha = 0.92;
      context.beginPath(); context.roundRect(bx, by, w, h, 4); context.fill();
      context.globalAlpha = 1;
      context.strokeStyle = mobo.theme.colour("line");
      context.stroke();
      context.fillStyle = mobo.theme.colour("ink");
      context.fillText(name, bx + 5, by + 13.5);
      taken.push(best);
    }
    context.strokeStyle = mobo.theme.colour("ink");
    context.lineWidth = 1.8;
    context.beginPath();
    context.moveTo(x - 5, y); context.lineTo(x + 5, y); context.moveTo(x, y - 5); context.lineTo(x, y + 5);
    context.stroke();
  }
};
