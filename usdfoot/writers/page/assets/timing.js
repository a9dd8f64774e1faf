/** When which foot stands: the timing diagram of [P] Figure 1 (b), and below it on how many feet. */
page.timing = (() => {
  const { color } = page.dom;
  const NAMES = ["left", "right"];

  function create(holder, crowd, state) {
    const chart = page.chart.overTime(holder, crowd, state, {
      height: 112,
      title: "Contacts",
      plot: (context, x, box, legend) => {
        plot(context, crowd, state, x, box);
        page.chart.legend(legend, [
          ["left", "left stands"],
          ["right", "right stands"],
          ["both", "double stance"],
          ["flight", "flight"],
        ]);
      },
    });
    chart.body.addEventListener("dblclick", () => choose(crowd, state));
  }

  /** The footstep whose foot came down last. */
  function choose(crowd, state) {
    const { firstStep, stepCount } = crowd.agents[state.agent];
    let found = firstStep;
    for (let step = firstStep; step < firstStep + stepCount; step++) {
      if (crowd.arrays.strikeTimes[step] <= state.time) found = step;
    }
    state.set({ step: found });
  }

  function plot(context, crowd, state, x, box) {
    const agent = crowd.agents[state.agent];
    const height = (box.bottom - box.top) / 3;
    const row = (number) => box.top + number * height;
    context.fillStyle = color("muted");
    context.textAlign = "right";
    ["left", "right", "support"].forEach((name, i) => context.fillText(name, box.left - 5, row(i) + 0.5 * height + 4));
    const { strikeTimes, flatTimes, liftoffTimes, sides } = crowd.arrays;
    for (let step = agent.firstStep; step < agent.firstStep + agent.stepCount; step++) {
      const side = sides[step];
      const [strike, flat, liftoff] = [strikeTimes, flatTimes, liftoffTimes].map((times) => x(times[step]));
      const top = row(side) + 3;
      context.fillStyle = color(NAMES[side]);
      context.globalAlpha = 0.45;
      context.fillRect(strike, top, flat - strike, height - 6);
      context.globalAlpha = 1;
      context.fillRect(flat, top, liftoff - flat, height - 6);
      if (step === state.step) {
        context.strokeStyle = color("chosen");
        context.lineWidth = 3;
        context.strokeRect(strike, top, liftoff - strike, height - 6);
        context.lineWidth = 1;
      }
      if (liftoff - strike > 16) {
        context.fillStyle = color("on-side");
        context.textAlign = "center";
        context.fillText(step - agent.firstStep, 0.5 * (strike + liftoff), row(side) + 0.5 * height + 4);
      }
    }
    support(context, crowd, agent, x, row(2) + 3, height - 6);
  }

  /** Between any two events: on which feet the agent stands. */
  function support(context, crowd, agent, x, top, height) {
    const { strikeTimes, liftoffTimes, sides } = crowd.arrays;
    const events = [];
    for (let step = agent.firstStep; step < agent.firstStep + agent.stepCount; step++) {
      events.push([strikeTimes[step], sides[step], 1], [liftoffTimes[step], sides[step], -1]);
    }
    events.sort((a, b) => a[0] - b[0]);
    const feet = [0, 0];
    events.forEach(([time, side, change], i) => {
      feet[side] += change;
      if (i === events.length - 1) return;
      const name = feet[0] && feet[1] ? "both" : feet[0] ? "left" : feet[1] ? "right" : "flight";
      context.fillStyle = color(name);
      context.fillRect(x(time), top, x(events[i + 1][0]) - x(time), height);
    });
  }

  return { create };
})();
