// The table: a page of the shown jobs, sorted by any column.

const LEAST_ROWS = 25, PRINTED_ROWS = 500;

// A small sweep is one page, in which the browser finds every word.
const sorting = { key: "job", down: false, page: 0, size: jobs.length <= 100 ? 100 : LEAST_ROWS };

const headings = [
  { key: "job", title: "job", compare: (a, b) => jobs[a].number - jobs[b].number },
  { key: "picture", title: "picture" },
  { key: "status", title: "status", compare: (a, b) => states.indexOf(jobs[a].state) - states.indexOf(jobs[b].state) },
  ...columns.filter(({ group }) => group !== "checks").map((column) => ({ key: column, title: column.title, column, compare: (a, b) => compareValues(column.numbers[a], column.numbers[b]) })),
  { key: "checks", title: "checks", compare: (a, b) => jobs[b].unmet.length - jobs[a].unmet.length },
  { key: "open", title: "open" },
];

// Jobs without a value come last, whichever way the others are sorted.
function compareValues(a, b) {
  if (Number.isNaN(a) || Number.isNaN(b)) return Number.isNaN(a) - Number.isNaN(b);
  return (sorting.down ? -1 : 1) * (a - b);
}

function sorted() {
  const { compare, column } = headings.find(({ key }) => key === sorting.key);
  const order = jobs.map(({ at }) => at).filter((at) => selection.shown[at]);
  const sign = sorting.down && !column ? -1 : 1;
  return order.sort((a, b) => sign * compare(a, b) || a - b);
}

const isFigure = ({ column }) => column && !column.names;

function drawHead(row) {
  row.replaceChildren(...headings.filter(used).map((heading) => {
    const cell = make("th", { scope: "col", class: isFigure(heading) ? "number" : "" });
    if (!heading.compare) cell.textContent = heading.title;
    else {
      const isBy = sorting.key === heading.key;
      cell.setAttribute("aria-sort", isBy ? (sorting.down ? "descending" : "ascending") : "none");
      cell.append(make("button", { type: "button", text: heading.title, onclick: () => sortBy(heading) }));
    }
    return cell;
  }));
}

const some = {
  picture: source.has.some((bits) => bits & 1),
  checks: jobs.some(({ checks }) => checks),
  open: source.has.some((bits) => bits & 6),
};

const used = ({ key }) => some[key] ?? true;

function sortBy({ key }) {
  Object.assign(sorting, { down: sorting.key === key && !sorting.down, key, page: 0 });
  drawTable();
  const at = headings.filter(used).findIndex((heading) => heading.key === key);
  tableParts.head.children[at].querySelector("button").focus();
}

function rowOf(at) {
  const job = jobs[at];
  const button = make("button", { type: "button", class: "pick", "aria-label": `Job ${job.number}`, text: String(job.number), onclick: () => pick(at) });
  const cells = {
    job: () => make("th", { scope: "row", class: "job" }, [button]),
    picture: () => make("td", { "data-label": "picture" }, picture(job)),
    status: () => make("td", { class: "said", "data-label": "status" }, [
      make("span", { class: `${stateStyles[job.state]} word`, text: stateText(job) }), ...said(job)]),
    checks: () => make("td", { "data-label": "checks" }, checksOf(job)),
    open: () => make("td", { "data-label": "open" }, links(job)),
  };
  const row = make("tr", { "data-at": at }, headings.filter(used).map(({ key, column }) => {
    if (!column) return cells[key]();
    const text = valueText(column, at);
    // Empty cells are left out on a narrow screen.
    return make("td", { class: column.names ? "" : "number", "data-label": column.title, text });
  }));
  row.addEventListener("pointerenter", () => point(at));
  row.addEventListener("pointerleave", () => point(-1));
  button.addEventListener("focus", () => point(at));
  return row;
}

function checksOf(job) {
  if (!job.unmet.length) return [job.checks];
  const lines = job.unmet.map((text) => make("span", { class: `hint ${text[0] === "✕" ? "failed" : "warning"}`, text }));
  if (lines.length <= 3) return [job.checks, ...lines];
  return [make("details", {}, [make("summary", { text: job.checks }), ...lines])];
}

let tableParts;

function drawTable() {
  const { head, body, pages } = tableParts, order = sorted();
  const last = Math.max(0, Math.ceil(order.length / sorting.size) - 1);
  sorting.page = Math.min(sorting.page, last);
  const from = sorting.page * sorting.size, rows = order.slice(from, from + sorting.size);
  drawHead(head);
  body.replaceChildren(...rows.map(rowOf));
  pages.hidden = order.length <= LEAST_ROWS;
  pages.querySelector("output").textContent =
    order.length ? `${(from + 1).toLocaleString("en")}–${(from + rows.length).toLocaleString("en")} of ${order.length.toLocaleString("en")}` : "no job";
  pages.querySelector("[data-step='-1']").disabled = sorting.page === 0;
  pages.querySelector("[data-step='1']").disabled = sorting.page === last;
  pointInTable();
}

function pointInTable() {
  for (const row of tableParts.body.children) {
    const at = Number(row.dataset.at);
    row.classList.toggle("at", at === selection.hovered);
    row.classList.toggle("picked", at === selection.picked);
    row.querySelector(".pick").setAttribute("aria-pressed", String(at === selection.picked));
  }
}

function startTable(section) {
  const table = section.querySelector("table");
  const pages = section.querySelector("[data-pages]");
  tableParts = { head: table.tHead.rows[0], body: table.tBodies[0], pages };
  for (const line of section.querySelectorAll("[data-static]")) line.remove();
  pages.addEventListener("click", ({ target }) => {
    if (!target.dataset.step) return;
    sorting.page += Number(target.dataset.step);
    drawTable();
  });
  const rows = pages.querySelector("select");
  rows.value = sorting.size;
  const show = (size) => {
    Object.assign(sorting, { size, page: 0 });
    drawTable();
  };
  rows.addEventListener("change", () => show(Number(rows.value)));
  // On paper there are no pages to turn.
  window.addEventListener("beforeprint", () => show(PRINTED_ROWS));
  window.addEventListener("afterprint", () => show(Number(rows.value)));
  watchers.shown.push(() => {
    sorting.page = 0;
    drawTable();
  });
  watchers.pointed.push(pointInTable);
}
