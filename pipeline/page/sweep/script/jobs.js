// The jobs as the page has them: columns of numbers, of which a category is the place of its name.

const source = JSON.parse(document.getElementById("sweep-data").textContent);
const states = ["built", "unmet", "failed", "running", "missing"];

const columns = source.columns.map(({ title, group, values, names = null }, index) => {
  const numbers = Float64Array.from(values, (value) => value ?? NaN);
  let low = Infinity, high = -Infinity, whole = true;
  for (const value of numbers) {
    if (Number.isNaN(value)) continue;
    if (value < low) low = value;
    if (value > high) high = value;
    whole &&= Number.isInteger(value);
  }
  // As on the plots of a small sweep: positive values of a key that are far apart are shown by their logarithm.
  const log = group === "key" && !names && low > 0 && high / low >= 30;
  return { index, title, group, numbers, names, low, high, whole, log };
});

const jobs = source.numbers.map((number, at) => ({
  at, number,
  state: states[source.states[at]],
  message: source.texts[source.messages[at]],
  problems: source.problems[at] ?? [],
  checks: source.texts[source.checks[at]],
  unmet: (source.unmet[at] ?? []).map((text) => source.texts[text]),
  folder: source.folders[at],
  has: source.has[at],
}));

function valueText(column, at) {
  const value = column.numbers[at];
  if (Number.isNaN(value)) return "";
  return column.names ? column.names[value] : numberText(value);
}

function numberText(value) {
  if (Number.isInteger(value)) return value.toLocaleString("en");
  return String(Number(value.toPrecision(6)));
}

function stateText(job) {
  const marks = { built: "✓ built", unmet: "! built", failed: "✕ failed" };
  return marks[job.state] ?? job.state;
}

const stateStyles = { built: "built", unmet: "invalid", failed: "failed", running: "soft", missing: "soft" };

// A path below the folder of the sweep, as an address.
const address = (path) => path.split("/").map(encodeURIComponent).join("/").replace(/^([^/]*)%3A/, "./$1%3A");
