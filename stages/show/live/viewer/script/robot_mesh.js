// The robot in two draw calls whatever its number of links: all visuals are one mesh, all colliders another, and
// every body is a bone of one skeleton.

const HIGHLIGHT = 0.6;
const SAMPLES = 6000; // corners by which the camera finds its place

// Colours that tell neighbours apart: each a golden angle further round the circle.
function colliderColour(index) {
  const { r, g, b } = new THREE.Color().setHSL((0.36 + index * 0.381966) % 1, 0.62, 0.52).getRGB({}, "srgb");
  return [r, g, b, 0.5];
}

class RobotMesh {
  constructor(pack) {
    const { bodies, geoms } = pack.header;
    const colliders = geoms.filter((geom) => geom.role === "collision");
    this.bones = bodies.map(() => {
      const bone = new THREE.Bone();
      bone.matrixAutoUpdate = bone.matrixWorldAutoUpdate = false;
      return bone;
    });
    this.skeleton = new THREE.Skeleton(this.bones, bodies.map(() => new THREE.Matrix4()));
    const visuals = geoms.filter((geom) => geom.role !== "collision");
    this.triangles = {
      visual: new Triangles(pack, visuals),
      collider: new Triangles(pack, colliders.map((geom, index) => ({ ...geom, rgba: colliderColour(index) }))),
    };
    const transparent = visuals.some((geom) => geom.rgba[3] < 0.99);
    this.visual = this.skinned(this.triangles.visual, { transparent, metalness: 0.1, roughness: 0.5 });
    this.collider = this.skinned(this.triangles.collider, {
      transparent: true, roughness: 0.9, depthWrite: false, polygonOffset: true, polygonOffsetFactor: -2,
    });
    this.visual.castShadow = this.visual.receiveShadow = true;
    this.collider.renderOrder = 2;
    this.at = new THREE.Vector3();
    this.turn = new THREE.Quaternion();
    this.one = new THREE.Vector3(1, 1, 1);
    this.tinted = new Set();
  }

  skinned(triangles, look) {
    const geometry = new THREE.BufferGeometry();
    const corners = triangles.positions.length / 3;
    const weights = new Uint8Array(4 * corners);
    for (let i = 0; i < corners; i++) weights[4 * i] = 255;
    const set = (name, array, size, normalized) =>
      geometry.setAttribute(name, new THREE.BufferAttribute(array, size, normalized));
    set("position", triangles.positions, 3, false);
    set("normal", triangles.normals, 4, true);
    set("color", triangles.colours.slice(), 4, true);
    set("skinIndex", triangles.bodies, 4, false);
    set("skinWeight", weights, 4, true);
    const material = new THREE.MeshStandardMaterial({ vertexColors: true, side: THREE.DoubleSide, ...look });
    // The colours are kept as square roots, so that eight bits hold the dark ones.
    material.onBeforeCompile = (shader) => {
      shader.vertexShader = shader.vertexShader.replace(
        "#include <color_vertex>", "#include <color_vertex>\n vColor.rgb = vColor.rgb * vColor.rgb;");
    };
    const mesh = new THREE.SkinnedMesh(geometry, material);
    mesh.bind(this.skeleton, new THREE.Matrix4());
    mesh.frustumCulled = false;
    return mesh;
  }

  // Takes over the poses of the bodies.
  pose(xpos, xquat) {
    for (let body = 0; body < this.bones.length; body++) {
      const [p, q] = [3 * body, 4 * body];
      this.at.set(xpos[p], xpos[p + 1], xpos[p + 2]);
      this.turn.set(xquat[q + 1], xquat[q + 2], xquat[q + 3], xquat[q]);
      this.bones[body].matrixWorld.compose(this.at, this.turn, this.one);
    }
  }

  // Shows `bodies` in the colour of what is picked, all others in their own.
  highlight(bodies, colour) {
    for (const [name, mesh] of [["visual", this.visual], ["collider", this.collider]]) {
      const { colours, ranges } = this.triangles[name];
      const shown = mesh.geometry.attributes.color;
      for (const body of new Set([...this.tinted, ...bodies])) {
        const [first, count] = ranges.get(body) ?? [0, 0];
        const share = bodies.includes(body) ? HIGHLIGHT : 0;
        const tint = [colour.r, colour.g, colour.b].map((value) => 255 * Math.sqrt(value));
        for (let i = 4 * first; i < 4 * (first + count); i++) {
          if (i % 4 < 3) shown.array[i] = (1 - share) * colours[i] + share * tint[i % 4];
        }
        shown.addUpdateRange(4 * first, 4 * count);
      }
      shown.needsUpdate = true;
    }
    this.tinted = new Set(bodies);
  }

  // Middle and radius [m] of what is shown at this pose, and a share of its corners; null where nothing is shown.
  bounds() {
    const shown = this.triangles.visual.positions.length > 0 ? this.triangles.visual : this.triangles.collider;
    const low = new THREE.Vector3(Infinity, Infinity, Infinity);
    const high = low.clone().negate();
    const corner = new THREE.Vector3();
    const corners = [];
    const every = Math.ceil(shown.positions.length / 3 / SAMPLES);
    for (const [body, [first, count]] of shown.ranges) {
      if (body === 0) continue;
      for (let i = first; i < first + count; i++) {
        corner.fromArray(shown.positions, 3 * i).applyMatrix4(this.bones[body].matrixWorld);
        low.min(corner);
        high.max(corner);
        if (i % every === 0) corners.push(corner.clone());
      }
    }
    if (low.x > high.x) return null;
    return { center: low.clone().add(high).multiplyScalar(0.5), radius: low.distanceTo(high) / 2, corners };
  }
}
