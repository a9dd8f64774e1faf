/** The crowd: agents, footsteps and figures on the arrays of the data block. */
page.crowd = (() => {
  const NOTHING = -32768;

  /** What everything else asks; positions are in metres around header.origin, times in seconds after header.start. */
  function build({ header, arrays }) {
    const agents = agentsOf(header, arrays);
    const stepAgents = new Uint32Array(arrays.sides.length);
    for (const agent of agents) stepAgents.fill(agent.index, agent.firstStep, agent.firstStep + agent.stepCount);
    const figures = header.figures.map((figure) => ({
      ...figure,
      values: arrays[(figure.perAgent ? "agent:" : "step:") + figure.key],
    }));
    const crowd = {
      header,
      arrays,
      agents,
      figures,
      stepAgents,
      joints: framesFirst(agents, arrays.joints),
      clipStarts: startsOf(arrays.clipCounts),
      duration: agents.reduce((end, agent) => Math.max(end, agent.end), 0),
    };
    Object.assign(crowd, severities(crowd));
    return crowd;
  }

  function agentsOf(header, arrays) {
    let frame = 0;
    let step = 0;
    let joint = 0;
    return header.names.map((name, index) => {
      const stick = header.stickFigures[arrays.stickIndices[index]];
      const frameCount = arrays.frameCounts[index];
      const stepCount = arrays.stepCounts[index];
      const start = arrays.startTimes[index];
      const end = start + (frameCount - 1) * header.frameTime;
      const agent = { index, name, source: header.sources[index], stick, frameCount, stepCount, start, end };
      Object.assign(agent, { firstFrame: frame, firstStep: step, firstJoint: joint });
      frame += frameCount;
      step += stepCount;
      joint += frameCount * stick.parents.length * 3;
      return agent;
    });
  }

  /** Joints by agent, frame, joint and axis, from agent, joint, axis and frame: a pose is read in one go. */
  function framesFirst(agents, stored) {
    const joints = new Int16Array(stored.length);
    for (const { firstJoint, frameCount, stick } of agents) {
      const width = stick.parents.length * 3;
      for (let column = 0; column < width; column++) {
        for (let frame = 0; frame < frameCount; frame++) {
          joints[firstJoint + frame * width + column] = stored[firstJoint + column * frameCount + frame];
        }
      }
    }
    return joints;
  }

  function startsOf(counts) {
    const starts = new Uint32Array(counts.length + 1);
    for (let i = 0; i < counts.length; i++) starts[i + 1] = starts[i] + counts[i];
    return starts;
  }

  /** How much of what a target allows a value uses: above 1 it misses it; NaN without value or target. */
  function share(value, figure) {
    const { target, atLeast } = figure;
    if (target === null || figure.ofMean || !Number.isFinite(value)) return NaN;
    if (!atLeast) return target > 0 ? value / target : value > target ? 1 + value - target : 0;
    if (target < 0) return value < 0 ? value / target : 0;
    return value >= target ? target / Math.max(value, 1e-9) : 1 + (target - value) / target;
  }

  /** The largest share of every footstep and agent, and which figure has it (-1 = none). */
  function severities({ agents, figures, arrays, stepAgents }) {
    const stepSeverity = new Float32Array(stepAgents.length);
    const stepFigure = new Int8Array(stepAgents.length).fill(-1);
    const agentSeverity = new Float32Array(agents.length);
    figures.forEach((figure, number) => {
      for (let i = 0; i < figure.values.length; i++) {
        const part = share(figure.values[i], figure);
        if (figure.perAgent) {
          if (part > agentSeverity[i]) agentSeverity[i] = part;
        } else if (part > stepSeverity[i]) {
          stepSeverity[i] = part;
          stepFigure[i] = number;
        }
      }
    });
    for (let step = 0; step < stepAgents.length; step++) {
      const agent = stepAgents[step];
      if (arrays.promised[step]) agentSeverity[agent] = Math.max(agentSeverity[agent], stepSeverity[step]);
    }
    return { stepSeverity, stepFigure, agentSeverity };
  }

  /** Frame before a time, and how far it is to the next, 0 to 1; before and after its motion an agent stands still. */
  function frameAt(crowd, agent, time) {
    const place = Math.min(Math.max((time - agent.start) / crowd.header.frameTime, 0), agent.frameCount - 1);
    const frame = Math.min(Math.floor(place), Math.max(agent.frameCount - 2, 0));
    return { frame, part: place - frame };
  }

  /** Position of the root at a frame, put into out. */
  function rootAt(crowd, agent, { frame, part }, out) {
    const next = Math.min(frame + 1, agent.frameCount - 1);
    for (let axis = 0; axis < 3; axis++) {
      const row = agent.firstFrame * 3 + axis * agent.frameCount;
      const value = crowd.arrays.roots[row + frame];
      out[axis] = 0.001 * (value + part * (crowd.arrays.roots[row + next] - value));
    }
    return out;
  }

  /** Positions of all joints at a frame, put into out from `offset` on. */
  function jointsAt(crowd, agent, place, root, out, offset) {
    const width = agent.stick.parents.length * 3;
    const first = agent.firstJoint + place.frame * width;
    const second = agent.firstJoint + Math.min(place.frame + 1, agent.frameCount - 1) * width;
    const { joints } = crowd;
    const { resolution } = crowd.header;
    for (let i = 0; i < width; i++) {
      const value = joints[first + i];
      out[offset + i] = root[i % 3] + resolution * (value + place.part * (joints[second + i] - value));
    }
  }

  /** Height of a sole over the terrain at a frame [m], NaN where it is not known. */
  function soleHeight(crowd, agent, side, frame) {
    const value = crowd.arrays.soles[agent.firstFrame * 2 + side * agent.frameCount + frame];
    return value === NOTHING ? NaN : value * crowd.header.soleResolution;
  }

  /** Direction of a footstep on the ground as a unit vector (x, z). */
  function stepForward(crowd, step) {
    const [x, y, z, w] = crowd.arrays.orientations.subarray(4 * step, 4 * step + 4);
    const forward = [2 * (x * z + w * y), 1 - 2 * (x * x + y * y)];
    const length = Math.hypot(...forward) || 1;
    return [forward[0] / length, forward[1] / length];
  }

  return { build, share, frameAt, rootAt, jointsAt, soleHeight, stepForward };
})();
