// The panel beside the robot: controls of the actuators, values of the joints.

const FEW = 16; // sliders that are shown unfolded

class Panel {
  constructor(view, root) {
    this.view = view;
    this.root = root;
    const { joints, actuators } = view.pack.header;
    this.joints = joints.flatMap((joint) =>
      jointSliders(joint).map((slider, k) => ({
        joint, k, ...makeSlider(slider, (value) => this.posed(joint, k, value)),
      })));
    this.actuators = actuators.map((actuator, index) =>
      makeSlider(actuatorSlider(actuator), (value) => view.control(index, value)));
    this.controls = makeFold(`Controls (${actuators.length})`, this.actuators.map(({ row }) => row), true);
    const values = makeFold(
      `Joints (${this.joints.length})`, this.joints.map(({ row }) => row), this.joints.length <= FEW);
    this.controls.hidden = true;
    values.hidden = this.joints.length === 0;
    root.append(this.controls, values);
  }

  posed(joint, k, value) {
    const target = jointValue(joint, this.view.qpos);
    target[k] = value;
    const turn = Math.hypot(...target);
    const most = joint.type === "ball" ? (joint.range?.[1] ?? Math.PI) : Infinity;
    this.view.pose(joint, turn > most ? target.map((one) => (one * most) / turn) : target);
  }

  // Shows the values; controls only where there is an engine that they act on.
  refresh() {
    const { qpos, ctrl, engine } = this.view;
    for (const { joint, k, show } of this.joints) show(k ? jointValue(joint, qpos)[k] : firstValue(joint, qpos));
    for (let i = 0; i < this.actuators.length; i++) this.actuators[i].show(ctrl[i]);
    this.controls.hidden = !engine || this.actuators.length === 0;
  }
}

function firstValue(joint, qpos) {
  return joint.type === "ball" ? jointValue(joint, qpos)[0] : qpos[joint.qpos];
}
