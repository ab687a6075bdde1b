// Quaternions (wxyz) and vectors within flat arrays: an offset stands beside each array, and nothing is allocated.

function multiplyQuaternions(out, o, a, i, b, j) {
  const w = a[i], x = a[i + 1], y = a[i + 2], z = a[i + 3];
  const bw = b[j], bx = b[j + 1], by = b[j + 2], bz = b[j + 3];
  out[o] = w * bw - x * bx - y * by - z * bz;
  out[o + 1] = w * bx + x * bw + y * bz - z * by;
  out[o + 2] = w * by - x * bz + y * bw + z * bx;
  out[o + 3] = w * bz + x * by - y * bx + z * bw;
}

function rotateVector(out, o, q, i, v, j) {
  const w = q[i], x = q[i + 1], y = q[i + 2], z = q[i + 3];
  const vx = v[j], vy = v[j + 1], vz = v[j + 2];
  const tx = 2 * (y * vz - z * vy);
  const ty = 2 * (z * vx - x * vz);
  const tz = 2 * (x * vy - y * vx);
  out[o] = vx + w * tx + y * tz - z * ty;
  out[o + 1] = vy + w * ty + z * tx - x * tz;
  out[o + 2] = vz + w * tz + x * ty - y * tx;
}

function normalizeQuaternion(q, i) {
  const norm = Math.hypot(q[i], q[i + 1], q[i + 2], q[i + 3]);
  if (norm < 1e-15) {
    q[i] = 1;
    q[i + 1] = q[i + 2] = q[i + 3] = 0;
  } else {
    for (let k = i; k < i + 4; k++) q[k] /= norm;
  }
}

// The rotation by `angle` [rad] about a unit axis.
function quaternionAbout(out, o, axis, i, angle) {
  const sine = Math.sin(angle / 2);
  out[o] = Math.cos(angle / 2);
  for (let k = 0; k < 3; k++) out[o + 1 + k] = sine * axis[i + k];
}

// The rotation by a rotation vector [rad].
function quaternionOfVector(out, o, vector, i) {
  const angle = Math.hypot(vector[i], vector[i + 1], vector[i + 2]);
  const share = angle < 1e-12 ? 0.5 : Math.sin(angle / 2) / angle;
  out[o] = Math.cos(angle / 2);
  for (let k = 0; k < 3; k++) out[o + 1 + k] = share * vector[i + k];
}

// The rotation vector [rad], at most half a turn, of a quaternion.
function vectorOfQuaternion(out, o, q, i) {
  const sign = q[i] < 0 ? -1 : 1;
  const sine = Math.hypot(q[i + 1], q[i + 2], q[i + 3]);
  const share = sine < 1e-12 ? 2 : (2 * Math.atan2(sine, sign * q[i])) / sine;
  for (let k = 0; k < 3; k++) out[o + k] = sign * share * q[i + 1 + k];
}

// Solves A x = b in place of b for a symmetric positive definite A (n by n, row by row), which is overwritten
// by its Cholesky factor. Returns whether A was one.
function solveInPlace(A, b, n) {
  for (let i = 0; i < n; i++) {
    for (let j = 0; j <= i; j++) {
      let sum = A[i * n + j];
      for (let k = 0; k < j; k++) sum -= A[i * n + k] * A[j * n + k];
      if (i === j) {
        if (!(sum > 0)) return false;
        A[i * n + i] = Math.sqrt(sum);
      } else {
        A[i * n + j] = sum / A[j * n + j];
      }
    }
  }
  for (let i = 0; i < n; i++) {
    for (let k = 0; k < i; k++) b[i] -= A[i * n + k] * b[k];
    b[i] /= A[i * n + i];
  }
  for (let i = n - 1; i >= 0; i--) {
    for (let k = i + 1; k < n; k++) b[i] -= A[k * n + i] * b[k];
    b[i] /= A[i * n + i];
  }
  return true;
}
