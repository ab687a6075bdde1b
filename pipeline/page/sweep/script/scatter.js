// One value against another, with the Pareto front.

const MARGIN = { left: 58, right: 14, top: 12, bottom: 40 };

const scatter = { plot: null, x: null, y: null, places: new Float32Array(2 * jobs.length) };

function placeDots() {
  const { plot, places } = scatter, { x, y } = selection.pair;
  scatter.x = axisOf(x);
  scatter.y = axisOf(y);
  const wide = plot.width - MARGIN.left - MARGIN.right, high = plot.height - MARGIN.top - MARGIN.bottom;
  // Jobs of one category are spread a little, always in the same way.
  const spread = (column, at) => (column.names ? (((at * 0.618034) % 1) - 0.5) * 0.5 / column.names.length : 0);
  for (let at = 0; at < jobs.length; at++) {
    places[2 * at] = MARGIN.left + wide * (scatter.x.share(x.numbers[at]) + spread(x, at));
    places[2 * at + 1] = MARGIN.top + high * (1 - scatter.y.share(y.numbers[at]) - spread(y, at));
  }
}

function drawScatter() {
  const { plot } = scatter;
  if (!selection.pair.x || !fit(plot, plot.box.clientWidth, Math.min(420, Math.max(260, plot.box.clientWidth * 0.7)))) return;
  placeDots();
  const context = plot.below, { places } = scatter;
  drawAxes(context, plot);
  const dot = (at, radius) => context.rect(places[2 * at] - radius, places[2 * at + 1] - radius, 2 * radius, 2 * radius);
  const radius = jobs.length > 2000 ? 1.5 : jobs.length > 300 ? 2 : 3;
  const some = (colour, alpha, isDrawn) => {
    context.globalAlpha = alpha;
    context.fillStyle = colour;
    context.beginPath();
    for (let at = 0; at < jobs.length; at++) if (isDrawn(at) && !Number.isNaN(places[2 * at] + places[2 * at + 1])) dot(at, radius);
    context.fill();
    context.globalAlpha = 1;
  };
  const { shown, front } = selection;
  some(colours.soft, 0.18, (at) => !shown[at]);
  const alpha = opacity(selection.count, 0.35);
  some(colours.accent, alpha, (at) => shown[at] && jobs[at].state === "built");
  some(colours.warn, alpha, (at) => shown[at] && jobs[at].state !== "built");
  drawFront(context, [...front.keys()].filter((at) => front[at]));
  pointInScatter();
}

function drawAxes(context, { width, height }) {
  const { pair } = selection, { x, y } = scatter;
  const base = height - MARGIN.bottom, right = width - MARGIN.right;
  for (const [value, name] of y.ticks) {
    const at = MARGIN.top + (base - MARGIN.top) * (1 - y.share(value));
    drawLine(context, MARGIN.left, at, right, at, colours.line);
    writeText(context, name, MARGIN.left - 6, at + 3.5, MARGIN.left - 8, { align: "right" });
  }
  drawLine(context, MARGIN.left, base, right, base, colours.soft);
  for (const [value, name] of x.ticks) {
    const at = MARGIN.left + (right - MARGIN.left) * x.share(value);
    drawLine(context, at, base, at, base + 4, colours.soft);
    writeText(context, name, at, base + 16, (right - MARGIN.left) / x.ticks.length);
  }
  writeText(context, pair.x.title, (MARGIN.left + right) / 2, height - 8, right - MARGIN.left, { colour: colours.text });
}

// The front as a line of steps through its jobs, from which no shown job is on the better side.
function drawFront(context, front) {
  const { places } = scatter, { directions } = selection;
  if (!front.length) return;
  front.sort((a, b) => places[2 * a] - places[2 * b] || places[2 * a + 1] - places[2 * b + 1]);
  context.strokeStyle = colours.good;
  context.lineWidth = 1.6;
  context.beginPath();
  front.forEach((at, number) => {
    const [x, y] = [places[2 * at], places[2 * at + 1]];
    if (number === 0) context.moveTo(x, y);
    else {
      const before = front[number - 1];
      if (directions.x > 0) context.lineTo(places[2 * before], y);
      else context.lineTo(x, places[2 * before + 1]);
      context.lineTo(x, y);
    }
  });
  context.stroke();
  context.fillStyle = colours.good;
  for (const at of front) {
    context.beginPath();
    context.arc(places[2 * at], places[2 * at + 1], 4, 0, 7);
    context.fill();
  }
}

function pointInScatter() {
  const { plot, places } = scatter;
  if (!plot || !selection.pair.x) return;
  const context = plot.above;
  context.clearRect(0, 0, plot.width, plot.height);
  for (const [at, colour] of [[selection.picked, colours.bad], [selection.hovered, colours.text]]) {
    if (at < 0 || Number.isNaN(places[2 * at] + places[2 * at + 1])) continue;
    context.strokeStyle = colour;
    context.lineWidth = 2;
    context.beginPath();
    context.arc(places[2 * at], places[2 * at + 1], 6.5, 0, 7);
    context.stroke();
  }
}

// The shown job nearest to a place, none that is far.
function dotAt(x, y) {
  const { places } = scatter;
  let nearest = -1, least = 14 ** 2;
  for (let at = 0; at < jobs.length; at++) {
    const distance = (places[2 * at] - x) ** 2 + (places[2 * at + 1] - y) ** 2;
    if (distance < least && selection.shown[at]) [nearest, least] = [at, distance];
  }
  return nearest;
}

// Steps by the arrow keys from job to job, in the order of the value on the horizontal axis.
function stepDots(event) {
  const { places } = scatter;
  const order = jobs.map(({ at }) => at).filter((at) => selection.shown[at] && !Number.isNaN(places[2 * at] + places[2 * at + 1]));
  order.sort((a, b) => places[2 * a] - places[2 * b] || places[2 * b + 1] - places[2 * a + 1] || a - b);
  if (!order.length) return;
  const now = order.indexOf(selection.hovered), last = order.length - 1;
  const next = { ArrowRight: Math.min(last, now + 1), ArrowLeft: Math.max(0, now - 1), Home: 0, End: last }[event.key];
  if (next !== undefined) point(order[next]);
  else if (event.key === "Enter" && selection.hovered >= 0) pick(selection.hovered);
  else if (event.key === "Escape") point(-1);
  else return;
  event.preventDefault();
}

function startScatter(box) {
  scatter.plot = makeCanvas(box, "");
  const { lower } = scatter.plot;
  Object.assign(lower, { tabIndex: 0 });
  lower.addEventListener("pointermove", ({ offsetX, offsetY }) => point(dotAt(offsetX, offsetY)));
  lower.addEventListener("pointerleave", () => point(-1));
  lower.addEventListener("click", ({ offsetX, offsetY }) => {
    const at = dotAt(offsetX, offsetY);
    if (at >= 0) pick(at);
  });
  lower.addEventListener("keydown", stepDots);
  watchers.shown.push(drawScatter, nameScatter);
  watchers.pointed.push(pointInScatter);
}

function nameScatter() {
  const { pair: { x, y }, front, count } = selection;
  if (!x) return;
  const number = front.reduce((sum, one) => sum + one, 0);
  const words = number ? `, ${number} on the Pareto front` : "";
  scatter.plot.lower.setAttribute("aria-label",
    `${y.title} against ${x.title}, of ${count} jobs${words}. Arrow keys step from job to job, Enter picks a job.`);
}
