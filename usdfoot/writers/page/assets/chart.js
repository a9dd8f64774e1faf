/** Drawings on canvases that follow the size of their place and the theme; and those over time, with one cursor. */
page.chart = (() => {
  const { element, color } = page.dom;
  const FONT = "11px system-ui, sans-serif";
  const MARGIN = { left: 46, right: 10, top: 8, bottom: 20 };

  /** A canvas in a place; `draw` gets its context, width and height in CSS pixels. */
  function canvas(holder, height, label, draw) {
    const made = element("canvas", { role: "img", "aria-label": label });
    if (height) made.style.height = `${height}px`;
    holder.append(made);
    function redraw() {
      const { clientWidth, clientHeight } = made;
      if (!clientWidth || !clientHeight) return;
      const ratio = Math.min(window.devicePixelRatio, 2);
      made.width = Math.round(clientWidth * ratio);
      made.height = Math.round(clientHeight * ratio);
      const context = made.getContext("2d");
      context.scale(ratio, ratio);
      context.font = FONT;
      context.lineWidth = 1;
      draw(context, clientWidth, clientHeight);
    }
    new ResizeObserver(redraw).observe(made);
    return { canvas: made, redraw };
  }

  /** Round numbers between two, about `count` of them. */
  function ticks(low, high, count) {
    const raw = (high - low) / Math.max(count, 1);
    if (!(raw > 0)) return [low];
    const power = 10 ** Math.floor(Math.log10(raw));
    const spacing = power * [1, 2, 5, 10].find((step) => step * power >= raw * 0.999);
    const first = Math.ceil(low / spacing - 1e-9);
    const last = Math.floor(high / spacing + 1e-9);
    return Array.from({ length: last - first + 1 }, (_, i) => Number(((first + i) * spacing).toPrecision(12)));
  }

  /** A chart over the time of the chosen agent; a click goes there. `plot` gets context, x(time) and the inner box. */
  function overTime(holder, crowd, state, { height, title, plot }) {
    const frame = element("div", { class: "chart" }, element("h3", {}, title));
    const body = element("div", { class: "plot" });
    const cursor = element("div", { class: "cursor" });
    const legend = element("div", { class: "legend" });
    frame.append(body, legend);
    holder.append(frame);
    const drawing = canvas(body, height, title, (context, width, full) => {
      const box = { left: MARGIN.left, right: width - MARGIN.right, top: MARGIN.top, bottom: full - MARGIN.bottom };
      const { start, end } = crowd.agents[state.agent];
      const x = (time) => box.left + ((time - start) / Math.max(end - start, 1e-6)) * (box.right - box.left);
      timeAxis(context, box, x, start, end, crowd.header.start);
      plot(context, x, box, legend);
    });
    body.append(cursor);

    function move() {
      const { start, end } = crowd.agents[state.agent];
      const part = (state.time - start) / Math.max(end - start, 1e-6);
      cursor.hidden = part < 0 || part > 1;
      cursor.style.left = `calc(${MARGIN.left}px + ${part} * (100% - ${MARGIN.left + MARGIN.right}px))`;
    }

    body.addEventListener("pointerdown", (event) => {
      const inside = event.clientX - body.getBoundingClientRect().left - MARGIN.left;
      const part = inside / (body.clientWidth - MARGIN.left - MARGIN.right);
      const { start, end } = crowd.agents[state.agent];
      state.set({ playing: false, time: start + Math.min(Math.max(part, 0), 1) * (end - start) });
    });
    state.on("agent time", move);
    state.on("agent step theme", drawing.redraw);
    move();
    return { body, legend, redraw: drawing.redraw };
  }

  function timeAxis(context, box, x, start, end, shift) {
    context.strokeStyle = color("line");
    context.fillStyle = color("muted");
    context.textAlign = "center";
    for (const tick of ticks(start + shift, end + shift, (box.right - box.left) / 70)) {
      const place = Math.round(x(tick - shift)) + 0.5;
      stroke(context, [place, box.top], [place, box.bottom]);
      context.fillText(`${tick} s`, place, box.bottom + 14);
    }
  }

  /** Lines and numbers at heights of the box; gives back y(value). */
  function valueAxis(context, box, low, high, unit) {
    const y = (value) => box.bottom - ((value - low) / Math.max(high - low, 1e-9)) * (box.bottom - box.top);
    context.strokeStyle = color("line");
    context.fillStyle = color("muted");
    context.textAlign = "right";
    const marks = ticks(low, high, (box.bottom - box.top) / 26);
    marks.forEach((mark, i) => {
      const place = Math.round(y(mark)) + 0.5;
      stroke(context, [box.left, place], [box.right, place]);
      context.fillText(i === marks.length - 1 ? `${mark} ${unit}` : `${mark}`, box.left - 5, place + 3);
    });
    return y;
  }

  function stroke(context, from, to) {
    context.beginPath();
    context.moveTo(...from);
    context.lineTo(...to);
    context.stroke();
  }

  /** A line through values over frames of an agent; NaN breaks it. */
  function curve(context, agent, frameTime, x, y, value) {
    context.beginPath();
    let open = false;
    for (let frame = 0; frame < agent.frameCount; frame++) {
      const height = value(frame);
      if (Number.isFinite(height)) {
        if (open) context.lineTo(x(agent.start + frame * frameTime), y(height));
        else context.moveTo(x(agent.start + frame * frameTime), y(height));
      }
      open = Number.isFinite(height);
    }
    context.stroke();
  }

  /** Squares in colors of the style, by name, with what they stand for. */
  function legend(holder, entries) {
    holder.replaceChildren(
      ...entries.map(([tone, text]) => {
        const square = element("i");
        square.style.background = `var(--${tone})`;
        return element("span", {}, square, text);
      }),
    );
  }

  return { canvas, ticks, overTime, valueAxis, stroke, curve, legend };
})();
