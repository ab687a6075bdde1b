// Elements of the page.

let madeSliders = 0;

// A labelled slider: what to put on the page, and `show(value)`, which changes neither focus nor what is dragged.
function makeSlider({ label, low, high, unit }, onMove) {
  const id = `live-slider-${madeSliders++}`;
  // Screen readers say the value of the slider itself, and not each value while it runs.
  const output = make("output", { for: id, "aria-live": "off" });
  const input = make("input", { id, type: "range", min: low, max: high, step: "any" });
  const show = (value) => {
    const text = valueText(value, unit);
    const moved = Math.abs(Number(input.value) - Math.min(high, Math.max(low, value))) > (high - low) / 1000;
    if (output.textContent === text && !moved) return;
    output.textContent = text;
    input.value = value;
    input.setAttribute("aria-valuetext", text);
    const share = high > low ? Math.min(1, Math.max(0, (value - low) / (high - low))) : 0;
    input.style.setProperty("--share", `${(100 * share).toFixed(1)}%`);
  };
  input.addEventListener("input", () => onMove(Number(input.value)));
  const row = make("div", { class: "live-slider" }, [make("label", { for: id, text: label }), output, input]);
  return { row, input, show };
}

function makeFold(title, rows, open) {
  const fold = make("details", { class: "live-fold" }, [make("summary", { text: title }), ...rows]);
  fold.open = open;
  return fold;
}
