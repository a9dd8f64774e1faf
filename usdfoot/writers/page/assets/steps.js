/** Every footstep of the agents shown, the worst first. */
page.steps = (() => {
  const { element, byId, number } = page.dom;
  const SHOWN = {
    placement: "placement",
    slide: "slide",
    subframeSlide: "between",
    heelSlide: "heel",
    yaw: "yaw",
    clearance: "clearance",
    timing: "timing",
    blend: "blend",
    hull: "hull",
  };

  function create(crowd, state) {
    const holder = byId("steps");
    const found = element("span", { class: "hint", role: "status" });
    const own = element("input", { type: "checkbox" });
    const missed = element("input", { type: "checkbox" });
    holder.append(
      element("h2", {}, "Worst steps ", found),
      element(
        "div",
        { class: "bar small" },
        element("label", {}, own, " of the chosen agent only"),
        element("label", {}, missed, " over a target only"),
        element("span", { class: "hint" }, "a click goes there in the 3-D view; \u25b2 misses its target"),
      ),
    );
    const rows = page.rows.create(holder, columns(crowd), {
      label: "footsteps",
      sort: 0,
      onPick: (step) => state.chooseStep(step),
      isChosen: (step) => step === state.step,
    });

    function filter() {
      const chosen = [];
      for (let step = 0; step < crowd.stepAgents.length; step++) {
        const agent = crowd.stepAgents[step];
        if (own.checked ? agent !== state.agent : !state.shown[agent]) continue;
        if (missed.checked && !(crowd.stepSeverity[step] > 1)) continue;
        chosen.push(step);
      }
      found.textContent = `${chosen.length} of ${crowd.stepAgents.length}`;
      rows.show(chosen);
    }

    own.addEventListener("change", filter);
    missed.addEventListener("change", filter);
    state.on("shown", filter);
    state.on("agent", () => own.checked && filter());
    state.on("step", rows.draw);
    filter();
  }

  function columns(crowd) {
    const { arrays, agents, stepAgents, header } = crowd;
    const agentOf = (step) => agents[stepAgents[step]];
    const plain = (title, width, text, value = text) => ({ title, width, text, value });
    const status = (step) => header.statuses[arrays.stepStatuses[step]];
    return [
      {
        title: "of target",
        width: "minmax(84px, 0.8fr)",
        number: true,
        hint: "the figure nearest to its target or farthest beyond: 100 % is the target",
        text: (step) => `${number(100 * crowd.stepSeverity[step], 0)} %`,
        value: (step) => crowd.stepSeverity[step],
        mark: (step) => crowd.stepSeverity[step] > 1,
      },
      plain("agent", "minmax(110px, 1.5fr)", (step) => agentOf(step).name),
      { ...plain("step", "54px", (step) => String(step - agentOf(step).firstStep), (step) => step - agentOf(step).firstStep), number: true },
      plain("foot", "52px", (step) => (arrays.sides[step] ? "right" : "left")),
      {
        ...plain("strike s", "70px", (step) => number(arrays.strikeTimes[step] + header.start, 2), (step) => arrays.strikeTimes[step]),
        number: true,
      },
      plain("status", "minmax(104px, 1fr)", status),
      ...crowd.figures.filter(({ key }) => key in SHOWN).map(figureColumn),
    ];
  }

  function figureColumn(figure) {
    return {
      title: `${SHOWN[figure.key]} ${figure.unit}`.trim(),
      width: "minmax(76px, 1fr)",
      number: true,
      hint: `${figure.title}: ${figure.meaning} ${page.dom.target(figure)}`,
      text: (step) => number(figure.values[step], figure.digits),
      value: (step) => figure.values[step],
      mark: (step) => page.crowd.share(figure.values[step], figure) > 1,
    };
  }

  return { create };
})();
