// Moves one joint and lets the others follow: relations hold and loops stay closed. Damped Gauss–Newton with
// finite differences over the joints that a relation or a loop is about, in small steps from a pose that is closed.

const CLOSED = 1e-8; // m and rad
const DIFFERENCE = 1e-6;
const STRIDE = { hinge: 0.1, ball: 0.1, slide: 0.01 }; // of one step, rad or m

class Closing {
  constructor(header, kinematics) {
    this.kinematics = kinematics;
    this.joints = header.joints;
    this.relations = header.relations;
    this.loops = header.loops;
    this.involved = this.joints.filter((joint, index) => joint.type !== "free" && this.concerns(header, index));
    const rows = this.loops.reduce((sum, loop) => sum + (loop.type === "weld" ? 6 : 3), this.relations.length);
    this.residual = new Float64Array(rows);
    this.ahead = new Float64Array(rows);
    this.behind = new Float64Array(rows);
    this.scratch = new Float64Array(16);
  }

  concerns(header, index) {
    if (this.relations.some((one) => one.follower === index || one.driver === index)) return true;
    return this.loops.some((loop) => between(header.bodies, ...loop.bodies).has(header.joints[index].body));
  }

  // Moves `joint` to `target` (one value; of a ball a rotation vector), or as far as loops and limits let it.
  // Returns whether it came there.
  move(joint, target) {
    const { kinematics } = this;
    const from = jointValue(joint, kinematics.qpos);
    const way = Math.max(...target.map((value, k) => Math.abs(value - from[k])));
    if (!this.involved.includes(joint)) {
      setJointValue(joint, kinematics.qpos, target);
      kinematics.update();
      return true;
    }
    kinematics.update();
    const open = this.solve(new Set([joint]));
    let [done, step] = [0, 1 / Math.min(200, Math.max(1, Math.ceil(way / STRIDE[joint.type])))];
    const least = step / 64;
    while (done < 1 && step >= least) {
      const kept = kinematics.qpos.slice();
      const next = Math.min(1, done + step);
      setJointValue(joint, kinematics.qpos, target.map((value, k) => from[k] + next * (value - from[k])));
      if (this.settle(joint, kept, Math.max(CLOSED, open))) {
        done = next;
      } else {
        kinematics.qpos.set(kept);
        step /= 2;
      }
    }
    kinematics.update();
    return done >= 1;
  }

  // Closes with `joint` held; joints that would leave their limits are held at them.
  settle(joint, kept, tolerance) {
    const held = new Set([joint]);
    for (let round = 0; round < 4; round++) {
      if (this.solve(held) > tolerance) return false;
      const beyond = this.involved.filter((one) => !held.has(one) && this.clip(one, kept));
      if (beyond.length === 0) return true;
      for (const one of beyond) held.add(one);
    }
    return false;
  }

  // Brings a joint back to its limits, or to where it was if that lay beyond; whether it had left them.
  clip(joint, kept) {
    if (!joint.range || joint.type === "ball") return false;
    const { qpos } = this.kinematics;
    const low = Math.min(joint.range[0], kept[joint.qpos]);
    const high = Math.max(joint.range[1], kept[joint.qpos]);
    const value = qpos[joint.qpos];
    qpos[joint.qpos] = Math.min(high, Math.max(low, value));
    return Math.abs(value - qpos[joint.qpos]) > 1e-9;
  }

  solve(held) {
    const { kinematics, residual } = this;
    const free = this.involved.filter((joint) => !held.has(joint));
    const columns = free.flatMap((joint) => (joint.type === "ball" ? [0, 1, 2] : [0]).map((k) => [joint, k]));
    const n = columns.length;
    kinematics.update();
    let worst = this.measure(residual);
    for (let round = 0; round < 50 && worst > CLOSED * 1e-3 && n > 0; round++) {
      const jacobian = columns.map(([joint, k]) => this.column(joint, k));
      const A = new Float64Array(n * n);
      const delta = new Float64Array(n);
      let largest = 0;
      for (let i = 0; i < n; i++) {
        for (let j = 0; j < n; j++) A[i * n + j] = dot(jacobian[i], jacobian[j]);
        delta[i] = -dot(jacobian[i], residual);
        largest = Math.max(largest, A[i * n + i]);
      }
      for (let i = 0; i < n; i++) A[i * n + i] += 1e-10 * largest + 1e-30;
      if (!solveInPlace(A, delta, n)) break;
      const better = this.search(columns, delta, worst);
      if (better === null) break;
      worst = better;
    }
    return worst;
  }

