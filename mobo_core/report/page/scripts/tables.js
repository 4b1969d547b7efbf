// Horizontal bars: [{label, value, text, colour}].
mobo.bars = (root, rows, { title, most = Math.max(...rows.map((row) => row.value), 1e-12) }) =>
  root.append(mobo.el("table.bars.plain", {}, mobo.el("caption", {}, title), mobo.el("tbody", {}, rows.map((row) => mobo.el("tr", {},
    mobo.el("th", { scope: "row" }, row.label), mobo.el("td.n", {}, row.text),
    mobo.el("td.bar", { "aria-hidden": "true" }, mobo.el("i.mean", { style: `width:${(100 * row.value) / most}%${row.colour ? `;background:${row.colour}` : ""}` })))))));

// A table that its headings sort. columns: [{name, title, number, text: (row) => text or node, value: (row) => what it is sorted by}].
mobo.sortedTable = (root, columns, rows, { caption = "", by = null, down = true, most = 400, tall = false } = {}) => {
  const { el } = mobo, body = el("tbody");
  let [key, falling] = [by ?? columns[0].name, down];
  const heads = columns.map((column) => el(column.number ? "th.n" : "th", { scope: "col" },
    el("button.sort", { type: "button", title: column.help ?? "", onclick: () => { falling = key === column.name ? !falling : !!column.number; key = column.name; show(); } }, column.title)));
  const show = () => {
    const column = columns.find((one) => one.name === key), sign = falling ? -1 : 1;
    const worth = new Map(rows.map((row) => [row, column.value(row)]));
    const ordered = rows.slice().sort((a, b) => {
      const [u, v] = [worth.get(a), worth.get(b)];
      if (typeof u === "number" && (Number.isNaN(u) || Number.isNaN(v))) return Number.isNaN(u) - Number.isNaN(v);
      return (u < v ? -1 : u > v ? 1 : 0) * sign;
    });
    heads.forEach((head, i) => head.setAttribute("aria-sort", columns[i].name === key ? (falling ? "descending" : "ascending") : "none"));
    body.replaceChildren(...ordered.slice(0, most).map((row) => el("tr", {}, columns.map((one) => el(one.number ? "td.n" : "td", {}, one.text(row))))));
  };
  root.append(el(tall ? "div.wide.tall" : "div.wide", tall ? { tabindex: 0 } : {}, el("table", {}, caption ? el("caption", {}, caption) : null, el("thead", {}, el("tr", {}, heads)), body)));
  show();
  return { show, set rows(next) { rows = next; show(); } };
};

// A button that names a trial and shows it.
mobo.armButton = (study, row, text = String(study.raw.trial[row])) =>
  mobo.el("button.arm", { type: "button", title: "show this arm", onclick: () => study.choose(row, { reveal: true }) }, text);
