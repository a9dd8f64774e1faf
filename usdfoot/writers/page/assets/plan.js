/** The way of the chosen agent from above: footprints as planned, where the ball stood, the path of the root. */
page.plan = (() => {
  const { element, color, number, withUnit } = page.dom;
  const MAGNIFICATIONS = [1000, 100, 10, 1];

  function create(crowd, state) {
    const holder = page.dom.byId("plan");
    const scale = element("span", { class: "hint" });
    const tip = element("div", { class: "tip", hidden: true });
    holder.append(element("h3", {}, "From above ", scale));
    const body = element("div", { class: "plot" });
    const legend = element("div", { class: "legend" });
    holder.append(body, legend);
    const look = { zoom: 1, x: 0, y: 0 };
    let seen = null;
    const drawing = page.chart.canvas(body, 0, "Footprints and root path from above", (context, width, height) => {
      seen = layout(crowd, crowd.agents[state.agent], width, height, look);
      const magnification = magnify(crowd, crowd.agents[state.agent]);
      scale.textContent = `placement errors drawn \u00d7 ${magnification}, \u00d7 1 where the status promises nothing`;
      paint(context, crowd, state, seen, magnification);
    });
    body.append(tip);
    page.chart.legend(legend, [
      ["left", "left print"],
      ["right", "right print"],
      ["ink", "where the ball stood"],
      ["over", "dashed: promises nothing"],
      ["accent", "root"],
    ]);

    function reset() {
      Object.assign(look, { zoom: 1, x: 0, y: 0 });
      drawing.redraw();
    }

    body.addEventListener("wheel", (event) => {
      const factor = Math.exp(-0.0015 * event.deltaY);
      const box = body.getBoundingClientRect();
      const [x, y] = [event.clientX - box.left - 0.5 * box.width, event.clientY - box.top - 0.5 * box.height];
      const zoom = Math.min(Math.max(look.zoom * factor, 1), 200);
      look.x = x - ((x - look.x) * zoom) / look.zoom;
      look.y = y - ((y - look.y) * zoom) / look.zoom;
      look.zoom = zoom;
      event.preventDefault();
      drawing.redraw();
    }, { passive: false });
    body.addEventListener("pointermove", (event) => {
      if (event.buttons) {
        look.x += event.movementX;
        look.y += event.movementY;
        drawing.redraw();
      }
      const box = body.getBoundingClientRect();
      const step = nearest(crowd, state, seen, event.clientX - box.left, event.clientY - box.top);
      tip.hidden = step < 0;
      if (step >= 0) {
        tip.style.left = `${Math.min(event.clientX - box.left + 12, box.width - 190)}px`;
        tip.style.top = `${event.clientY - box.top + 12}px`;
        tip.replaceChildren(...describe(crowd, step).map((line) => element("div", {}, line)));
      }
    });
    body.addEventListener("pointerleave", () => (tip.hidden = true));
    body.addEventListener("dblclick", reset);
    body.addEventListener("click", (event) => {
      const box = body.getBoundingClientRect();
      const step = nearest(crowd, state, seen, event.clientX - box.left, event.clientY - box.top);
      if (step >= 0) state.chooseStep(step);
    });
    state.on("agent", reset);
    state.on("time step theme", drawing.redraw);
  }

  /** From the world to the canvas: the way from the first to the last footstep goes to the right. */
  function layout(crowd, agent, width, height, look) {
    const { positions } = crowd.arrays;
    const at = (step) => [positions[3 * step], positions[3 * step + 2]];
    const steps = Array.from({ length: agent.stepCount }, (_, i) => agent.firstStep + i);
    const [from, to] = [at(steps[0]), at(steps[steps.length - 1])];
    const away = Math.hypot(to[0] - from[0], to[1] - from[1]);
    const [ux, uz] = away > agent.stick.legLength ? [(to[0] - from[0]) / away, (to[1] - from[1]) / away] : [1, 0];
    const turned = steps.map(at).map(([x, z]) => [x * ux + z * uz, z * ux - x * uz]);
    const margin = 3 * agent.stick.footLength;
    const low = [0, 1].map((axis) => Math.min(...turned.map((point) => point[axis])) - margin);
    const high = [0, 1].map((axis) => Math.max(...turned.map((point) => point[axis])) + margin);
    const size = look.zoom * Math.min(width / (high[0] - low[0]), height / (high[1] - low[1]));
    const [cx, cy] = [0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])];
    const place = (x, z) => [
      0.5 * width + look.x + size * (x * ux + z * uz - cx),
      0.5 * height + look.y + size * (z * ux - x * uz - cy),
    ];
    return { place, size, steps, width, height };
  }

  /** How much larger errors are drawn: so that the largest that is promised stays within a foot. */
  function magnify(crowd, agent) {
    const { values } = crowd.figures.find((figure) => figure.key === "placement");
    let worst = 0;
    for (let step = agent.firstStep; step < agent.firstStep + agent.stepCount; step++) {
      if (crowd.arrays.promised[step] && values[step] > worst) worst = values[step];
    }
    return MAGNIFICATIONS.find((factor) => 0.001 * worst * factor <= agent.stick.footLength) ?? 1;
  }

  function paint(context, crowd, state, seen, magnification) {
    const agent = crowd.agents[state.agent];
    ruler(context, seen);
    rootPath(context, crowd, agent, seen);
    for (const step of seen.steps) footprint(context, crowd, state, step, agent.stick.footLength, seen);
    for (const step of seen.steps) stood(context, crowd, step, seen, magnification);
    const root = page.crowd.rootAt(crowd, agent, page.crowd.frameAt(crowd, agent, state.time), []);
    const [x, y] = seen.place(root[0], root[2]);
    context.fillStyle = color("accent");
    context.beginPath();
    context.arc(x, y, 5, 0, 2 * Math.PI);
    context.fill();
  }

  function rootPath(context, crowd, agent, { place }) {
    context.strokeStyle = color("accent");
    context.lineWidth = 1.5;
    context.beginPath();
    for (let frame = 0; frame < agent.frameCount; frame++) {
      const root = page.crowd.rootAt(crowd, agent, { frame, part: 0 }, []);
      context.lineTo(...place(root[0], root[2]));
    }
    context.stroke();
    context.lineWidth = 1;
  }

  function footprint(context, crowd, state, step, size, { place }) {
    const { positions, sides, strikeTimes, liftoffTimes, promised } = crowd.arrays;
    const [sin, cos] = page.crowd.stepForward(crowd, step);
    const corners = crowd.header.printOutline;
    const mirror = sides[step] ? -size : size;
    context.beginPath();
    for (let i = 0; i < corners.length; i += 2) {
      const [x, z] = [corners[i] * mirror, corners[i + 1] * size];
      context.lineTo(...place(positions[3 * step] + x * cos + z * sin, positions[3 * step + 2] - x * sin + z * cos));
    }
    context.closePath();
    const tone = color(sides[step] ? "right" : "left");
    const stands = strikeTimes[step] <= state.time && state.time <= liftoffTimes[step];
    context.globalAlpha = stands ? 0.75 : 0.25;
    context.fillStyle = tone;
    context.fill();
    context.globalAlpha = 1;
    context.lineWidth = step === state.step ? 3 : 1;
    context.strokeStyle = step === state.step ? color("chosen") : promised[step] ? tone : color("over");
    context.setLineDash(promised[step] ? [] : [4, 3]);
    context.stroke();
    context.setLineDash([]);
    context.lineWidth = 1;
  }

  /** The ball's place, moved away from the footstep by the error times the magnification. */
  function stood(context, crowd, step, { place, size }, magnification) {
    const { positions, stood: places } = crowd.arrays;
    const [x, z] = [positions[3 * step], positions[3 * step + 2]];
    const [dx, dz] = [places[3 * step] - x, places[3 * step + 2] - z];
    if (!Number.isFinite(dx)) return;
    const larger = crowd.arrays.promised[step] ? magnification : 1;
    const from = place(x, z);
    const to = place(x + larger * dx, z + larger * dz);
    context.strokeStyle = context.fillStyle = color("ink");
    page.chart.stroke(context, from, to);
    context.beginPath();
    context.arc(...to, Math.min(Math.max(0.012 * size, 1.5), 4), 0, 2 * Math.PI);
    context.fill();
  }

  /** A metre, or what of it fits. */
  function ruler(context, { size, height }) {
    const length = [100, 50, 20, 10, 5, 2, 1, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01].find((value) => value * size <= 140) ?? 0.01;
    context.strokeStyle = context.fillStyle = color("muted");
    context.lineWidth = 2;
    page.chart.stroke(context, [14, height - 12], [14 + length * size, height - 12]);
    context.lineWidth = 1;
    context.textAlign = "left";
    context.fillText(`${length} m`, 14, height - 18);
  }

  function nearest(crowd, state, seen, x, y) {
    if (!seen) return -1;
    const { footLength } = crowd.agents[state.agent].stick;
    const reach = Math.max(footLength * seen.size, 12);
    let [found, least] = [-1, reach];
    for (const step of seen.steps) {
      const place = seen.place(crowd.arrays.positions[3 * step], crowd.arrays.positions[3 * step + 2]);
      const distance = Math.hypot(place[0] - x, place[1] - y);
      if (distance < least) [found, least] = [step, distance];
    }
    return found;
  }

  /** Lines about a footstep. */
  function describe(crowd, step) {
    const { arrays, header, figures, agents, stepAgents } = crowd;
    const agent = agents[stepAgents[step]];
    const seconds = (time) => number(time + header.start, 2);
    const lines = [
      `footstep ${step - agent.firstStep}, ${arrays.sides[step] ? "right" : "left"}: ${header.statuses[arrays.stepStatuses[step]]}`,
      `strike ${seconds(arrays.strikeTimes[step])} s, liftoff ${seconds(arrays.liftoffTimes[step])} s`,
    ];
    for (const figure of figures) {
      if (figure.perAgent || !Number.isFinite(figure.values[step])) continue;
      const missed = page.crowd.share(figure.values[step], figure) > 1 ? " \u25b2" : "";
      lines.push(`${figure.title} ${withUnit(figure.values[step], figure)}${missed}`);
    }
    return lines;
  }

  return { create, describe };
})();