  // Goes along `delta`, by half as much until that is better; the residual there, null where none is.
  search(columns, delta, worst) {
    const { kinematics, residual } = this;
    const start = kinematics.qpos.slice();
    const before = dot(residual, residual);
    let share = Math.min(1, 0.5 / Math.max(...delta.map(Math.abs)));
    for (let round = 0; round < 8; round++, share /= 2) {
      columns.forEach(([joint, k], i) => nudge(joint, kinematics.qpos, k, share * delta[i]));
      kinematics.update();
      const largest = this.measure(residual);
      if (dot(residual, residual) < before) return largest;
      kinematics.qpos.set(start);
    }
    kinematics.update();
    this.measure(residual);
    return null;
  }

  column(joint, k) {
    const { qpos } = this.kinematics;
    const kept = qpos.slice(joint.qpos, joint.qpos + 4);
    const width = joint.type === "ball" ? 4 : 1;
    for (const [sign, rows] of [[1, this.ahead], [-1, this.behind]]) {
      nudge(joint, qpos, k, sign * DIFFERENCE);
      this.kinematics.update();
      this.measure(rows);
      for (let i = 0; i < width; i++) qpos[joint.qpos + i] = kept[i];
    }
    return this.ahead.map((value, row) => (value - this.behind[row]) / (2 * DIFFERENCE));
  }

  // Writes how far relations and loops are open, and returns the largest of it [m, rad].
  measure(rows) {
    const { qpos } = this.kinematics;
    let row = 0;
    for (const { follower, driver, polynomial } of this.relations) {
      const led = this.joints[follower];
      const x = driver === null ? 0 : qpos[this.joints[driver].qpos] - this.joints[driver].ref;
      const y = polynomial.reduceRight((sum, factor) => sum * x + factor, 0);
      rows[row++] = qpos[led.qpos] - led.ref - y;
    }
    for (const loop of this.loops) row = this.gap(loop, rows, row);
    return rows.reduce((worst, value) => Math.max(worst, Math.abs(value)), 0);
  }

  gap(loop, rows, row) {
    const { xpos, xquat } = this.kinematics;
    const s = this.scratch;
    const [a, b] = loop.bodies;
    rotateVector(s, 0, xquat, 4 * a, loop.a_from.pos, 0);
    rotateVector(s, 3, xquat, 4 * b, loop.b_from.pos, 0);
    for (let k = 0; k < 3; k++) rows[row++] = xpos[3 * b + k] + s[3 + k] - xpos[3 * a + k] - s[k];
    if (loop.type !== "weld") return row;
    multiplyQuaternions(s, 0, xquat, 4 * a, loop.a_from.quat, 0);
    multiplyQuaternions(s, 4, xquat, 4 * b, loop.b_from.quat, 0);
    for (let k = 1; k < 4; k++) s[k] = -s[k];
    multiplyQuaternions(s, 8, s, 0, s, 4);
    vectorOfQuaternion(s, 12, s, 8);
    for (let k = 0; k < 3; k++) rows[row++] = s[12 + k];
    return row;
  }
}

// The bodies on the way from a to b, without those that both hang from.
function between(bodies, a, b) {
  const above = (body) => (body <= 0 ? [] : [body, ...above(bodies[body].parent)]);
  const [left, right] = [new Set(above(a)), new Set(above(b))];
  return new Set([...left, ...right].filter((body) => left.has(body) !== right.has(body)));
}

function dot(a, b) {
  let sum = 0;
  for (let i = 0; i < a.length; i++) sum += a[i] * b[i];
  return sum;
}

// A joint's value: one number, of a ball its rotation vector.
function jointValue(joint, qpos) {
  if (joint.type !== "ball") return [qpos[joint.qpos]];
  const vector = [0, 0, 0];
  vectorOfQuaternion(vector, 0, qpos, joint.qpos);
  return vector;
}

function setJointValue(joint, qpos, value) {
  if (joint.type === "ball") quaternionOfVector(qpos, joint.qpos, value, 0);
  else qpos[joint.qpos] = value[0];
}

// Moves one degree of freedom; of a ball about the axis k of the moved frame.
function nudge(joint, qpos, k, by) {
  if (joint.type !== "ball") {
    qpos[joint.qpos] += by;
    return;
  }
  const vector = [0, 0, 0];
  const turn = [1, 0, 0, 0];
  vector[k] = by;
  quaternionOfVector(turn, 0, vector, 0);
  multiplyQuaternions(qpos, joint.qpos, qpos, joint.qpos, turn, 0);
}
