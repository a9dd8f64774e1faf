/** A table of any length: only the rows in sight exist. A click on a heading sorts, on a row chooses. */
page.rows = (() => {
  const { element } = page.dom;
  const HEIGHT = 26;
  const SPARE = 6; // rows made beyond those in sight

  /**
   * @param holder   where the table goes
   * @param columns  {title, width, number, text(row), value(row), mark(row), hint}
   * @param options  {label, sort, descending, onPick(row), isChosen(row)}
   */
  function create(holder, columns, { label, sort = 0, descending = true, onPick, isChosen }) {
    const head = element("div", { class: "row head", role: "row" });
    const inner = element("div", { class: "inner" });
    const body = element("div", { class: "scroll", tabIndex: 0, role: "listbox", "aria-label": label }, inner);
    const template = columns.map((column) => column.width).join(" ");
    head.style.gridTemplateColumns = template;
    holder.append(element("div", { class: "table" }, head, body));
    const order = { column: sort, descending };
    let rows = [];

    const headings = columns.map((column, number) => {
      const heading = element("button", { type: "button", class: column.number ? "number" : "", title: column.hint ?? "" });
      heading.addEventListener("click", () => {
        const again = order.column === number;
        Object.assign(order, { column: number, descending: again ? !order.descending : Boolean(column.number) });
        arrange();
      });
      head.append(heading);
      return heading;
    });

    function arrange() {
      const { value } = columns[order.column];
      const keys = new Map(rows.map((row) => [row, value(row)]));
      const sign = order.descending ? -1 : 1;
      rows.sort((a, b) => sign * compare(keys.get(a), keys.get(b), sign) || a - b);
      headings.forEach((heading, number) => {
        const arrow = number === order.column ? (order.descending ? " \u25be" : " \u25b4") : "";
        heading.textContent = columns[number].title + arrow;
      });
      body.scrollTop = 0;
      draw();
    }

    /** Rows in sight, made anew. */
    function draw() {
      inner.style.height = `${rows.length * HEIGHT}px`;
      const first = Math.max(Math.floor(body.scrollTop / HEIGHT) - SPARE, 0);
      const last = Math.min(first + Math.ceil(body.clientHeight / HEIGHT) + 2 * SPARE, rows.length);
      inner.replaceChildren(...rows.slice(first, last).map((row, i) => made(row, first + i)));
    }

    function made(row, place) {
      const chosen = isChosen(row);
      const line = element("div", { class: chosen ? "row chosen" : "row", role: "option", "aria-selected": String(chosen) });
      line.style.top = `${place * HEIGHT}px`;
      line.style.gridTemplateColumns = template;
      for (const column of columns) {
        const missed = column.mark?.(row);
        const kind = `${column.number ? "number" : ""}${missed ? " missed" : ""}`;
        line.append(element("span", { class: kind }, (missed ? "\u25b2 " : "") + column.text(row)));
      }
      line.addEventListener("click", () => onPick(row));
      return line;
    }

    body.addEventListener("scroll", draw);
    body.addEventListener("keydown", (event) => {
      const move = { ArrowDown: 1, ArrowUp: -1 }[event.key];
      if (!move || !rows.length) return;
      const now = rows.findIndex(isChosen);
      const next = Math.min(Math.max(now + move, 0), rows.length - 1);
      onPick(rows[next]);
      const top = next * HEIGHT;
      if (top < body.scrollTop) body.scrollTop = top;
      if (top + HEIGHT > body.scrollTop + body.clientHeight) body.scrollTop = top + HEIGHT - body.clientHeight;
      event.preventDefault();
    });
    new ResizeObserver(draw).observe(body);
    return {
      draw,
      /** Show other rows, sorted as before. */
      show(chosen) {
        rows = chosen;
        arrange();
      },
    };
  }

  /** Order of two values; what is not known comes last either way. */
  function compare(a, b, sign) {
    if (typeof a === "string") return a.localeCompare(b, "en", { numeric: true });
    const [knownA, knownB] = [Number.isFinite(a), Number.isFinite(b)];
    if (knownA && knownB) return a - b;
    return knownA === knownB ? 0 : sign * (knownA ? -1 : 1);
  }

  return { create };
})();
