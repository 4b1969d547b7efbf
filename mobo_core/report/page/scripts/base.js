// What all scripts of the page share: elements, numbers as text, events, packed data, light and dark.
// Text from a study only ever becomes a text node or an attribute, never HTML.
const mobo = globalThis.mobo = { views: new Map() };

mobo.view = (name, show) => mobo.views.set(name, show); // show(root, data, study), once, when the page is read

mobo.el = (tag, attributes = {}, ...children) => {
  const [name, ...classes] = tag.split(".");
  const svg = mobo.el.svg.has(name);
  const node = svg ? document.createElementNS("http://www.w3.org/2000/svg", name) : document.createElement(name);
  if (classes.length) node.setAttribute("class", classes.join(" "));
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) node.addEventListener(key.slice(2), value);
    else if (value === true) node.setAttribute(key, "");
    else if (value !== false && value != null) node.setAttribute(key, value);
  }
  node.append(...children.flat().filter((child) => child != null));
  return node;
};
mobo.el.svg = new Set(["svg", "path", "line", "rect", "circle", "g", "text", "polyline", "tspan"]);

// Numbers: a fixed number of digits, a true minus, a dash for none.
mobo.fixed = (value, digits = 1) =>
  Number.isFinite(value) ? value.toFixed(digits).replace(/^-(?=0\.?0*$)/, "").replace("-", "\u2212") : "\u2013";
mobo.short = (value) => {
  if (!Number.isFinite(value)) return "\u2013";
  const size = Math.abs(value);
  if (size !== 0 && (size >= 1e6 || size < 1e-3)) return value.toExponential(2).replace("-", "\u2212");
  return String(Number(value.toPrecision(4))).replace("-", "\u2212");
};
mobo.count = (n) => n.toLocaleString("en-US");

mobo.Events = class {
  #heard = {};
  on(name, hear) { (this.#heard[name] ??= []).push(hear); }
  emit(name, what) { for (const hear of this.#heard[name] ?? []) hear(what); }
};

mobo.unpack = async (text) => {
  const raw = atob(text);
  const bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).arrayBuffer();
};

mobo.arrays = async (blob) => {
  const buffer = await mobo.unpack(blob.text);
  const types = { f8: Float64Array, f4: Float32Array, u1: Uint8Array, u2: Uint16Array, u4: Uint32Array, i2: Int16Array };
  const found = {};
  for (const [name, [type, first, count]] of Object.entries(blob.places))
    found[name] = new types[type](buffer, first, count);
  return found;
};

mobo.json = (id) => JSON.parse(document.getElementById(id).textContent);
// What stands behind the scripts, so that the first picture need not wait for it.
mobo.lateArrays = async (id) => {
  if (document.readyState === "loading") await new Promise((go) => document.addEventListener("DOMContentLoaded", go, { once: true }));
  return mobo.arrays(mobo.json(id));
};

mobo.theme = {
  get dark() {
    const chosen = document.documentElement.dataset.theme;
    return chosen ? chosen === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
  },
  colours: new Map(), // asked for at every frame
  colour(name) {
    if (!this.colours.has(name)) this.colours.set(name, getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim());
    return this.colours.get(name);
  },
  changed: new mobo.Events(),
  toggle() {
    document.documentElement.dataset.theme = this.dark ? "light" : "dark";
    this.changed.emit("change");
  },
};
mobo.theme.changed.on("change", () => mobo.theme.colours.clear());
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => mobo.theme.changed.emit("change"));

mobo.rgb = (hex) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16));
mobo.mixed = (a, b, share) => a.map((value, i) => Math.round(value + (b[i] - value) * share));

// Draw at the next frame, however often it is asked for until then.
mobo.atNextFrame = (draw) => {
  let asked = 0;
  return () => { if (!asked) asked = requestAnimationFrame(() => { asked = 0; draw(); }); };
};

// What was drawn is on the screen; a page in the background does not wait for it.
mobo.nextFrame = () => Promise.race([new Promise((go) => requestAnimationFrame(() => setTimeout(go))), new Promise((go) => setTimeout(go, 300))]);

mobo.say = (text) => { document.getElementById("said").textContent = text; };

mobo.copyButton = (text) => {
  const button = mobo.el("button.small", { type: "button" }, "Copy");
  button.addEventListener("click", async () => {
    let done = true;
    try { await navigator.clipboard.writeText(text); }
    catch {
      const area = mobo.el("textarea", { readonly: true });
      area.value = text;
      document.body.append(area);
      area.select();
      done = document.execCommand("copy");
      area.remove();
    }
    button.textContent = done ? "Copied" : "Not copied";
    mobo.say(button.textContent);
    setTimeout(() => { button.textContent = "Copy"; }, 1500);
  });
  return button;
};

// The gradation of voxel maps, red 0 to green 1, from a few colours of the pictures' own.
mobo.gradation = (stops) => (share) => {
  const at = Math.min(Math.max(share, 0), 1) * (stops.length - 1);
  const i = Math.min(Math.floor(at), stops.length - 2);
  return mobo.mixed(mobo.rgb(stops[i]), mobo.rgb(stops[i + 1]), at - i);
};
mobo.darkTextOn = (rgb) => {
  const [r, g, b] = rgb.map((v) => (v / 255 <= 0.04045 ? v / 255 / 12.92 : ((v / 255 + 0.055) / 1.055) ** 2.4));
  return 0.2126 * r + 0.7152 * g + 0.0722 * b > 0.2;
};
