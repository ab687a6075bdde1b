// What the page shows, as the build packed it: a header and a binary part, described in stages/show/live/pack.py.

class Pack {
  constructor(bytes) {
    const length = new DataView(bytes.buffer, bytes.byteOffset).getUint32(0, true);
    this.header = JSON.parse(new TextDecoder().decode(bytes.subarray(4, 4 + length)));
    this.binary = bytes.slice(4 + length); // a copy, so that it begins at 0 of its own buffer
  }

  static async read() {
    return new Pack(await inflated(taken("robot-pack")));
  }

  // The corners of a mesh in steps of its own grid (uint16 triples), and the triangles' corners.
  mesh(index) {
    const { positions, indices } = this.header.meshes[index];
    const Index = indices.bytes === 2 ? Uint16Array : Uint32Array;
    return {
      steps: new Uint16Array(this.binary.buffer, positions.at, 3 * positions.count),
      indices: new Index(this.binary.buffer, indices.at, indices.count),
      origin: positions.origin,
      step: positions.step,
    };
  }

  file(name) {
    const { at, bytes } = this.header.engine.files[name];
    return this.binary.subarray(at, at + bytes);
  }
}
