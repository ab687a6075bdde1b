// Parallel coordinates: a line for each job through its values; a range of an axis is a filter.

const ROOM = { top: 34, bottom: 22, side: 46, least: 92 };

const parallel = { plot: null, axes: [], drag: null };

function axisX(number) {
  const { plot, axes } = parallel;
  const wide = plot.width - 2 * ROOM.side;
  return axes.length < 2 ? plot.width / 2 : ROOM.side + (wide * number) / (axes.length - 1);
}

const axisY = (share) => ROOM.top + (parallel.plot.height - ROOM.top - ROOM.bottom) * (1 - share);

function drawParallel() {
  const { plot } = parallel;
  parallel.axes = columns.filter(({ onAxis }) => onAxis).map((column) => ({ column, ...axisOf(column) }));
  const { axes } = parallel;
  plot.box.parentElement.hidden = axes.length < 2;
  const wide = Math.max(plot.box.parentElement.clientWidth, 2 * ROOM.side + ROOM.least * (axes.length - 1));
  if (axes.length < 2 || !fit(plot, wide, 300)) return;
  const context = plot.below, { shown, front, count } = selection;
  context.lineJoin = "round";
  drawPaths(context, colours.line, jobs.length > 1000 ? 0.25 : 0.7, (at) => !shown[at]);
  drawPaths(context, colours.accent, opacity(count, 0.025), (at) => shown[at] && !front[at]);
  drawPaths(context, colours.good, 0.9, (at) => front[at]);
  axes.forEach(drawAxis);
  plot.lower.setAttribute("aria-label", `Parallel coordinates of ${count} jobs over ` +
    `${axes.map(({ column }) => column.title).join(", ")}. The ranges below filter the jobs.`);
  pointInParallel();
}

function drawPaths(context, colour, alpha, isDrawn) {
  context.globalAlpha = alpha;
  context.strokeStyle = colour;
  context.lineWidth = 1;
  for (const { at } of jobs) {
    if (!isDrawn(at)) continue;
    context.beginPath();
    tracePath(context, at);
    context.stroke();
  }
  context.globalAlpha = 1;
}

// The line of a job, broken where it has no value.
function tracePath(context, at) {
  let isDown = false;
  parallel.axes.forEach(({ column, share }, number) => {
    const y = axisY(share(column.numbers[at]));
    if (Number.isNaN(y)) isDown = false;
    else if (isDown) context.lineTo(axisX(number), y);
    else {
      context.moveTo(axisX(number), y);
      isDown = true;
    }
  });
}

function drawAxis({ column, share, ticks }, number) {
  const context = parallel.plot.below, x = axisX(number), { axes, plot } = parallel;
  const room = (plot.width - 2 * ROOM.side) / Math.max(1, axes.length - 1) - 8;
  drawLine(context, x, axisY(1), x, axisY(0), colours.soft);
  const edge = number === 0 || number === axes.length - 1 ? Math.min(room, 2 * ROOM.side) : room;
  writeText(context, column.title, x, 14, edge, { colour: colours.text });
  for (const [value, name] of ticks) {
    const width = Math.min(context.measureText(name).width, room - 10);
    context.globalAlpha = 0.8;
    context.fillStyle = colours.back;
    context.fillRect(x + 4, axisY(share(value)) - 7, width + 4, 13);
    context.globalAlpha = 1;
    writeText(context, name, x + 6, axisY(share(value)) + 3.5, room - 10, { align: "left" });
  }
  const range = selection.ranges.get(column);
  if (!range) return;
  const [bottom, top] = range.map((value) => axisY(Math.min(1, Math.max(0, share(value) || 0))));
  context.globalAlpha = 0.3;
  context.fillStyle = colours.accent;
  context.fillRect(x - 7, top - 2, 14, bottom - top + 4);
  context.globalAlpha = 1;
}

function pointInParallel() {
  const { plot } = parallel;
  if (!plot?.width) return;
  const context = plot.above;
  context.clearRect(0, 0, plot.width, plot.height);
  for (const [at, colour] of [[selection.picked, colours.bad], [selection.hovered, colours.text]]) {
    if (at < 0) continue;
    context.strokeStyle = colour;
    context.lineWidth = 2.2;
    context.beginPath();
    tracePath(context, at);
    context.stroke();
  }
}

// The shown job whose line is nearest to a place.
function lineAt(x, y) {
  const { axes } = parallel;
  const right = axes.findIndex((_, number) => axisX(number) >= x);
  if (right < 1) return -1;
  const part = (x - axisX(right - 1)) / (axisX(right) - axisX(right - 1));
  const [before, after] = [axes[right - 1], axes[right]];
  let nearest = -1, least = 8;
  for (const { at } of jobs) {
    if (!selection.shown[at]) continue;
    const one = axisY(before.share(before.column.numbers[at])), other = axisY(after.share(after.column.numbers[at]));
    const distance = Math.abs(one + part * (other - one) - y);
    if (distance < least) [nearest, least] = [at, distance];
  }
  return nearest;
}

function axisAt(x) {
  return parallel.axes.findIndex((_, number) => Math.abs(axisX(number) - x) < 14);
}

function startParallel(box) {
  parallel.plot = makeCanvas(box, "");
  const { lower } = parallel.plot;
  lower.addEventListener("pointerdown", (event) => {
    const number = axisAt(event.offsetX);
    if (number < 0) return;
    lower.setPointerCapture(event.pointerId);
    parallel.drag = { number, from: event.offsetY, moved: false };
  });
  lower.addEventListener("pointermove", (event) => {
    const { drag } = parallel;
    lower.style.cursor = axisAt(event.offsetX) >= 0 ? "ns-resize" : "";
    if (!drag) {
      point(lineAt(event.offsetX, event.offsetY));
      return;
    }
    drag.moved ||= Math.abs(event.offsetY - drag.from) > 4;
    if (drag.moved) dragRange(drag, event.offsetY);
  });
  const end = (event) => {
    const { drag } = parallel;
    parallel.drag = null;
    // A click on an axis takes its range away.
    if (drag && !drag.moved) setRange(parallel.axes[drag.number].column, -Infinity, Infinity);
    else if (!drag && event.type === "pointerup") {
      const at = lineAt(event.offsetX, event.offsetY);
      if (at >= 0) pick(at);
    }
  };
  lower.addEventListener("pointerup", end);
  lower.addEventListener("pointercancel", end);
  lower.addEventListener("pointerleave", () => point(-1));
  watchers.shown.push(drawParallel);
  watchers.pointed.push(pointInParallel);
}

// Sets the range of an axis, once a frame.
function dragRange(drag, to) {
  if (!drag.waits) {
    drag.waits = true;
    requestAnimationFrame(() => {
      drag.waits = false;
      setRange(...rangeOf(drag));
    });
  }
  drag.to = to;
}

function rangeOf({ number, from, to }) {
  const { column, value } = parallel.axes[number], { height } = parallel.plot;
  const share = (y) => 1 - (y - ROOM.top) / (height - ROOM.top - ROOM.bottom);
  const [low, high] = [from, to].map((y) => value(share(y))).sort((a, b) => a - b);
  return [column, low, high];
}
