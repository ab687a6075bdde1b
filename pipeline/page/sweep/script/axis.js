// Where a value is drawn on an axis, and which values are named.

const PAD = 0.04;

function axisOf(column) {
  const { names, log } = column;
  let { low, high } = column;
  if (names) [low, high] = [-0.5, names.length - 0.5];
  else if (log) [low, high] = [Math.log10(low), Math.log10(high)];
  if (!names) {
    const pad = low === high ? Math.abs(low) / 2 || 1 : PAD * (high - low);
    [low, high] = [low - pad, high + pad];
  }
  const share = (value) => ((log ? Math.log10(value) : value) - low) / (high - low);
  const value = (part) => (log ? 10 ** (low + part * (high - low)) : low + part * (high - low));
  return { share, value, ticks: ticksOf(column, low, high) };
}

function ticksOf({ names, log, whole, low, high }, from, to) {
  if (names) {
    const step = Math.ceil(names.length / 12);
    return names.map((name, at) => [at, name || "–"]).filter(([at]) => at % step === 0);
  }
  if (log) {
    const first = Math.floor(from), last = Math.ceil(to), step = Math.max(1, Math.ceil((last - first) / 5));
    const factors = last - first <= 2 ? [1, 2, 5] : [1];
    const all = [];
    for (let power = first; power <= last; power += step) all.push(...factors.map((factor) => factor * 10 ** power));
    return all.filter((value) => value >= low * 0.999 && value <= high * 1.001).map((value) => [value, numberText(value)]);
  }
  const least = Math.max(whole ? 1 : 0, (to - from) / 5), power = 10 ** Math.floor(Math.log10(least));
  const step = [1, 2, 5, 10].find((factor) => factor * power >= least * (1 - 1e-9)) * power;
  const ticks = [], decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const text = (value) => (decimals > 6 || Math.abs(value) >= 1e7 ? value.toPrecision(4)
    : (value + 0).toLocaleString("en", { minimumFractionDigits: decimals, maximumFractionDigits: decimals }));
  for (let at = Math.ceil(from / step - 1e-9); at * step <= to + 1e-9 * step; at++) {
    ticks.push([at * step, text(at * step)]);
  }
  return ticks;
}
