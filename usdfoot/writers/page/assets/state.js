/** What the person looking at the page chose; whoever shows it listens. */
page.state = (() => {
  function create(crowd) {
    const listeners = {};
    const state = {
      time: 0,
      playing: false,
      speed: 1,
      agent: crowd.agentSeverity.reduce((worst, part, agent, parts) => (part > parts[worst] ? agent : worst), 0),
      step: -1,
      follow: false,
      prints: true,
      alone: false,
      shown: new Uint8Array(crowd.agents.length).fill(1),

      /** Call `listener` whenever one of some values was set. */
      on(keys, listener) {
        for (const key of keys.split(" ")) (listeners[key] ??= []).push(listener);
      },

      /** Set some values and tell who listens, each once. */
      set(values) {
        Object.assign(state, values);
        const told = new Set(Object.keys(values).flatMap((key) => listeners[key] ?? []));
        for (const listener of told) listener();
      },

      /** Choose an agent, and go to its beginning if it is not moving now. */
      chooseAgent(agent) {
        const { start, end } = crowd.agents[agent];
        const time = state.time < start || state.time > end ? start : state.time;
        state.set({ agent, step: -1, time });
      },

      /** Choose a footstep, its agent, and the middle of its contact. */
      chooseStep(step) {
        const { strikeTimes, liftoffTimes } = crowd.arrays;
        const time = 0.5 * (strikeTimes[step] + liftoffTimes[step]);
        state.set({ step, agent: crowd.stepAgents[step], time: Math.min(Math.max(time, 0), crowd.duration) });
      },
    };
    return state;
  }

  return { create };
})();
