/** What there is to know at once, and what all of it was made from. */
page.summary = (() => {
  const { element, byId, number } = page.dom;

  function create(crowd) {
    const { header } = crowd;
    byId("title").textContent = header.title;
    verdict(header.total, crowd.arrays.promised.filter((promised) => !promised).length);
    tiles(crowd);
    targets(header.total);
    notes(header);
  }

  /** Whether the promised footsteps meet all targets, and how many footsteps promise nothing. */
  function verdict(total, unpromised) {
    const missed = total.filter((row) => !row.passed).length;
    const measured = total.filter((row) => row.value !== null).length;
    const pill = byId("verdict");
    pill.className = missed ? "pill bad" : "pill good";
    const met = missed ? `\u25b2 ${missed} of ${measured} figures miss their target` : `\u2713 all ${measured} figures within their targets`;
    pill.textContent = unpromised ? `${met} \u00b7 ${unpromised} footsteps promise nothing` : met;
  }

  function tiles(crowd) {
    const { arrays, agents, header } = crowd;
    const promised = arrays.promised.reduce((sum, value) => sum + value, 0);
    const all = arrays.promised.length;
    const over = crowd.stepSeverity.reduce((sum, value, step) => sum + (arrays.promised[step] && value > 1 ? 1 : 0), 0);
    const shown = [
      ["agents", String(agents.length), `${number(crowd.duration, 1)} s, ${number(1 / header.frameTime, 1)} frames/s drawn`],
      ["footsteps", String(all), `${promised} with a promise, ${all - promised} without`],
      ["steps over a target", String(over), `of the ${promised} promised`, over > 0],
    ];
    for (const name of ["placement mean", "placement worst", "slide", "lowest sole", "clearance", "blend error mean"]) {
      const row = header.total.find((entry) => entry.name === name);
      if (row) shown.push([name, value(row), `target ${bound(row)}`, !row.passed]);
    }
    byId("tiles").append(
      ...shown.map(([title, text, hint, missed]) =>
        element(
          "div",
          { class: missed ? "tile missed" : "tile" },
          element("span", { class: "hint" }, title),
          element("strong", {}, (missed ? "\u25b2 " : "") + text),
          element("span", { class: "hint" }, hint),
        ),
      ),
    );
  }

  const LEAST = 0.001; // what is smaller is only said to be so

  function value({ value: measured, unit }) {
    if (measured === null) return "-";
    const rounded = Number(Number(measured.toPrecision(3)).toFixed(3));
    const shown = measured !== 0 && Math.abs(measured) < LEAST ? `< ${LEAST}` : String(rounded);
    return `${shown} ${unit}`.trim();
  }

  const bound = (row) => `${row.at_least ? "\u2265" : "\u2264"} ${row.target} ${row.unit}`.trim();

  /** Every figure that `usdfoot validate` compares, of the whole crowd. */
  function targets(total) {
    const cell = (text, kind = "") => element("td", { class: kind }, text);
    const body = total.map((row) => {
      const mark = row.value === null ? "not measured" : row.passed ? "\u2713" : "\u25b2 missed";
      const kind = row.passed ? "" : "missed";
      return element("tr", {}, cell(row.name), cell(value(row), "number"), cell(bound(row), "number"), cell(mark, kind));
    });
    const head = ["figure", "worst of the crowd", "target", ""].map((text) => element("th", {}, text));
    byId("targets").append(
      element("h2", {}, "Against the targets"),
      element("table", {}, element("thead", {}, element("tr", {}, ...head)), element("tbody", {}, ...body)),
    );
  }

  function notes(header) {
    const holder = byId("notes");
    const list = (title, texts) =>
      texts.length ? [element("h2", {}, title), element("ul", {}, ...texts.map((text) => element("li", {}, text)))] : [];
    const facts = Object.entries({ usdfoot: header.version, ...header.facts }).flatMap(([name, text]) => [
      element("dt", {}, name),
      element("dd", {}, text),
    ]);
    holder.append(
      ...list("Problems", header.problems),
      ...list("What is shown", header.notes),
      element("h2", {}, "Made from"),
      element("dl", {}, ...facts),
    );
  }

  return { create };
})();
