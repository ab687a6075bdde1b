// The plots of a small sweep, which the page has without a script too: their dots follow the selection.

function startDots() {
  const dots = new Map(jobs.map(({ at }) => [at, []]));
  const places = new Map(jobs.map(({ number, at }) => [String(number), at]));
  for (const dot of document.querySelectorAll(".plots [data-job]")) {
    const at = places.get(dot.dataset.job);
    dots.get(at)?.push(dot);
    dot.addEventListener("pointerenter", () => point(at));
    dot.addEventListener("pointerleave", () => point(-1));
    dot.addEventListener("click", () => pick(at));
  }
  watchers.shown.push(() => {
    for (const [at, some] of dots) for (const dot of some) dot.classList.toggle("out", !selection.shown[at]);
  });
  watchers.pointed.push(() => {
    for (const [at, some] of dots) {
      for (const dot of some) dot.classList.toggle("at", at === selection.hovered || at === selection.picked);
    }
  });
}
