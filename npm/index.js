// Soft tissue for skinned avatars: the wasm engine, with typed arrays in and out. Types and units are in index.d.ts.

import loadWasm, { Core } from "./wasm/supple.js";
import { InvalidError, unpacked } from "./errors.js";

export { FileError, FormatError, InvalidError, NotFiniteError, SolveError, SuppleError } from "./errors.js";

let wasm;
let loading;

/** Loads the wasm: from beside this module, or from a URL, a Response, bytes or a WebAssembly.Module. `load` does it too. */
export function init(source) {
  loading ??= fetched(source).then(
    (found) => { wasm = found; },
    (error) => { loading = undefined; throw error; },
  );
  return loading;
}

async function fetched(source) {
  let from = source ?? new URL("./wasm/supple_bg.wasm", import.meta.url);
  if (from instanceof URL && from.protocol === "file:") {
    // Node fetches no files.
    const files = "node:fs/promises";
    const { readFile } = await import(/* webpackIgnore: true */ /* @vite-ignore */ files);
    from = await readFile(from);
  }
  return loadWasm({ module_or_path: from });
}

/** Bytes of what was handed in. */
function bytesOf(file) {
  if (file instanceof ArrayBuffer) return new Uint8Array(file);
  if (ArrayBuffer.isView(file)) return new Uint8Array(file.buffer, file.byteOffset, file.byteLength);
  const cure = "hand in an ArrayBuffer or a typed array: await response.arrayBuffer()";
  throw new InvalidError(`file: is neither an ArrayBuffer nor a view of one; ${cure}`, { field: "file", cure });
}

const BAKED = "SUPPLE\r\n";
const isBaked = (bytes) => String.fromCharCode(...bytes.subarray(0, BAKED.length)) === BAKED;

/** The avatar of a character or baked file. Baking takes seconds: in a page it is a worker that does it. */
export async function load(file, options = {}) {
  const { onProgress, worker, ...said } = options;
  let bytes = bytesOf(file);
  const wanted = worker ?? (typeof Worker === "function" && typeof document === "object");
  await init();
  if (wanted && !isBaked(bytes)) {
    const { baked, notes } = await inWorker(bytes, options);
    return new Avatar(Core.load(baked, JSON.stringify({ name: said.name, worldUp: said.worldUp }), () => {}), notes);
  }
  return new Avatar(Core.load(bytes, JSON.stringify(said), onProgress ?? (() => {})));
}

/** The bytes of a baked file, to be kept and loaded at once another time. */
export async function bake(file, options = {}) {
  const { onProgress, worker, ...said } = options;
  const bytes = bytesOf(file);
  const wanted = worker ?? (typeof Worker === "function" && typeof document === "object");
  if (wanted) return (await inWorker(bytes, options)).baked;
  const avatar = await load(bytes, { ...said, onProgress, worker: false });
  try {
    return avatar.save();
  } finally {
    avatar.free();
  }
}

function inWorker(bytes, { onProgress, worker: _, ...options }) {
  return new Promise((resolve, reject) => {
    const worker = new Worker(new URL("./worker.js", import.meta.url), { type: "module" });
    const end = (settle, value) => {
      worker.terminate();
      settle(value);
    };
    worker.onmessage = ({ data }) => {
      if (data.progress) onProgress?.(...data.progress);
      else if (data.error) end(reject, unpacked(data.error));
      else end(resolve, data);
    };
    worker.onerror = (event) => end(reject, new Error(`the worker that bakes: ${event.message ?? "could not start"}`));
    worker.postMessage({ bytes, options });
  });
}

/** Numbers of an array or of an { x, y, z, w? }. */
function numbers(value, field, count) {
  const found = value?.x === undefined ? value : [value.x, value.y, value.z, value.w].slice(0, count);
  if (found?.length !== count) {
    const cure = `hand in ${count} numbers, or an object with ${count === 3 ? "x, y, z" : "x, y, z, w"}`;
    throw new InvalidError(`${field}: has not ${count} numbers; ${cure}`, { field, cure });
  }
  return Float64Array.from(found);
}
const place = (value) => numbers(value, "position", 3);
const turn = (value) => (value === undefined ? new Float64Array() : numbers(value, "rotation", 4));
const spring = (value) => Float64Array.from(value ? [value.stiffness, value.damping ?? 0] : []);

/** Matrices as one array: an array of numbers is taken as it is, objects by their `elements`. */
function matricesOf(matrices) {
  if (ArrayBuffer.isView(matrices) || typeof matrices[0] === "number") return matrices;
  const all = new Float32Array(16 * matrices.length);
  matrices.forEach((matrix, i) => all.set(matrix.elements ?? matrix, 16 * i));
  return all;
}

/** The unit quaternion that turns z to `normal`. */
function fromZ(normal) {
  let [x, y, z] = numbers(normal, "normal", 3);
  const length = Math.hypot(x, y, z);
  if (!(length > 0)) throw new InvalidError("normal: has no direction; hand in a vector that is not 0", { field: "normal" });
  [x, y, z] = [x / length, y / length, z / length];
  // Half way between the two: q = (z × n, 1 + z·n), and any half turn where n = −z.
  const w = 1 + z;
  if (w < 1e-9) return [1, 0, 0, 0];
  const norm = Math.hypot(x, y, w);
  return [-y / norm, x / norm, 0, w / norm];
}

