// What is chosen of the jobs, the same in all views: which are shown, which the reader points at, which are picked.

const selection = {
  ranges: new Map(),      // column → [low, high], which a job's value must be within
  states: new Set(states),
  words: "",
  directions: { x: 0, y: 0 },  // 1: more is better, -1: less is better, 0: neither
  pair: { x: null, y: null },
  onlyFront: false,
  shown: new Uint8Array(jobs.length).fill(1),
  front: new Uint8Array(jobs.length),
  count: jobs.length,
  hovered: -1,
  picked: -1,
};

const watchers = { shown: [], pointed: [] };

function chosen() {
  const { ranges, words, shown } = selection;
  const sought = words.toLowerCase().split(/\s+/).filter(Boolean);
  for (const job of jobs) {
    let isShown = selection.states.has(job.state);
    for (const [column, [low, high]] of ranges) {
      if (!isShown) break;
      const value = column.numbers[job.at];
      isShown = value >= low && value <= high;
    }
    if (isShown && sought.length) {
      const text = wordsOf(job);
      isShown = sought.every((word) => text.includes(word));
    }
    shown[job.at] = isShown ? 1 : 0;
  }
}

// What a search looks through, made when it is first asked for.
function wordsOf(job) {
  job.words ??= [
    `job ${job.number}`, stateText(job), job.message, ...job.problems, ...job.unmet, job.folder,
    ...columns.filter(({ group }) => group === "key").map((column) => `${column.title}=${valueText(column, job.at)}`),
  ].join(" ").toLowerCase();
  return job.words;
}

// Applies the filters anew, and tells all views.
function select() {
  chosen();
  const { pair, directions, shown } = selection;
  selection.front.fill(0);
  if (pair.x && pair.y && directions.x && directions.y) {
    for (const at of paretoFront(pair.x.numbers, pair.y.numbers, directions.x, directions.y, shown)) {
      selection.front[at] = 1;
    }
    if (selection.onlyFront) shown.set(selection.front);
  }
  selection.count = shown.reduce((sum, one) => sum + one, 0);
  if (selection.hovered >= 0 && !shown[selection.hovered]) selection.hovered = -1;
  for (const tell of watchers.shown) tell();
}

function point(at) {
  if (selection.hovered === at) return;
  selection.hovered = at;
  for (const tell of watchers.pointed) tell();
}

function pick(at) {
  selection.picked = selection.picked === at ? -1 : at;
  for (const tell of watchers.pointed) tell();
}

function setRange(column, low, high) {
  if (low <= column.low && high >= column.high) selection.ranges.delete(column);
  else selection.ranges.set(column, [low, high]);
  select();
}
