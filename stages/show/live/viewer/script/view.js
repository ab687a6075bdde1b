// The view as a whole: what is shown, whether it runs, and who is told.

const LONGEST = 0.1; // s of a frame that are caught up with
const REFRESH = 80; // ms between two updates of the sliders while it runs

class View {
  constructor(pack, context, page) {
    this.pack = pack;
    this.page = page;
    const { header } = pack;
    this.kinematics = new Kinematics(header);
    this.closing = new Closing(header, this.kinematics);
    this.robot = new RobotMesh(pack);
    this.picking = new Picking(this.robot);
    this.stage = new Stage(page.canvas, context, header);
    this.home = header.keyframes[0] ?? { name: "start", qpos: header.qpos0, ctrl: [], act: [] };
    this.engine = null;
    this.running = false;
    this.waiting = false; // out of sight
    this.changed = true;
    this.posedSince = true; // the engine does not know the pose yet
    this.ctrl = new Float64Array(header.actuators.length);
    this.act = new Float64Array(header.activations);
    this.take(this.home);
    this.robot.pose(this.kinematics.xpos, this.kinematics.xquat);
    const box = this.robot.bounds() ?? {
      center: new THREE.Vector3(...header.camera.center),
      radius: header.camera.extent / 2 || 1,
      corners: [new THREE.Vector3(...header.camera.center)],
    };
    this.stage.furnish(box);
    this.overlays(header, box.radius);
    this.stage.scene.add(this.robot.visual, this.robot.collider);
    this.follows = header.joints.find((joint) => joint.type === "free")?.body ?? null;
    this.stood = [0, 0];
    this.remember();
    this.scriptTime = this.stepTime = 0;
    this.frame = this.frame.bind(this);
  }

  overlays(header, radius) {
    this.inertia = new InertiaBoxes(header);
    this.frames = new FrameAxes(header, radius / 7);
    this.contacts = new ContactMarks(radius / 28);
    this.line = new PullLine();
    this.layers = {
      visual: this.robot.visual, collider: this.robot.collider, inertia: this.inertia.object,
      frames: this.frames.object, contacts: this.contacts.object,
    };
    for (const name of ["collider", "inertia", "frames", "contacts"]) this.layers[name].visible = false;
    if (this.robot.triangles.visual.positions.length === 0) this.layers.collider.visible = true;
    this.stage.scene.add(this.inertia.object, this.frames.object, this.contacts.object, this.line.object);
  }

  // The joints' values as shown, whoever computes them.
  get qpos() {
    return this.running ? this.engine.views.qpos : this.kinematics.qpos;
  }

  take({ qpos, ctrl, act }) {
    this.kinematics.qpos.set(qpos);
    this.ctrl.fill(0).set(ctrl);
    this.act.fill(0).set(act);
    this.kinematics.update();
    this.posedSince = true;
  }

  // Goes to a keyframe, and on from there if it runs.
  reset(keyframe = this.home) {
    this.take(keyframe);
    if (this.running) this.intoEngine();
    this.draw();
  }

  // Moves a joint, and what it drags along. While it runs this pauses: a pose and physics cannot both be right.
  pose(joint, target) {
    if (this.running) this.pause();
    this.closing.move(joint, target);
    this.posedSince = true;
    this.hold();
    this.draw();
  }

  // The targets of servos go along with a pose, so that the robot stays there when it runs.
  hold() {
    const { actuators, joints } = this.pack.header;
    actuators.forEach(({ joint, range, target }, index) => {
      if (!target) return;
      const value = target.slope * this.kinematics.qpos[joints[joint].qpos] + target.offset;
      const kept = range && target.ctrl ? Math.min(range[1], Math.max(range[0], value)) : value;
      this.ctrl[index] = target.ctrl ? kept : 0;
      if (target.act !== null) this.act[target.act] = kept;
    });
  }

  control(index, value) {
    this.ctrl[index] = value;
    if (this.engine) this.engine.views.ctrl[index] = value;
    this.draw();
  }

  intoEngine() {
    this.engine.reset({ qpos: this.kinematics.qpos, ctrl: this.ctrl, act: this.act });
    this.posedSince = false;
  }

  run() {
    if (!this.engine || this.running) return;
    if (this.posedSince) this.intoEngine();
    this.running = true;
    this.last = performance.now();
    this.page.tell(`Simulating in MuJoCo ${this.page.version}`);
    this.page.showRunning(true);
    this.draw();
  }

