// What mouse, fingers and keys do in a scatter.
mobo.listenTo = (scatter) => {
  const over = scatter.canvas, fingers = new Map();
  let moved = 0;
  const place = (event) => { const box = over.getBoundingClientRect(); return [event.clientX - box.left, event.clientY - box.top]; };
  const hover = (now) => {
    const arm = mobo.knownAt(scatter, ...now);
    arm ? scatter.pointKnown(arm, ...now) : scatter.point(scatter.nearest(...now), ...now);
  };
  over.addEventListener("pointerdown", (event) => {
    over.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, place(event));
    moved = 0;
  });
  over.addEventListener("pointermove", (event) => {
    const now = place(event), before = fingers.get(event.pointerId);
    if (!before) { if (event.pointerType !== "touch") hover(now); return; }
    if (fingers.size === 1) {
      moved += Math.hypot(now[0] - before[0], now[1] - before[1]);
      if (moved > 4) { scatter.point(-1); scatter.move(now[0] - before[0], now[1] - before[1]); }
      else return;
    } else {
      const [other] = [...fingers].filter(([id]) => id !== event.pointerId).map(([, p]) => p);
      const far = (p) => Math.hypot(p[0] - other[0], p[1] - other[1]) || 1;
      moved = 99;
      scatter.zoom(far(before) / far(now), (now[0] + other[0]) / 2, (now[1] + other[1]) / 2);
    }
    fingers.set(event.pointerId, now);
  });
  const end = (event) => {
    const began = fingers.get(event.pointerId);
    fingers.delete(event.pointerId);
    if (began && event.type === "pointerup" && moved <= 4) {
      const row = scatter.nearest(...place(event), event.pointerType === "touch" ? 26 : 18);
      if (row >= 0) scatter.study.choose(row, { reveal: event.pointerType === "touch" });
    }
  };
  over.addEventListener("pointerup", end);
  over.addEventListener("pointercancel", end);
  over.addEventListener("pointerleave", () => scatter.point(-1));
  over.addEventListener("wheel", (event) => {
    event.preventDefault();
    scatter.point(-1);
    scatter.zoom(Math.exp(Math.max(-0.5, Math.min(0.5, event.deltaY * 0.0016))), ...place(event));
  }, { passive: false });
  over.addEventListener("dblclick", () => scatter.reset());
  over.addEventListener("keydown", (event) => {
    const steps = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    const middle = [scatter.width / 2, scatter.height / 2];
    if (steps[event.key] && event.shiftKey) scatter.move(-60 * steps[event.key][0], -60 * steps[event.key][1]);
    else if (steps[event.key]) {
      const from = scatter.hover >= 0 ? scatter.hover : scatter.study.chosen >= 0 ? scatter.study.chosen : scatter.nearest(...middle, 1e4);
      if (from < 0) return;
      const to = scatter.next(from, ...steps[event.key]);
      scatter.point(to, scatter.toX(scatter.x.values[to]), scatter.toY(scatter.y.values[to]));
      mobo.say(mobo.briefText(scatter.study, to));
    } else if (event.key === "Enter" || event.key === " ") {
      if (scatter.hover >= 0) scatter.study.choose(scatter.hover, { reveal: true });
    } else if (event.key === "p" && scatter.hover >= 0) scatter.study.pin(scatter.hover);
    else if (event.key === "+" || event.key === "=") scatter.zoom(0.8, ...middle);
    else if (event.key === "-") scatter.zoom(1.25, ...middle);
    else if (event.key === "0") scatter.reset();
    else if (event.key === "Escape") scatter.point(-1);
    else return;
    event.preventDefault();
  });
  over.addEventListener("blur", () => scatter.point(-1));
};
