// Triangles of geoms, merged into the arrays of one mesh: corners in their body's frame, with normal, colour and body.

const CREASE = Math.cos((38 * Math.PI) / 180); // faces that meet at less look round

class Triangles {
  constructor(pack, geoms) {
    const shapes = new Map();
    const pieces = geoms
      .filter((geom) => geom.type !== "plane")
      .map((geom) => ({ geom, shape: shapeOf(pack, geom, shapes) }))
      .sort((a, b) => a.geom.body - b.geom.body);
    const corners = pieces.reduce((sum, { shape }) => sum + shape.positions.length / 3, 0);
    this.positions = new Float32Array(3 * corners);
    this.normals = new Int8Array(4 * corners);
    this.colours = new Uint8Array(4 * corners);
    this.bodies = new Uint16Array(4 * corners);
    this.ranges = new Map(); // body -> [first corner, number of corners]
    let corner = 0;
    for (const { geom, shape } of pieces) corner = this.append(geom, shape, corner);
  }

  append({ body, pos, quat, rgba }, { positions, normals }, first) {
    const colour = new THREE.Color().setRGB(rgba[0], rgba[1], rgba[2], "srgb");
    const count = positions.length / 3;
    const at = new Float64Array(3);
    for (let i = 0; i < count; i++) {
      const corner = first + i;
      rotateVector(at, 0, quat, 0, positions, 3 * i);
      for (let k = 0; k < 3; k++) this.positions[3 * corner + k] = at[k] + pos[k];
      rotateVector(at, 0, quat, 0, normals, 3 * i);
      for (let k = 0; k < 3; k++) this.normals[4 * corner + k] = Math.round(127 * at[k]);
      this.colours[4 * corner] = 255 * Math.sqrt(colour.r);
      this.colours[4 * corner + 1] = 255 * Math.sqrt(colour.g);
      this.colours[4 * corner + 2] = 255 * Math.sqrt(colour.b);
      this.colours[4 * corner + 3] = 255 * rgba[3];
      this.bodies[4 * corner] = body;
    }
    const range = this.ranges.get(body) ?? [first, 0];
    this.ranges.set(body, [range[0], range[1] + count]);
    return first + count;
  }
}

function shapeOf(pack, geom, shapes) {
  if (geom.type !== "mesh") return primitive(geom.type, geom.size);
  if (!shapes.has(geom.mesh)) shapes.set(geom.mesh, creased(pack.mesh(geom.mesh)));
  return shapes.get(geom.mesh);
}

function primitive(type, [a, b, c]) {
  const upright = (geometry) => geometry.rotateX(Math.PI / 2);
  const make = {
    sphere: () => new THREE.SphereGeometry(a, 32, 20),
    ellipsoid: () => new THREE.SphereGeometry(1, 32, 20).scale(a, b, c),
    capsule: () => upright(new THREE.CapsuleGeometry(a, 2 * b, 10, 28)),
    cylinder: () => upright(new THREE.CylinderGeometry(a, a, 2 * b, 40)),
    box: () => new THREE.BoxGeometry(2 * a, 2 * b, 2 * c),
  }[type];
  const flat = make().toNonIndexed();
  return { positions: flat.attributes.position.array, normals: flat.attributes.normal.array };
}

// The corners of every triangle, each with the mean normal of the faces around that are not beyond a crease.
function creased({ steps, indices, origin, step }) {
  const welded = weld(steps);
  const faces = indices.length / 3;
  const positions = new Float32Array(9 * faces);
  for (let i = 0; i < indices.length; i++) {
    for (let k = 0; k < 3; k++) positions[3 * i + k] = origin[k] + step[k] * steps[3 * indices[i] + k];
  }
  const area = faceNormals(positions, faces);
  const [starts, around] = facesAround(indices, welded, steps.length / 3);
  const normals = new Float32Array(9 * faces);
  for (let i = 0; i < indices.length; i++) {
    const face = Math.floor(i / 3);
    const vertex = welded[indices[i]];
    let x = 0, y = 0, z = 0;
    for (let n = starts[vertex]; n < starts[vertex + 1]; n++) {
      const [mine, other] = [4 * face, 4 * around[n]];
      const cosine = area[mine] * area[other] + area[mine + 1] * area[other + 1] + area[mine + 2] * area[other + 2];
      if (cosine < CREASE && mine !== other) continue;
      const weight = area[other + 3];
      x += weight * area[other];
      y += weight * area[other + 1];
      z += weight * area[other + 2];
    }
    const norm = Math.hypot(x, y, z) || 1;
    normals[3 * i] = x / norm;
    normals[3 * i + 1] = y / norm;
    normals[3 * i + 2] = z / norm;
  }
  return { positions, normals };
}

// Of every vertex the first one at the same place.
function weld(steps) {
  const first = new Map();
  const welded = new Uint32Array(steps.length / 3);
  for (let i = 0; i < welded.length; i++) {
    const key = (steps[3 * i] * 65536 + steps[3 * i + 1]) * 65536 + steps[3 * i + 2];
    if (!first.has(key)) first.set(key, i);
    welded[i] = first.get(key);
  }
  return welded;
}

// Of every face the unit normal and the area.
function faceNormals(p, faces) {
  const found = new Float32Array(4 * faces);
  for (let f = 0; f < faces; f++) {
    const i = 9 * f;
    const ux = p[i + 3] - p[i], uy = p[i + 4] - p[i + 1], uz = p[i + 5] - p[i + 2];
    const vx = p[i + 6] - p[i], vy = p[i + 7] - p[i + 1], vz = p[i + 8] - p[i + 2];
    const x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
    const norm = Math.hypot(x, y, z);
    const share = norm > 0 ? 1 / norm : 0;
    found.set([x * share, y * share, z * share, norm], 4 * f);
  }
  return found;
}

// The faces at each vertex, one list after the other, and where each begins.
function facesAround(indices, welded, vertices) {
  const starts = new Uint32Array(vertices + 1);
  for (const index of indices) starts[welded[index] + 1]++;
  for (let v = 0; v < vertices; v++) starts[v + 1] += starts[v];
  const next = starts.slice();
  const around = new Uint32Array(indices.length);
  for (let i = 0; i < indices.length; i++) around[next[welded[indices[i]]]++] = Math.floor(i / 3);
  return [starts, around];
}
