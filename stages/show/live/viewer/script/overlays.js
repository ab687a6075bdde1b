// What is drawn over the robot when asked for, one draw call each: boxes of equal inertia, frames, contacts.

const AXES = ["#e5383b", "#2a9d3a", "#2f6fed"];
const CONTACTS = 64; // shown at most

class InertiaBoxes {
  constructor(header) {
    const material = new THREE.MeshStandardMaterial({ color: 0x8b5cf6, transparent: true, opacity: 0.45, depthWrite: false });
    this.bodies = header.bodies;
    this.object = new THREE.InstancedMesh(new THREE.BoxGeometry(1, 1, 1), material, this.bodies.length);
    this.object.frustumCulled = false;
    this.object.renderOrder = 3;
    this.local = this.bodies.map((body) => boxOf(body));
    this.matrix = new THREE.Matrix4();
  }

  update(robot) {
    for (let body = 0; body < this.bodies.length; body++) {
      this.matrix.multiplyMatrices(robot.bones[body].matrixWorld, this.local[body]);
      this.object.setMatrixAt(body, this.matrix);
    }
    this.object.instanceMatrix.needsUpdate = true;
  }
}

// The box of uniform density with a body's mass and inertia: mass (b² + c²) / 12 about its first axis, and so on.
function boxOf({ mass, com, inertia }) {
  const [a, b, c] = inertia.diagonal;
  const side = (sum) => (mass > 1e-9 ? Math.sqrt(Math.max(0, (6 * sum) / mass)) : 0);
  const [w, x, y, z] = inertia.quat;
  return new THREE.Matrix4().compose(
    new THREE.Vector3(...com), new THREE.Quaternion(x, y, z, w),
    new THREE.Vector3(side(b + c - a), side(a + c - b), side(a + b - c)));
}

class FrameAxes {
  constructor(header, length) {
    const ofBodies = header.bodies.map((_, body) => ({ body, pos: [0, 0, 0], quat: [1, 0, 0, 0], length })).slice(1);
    this.frames = [...ofBodies, ...header.frames.map((frame) => ({ ...frame, length: length * 0.6 }))];
    const material = new THREE.MeshBasicMaterial({ depthTest: false, transparent: true, toneMapped: false });
    this.object = new THREE.InstancedMesh(new THREE.BoxGeometry(1, 1, 1), material, 3 * this.frames.length);
    this.object.frustumCulled = false;
    this.object.renderOrder = 5;
    this.matrix = new THREE.Matrix4();
    this.local = this.frames.flatMap((frame, index) => [0, 1, 2].map((axis) => {
      this.object.setColorAt(3 * index + axis, new THREE.Color(AXES[axis]));
      return barOf(frame, axis);
    }));
  }

  update(robot) {
    for (let i = 0; i < this.local.length; i++) {
      const { body } = this.frames[Math.floor(i / 3)];
      this.object.setMatrixAt(i, this.matrix.multiplyMatrices(robot.bones[body].matrixWorld, this.local[i]));
    }
    this.object.instanceMatrix.needsUpdate = true;
  }
}

// A thin bar from a frame's origin along one of its axes, made of a box of edge 1.
function barOf({ pos, quat: [w, x, y, z], length }, axis) {
  const middle = new THREE.Vector3().setComponent(axis, length / 2);
  const size = new THREE.Vector3(1, 1, 1).multiplyScalar(length / 26).setComponent(axis, length);
  const frame = new THREE.Matrix4().compose(
    new THREE.Vector3(...pos), new THREE.Quaternion(x, y, z, w), new THREE.Vector3(1, 1, 1));
  return frame.multiply(new THREE.Matrix4().compose(middle, new THREE.Quaternion(), size));
}

class ContactMarks {
  constructor(radius) {
    const geometry = new THREE.CylinderGeometry(radius, radius, radius / 6, 20).rotateX(Math.PI / 2);
    const material = new THREE.MeshBasicMaterial({ color: 0xf59e0b, depthTest: false, transparent: true, opacity: 0.9 });
    this.object = new THREE.InstancedMesh(geometry, material, CONTACTS);
    this.object.frustumCulled = false;
    this.object.renderOrder = 6;
    this.object.count = 0;
    this.matrix = new THREE.Matrix4();
    this.turn = new THREE.Quaternion();
    this.up = new THREE.Vector3(0, 0, 1);
    this.normal = new THREE.Vector3();
    this.at = new THREE.Vector3();
    this.one = new THREE.Vector3(1, 1, 1);
  }

  // `contacts`: of each the place and the unit normal, six numbers.
  update(contacts) {
    this.object.count = Math.min(CONTACTS, contacts.length);
    for (let i = 0; i < this.object.count; i++) {
      this.at.fromArray(contacts[i], 0);
      this.turn.setFromUnitVectors(this.up, this.normal.fromArray(contacts[i], 3));
      this.object.setMatrixAt(i, this.matrix.compose(this.at, this.turn, this.one));
    }
    this.object.instanceMatrix.needsUpdate = true;
  }
}

// The spring by which the mouse pulls a body: a line from the body to the pointer.
class PullLine {
  constructor() {
    this.positions = new Float32Array(6);
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(this.positions, 3));
    const material = new THREE.LineBasicMaterial({ color: 0xf59e0b, depthTest: false, transparent: true });
    this.object = new THREE.LineSegments(geometry, material);
    this.object.frustumCulled = this.object.visible = false;
    this.object.renderOrder = 7;
  }

  show(from, to) {
    from.toArray(this.positions, 0);
    to.toArray(this.positions, 3);
    this.object.geometry.attributes.position.needsUpdate = true;
    this.object.visible = true;
  }
}
