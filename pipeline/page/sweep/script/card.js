// The job that is pointed at, else the job that is picked: its picture, its values and its links.

function showCard(card) {
  const at = selection.hovered >= 0 ? selection.hovered : selection.picked;
  if (at < 0) {
    card.replaceChildren(make("p", { class: "soft", text: "Point at a job, or pick it, to see it here." }));
    return;
  }
  const job = jobs[at];
  const pairs = columns.filter((column) => !Number.isNaN(column.numbers[at]));
  card.replaceChildren(
    make("h3", {}, [`Job ${job.number} `, make("span", { class: `${stateStyles[job.state]} word`, text: stateText(job) })]),
    ...picture(job),
    ...said(job),
    make("dl", {}, pairs.flatMap((column) => [
      make("dt", { text: column.title }), make("dd", { text: valueText(column, at) })])),
    make("p", {}, links(job)),
  );
}

function picture(job) {
  if (!(job.has & 1)) return [];
  return [make("img", { class: "thumbnail", src: address(`${job.folder}/preview.png`), alt: `The robot of job ${job.number}`, loading: "lazy" })];
}

// The message and the problems of a job, where they say more than its state.
function said(job) {
  const lines = ["valid", job.state].includes(job.message) ? [] : [job.message, ...job.problems];
  return lines.map((text) => make("span", { class: "hint", text: text.length > 300 ? `${text.slice(0, 299)}…` : text }));
}

function links(job) {
  const all = [["report", `${job.folder}/report.html`, 2], ["folder", `${job.folder}/`, 4]];
  return all.filter(([, , bit]) => job.has & bit).flatMap(([word, path]) =>
    [make("a", { href: address(path), "aria-label": `${word} of job ${job.number}`, text: word }), " "]);
}
