// The mouse, the finger and the keys on the canvas: orbit, pick, pull, turn.

const STILL = 4; // pixels that a click may move

class Pointer {
  constructor(view) {
    this.view = view;
    this.from = null;
    const { canvas, controls } = view.stage;
    const on = (name, handler) => canvas.addEventListener(name, handler.bind(this), { capture: true });
    on("pointerdown", this.down);
    on("pointermove", this.move);
    on("pointerup", this.up);
    on("pointercancel", this.cancel);
    on("keydown", this.key);
    canvas.addEventListener("focus", () => (controls.enableZoom = true));
    canvas.addEventListener("blur", () => (controls.enableZoom = false));
    controls.addEventListener("change", () => view.draw());
  }

  down(event) {
    const { view } = this;
    view.stage.canvas.focus({ preventScroll: true, focusVisible: false });
    if (event.button !== 0 || !event.isPrimary) return this.cancel();
    const { origin, direction } = view.stage.rayAt(event);
    this.from = { x: event.clientX, y: event.clientY, hit: view.picking.hit(origin, direction) };
    const pulls = view.running && this.from.hit !== null && view.movable(this.from.hit.body);
    view.stage.controls.enabled = !pulls;
    if (!pulls) return;
    view.stage.canvas.setPointerCapture(event.pointerId);
    this.normal = view.stage.camera.getWorldDirection(new THREE.Vector3());
    this.target = this.from.hit.point.clone();
  }

  move(event) {
    if (!this.from || !this.target || this.still(event)) return;
    const { origin, direction } = this.view.stage.rayAt(event);
    const away = this.from.hit.point.clone().sub(origin).dot(this.normal) / direction.dot(this.normal);
    this.target.copy(origin).addScaledVector(direction, away);
    this.view.pull(this.from.hit, this.target);
  }

  up(event) {
    if (this.from && this.still(event)) this.view.pick(this.from.hit?.body ?? null);
    this.cancel();
  }

  cancel() {
    this.from = this.target = null;
    this.view.stage.controls.enabled = true;
    this.view.letGo();
  }

  still(event) {
    return Math.hypot(event.clientX - this.from.x, event.clientY - this.from.y) < STILL;
  }

  key(event) {
    const { stage } = this.view;
    const act = {
      " ": () => this.view.toggle(),
      ArrowLeft: () => stage.turn(-TURN, 0),
      ArrowRight: () => stage.turn(TURN, 0),
      ArrowUp: () => stage.turn(0, TURN),
      ArrowDown: () => stage.turn(0, -TURN),
      "+": () => stage.zoom(0.9),
      "-": () => stage.zoom(1 / 0.9),
      Home: () => stage.home(),
      Escape: () => this.view.pick(null),
    }[event.key];
    if (!act || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    act();
    this.view.draw();
  }
}
