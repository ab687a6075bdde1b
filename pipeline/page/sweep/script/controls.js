// The filters and the choices of the plots: forms, so that the keyboard and screen readers have all that the mouse has.

function startControls(form) {
  const search = form.querySelector("[name=words]");
  let pause;
  search.addEventListener("input", () => {
    clearTimeout(pause);
    pause = setTimeout(() => {
      selection.words = search.value;
      select();
    }, 120);
  });
  const count = form.querySelector("[data-count]");
  const reset = form.querySelector("[type=reset]");
  form.addEventListener("reset", () => setTimeout(() => {
    selection.ranges.clear();
    selection.states = new Set(states);
    Object.assign(selection, { words: "", onlyFront: false });
    select();
  }));
  form.addEventListener("submit", (event) => event.preventDefault());
  startStates(form.querySelector("[data-states]"));
  const ranges = columns.filter(({ low, high }) => low < high).map(makeRange);
  form.querySelector("[data-ranges]").append(...ranges.map(({ row }) => row));
  watchers.shown.push(() => {
    count.textContent = `${selection.count.toLocaleString("en")} of ${jobs.length.toLocaleString("en")} jobs shown`;
    const { ranges: set, words, onlyFront } = selection;
    reset.disabled = !set.size && !words && !onlyFront && selection.states.size === states.length;
    for (const { show } of ranges) show();
  });
}

function startStates(box) {
  const numbers = Object.fromEntries(states.map((state) => [state, 0]));
  for (const { state } of jobs) numbers[state]++;
  const some = states.filter((state) => numbers[state]);
  if (some.length < 2) {
    box.hidden = true;
    return;
  }
  const names = { built: "built", unmet: "check failed", failed: "failed", running: "running", missing: "missing" };
  for (const state of some) {
    const input = make("input", { type: "checkbox", checked: "", value: state, onchange: () => {
      if (input.checked) selection.states.add(state);
      else selection.states.delete(state);
      select();
    } });
    box.append(make("label", {}, [input, ` ${names[state]} (${numbers[state].toLocaleString("en")})`]));
  }
}

// The range of a column, and whether it is an axis of the parallel coordinates.
function makeRange(column) {
  const axis = make("input", { type: "checkbox", "aria-label": `${column.title} as an axis` });
  axis.checked = axis.defaultChecked = column.onAxis;
  axis.addEventListener("change", () => {
    column.onAxis = axis.checked;
    drawParallel();
  });
  const { inputs, show } = column.names ? makeChoice(column) : makeBounds(column);
  const row = make("div", { class: "range", role: "group", "aria-label": column.title }, [
    make("label", {}, [axis, ` ${column.title}`]), ...inputs]);
  return { row, show };
}

function makeBounds(column) {
  const bound = (word, place) => make("input", {
    type: "number", step: "any", placeholder: numberText(place), "aria-label": `${column.title} ${word}` });
  const low = bound("from", column.low), high = bound("to", column.high);
  const change = () => setRange(column, low.value === "" ? -Infinity : Number(low.value), high.value === "" ? Infinity : Number(high.value));
  for (const input of [low, high]) input.addEventListener("change", change);
  const show = () => {
    const range = selection.ranges.get(column) ?? [-Infinity, Infinity];
    [low, high].forEach((input, at) => {
      if (document.activeElement !== input) input.value = Number.isFinite(range[at]) ? Number(range[at].toPrecision(6)) : "";
    });
  };
  return { inputs: [low, make("span", { "aria-hidden": "true", text: "–" }), high], show };
}

function makeChoice(column) {
  const choice = make("select", { "aria-label": column.title }, [
    make("option", { value: "", text: "all" }),
    ...column.names.map((name, at) => make("option", { value: at, text: name || "–" })),
    make("option", { value: "some", text: "some", hidden: "" }),
  ]);
  choice.addEventListener("change", () => {
    if (choice.value === "") setRange(column, -Infinity, Infinity);
    else if (choice.value !== "some") setRange(column, Number(choice.value), Number(choice.value));
  });
  const show = () => {
    const range = selection.ranges.get(column);
    choice.value = !range ? "" : range[0] === range[1] ? String(range[0]) : "some";
  };
  return { inputs: [choice], show };
}

// Which two values are against each other, and which way each of them is better.
function startPair(form) {
  const plotted = columns.filter(({ low, high }) => low <= high);
  const figures = plotted.filter(({ group, low, high }) => group !== "key" && low < high);
  const keys = plotted.filter(({ group, low, high }) => group === "key" && low < high);
  const start = { x: keys.find(({ names }) => !names) ?? keys[0] ?? figures[1], y: figures.find(({ group }) => group === "objective") ?? figures[0] };
  if (!start.x || !start.y) return false;
  for (const side of ["x", "y"]) {
    const choice = form.querySelector(`[name=${side}]`), direction = form.querySelector(`[name=${side}-better]`);
    choice.append(...plotted.map((column) => make("option", { value: column.index, text: column.title })));
    choice.value = start[side].index;
    selection.pair[side] = start[side];
    choice.addEventListener("change", () => {
      selection.pair[side] = columns[choice.value];
      select();
    });
    direction.addEventListener("change", () => {
      selection.directions[side] = Number(direction.value);
      select();
    });
  }
  const only = form.querySelector("[name=front]"), words = form.querySelector("[data-front]");
  only.addEventListener("change", () => {
    selection.onlyFront = only.checked;
    select();
  });
  watchers.shown.push(() => {
    const number = selection.front.reduce((sum, one) => sum + one, 0);
    const { x, y } = selection.directions;
    only.disabled = !x || !y;
    only.checked = selection.onlyFront && !only.disabled;
    words.textContent = x && y ? `Pareto front: ${number.toLocaleString("en")} ${number === 1 ? "job" : "jobs"}`
      : "To see the Pareto front, choose for both values whether more or less is better.";
  });
  return true;
}
