// The room that the robot stands in: canvas, camera, light, ground. It draws when asked to.

const FIELD = 34; // of view, degrees
const TURN = Math.PI / 36; // by one key
const VISIBLE_HEIGHT = 0.72; // of the canvas, between the buttons
const VISIBLE_WIDTH = 0.84;

class Stage {
  // `canvas` has a WebGL 2 context already, which `context` is.
  constructor(canvas, context, header) {
    this.canvas = canvas;
    this.header = header;
    this.renderer = new THREE.WebGLRenderer({ canvas, context, alpha: true, antialias: true });
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio));
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = THREE.PCFShadowMap;
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(FIELD, 1, 0.01, 100);
    this.camera.up.set(0, 0, 1);
    this.controls = new THREE.OrbitControls(this.camera, canvas);
    this.controls.enableDamping = false;
    this.controls.enableZoom = false; // the wheel scrolls the page until the view is chosen
    this.ray = { origin: new THREE.Vector3(), direction: new THREE.Vector3() };
  }

  // Sets camera, light and ground to a robot of this middle and radius [m], of which `corners` are to be seen.
  furnish({ center, radius, corners }) {
    this.center = center.clone();
    this.radius = radius;
    this.corners = corners.map((corner) => corner.clone().sub(center));
    this.light();
    this.floor();
    this.resize();
    this.home();
  }

  light() {
    const key = new THREE.DirectionalLight(0xffffff, 2.2);
    key.position.copy(this.center).add(new THREE.Vector3(-0.9, -1.5, 2.6).multiplyScalar(2 * this.radius));
    key.target.position.copy(this.center);
    key.castShadow = true;
    key.shadow.mapSize.setScalar(this.canvas.clientWidth * this.renderer.getPixelRatio() < 700 ? 1024 : 2048);
    key.shadow.radius = 2.5;
    key.shadow.normalBias = this.radius / 70;
    key.shadow.bias = -0.0006;
    const reach = 1.9 * this.radius;
    Object.assign(key.shadow.camera, { left: -reach, right: reach, top: reach, bottom: -reach });
    Object.assign(key.shadow.camera, { near: 3 * this.radius, far: 11 * this.radius });
    const fill = new THREE.DirectionalLight(0xdbeafe, 1.1);
    fill.position.set(2, 1.2, 0.8);
    const rim = new THREE.DirectionalLight(0xffffff, 1);
    rim.position.set(0.4, 2, 1.4);
    const sky = new THREE.HemisphereLight(0xffffff, 0xb4b8c0, 1.9);
    sky.position.set(0, 0, 1);
    this.scene.add(key, key.target, fill, rim, sky);
    this.goAlong = [this.center, this.camera.position, this.controls.target, key.position, key.target.position];
  }

  floor() {
    const plane = this.header.geoms.find((geom) => geom.role === "ground" && geom.type === "plane");
    this.grid = new THREE.Mesh(new THREE.PlaneGeometry(1, 1), gridMaterial(this.radius));
    const shadow = new THREE.Mesh(new THREE.PlaneGeometry(1, 1), new THREE.ShadowMaterial({ opacity: 0.28 }));
    shadow.receiveShadow = true;
    const [w, x, y, z] = plane?.quat ?? [1, 0, 0, 0];
    for (const one of [this.grid, shadow]) {
      one.scale.setScalar(24 * this.radius);
      one.quaternion.set(x, y, z, w);
      one.position.set(this.center.x, this.center.y, plane ? plane.pos[2] : this.center.z - this.radius);
      one.renderOrder = -1;
      one.material.depthWrite = false;
    }
    shadow.visible = this.grid.visible = Boolean(plane);
    this.scene.add(this.grid, shadow);
    this.colour();
  }

  // Takes the colours of the page, which are others in the dark.
  colour() {
    const style = getComputedStyle(this.canvas);
    this.grid?.material.uniforms.colour.value.set(style.getPropertyValue("--live-grid").trim() || "#888");
    this.accent = new THREE.Color(style.getPropertyValue("--live-pick").trim() || "#0ea5e9");
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (!width || !height) return;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
  }

  // The camera's first place: the whole robot, from where the build looks at it.
  home() {
    const { azimuth, elevation } = this.header.camera;
    const [turn, rise] = [(azimuth * Math.PI) / 180, (elevation * Math.PI) / 180];
    const forward = new THREE.Vector3(
      Math.cos(rise) * Math.cos(turn), Math.cos(rise) * Math.sin(turn), Math.sin(rise));
    const { target, distance } = this.fit(forward);
    this.camera.near = distance / 100;
    this.camera.far = distance * 40;
    this.camera.position.copy(target).addScaledVector(forward, -distance);
    this.controls.target.copy(target);
    this.controls.minDistance = this.radius / 10;
    this.controls.maxDistance = distance * 8;
    this.camera.updateProjectionMatrix();
    this.controls.update();
  }

  // What to look at along `forward`, and from how far, to see all corners with a margin.
  fit(forward) {
    const right = new THREE.Vector3(forward.y, -forward.x, 0).normalize();
    if (right.lengthSq() < 0.5) right.set(1, 0, 0);
    const up = right.clone().cross(forward);
    const seen = this.corners.map((from) => [from.dot(right), from.dot(up), from.dot(forward)]);
    const middle = (values) => (Math.min(...values) + Math.max(...values)) / 2;
    const [x, y] = [0, 1].map((k) => middle(seen.map((at) => at[k])));
    const tall = Math.tan((FIELD * Math.PI) / 360) * VISIBLE_HEIGHT;
    const wide = Math.tan((FIELD * Math.PI) / 360) * this.camera.aspect * VISIBLE_WIDTH;
    const away = (at) => Math.max(Math.abs(at[0] - x) / wide, Math.abs(at[1] - y) / tall) - at[2];
    const distance = Math.max(...seen.map(away));
    const target = this.center.clone().addScaledVector(right, x).addScaledVector(up, y);
    return { target, distance: Math.max(distance, this.radius / 2) };
  }

  // Turns the camera about what it looks at.
  turn(left, up) {
    const offset = this.camera.position.clone().sub(this.controls.target);
    const distance = offset.length();
    const azimuth = Math.atan2(offset.y, offset.x) + left;
    const polar = Math.min(3.1, Math.max(0.05, Math.acos(offset.z / distance) - up));
    offset.set(Math.sin(polar) * Math.cos(azimuth), Math.sin(polar) * Math.sin(azimuth), Math.cos(polar));
    this.camera.position.copy(this.controls.target).addScaledVector(offset, distance);
    this.controls.update();
  }

  zoom(factor) {
    this.camera.position.sub(this.controls.target).multiplyScalar(factor).add(this.controls.target);
    this.controls.update();
  }

  // Moves camera and light along with a robot that goes away.
  follow(x, y) {
    if (x === 0 && y === 0) return;
    for (const one of this.goAlong) {
      one.x += x;
      one.y += y;
    }
  }

  // The ray through a point of the screen, in the world.
  rayAt(event) {
    const box = this.canvas.getBoundingClientRect();
    const x = (2 * (event.clientX - box.left)) / box.width - 1;
    const y = 1 - (2 * (event.clientY - box.top)) / box.height;
    this.ray.origin.setFromMatrixPosition(this.camera.matrixWorld);
    this.ray.direction.set(x, y, 0.5).unproject(this.camera).sub(this.ray.origin).normalize();
    return this.ray;
  }

  render() {
    this.renderer.render(this.scene, this.camera);
  }
}

