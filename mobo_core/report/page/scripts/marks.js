// The marks of a scatter: shapes as polygons in a square of side 2, for SVG paths and for stamps of pixels.
mobo.marks = (() => {
  const ring = (n, turn = 0, r = 1) => Array.from({ length: n }, (_, i) => {
    const a = turn + (2 * Math.PI * i) / n;
    return [r * Math.sin(a), -r * Math.cos(a)];
  });
  const cross = (turn) => {
    const w = 0.36;
    const arms = [[-w, -1], [w, -1], [w, -w], [1, -w], [1, w], [w, w], [w, 1], [-w, 1], [-w, w], [-1, w], [-1, -w], [-w, -w]];
    const c = Math.cos(turn), s = Math.sin(turn);
    return arms.map(([x, y]) => [c * x - s * y, s * x + c * y]);
  };
  const shapes = { // by matplotlib's letters, as the pictures have them
    o: ring(24), s: ring(4, Math.PI / 4, 1.25), D: ring(4, 0, 1.2), "^": ring(3, 0, 1.25), v: ring(3, Math.PI, 1.25),
    "<": ring(3, -Math.PI / 2, 1.25), ">": ring(3, Math.PI / 2, 1.25), P: cross(0), X: cross(Math.PI / 4), p: ring(5, 0, 1.12),
    h: ring(6, 0, 1.1),
  };
  const of = (name) => shapes[name] ?? shapes.o;
  const inside = (polygon, x, y) => {
    let found = false;
    for (let i = 0, j = polygon.length - 1; i < polygon.length; j = i++) {
      const [xi, yi] = polygon[i], [xj, yj] = polygon[j];
      if (yi > y !== yj > y && x < ((xj - xi) * (y - yi)) / (yj - yi) + xi) found = !found;
    }
    return found;
  };
  const path = (name, r, cx = 0, cy = 0) =>
    `M${of(name).map(([x, y]) => `${(cx + r * x).toFixed(2)},${(cy + r * y).toFixed(2)}`).join("L")}Z`;
  const icon = (name, colour, size = 14) =>
    mobo.el("svg.mark", { viewBox: "-9 -9 18 18", width: size, height: size, "aria-hidden": "true" },
      mobo.el("path", { d: path(name, 6.4), fill: colour }));

  const packed = (pixels, reach) => ({
    x: Int32Array.from(pixels, (p) => p.x), y: Int32Array.from(pixels, (p) => p.y), reach,
    r: Uint8Array.from(pixels, (p) => p.colour[0]), g: Uint8Array.from(pixels, (p) => p.colour[1]),
    b: Uint8Array.from(pixels, (p) => p.colour[2]), cover: Uint16Array.from(pixels, (p) => p.cover),
  });

  // Pixels of a mark of radius r: offsets, and colours with how much they cover.
  const stamp = (name, r, fill, edge, edgeWidth) => {
    const polygon = of(name), size = Math.ceil(1.3 * (r + edgeWidth)) + 1, fine = 4;
    const pixels = [];
    for (let y = -size; y <= size; y++)
      for (let x = -size; x <= size; x++) {
        let whole = 0, inner = 0;
        for (let b = 0; b < fine; b++)
          for (let a = 0; a < fine; a++) {
            const px = x + (a + 0.5) / fine - 0.5, py = y + (b + 0.5) / fine - 0.5;
            whole += inside(polygon, px / (r + edgeWidth), py / (r + edgeWidth));
            inner += inside(polygon, px / r, py / r);
          }
        if (whole) {
          const colour = mobo.mixed(edge, fill, inner / whole);
          pixels.push({ x, y, colour, cover: Math.round((256 * whole) / (fine * fine)) });
        }
      }
    return packed(pixels, size);
  };

  const circle = (r, width, colour) => {
    const size = Math.ceil(r + width), pixels = [];
    for (let y = -size; y <= size; y++)
      for (let x = -size; x <= size; x++) {
        const covered = Math.min(Math.max(0.5 + width / 2 - Math.abs(Math.hypot(x, y) - r), 0), 1);
        if (covered > 0.02) pixels.push({ x, y, colour, cover: Math.round(256 * covered) });
      }
    return packed(pixels, size);
  };

  // Press a stamp into an image of 32-bit pixels (red lowest), its middle at the pixel (cx, cy).
  const press = (pixels, width, height, mark, cx, cy) => {
    const { x, y, r, g, b, cover, reach } = mark;
    const whole = cx >= reach && cy >= reach && cx < width - reach && cy < height - reach;
    for (let k = 0; k < x.length; k++) {
      const px = cx + x[k], py = cy + y[k];
      if (!whole && (px < 0 || py < 0 || px >= width || py >= height)) continue;
      const at = py * width + px, c = cover[k];
      if (c >= 256) pixels[at] = 0xff000000 | (b[k] << 16) | (g[k] << 8) | r[k];
      else {
        const old = pixels[at], d = 256 - c;
        pixels[at] = 0xff000000 | (((b[k] * c + ((old >> 16) & 255) * d) >> 8) << 16)
          | (((g[k] * c + ((old >> 8) & 255) * d) >> 8) << 8) | ((r[k] * c + (old & 255) * d) >> 8);
      }
    }
  };
  return { path, icon, stamp, circle, press };
})();
