/** Time: play, stop, speed, a slider, and what is drawn in the 3-D view. */
page.player = (() => {
  const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4];
  const { element, number } = page.dom;

  function create(crowd, state, view) {
    const { start, codeRate, frameTime } = crowd.header;
    const play = element("button", { type: "button", class: "main", "aria-label": "play" }, "\u25b6");
    const slider = element("input", { type: "range", min: 0, max: crowd.duration, step: "any", value: 0, "aria-label": "time" });
    const label = element("output", { class: "time" });
    const speed = element(
      "select",
      { "aria-label": "speed" },
      ...SPEEDS.map((value) => element("option", { value, selected: value === 1 }, `${value}\u00d7`)),
    );
    const follow = box("follow", "follow", "keep the chosen agent in the middle");
    const prints = box("footprints", "prints", "show the footsteps");
    const alone = box("only this agent", "alone", "hide the others");
    const all = element("button", { type: "button", title: "show everybody" }, "fit all");
    const one = element("button", { type: "button", title: "show the way of the chosen agent" }, "fit agent");
    page.dom.byId("player").append(
      element("div", { class: "bar" }, play, slider, label),
      element("div", { class: "bar small" }, element("label", {}, "speed ", speed), follow, prints, alone, all, one),
    );

    function box(text, name, title) {
      const input = element("input", { type: "checkbox", checked: state[name] });
      input.addEventListener("change", () => state.set({ [name]: input.checked }));
      state.on(name, () => (input.checked = state[name]));
      return element("label", { title }, input, ` ${text}`);
    }

    function show() {
      slider.value = state.time;
      const seconds = start + state.time;
      label.textContent = `${number(seconds, 2)} s \u00b7 code ${number(seconds * codeRate, 1)}`;
    }

    let last = 0;
    /** One moment further, from the end back to the beginning. */
    function advance(now) {
      if (!state.playing) return;
      const passed = (Math.min(now - last, 250) / 1000) * state.speed;
      last = now;
      const time = state.time + passed;
      state.set({ time: time > crowd.duration ? 0 : time });
      requestAnimationFrame(advance);
    }

    function toggle() {
      state.set({ playing: !state.playing });
    }

    state.on("playing", () => {
      play.textContent = state.playing ? "\u275a\u275a" : "\u25b6";
      play.setAttribute("aria-label", state.playing ? "pause" : "play");
      last = performance.now();
      if (state.playing) requestAnimationFrame(advance);
    });
    state.on("time", show);
    play.addEventListener("click", toggle);
    slider.addEventListener("input", () => state.set({ time: Number(slider.value) }));
    speed.addEventListener("change", () => state.set({ speed: Number(speed.value) }));
    all.addEventListener("click", () => view.fit?.(false));
    one.addEventListener("click", () => view.fit?.(true));
    document.addEventListener("keydown", (event) => {
      if (event.target.closest("input, select, button, [role=listbox]")) return;
      const shift = { ArrowLeft: -frameTime, ArrowRight: frameTime }[event.key];
      if (event.key === " ") toggle();
      else if (shift) state.set({ playing: false, time: Math.min(Math.max(state.time + shift, 0), crowd.duration) });
      else return;
      event.preventDefault();
    });
    show();
  }

  return { create };
})();
