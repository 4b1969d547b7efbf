// Where an axis has its ticks, and what they say.
mobo.ticks = (low, high, about = 6) => {
  const span = high - low;
  if (!(span > 0)) return { step: 1, values: [low] };
  const rough = span / about, power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= rough * 0.999);
  const values = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * span; i++) values.push(i * step);
  return { step, values };
};
mobo.tickText = (value, step) => {
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  return mobo.fixed(Math.abs(value) < step / 1e6 ? 0 : value, Math.min(digits, 6));
};