  pause(word = "Paused") {
    if (this.running) {
      this.kinematics.qpos.set(this.engine.views.qpos);
      this.kinematics.update();
      this.letGo();
    }
    this.running = false;
    this.page.tell(word);
    this.page.showRunning(false);
    this.draw();
  }

  toggle() {
    if (this.running) this.pause();
    else this.run();
  }

  // Steps the engine for the seconds since the last frame; a state that is not finite ends it.
  advance(seconds) {
    let reason = "";
    try {
      this.engine.look();
      const gone = this.engine.advance(Math.min(LONGEST, seconds));
      if (!Number.isNaN(gone)) return this.pace(gone, seconds);
    } catch (error) {
      reason = ` (${messageOf(error)})`;
    }
    this.letGo();
    this.running = false;
    this.take(this.home);
    this.pause(`The simulation became unstable and was stopped${reason}; the robot is back at ${this.home.name}`);
  }

  // Tells about once a second how fast simulated time goes, where that is slower than the clock.
  pace(simulated, seconds) {
    this.paced ??= { simulated: 0, seconds: 0 };
    this.paced.simulated += simulated;
    this.paced.seconds += seconds;
    if (this.paced.seconds < 1) return;
    this.page.showRate(this.paced.simulated / this.paced.seconds);
    this.paced = null;
  }

  movable(body) {
    for (let at = body; at > 0; at = this.pack.header.bodies[at].parent) {
      if (this.kinematics.joints[at].length) return true;
    }
    return false;
  }

  pull(hit, target) {
    if (!this.running) return;
    if (this.engine.pull) this.engine.drag(target.toArray());
    else this.engine.grab(hit.body, hit.local.toArray(), target.toArray());
    this.pulled = { hit, target };
  }

  letGo() {
    this.engine?.release();
    this.pulled = null;
    this.line.object.visible = false;
    this.draw();
  }

  pick(body) {
    const { bodies } = this.pack.header;
    const link = body === null ? null : bodies[body].link;
    const same = bodies.map((_, index) => index).filter((index) =>
      index === body || (link !== null && link !== undefined && bodies[index].link === link));
    this.robot.highlight(body === null ? [] : same, this.stage.accent);
    this.page.showLink(body);
    this.draw();
  }

  show(layer, visible) {
    this.layers[layer].visible = visible;
    this.robot.collider.castShadow = !this.layers.visual.visible;
    this.draw();
  }

  // The root's place, from which the camera goes along.
  remember() {
    if (this.follows === null) return;
    const { elements } = this.robot.bones[this.follows].matrixWorld;
    [this.stood[0], this.stood[1]] = [elements[12], elements[13]];
  }

  draw() {
    this.changed = true;
    if (!this.asked && !this.waiting) {
      this.asked = true;
      requestAnimationFrame(this.frame);
    }
  }

  frame(now) {
    this.asked = false;
    if (this.waiting) return;
    const began = performance.now();
    if (this.running) this.advance(Math.max(0, now - (this.last ?? now)) / 1000);
    this.stepTime = performance.now() - began;
    this.last = now;
    this.update();
    if (!this.refreshed || !this.running || now - this.refreshed > REFRESH) {
      this.page.panel.refresh();
      this.refreshed = now;
    }
    this.stage.render();
    this.scriptTime = performance.now() - began;
    if (this.running) this.draw();
  }

  // Brings all that is drawn to the present pose.
  update() {
    const { xpos, xquat } = this.running ? this.engine.views : this.kinematics;
    this.robot.pose(xpos, xquat);
    if (this.follows !== null) {
      const x = this.stood[0];
      const y = this.stood[1];
      this.remember();
      this.stage.follow(this.stood[0] - x, this.stood[1] - y);
    }
    if (this.inertia.object.visible) this.inertia.update(this.robot);
    if (this.frames.object.visible) this.frames.update(this.robot);
    if (this.contacts.object.visible) this.contacts.update(this.contactsNow());
    if (this.pulled) {
      const { hit, target } = this.pulled;
      this.line.show(hit.point.copy(hit.local).applyMatrix4(this.robot.bones[hit.body].matrixWorld), target);
    }
  }

  // Contacts are the engine's: at a pose it is asked for them.
  contactsNow() {
    if (!this.engine) return [];
    if (this.posedSince) this.intoEngine();
    return this.engine.contacts();
  }
}
