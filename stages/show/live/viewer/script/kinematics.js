// Poses of the bodies from the joints' values, as MuJoCo computes them (mj_kinematics).

class Kinematics {
  constructor(header) {
    this.bodies = header.bodies;
    this.qpos = Float64Array.from(header.qpos0);
    this.xpos = new Float64Array(3 * this.bodies.length);
    this.xquat = new Float64Array(4 * this.bodies.length);
    this.xquat[0] = 1;
    this.joints = this.bodies.map(() => []);
    for (const joint of header.joints) this.joints[joint.body].push(joint);
    this.turn = new Float64Array(4);
    this.anchor = new Float64Array(3);
    this.offset = new Float64Array(3);
    this.update();
  }

  // Writes xpos (in m) and xquat of every body in the world.
  update() {
    for (let body = 1; body < this.bodies.length; body++) {
      const joints = this.joints[body];
      if (joints.length === 1 && joints[0].type === "free") this.float(body, joints[0]);
      else this.hang(body, joints);
      normalizeQuaternion(this.xquat, 4 * body);
    }
  }

  float(body, joint) {
    for (let k = 0; k < 3; k++) this.xpos[3 * body + k] = this.qpos[joint.qpos + k];
    for (let k = 0; k < 4; k++) this.xquat[4 * body + k] = this.qpos[joint.qpos + 3 + k];
  }

  hang(body, joints) {
    const { xpos, xquat } = this;
    const { parent, pos, quat } = this.bodies[body];
    const p = 3 * body;
    rotateVector(xpos, p, xquat, 4 * parent, pos, 0);
    for (let k = 0; k < 3; k++) xpos[p + k] += xpos[3 * parent + k];
    multiplyQuaternions(xquat, 4 * body, xquat, 4 * parent, quat, 0);
    for (const joint of joints) this.move(body, joint);
  }

  move(body, joint) {
    const { xpos, xquat, qpos, anchor, offset, turn } = this;
    const p = 3 * body;
    if (joint.type === "slide") {
      rotateVector(offset, 0, xquat, 4 * body, joint.axis, 0);
      for (let k = 0; k < 3; k++) xpos[p + k] += offset[k] * (qpos[joint.qpos] - joint.ref);
      return;
    }
    rotateVector(anchor, 0, xquat, 4 * body, joint.pos, 0);
    for (let k = 0; k < 3; k++) anchor[k] += xpos[p + k];
    if (joint.type === "hinge") {
      quaternionAbout(turn, 0, joint.axis, 0, qpos[joint.qpos] - joint.ref);
    } else {
      for (let k = 0; k < 4; k++) turn[k] = qpos[joint.qpos + k];
      normalizeQuaternion(turn, 0);
    }
    multiplyQuaternions(xquat, 4 * body, xquat, 4 * body, turn, 0);
    rotateVector(offset, 0, xquat, 4 * body, joint.pos, 0);
    for (let k = 0; k < 3; k++) xpos[p + k] = anchor[k] - offset[k];
  }
}
