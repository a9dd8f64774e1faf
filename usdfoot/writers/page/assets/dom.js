/** Elements, colours and numbers. Text of the scene only ever becomes text, never markup. */
page.dom = (() => {
  /** A new element; `options` are its properties, `children` elements or texts. */
  function element(tag, options = {}, ...children) {
    const made = document.createElement(tag);
    for (const [name, value] of Object.entries(options)) {
      if (name === "class") made.className = value;
      else if (name.startsWith("aria-") || name === "role" || name === "for") made.setAttribute(name, value);
      else made[name] = value;
    }
    made.append(...children.filter((child) => child !== null));
    return made;
  }

  const byId = (id) => document.getElementById(id);

  /** Value of one of the style's colours. */
  function color(name) {
    return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
  }

  /** A number for people: fixed digits, no minus zero. */
  function number(value, digits) {
    if (value === null || !Number.isFinite(value)) return "-";
    const text = value.toFixed(digits);
    return Number(text) === 0 ? text.replace("-", "") : text;
  }

  /** A value of a figure with its unit. */
  function withUnit(value, { digits, unit }) {
    return unit ? `${number(value, digits)} ${unit}` : number(value, digits);
  }

  /** A target as it is read: "<= 1 mm". */
  function target(figure) {
    if (figure.target === null) return "no target";
    const bound = `${figure.atLeast ? "\u2265" : "\u2264"} ${figure.target} ${figure.unit}`.trim();
    return figure.ofMean ? `mean ${bound}` : bound;
  }

  /** The last part of a prim path. */
  const leaf = (path) => path.slice(path.lastIndexOf("/") + 1);

  return { element, byId, color, number, withUnit, target, leaf };
})();
