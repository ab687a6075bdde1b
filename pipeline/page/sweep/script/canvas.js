// A plot on two canvases: the jobs, drawn where the selection changes, and above them the job that is pointed at.

let colours;

function readColours() {
  const style = getComputedStyle(document.documentElement);
  colours = Object.fromEntries(["text", "soft", "line", "back", "accent", "good", "warn", "bad"]
    .map((name) => [name, style.getPropertyValue(`--${name}`).trim()]));
}

function makeCanvas(box, label) {
  const lower = make("canvas", { role: "img", "aria-label": label });
  const upper = make("canvas", { class: "upper", "aria-hidden": "true" });
  box.append(lower, upper);
  const plot = { box, lower, upper, width: 0, height: 0, below: lower.getContext("2d"), above: upper.getContext("2d") };
  return plot;
}

// Gives the canvases the size of their box; false where it has none.
function fit(plot, width, height) {
  const ratio = window.devicePixelRatio || 1;
  Object.assign(plot, { width, height });
  for (const canvas of [plot.lower, plot.upper]) {
    Object.assign(canvas, { width: Math.round(width * ratio), height: Math.round(height * ratio) });
    Object.assign(canvas.style, { width: `${width}px`, height: `${height}px` });
  }
  for (const context of [plot.below, plot.above]) {
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.font = "11px system-ui, -apple-system, 'Segoe UI', sans-serif";
  }
  return width > 0;
}

// Text that is cut where there is no room.
function writeText(context, words, x, y, room, { align = "center", colour = colours.soft } = {}) {
  let text = words;
  while (text.length > 1 && context.measureText(text).width > room) text = `${text.replace(/…$/, "").slice(0, -1)}…`;
  context.textAlign = align;
  context.fillStyle = colour;
  context.fillText(text, x, y);
}

function drawLine(context, x1, y1, x2, y2, colour) {
  context.strokeStyle = colour;
  context.lineWidth = 1;
  context.beginPath();
  context.moveTo(x1, y1);
  context.lineTo(x2, y2);
  context.stroke();
}

// How much of a job is seen, so that many above each other are still told apart.
const opacity = (count, least) => Math.min(0.9, Math.max(least, 30 / (count + 1) ** 0.75));
