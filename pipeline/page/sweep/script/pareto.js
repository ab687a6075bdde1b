// The Pareto front: the shown jobs than which no other is better in one value and at least as good in the other.

function paretoFront(xs, ys, directionX, directionY, shown) {
  const order = [];
  for (let at = 0; at < xs.length; at++) {
    if (shown[at] && !Number.isNaN(xs[at]) && !Number.isNaN(ys[at])) order.push(at);
  }
  // The best x first, and of the same x the best y.
  order.sort((a, b) => directionX * (xs[b] - xs[a]) || directionY * (ys[b] - ys[a]) || a - b);
  const front = [];
  let best = -Infinity, bestX = NaN;
  for (const at of order) {
    const y = directionY * ys[at];
    // Jobs with the same two values are as good as each other.
    if (y > best || (y === best && xs[at] === bestX)) {
      front.push(at);
      best = y;
      bestX = xs[at];
    }
  }
  return front;
}
