// Which body lies under the pointer, and where.

class Picking {
  constructor(robot) {
    this.robot = robot;
    this.inverse = new THREE.Matrix4();
    this.origin = new THREE.Vector3();
    this.direction = new THREE.Vector3();
  }

  // The nearest triangle on a ray in the world: {body, point, local, distance}, or null. `local` is in the body's frame.
  hit(origin, direction) {
    let nearest = null;
    for (const [mesh, triangles] of [
      [this.robot.visual, this.robot.triangles.visual],
      [this.robot.collider, this.robot.triangles.collider],
    ]) {
      if (!mesh.visible) continue;
      for (const [body, range] of triangles.ranges) {
        if (body === 0) continue;
        const distance = this.distance(triangles, body, range, origin, direction);
        if (distance < (nearest?.distance ?? Infinity)) nearest = { body, distance };
      }
    }
    if (!nearest) return null;
    const point = origin.clone().addScaledVector(direction, nearest.distance);
    const local = point.clone().applyMatrix4(this.robot.bones[nearest.body].matrixWorld.clone().invert());
    return { ...nearest, point, local };
  }

  distance({ positions }, body, [first, count], origin, direction) {
    this.inverse.copy(this.robot.bones[body].matrixWorld).invert();
    const o = this.origin.copy(origin).applyMatrix4(this.inverse);
    const d = this.direction.copy(direction).transformDirection(this.inverse);
    let nearest = Infinity;
    for (let i = 3 * first; i < 3 * (first + count); i += 9) {
      const distance = rayTriangle(o, d, positions, i);
      if (distance < nearest) nearest = distance;
    }
    return nearest;
  }
}

// Möller and Trumbore (1997): the distance along the ray to the triangle at p[i], Infinity where it misses.
function rayTriangle(o, d, p, i) {
  const ux = p[i + 3] - p[i], uy = p[i + 4] - p[i + 1], uz = p[i + 5] - p[i + 2];
  const vx = p[i + 6] - p[i], vy = p[i + 7] - p[i + 1], vz = p[i + 8] - p[i + 2];
  const hx = d.y * vz - d.z * vy, hy = d.z * vx - d.x * vz, hz = d.x * vy - d.y * vx;
  const determinant = ux * hx + uy * hy + uz * hz;
  if (Math.abs(determinant) < 1e-18) return Infinity;
  const sx = o.x - p[i], sy = o.y - p[i + 1], sz = o.z - p[i + 2];
  const u = (sx * hx + sy * hy + sz * hz) / determinant;
  if (u < 0 || u > 1) return Infinity;
  const qx = sy * uz - sz * uy, qy = sz * ux - sx * uz, qz = sx * uy - sy * ux;
  const v = (d.x * qx + d.y * qy + d.z * qz) / determinant;
  if (v < 0 || u + v > 1) return Infinity;
  const t = (vx * qx + vy * qy + vz * qz) / determinant;
  return t > 0 ? t : Infinity;
}
