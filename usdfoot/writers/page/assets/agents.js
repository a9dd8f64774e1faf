/** The list of agents and the filter that says which are shown, here and everywhere. */
page.agents = (() => {
  const { element, byId, number, leaf } = page.dom;

  function create(crowd, state) {
    const holder = byId("agents");
    const name = element("input", { type: "search", placeholder: "name, part of it, or * ?", "aria-label": "filter by name" });
    const status = element("select", { "aria-label": "filter by state" }, ...choices(crowd));
    const found = element("span", { class: "hint", role: "status" });
    holder.append(
      element("h2", {}, "Agents ", found),
      element("div", { class: "bar small" }, name, status),
    );
    const rows = page.rows.create(holder, columns(crowd), {
      label: "agents",
      sort: 2,
      onPick: (agent) => state.chooseAgent(agent),
      isChosen: (agent) => agent === state.agent,
    });

    function filter() {
      const named = pattern(name.value.trim());
      const stated = statusTest(crowd, status.value);
      const shown = Uint8Array.from(crowd.agents, (agent) => Number(named.test(agent.name) && stated(agent)));
      const left = [...shown.keys()].filter((agent) => shown[agent]);
      found.textContent = `${left.length} of ${shown.length}`;
      rows.show(left);
      state.set({ shown });
    }

    name.addEventListener("input", filter);
    status.addEventListener("change", filter);
    state.on("agent", rows.draw);
    filter();
  }

  function columns(crowd) {
    const worst = (agent) => crowd.agentSeverity[agent];
    return [
      { title: "agent", width: "1fr", text: (agent) => crowd.agents[agent].name, value: (agent) => crowd.agents[agent].name },
      {
        title: "steps",
        width: "64px",
        number: true,
        text: (agent) => String(crowd.agents[agent].stepCount),
        value: (agent) => crowd.agents[agent].stepCount,
      },
      {
        title: "of target",
        width: "96px",
        number: true,
        hint: "the figure nearest to its target or farthest beyond: 100 % is the target",
        text: (agent) => `${number(100 * worst(agent), 0)} %`,
        value: worst,
        mark: (agent) => worst(agent) > 1,
      },
    ];
  }

  /** All, those with something wrong, and every status that occurs. */
  function choices(crowd) {
    const present = new Set(crowd.arrays.stepStatuses);
    const options = [
      ["all", "all"],
      ["over", "over a target"],
      ["unpromised", "with steps that promise nothing"],
      ...crowd.header.statuses.map((status, i) => [`status ${i}`, `with ${status} steps`]).filter((_, i) => present.has(i)),
    ];
    return options.map(([value, text]) => element("option", { value }, text));
  }

  function statusTest(crowd, choice) {
    const { stepStatuses, promised } = crowd.arrays;
    const some = (test) => (agent) => {
      for (let step = agent.firstStep; step < agent.firstStep + agent.stepCount; step++) if (test(step)) return true;
      return false;
    };
    if (choice === "over") return (agent) => crowd.agentSeverity[agent.index] > 1;
    if (choice === "unpromised") return some((step) => !promised[step]);
    if (choice === "all") return () => true;
    const wanted = Number(choice.split(" ")[1]);
    return some((step) => stepStatuses[step] === wanted);
  }

  /** Part of a name, or all of it where * and ? stand for anything. */
  function pattern(text) {
    const literal = text.replace(/[.+^${}()|[\]\\]/g, "\\$&");
    if (!/[*?]/.test(text)) return new RegExp(literal, "i");
    return new RegExp(`^${literal.replace(/\*/g, ".*").replace(/\?/g, ".")}$`, "i");
  }

  /** Heading of the panel of the chosen agent. */
  function heading(crowd, state) {
    const holder = byId("agentHead");
    function show() {
      const agent = crowd.agents[state.agent];
      const facts = [
        `${agent.stepCount} footsteps`,
        `${number(agent.start + crowd.header.start, 2)} to ${number(agent.end + crowd.header.start, 2)} s`,
      ];
      if (agent.source) facts.push(`from ${agent.source}`);
      for (const figure of crowd.figures) {
        if (figure.perAgent && Number.isFinite(figure.values[agent.index])) {
          const missed = page.crowd.share(figure.values[agent.index], figure) > 1 ? "\u25b2 " : "";
          facts.push(`${missed}${figure.title} ${page.dom.withUnit(figure.values[agent.index], figure)}`);
        }
      }
      const chosen = state.step >= 0 ? page.plan.describe(crowd, state.step) : [];
      holder.replaceChildren(
        element("h2", {}, `Agent ${leaf(agent.name)}`),
        element("p", { class: "hint" }, facts.join(" \u00b7 ")),
        chosen.length ? element("p", { class: "chosenStep" }, chosen.join(" \u00b7 ")) : "",
      );
    }
    state.on("agent step", show);
    show();
  }

  return { create, heading };
})();
