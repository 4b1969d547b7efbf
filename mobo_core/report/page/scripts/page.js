// Puts the page together once it is read: figures' views, the chosen arm, the pinned ones, links, light and dark.
(async () => {
  const { el } = mobo;
  const began = performance.now();
  const themeButton = document.getElementById("theme");
  const nameTheme = () => { themeButton.textContent = mobo.theme.dark ? "Light" : "Dark"; };
  themeButton.addEventListener("click", () => mobo.theme.toggle());
  mobo.theme.changed.on("change", nameTheme);
  nameTheme();

  // Sections by their headings.
  const nav = document.getElementById("nav");
  const navOf = new Map();
  for (const section of document.querySelectorAll("section[data-nav]")) {
    const button = el("button", { type: "button", hidden: section.hidden, onclick: () => { section.scrollIntoView(); section.focus({ preventScroll: true }); } }, section.dataset.nav);
    navOf.set(section, button);
    nav.append(button);
  }

  if (!document.getElementById("meta")) return; // no arm was evaluated
  const study = await mobo.Study.read();
  mobo.study = study;

  for (const section of document.querySelectorAll("[data-view]")) {
    const name = section.dataset.view, show = mobo.views.get(name);
    if (!show) continue;
    const root = el("div.view");
    section.insertBefore(root, section.querySelector(".below"));
    try { show(root, mobo.json(`data-${name}`), study); }
    catch (error) { console.error(error); root.replaceChildren(el("p.bad", {}, `This view failed: ${error.message}`)); }
    if (name === "sampling") await mobo.nextFrame();
  }

  const place = document.getElementById("arm");
  const card = new mobo.Card(place, study, { heading: "h2" });
  study.on("choose", ({ row, reveal }) => {
    card.show(row);
    if (reveal) { card.root.focus({ preventScroll: true }); card.root.scrollIntoView({ block: innerWidth < 1100 ? "start" : "nearest" }); }
    mobo.say(`Shown: ${mobo.briefText(study, row)}`);
  });

  const pinned = document.getElementById("pinned"), cards = new Map();
  const showPins = () => {
    card.refresh();
    pinned.hidden = !study.pins.length;
    navOf.get(pinned).hidden = pinned.hidden;
    const body = document.getElementById("pins");
    for (const [row, one] of cards) if (!study.isPinned(row)) { one.root.remove(); cards.delete(row); }
    for (const row of study.pins)
      if (!cards.has(row)) { const one = new mobo.Card(body, study); cards.set(row, one); one.show(row); }
    for (const one of cards.values()) one.refresh();
    document.getElementById("pinnote").hidden = study.pins.length !== 1;
  };
  study.on("pin", showPins);

  // Numbers of trials in the page's tables show these.
  for (const cell of document.querySelectorAll("td[data-trial]")) {
    const row = study.rowOf.get(Number(cell.dataset.trial));
    if (row !== undefined) cell.replaceChildren(mobo.armButton(study, row));
  }

  const first = study.readAddress();
  if (first >= 0) study.choose(first);
  showPins();
  document.documentElement.dataset.ready = (performance.now() - began).toFixed(0);
})();
