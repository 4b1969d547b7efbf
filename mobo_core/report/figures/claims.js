// The paper's claims: each with its verdict, and in a fold its statements with their numbers.
mobo.view("claims", (root, data) => {
  const { el } = mobo;
  const marks = { "reproduced": "\u2713", "not reproduced": "\u2717", "inconclusive": "?" };
  const marked = (verdict) => `${marks[verdict]} ${verdict}`;
  const body = el("tbody");
  for (const one of data) {
    const parts = el("table.plain", {}, el("tbody", {}, one.parts.map((part) => el("tr", {},
      el("td", {}, marked(part.verdict)), el("td.wrap", {}, part.text), el("td.n", {}, part.margin), el("td.n", {}, part.interval), el("td.wrap.note", {}, part.numbers)))));
    body.append(el("tr", {}, el("td", {}, one.claim), el("td", {}, el("b", {}, marked(one.verdict))),
      el("td.wrap", {}, el("details", {}, el("summary", {}, one.text), el("div.wide", {}, parts)))));
  }
  root.append(el("div.wide", {}, el("table", {}, el("thead", {}, el("tr", {}, ["claim", "verdict", "what the paper says"].map((title) => el("th", { scope: "col" }, title)))), body)));
});
