/** Puts the page together. */
(async () => {
  const { byId } = page.dom;
  try {
    const crowd = page.crowd.build(await page.data.load());
    const state = page.state.create(crowd);
    page.summary.create(crowd);
    page.agents.create(crowd, state);
    const view = page.view.create(crowd, state);
    page.player.create(crowd, state, view);
    page.agents.heading(crowd, state);
    page.plan.create(crowd, state);
    const lines = byId("lines");
    for (const part of [page.timing, page.heights, page.weights]) part.create(lines, crowd, state);
    page.steps.create(crowd, state);
    page.histograms.create(crowd, state);
    followTheme(state);
    Object.assign(window, { usdfoot: { crowd, state, view } });
    document.documentElement.dataset.ready = "yes";
  } catch (error) {
    byId("verdict").textContent = `the page cannot be shown: ${error.message}`;
    throw error;
  }

  /** Light or dark as the system says, until the button says otherwise. */
  function followTheme(state) {
    const dark = window.matchMedia("(prefers-color-scheme: dark)");
    const root = document.documentElement;
    byId("theme").addEventListener("click", () => {
      const now = root.dataset.theme ?? (dark.matches ? "dark" : "light");
      root.dataset.theme = now === "dark" ? "light" : "dark";
      state.set({ theme: root.dataset.theme });
    });
    dark.addEventListener("change", () => state.set({ theme: root.dataset.theme }));
  }
})();
