/** Which clips each step was blended from, from the strike before it to its own; or what it asked of physics. */
page.weights = (() => {
  const { color, leaf, number } = page.dom;
  const MOST = 8; // clips with a color of their own

  function create(holder, crowd, state) {
    page.chart.overTime(holder, crowd, state, {
      height: 112,
      title: "Blend weights",
      plot: (context, x, box, legend) => plot(context, crowd, crowd.agents[state.agent], x, box, legend),
    });
  }

  function plot(context, crowd, agent, x, box, legend) {
    const names = strongest(crowd, agent);
    const y = page.chart.valueAxis(context, box, 0, 1, "");
    if (!names.length) {
      context.fillStyle = color("muted");
      context.textAlign = "center";
      const middle = [0.5 * (box.left + box.right), 0.5 * (box.top + box.bottom)];
      context.fillText("no clips are recorded: the motion is physics", ...middle);
      return page.chart.legend(legend, []);
    }
    const { strikeTimes, clipIndices, clipWeights } = crowd.arrays;
    for (let step = agent.firstStep + 1; step < agent.firstStep + agent.stepCount; step++) {
      const [from, to] = [x(strikeTimes[step - 1]), x(strikeTimes[step])];
      const entries = [];
      for (let i = crowd.clipStarts[step]; i < crowd.clipStarts[step + 1]; i++) {
        entries.push([names.indexOf(clipIndices[i]), clipWeights[i]]);
      }
      let sum = 0;
      for (const [place, weight] of entries.sort((a, b) => a[0] - b[0])) {
        context.fillStyle = color(tone(place));
        context.fillRect(from, y(sum + weight), Math.max(to - from - 1, 0.5), y(sum) - y(sum + weight));
        sum += weight;
      }
    }
    rootWeights(context, crowd, agent, x, y);
    const entries = names.slice(0, MOST).map((clip, place) => [tone(place), leaf(crowd.header.clips[clip])]);
    if (names.length > MOST) entries.push([tone(MOST), `${names.length - MOST} more`]);
    entries.push(["ink", `root weight, mean ${number(meanRootWeight(crowd, agent), 2)}`]);
    page.chart.legend(legend, entries);
  }

  const tone = (place) => (place >= 0 && place < MOST ? `clip-${place}` : "clip-rest");

  /** Clips of an agent, the most used first. */
  function strongest(crowd, agent) {
    const sums = new Map();
    const { clipIndices, clipWeights } = crowd.arrays;
    const [first, last] = [crowd.clipStarts[agent.firstStep], crowd.clipStarts[agent.firstStep + agent.stepCount]];
    for (let i = first; i < last; i++) sums.set(clipIndices[i], (sums.get(clipIndices[i]) ?? 0) + clipWeights[i]);
    return [...sums.entries()].sort((a, b) => b[1] - a[1]).map(([clip]) => clip);
  }

  function rootWeights(context, crowd, agent, x, y) {
    const { strikeTimes, rootWeights: weights } = crowd.arrays;
    context.strokeStyle = color("ink");
    context.lineWidth = 2;
    for (let step = agent.firstStep + 1; step < agent.firstStep + agent.stepCount; step++) {
      if (!Number.isFinite(weights[step])) continue;
      const height = y(weights[step]);
      page.chart.stroke(context, [x(strikeTimes[step - 1]), height], [x(strikeTimes[step]), height]);
    }
    context.lineWidth = 1;
  }

  function meanRootWeight(crowd, agent) {
    const values = crowd.arrays.rootWeights.subarray(agent.firstStep, agent.firstStep + agent.stepCount);
    const known = values.filter(Number.isFinite);
    return known.length ? known.reduce((sum, value) => sum + value, 0) / known.length : NaN;
  }

  return { create };
})();