// Lines every so many metres, each tenth stronger, which fade out towards the horizon.
function gridMaterial(radius) {
  const cell = 10 ** Math.floor(Math.log10(radius));
  return new THREE.ShaderMaterial({
    transparent: true,
    side: THREE.DoubleSide,
    uniforms: { colour: { value: new THREE.Color() }, cell: { value: cell }, reach: { value: 6 * radius } },
    vertexShader: `
      varying vec2 place;
      varying vec2 middle;
      void main() {
        vec4 world = modelMatrix * vec4(position, 1.0);
        place = world.xy;
        middle = modelMatrix[3].xy;
        gl_Position = projectionMatrix * viewMatrix * world;
      }`,
    fragmentShader: `
      uniform vec3 colour;
      uniform float cell;
      uniform float reach;
      varying vec2 place;
      varying vec2 middle;
      float lines(float size) {
        vec2 steps = place / size;
        vec2 width = max(fwidth(steps), vec2(1e-4));
        vec2 away = abs(fract(steps - 0.5) - 0.5) / width;
        float fine = 1.0 - clamp(max(width.x, width.y) * 2.0 - 0.4, 0.0, 1.0);
        return fine * (1.0 - min(min(away.x, away.y), 1.0));
      }
      void main() {
        float fade = 1.0 - smoothstep(0.15, 1.0, length(place - middle) / reach);
        float strength = max(0.35 * lines(cell), 0.8 * lines(10.0 * cell));
        gl_FragColor = vec4(colour, strength * fade * fade);
        #include <colorspace_fragment>
      }`,
  });
}
