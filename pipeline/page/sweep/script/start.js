// Starts the views, and tells a program when they are ready.

const MOST_AXES = 8;

function chooseAxes() {
  const varied = columns.filter(({ low, high, group }) => low < high && !["calls", "checks"].includes(group));
  varied.sort((a, b) => (a.group === "key" ? 0 : 1) - (b.group === "key" ? 0 : 1) || a.index - b.index);
  for (const column of columns) column.onAxis = varied.indexOf(column) >= 0 && varied.indexOf(column) < MOST_AXES;
}

function start() {
  const section = document.getElementById("compare");
  readColours();
  chooseAxes();
  startTable(document.getElementById("jobs"));
  startDots();
  const form = section.querySelector("form"), body = section.querySelector("[data-views]");
  for (const line of section.querySelectorAll("[data-static]")) line.remove();
  form.hidden = false;
  startControls(form);
  const hasPair = startPair(section.querySelector("[data-pair]"));
  body.hidden = !hasPair;
  if (hasPair) {
    startScatter(section.querySelector("[data-scatter]"));
    startParallel(section.querySelector("[data-parallel]"));
    const card = section.querySelector("[data-card]");
    watchers.pointed.push(() => showCard(card));
    showCard(card);
    const redraw = () => {
      readColours();
      drawScatter();
      drawParallel();
    };
    window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
    let width = body.clientWidth;
    new ResizeObserver(() => {
      if (width === body.clientWidth) return;
      width = body.clientWidth;
      redraw();
    }).observe(body);
  }
  select();
}

start();
window.linkwright = {
  ready: Promise.resolve(), selection, jobs, columns, paretoFront, point, pick, scatter, parallel, axisX, axisY,
};
