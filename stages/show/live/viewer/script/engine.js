// MuJoCo in the page: compiles the pack's copy of the model and steps it. Positions are read where the engine
// keeps them; when its memory grows, they are asked for again.

const ROOM = "/robot";
const FRAME_BUDGET = 12; // ms of stepping in one frame at most

class Engine {
  static async start(pack, pieces) {
    const [wasmBinary, code] = await Promise.all([inflated(pieces.wasm), inflatedText(pieces.glue)]);
    const words = [];
    const hear = (line) => void (words.length < 50 && words.push(String(line)));
    const mujoco = await evaluated(code, "mujocoGlue").default({ wasmBinary, print: hear, printErr: hear });
    try {
      return new Engine(mujoco, pack);
    } catch (error) {
      throw new Error(words.join(" ") || messageOf(error));
    }
  }

  constructor(mujoco, pack) {
    this.mujoco = mujoco;
    const { xml, files } = pack.header.engine;
    this.write("model.xml", xml);
    for (const name of Object.keys(files)) this.write(name, pack.file(name));
    this.model = mujoco.MjModel.from_xml_path(`${ROOM}/model.xml`);
    if (!this.model) throw new Error("the model did not compile");
    const { qpos0, bodies, activations } = pack.header;
    if (this.model.nq !== qpos0.length || this.model.nbody !== bodies.length || this.model.na !== activations) {
      throw new Error("the engine's copy of the model has other joints or bodies");
    }
    // Else the engine would start anew by itself, and nobody would be told.
    this.model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET.value;
    this.data = new mujoco.MjData(this.model);
    this.timestep = this.model.opt.timestep;
    this.owed = 0;
    this.pull = null;
    this.views = {};
    this.look();
  }

  write(name, content) {
    const path = `${ROOM}/${name}`;
    this.mujoco.FS.mkdirTree(path.slice(0, path.lastIndexOf("/")));
    this.mujoco.FS.writeFile(path, content);
  }

  // Takes hold of the arrays again where the engine's memory has moved.
  look() {
    if (this.views.qpos?.byteLength || (this.views.qpos && this.model.nq === 0)) return;
    for (const name of ["qpos", "qvel", "ctrl", "xpos", "xquat"]) this.views[name] = this.data[name];
  }

  reset({ qpos, ctrl, act }) {
    this.mujoco.mj_resetData(this.model, this.data);
    this.owed = 0;
    this.look();
    this.views.qpos.set(qpos);
    this.views.ctrl.set(ctrl);
    if (act.length) this.data.act.set(act);
    this.mujoco.mj_forward(this.model, this.data);
    this.look();
  }

  // Goes on by `seconds` of real time as far as the frame's budget allows; what is left over is dropped. Returns the
  // simulated time, NaN where the state is no longer finite.
  advance(seconds) {
    this.owed += seconds;
    const until = performance.now() + FRAME_BUDGET;
    let steps = 0;
    while (this.owed >= this.timestep && performance.now() < until) {
      this.step();
      this.owed -= this.timestep;
      steps++;
    }
    if (this.owed >= this.timestep) this.owed = 0;
    return this.finite() ? steps * this.timestep : NaN;
  }

  step() {
    if (this.pull) this.mujoco.mjv_applyPerturbForce(this.model, this.data, this.pull.perturb);
    this.mujoco.mj_step(this.model, this.data);
  }

  finite() {
    this.look();
    const { qpos, qvel } = this.views;
    for (let i = 0; i < qpos.length; i++) if (!(Math.abs(qpos[i]) < 1e10)) return false;
    for (let i = 0; i < qvel.length; i++) if (!(Math.abs(qvel[i]) < 1e10)) return false;
    return true;
  }

  // Pulls a body by a spring from `local` (in its frame) to `target` (in the world), as MuJoCo's own viewer does.
  grab(body, local, target) {
    const { mujoco } = this;
    this.release();
    this.perturb ??= new mujoco.MjvPerturb();
    this.eye();
    mujoco.mjv_defaultPerturb(this.perturb);
    this.perturb.select = body;
    for (let k = 0; k < 3; k++) this.perturb.localpos[k] = local[k];
    mujoco.mjv_initPerturb(this.model, this.data, this.drawn, this.perturb);
    this.perturb.active = mujoco.mjtPertBit.mjPERT_TRANSLATE.value;
    this.pull = { perturb: this.perturb };
    this.drag(target);
    this.look();
  }

  // MuJoCo asks for a camera before it pulls; where that stands makes no difference to the force.
  eye() {
    if (this.drawn) return;
    const camera = new this.mujoco.MjvCamera();
    this.drawn = new this.mujoco.MjvScene(this.model, 1);
    this.mujoco.mjv_defaultFreeCamera(this.model, camera);
    this.mujoco.mjv_updateCamera(this.model, this.data, camera, this.drawn);
    camera.delete();
  }

  drag(target) {
    const goal = this.perturb.refselpos;
    for (let k = 0; k < 3; k++) goal[k] = target[k];
  }

  release() {
    if (!this.pull) return;
    this.pull = null;
    this.data.xfrc_applied.fill(0);
  }

  // Of each contact its place and its normal.
  contacts() {
    const found = [];
    const all = this.data.contact;
    for (let i = 0; i < Math.min(all.size(), CONTACTS); i++) {
      const one = all.get(i);
      if (one.exclude === 0) found.push([...one.pos, ...one.frame.slice(0, 3)]);
      one.delete();
    }
    all.delete();
    return found;
  }
}

function messageOf(error) {
  return error?.message || String(error);
}