/** A solid that the skin cannot enter. */
class Collider {
  #core;
  #number;
  constructor(core, number) {
    [this.#core, this.#number] = [core, number];
  }
  moveTo(position, rotation) {
    this.#core().move_collider(this.#number, place(position), turn(rotation), false);
  }
  placeAt(position, rotation) {
    this.#core().move_collider(this.#number, place(position), turn(rotation), true);
  }
  set friction(value) {
    this.#core().set_collider_friction(this.#number, value);
  }
  remove() {
    this.#core().remove_collider(this.#number);
  }
}

class Avatar {
  #core;
  #views = new Map();
  #alive = () => {
    if (this.#core) return this.#core;
    throw new InvalidError("avatar: was freed; load it again", { field: "avatar", cure: "load it again" });
  };

  constructor(core, notes) {
    this.#core = core;
    const info = JSON.parse(core.info());
    Object.assign(this, info, { notes: notes ?? info.notes, triangles: core.triangles() });
    this.skins = info.skins.map((joints) => Uint32Array.from(joints));
    this.parts = JSON.parse(core.parts()).map((part, i) => new Part(part, i, core, (name) => this.#view(name)));
  }

  /** An array of the wasm as it is now: a view that is made anew where the wasm's memory has grown. */
  #view(name) {
    const core = this.#alive();
    let view = this.#views.get(name);
    if (view?.buffer !== wasm.memory.buffer) {
      const [at, length] = core.buffer(name);
      view = new Float32Array(wasm.memory.buffer, at, length);
      this.#views.set(name, view);
    }
    return view;
  }

  get positions() { return this.#view("positions"); }
  get normals() { return this.#view("normals"); }
  get displacements() {
    this.#alive().find_displacements();
    return this.#view("displacements");
  }
  get jointMatrices() {
    this.#alive().find_joints();
    return this.#view("joints");
  }
  get contacts() {
    this.#alive().find_contacts();
    return { forces: this.#view("forces"), pressures: this.#view("pressures") };
  }
  get contactForce() { return [...this.#alive().contact_force()]; }
  get report() { return JSON.parse(this.#alive().report()); }

  step(dt) { this.#alive().step(dt); }
  settle() { return this.#alive().settle(); }

  joint(name) { return this.joints.findIndex((joint) => joint.name === name); }
  #number(joint) {
    const number = typeof joint === "number" ? joint : this.joint(joint);
    if (number >= 0) return number;
    const cure = `there are ${this.joints.map((j) => j.name).join(", ")}`;
    throw new InvalidError(`joint: none is called "${joint}"; ${cure}`, { field: "joint", cure });
  }

  follow(matrices) { this.#alive().follow(matricesOf(matrices)); }
  followSkinning(matrices, skin = 0) { this.#alive().follow_skinning(skin, matricesOf(matrices)); }
  track(matrices, { rotation, position }) {
    this.#alive().track(matricesOf(matrices), spring(rotation), spring(position));
  }
  hold() { this.#alive().hold(); }
  ragdoll({ stiffness = 0, damping } = {}) { this.#alive().ragdoll(stiffness, damping); }
  pull(joint, matrix, { rotation, position }) {
    const target = Float64Array.from(matrix.elements ?? matrix);
    this.#alive().pull(this.#number(joint), target, spring(rotation), spring(position));
  }
  release(joint) { this.#alive().release(this.#number(joint)); }
  teleport(position, rotation) { this.#alive().teleport(place(position), turn(rotation)); }
  reset() { this.#alive().reset(); }
  sleep() { this.#alive().set_awake(false); }
  wake() { this.#alive().set_awake(true); }

  set(settings) { this.#alive().set(JSON.stringify(settings)); }

  #add(kind, sizes, position, { rotation, friction = 0, stiffness = null, margin = 0 } = {}) {
    const surface = JSON.stringify({ friction, stiffness, margin });
    const at = [place(position), turn(rotation)];
    return new Collider(this.#alive, this.#alive().add_collider(kind, Float64Array.from(sizes), ...at, surface));
  }
  addSphere(radius, position, options) { return this.#add("sphere", [radius], position, options); }
  addCapsule(radius, halfLength, position, options) { return this.#add("capsule", [radius, halfLength], position, options); }
  addCylinder(radius, halfLength, position, options) { return this.#add("cylinder", [radius, halfLength], position, options); }
  addBox(halfExtents, position, options) { return this.#add("box", numbers(halfExtents, "halfExtents", 3), position, options); }
  addHalfSpace(point, normal, options) {
    return this.#add("halfSpace", [], point, { ...options, rotation: fromZ(normal) });
  }
  addGround() { return new Collider(this.#alive, this.#alive().add_ground()); }

  save() { return this.#alive().save(); }
  clone() { return new Avatar(this.#alive().again(), this.notes); }
  free() {
    this.#core?.free();
    this.#core = undefined;
    this.#views.clear();
  }
}

/** A primitive of the character's file: its own vertices, which seams split, and what moves them. */
class Part {
  #view;
  #own = new Map();
  constructor({ first, vertices, coordinates, ...info }, i, core, view) {
    this.#view = (name) => {
      const all = view(name);
      let own = this.#own.get(name);
      if (own?.buffer !== all.buffer) this.#own.set(name, (own = all.subarray(3 * first, 3 * (first + vertices))));
      return own;
    };
    Object.assign(this, info);
    this.triangles = core.part_triangles(i);
    this.vertices = core.part_vertices(i);
    this.coordinates = Array.from({ length: coordinates }, (_, set) => core.part_coordinates(i, set));
    this.colours = core.part_colours(i);
  }
  get positions() { return this.#view("partPositions"); }
  get normals() { return this.#view("partNormals"); }
}

export { Avatar, Collider };
