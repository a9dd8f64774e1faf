/** How high the soles are over the terrain, and how high the ground and the pelvis are. */
page.heights = (() => {
  const { color } = page.dom;
  const SIDES = ["left", "right"];

  function create(holder, crowd, state) {
    page.chart.overTime(holder, crowd, state, {
      height: 120,
      title: "Soles over the terrain [mm]",
      plot: (context, x, box, legend) => soles(context, crowd, state, x, box, legend),
    });
    page.chart.overTime(holder, crowd, state, {
      height: 104,
      title: "Height of pelvis and ground [m]",
      plot: (context, x, box, legend) => elevations(context, crowd, state, x, box, legend),
    });
  }

  function soles(context, crowd, state, x, box, legend) {
    const agent = crowd.agents[state.agent];
    const height = (side) => (frame) => 1000 * page.crowd.soleHeight(crowd, agent, side, frame);
    let [low, high] = [-5, 60];
    for (let frame = 0; frame < agent.frameCount; frame++) {
      for (const side of [0, 1]) {
        const value = height(side)(frame);
        if (value < low) low = value;
        if (value > high) high = value;
      }
    }
    const y = page.chart.valueAxis(context, box, low, high, "");
    swings(context, crowd, agent, x, y, box);
    context.lineWidth = 1.5;
    for (const side of [0, 1]) {
      context.strokeStyle = color(SIDES[side]);
      page.chart.curve(context, agent, crowd.header.frameTime, x, y, height(side));
    }
    context.lineWidth = 1;
    const least = crowd.figures.find((figure) => figure.key === "clearance").target;
    const deepest = crowd.figures.find((figure) => figure.key === "sole").target;
    context.strokeStyle = color("over");
    context.setLineDash([5, 4]);
    page.chart.stroke(context, [box.left, y(deepest)], [box.right, y(deepest)]);
    context.setLineDash([]);
    page.chart.legend(legend, [
      ["left", "left"],
      ["right", "right"],
      ["swing", `mid swing: at least ${least} mm`],
      ["over", `deepest allowed: ${deepest} mm`],
    ]);
  }

  /** The part of each swing in which the clearance counts. */
  function swings(context, crowd, agent, x, y, box) {
    const { strikeTimes, liftoffTimes, sides } = crowd.arrays;
    const least = crowd.figures.find((figure) => figure.key === "clearance").target;
    const last = [NaN, NaN];
    context.fillStyle = color("swing");
    for (let step = agent.firstStep; step < agent.firstStep + agent.stepCount; step++) {
      const [from, to] = [last[sides[step]], strikeTimes[step]];
      if (to > from) {
        const [begin, end] = [x(from + 0.2 * (to - from)), x(from + 0.8 * (to - from))];
        context.fillRect(begin, y(least), end - begin, Math.min(y(0), box.bottom) - y(least));
      }
      last[sides[step]] = liftoffTimes[step];
    }
  }

  function elevations(context, crowd, state, x, box, legend) {
    const agent = crowd.agents[state.agent];
    const shift = crowd.header.origin[1];
    const joints = new Float32Array(3 * agent.stick.parents.length);
    const root = [];
    const [grounds, pelvises] = [[], []];
    for (let frame = 0; frame < agent.frameCount; frame++) {
      const place = { frame, part: 0 };
      page.crowd.jointsAt(crowd, agent, place, page.crowd.rootAt(crowd, agent, place, root), joints, 0);
      grounds.push(root[1] + shift);
      pelvises.push(joints[1] + shift);
    }
    const low = Math.min(...grounds);
    const y = page.chart.valueAxis(context, box, low - 0.05, Math.max(...pelvises) + 0.05, "");
    context.lineWidth = 1.5;
    for (const [tone, values] of [["ground-edge", grounds], ["accent", pelvises]]) {
      context.strokeStyle = color(tone);
      page.chart.curve(context, agent, crowd.header.frameTime, x, y, (frame) => values[frame]);
    }
    context.lineWidth = 1;
    page.chart.legend(legend, [
      ["accent", "pelvis"],
      ["ground-edge", "ground below the root"],
    ]);
  }

  return { create };
})();
