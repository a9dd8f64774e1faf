/** How all footsteps and agents of the filter do: a histogram for each figure of design.md section 10. */
page.histograms = (() => {
  const { element, byId, color, number, withUnit, target } = page.dom;
  const BINS = 24;
  const KINDS = ["good", "over", "unpromised"];

  function create(crowd, state) {
    const holder = byId("histograms");
    const parts = crowd.figures.map((figure) => {
      const caption = element("p", { class: "hint" });
      const card = element("div", { class: "histogram" }, element("h3", { title: figure.meaning }, title(figure)));
      holder.append(card);
      let counted = count(crowd, state, figure);
      const drawing = page.chart.canvas(card, 118, figure.title, (context, width, height) => {
        paint(context, figure, counted, width, height);
      });
      card.append(caption);
      const show = () => {
        counted = count(crowd, state, figure);
        card.hidden = !counted.known && figure.target === null;
        caption.textContent = words(figure, counted);
        drawing.canvas.hidden = !counted.known;
        drawing.redraw();
      };
      show();
      return { show, redraw: drawing.redraw };
    });
    const legend = element("div", { class: "legend" });
    holder.before(legend);
    page.chart.legend(legend, [
      ["good", "within the target"],
      ["over", "target missed"],
      ["unpromised", "status promises nothing"],
      ["ink", "target (dashed)"],
    ]);
    let due = 0;
    state.on("shown", () => {
      clearTimeout(due);
      due = setTimeout(() => parts.forEach((part) => part.show()), 120);
    });
    state.on("theme", () => parts.forEach((part) => part.redraw()));
  }

  const title = (figure) => (figure.unit ? `${figure.title} [${figure.unit}]` : figure.title);

  /** Numbers in each bin by kind, and what the values are like. */
  function count(crowd, state, figure) {
    const values = [];
    for (let i = 0; i < figure.values.length; i++) {
      const agent = figure.perAgent ? i : crowd.stepAgents[i];
      if (!state.shown[agent] || !Number.isFinite(figure.values[i])) continue;
      const kept = figure.perAgent || crowd.arrays.promised[i];
      const missed = page.crowd.share(figure.values[i], figure) > 1;
      values.push([figure.values[i], kept ? (missed ? 1 : 0) : 2]);
    }
    values.sort((a, b) => a[0] - b[0]);
    const { low, high } = range(values, figure);
    const bins = KINDS.map(() => new Uint32Array(BINS));
    for (const [value, kind] of values) {
      const bin = Math.floor(((value - low) / (high - low)) * BINS);
      bins[kind][Math.min(Math.max(bin, 0), BINS - 1)]++;
    }
    const promised = values.filter(([, kind]) => kind < 2).map(([value]) => value);
    return {
      low,
      high,
      bins,
      known: values.length,
      beyond: values.filter(([value]) => value > high).length,
      mean: promised.reduce((sum, value) => sum + value, 0) / promised.length,
      worst: figure.atLeast ? promised[0] : promised[promised.length - 1],
      missed: values.filter(([, kind]) => kind === 1).length,
    };
  }

  /** What the bins cover: all but the largest hundredth of the values, and the target. */
  function range(values, figure) {
    if (!values.length) return { low: 0, high: 1 };
    const most = values[Math.floor(0.99 * (values.length - 1))][0];
    let low = Math.min(values[0][0], 0);
    let high = Math.max(most, 10 ** -figure.digits);
    if (figure.target !== null) {
      low = Math.min(low, figure.target);
      high = Math.max(high, 1.15 * figure.target);
    }
    return { low, high };
  }

  function paint(context, figure, counted, width, height) {
    const box = { left: 34, right: width - 8, top: 8, bottom: height - 20 };
    const sums = Array.from({ length: BINS }, (_, bin) => counted.bins.reduce((sum, part) => sum + part[bin], 0));
    const most = Math.max(...sums, 1);
    const x = (value) => box.left + ((value - counted.low) / (counted.high - counted.low)) * (box.right - box.left);
    const scaled = (number) => Math.sqrt(number / most) * (box.bottom - box.top);
    axes(context, box, x, counted, most, scaled);
    const each = (box.right - box.left) / BINS;
    for (let bin = 0; bin < BINS; bin++) {
      let sum = 0;
      KINDS.forEach((kind, number) => {
        const [bottom, top] = [scaled(sum), scaled((sum += counted.bins[number][bin]))];
        context.fillStyle = color(kind);
        if (top > bottom) context.fillRect(box.left + bin * each + 0.5, box.bottom - top, each - 1, Math.max(top - bottom, 1));
      });
    }
    if (figure.target === null) return;
    context.strokeStyle = color("ink");
    context.lineWidth = 1.5;
    context.setLineDash([4, 3]);
    page.chart.stroke(context, [x(figure.target), box.top - 4], [x(figure.target), box.bottom]);
    context.setLineDash([]);
    context.lineWidth = 1;
  }

  function axes(context, box, x, counted, most, scaled) {
    context.fillStyle = color("muted");
    context.strokeStyle = color("line");
    context.textAlign = "right";
    context.fillText(most, box.left - 4, box.bottom - scaled(most) + 8);
    context.fillText("0", box.left - 4, box.bottom);
    page.chart.stroke(context, [box.left, box.bottom + 0.5], [box.right, box.bottom + 0.5]);
    context.textAlign = "center";
    for (const tick of page.chart.ticks(counted.low, counted.high, 4)) context.fillText(tick, x(tick), box.bottom + 14);
  }

  /** What the picture says. */
  function words(figure, counted) {
    if (!counted.known) return "nothing to measure";
    const parts = [`mean ${number(counted.mean, figure.digits)}`, `worst ${withUnit(counted.worst, figure)}`];
    parts.push(target(figure));
    if (counted.missed) parts.push(`\u25b2 ${counted.missed} over`);
    if (counted.beyond) parts.push(`last bar: ${counted.beyond} beyond`);
    return parts.join(" \u00b7 ");
  }

  return { create };
})();
