// All lengths are m, times s, forces N, angles rad; y points up unless `worldUp` says otherwise. Matrices are column-major.

/** Three numbers, or an object with x, y, z (a three.js Vector3). */
export type Vector = readonly [number, number, number] | Float32Array | Float64Array | { x: number; y: number; z: number };
/** A unit quaternion: four numbers, or an object with x, y, z, w. */
export type Rotation =
  | readonly [number, number, number, number] | Float32Array | Float64Array
  | { x: number; y: number; z: number; w: number };
/** 16 numbers a matrix one after the other, or objects with `elements` (three.js Matrix4). */
export type Matrices = Float32Array | readonly number[] | readonly { elements: ArrayLike<number> }[];
/** N/m and N·s/m of a place, N·m/rad and N·m·s of a rotation. */
export interface Spring { stiffness: number; damping?: number }
export type Axis = "x" | "y" | "z";

export interface LoadOptions {
  /** Names the file in errors; its ending tells what its content does not. */
  name?: string;
  /** The `[bake]` keys of a recipe: { bounce: 0.7, handles: [{ count: 60 }] }. */
  recipe?: Record<string, unknown>;
  /** Amounts of the model's shapes. */
  betas?: readonly number[];
  /** Names of parts that are tissue, or rigid, against what is chosen. */
  tissue?: readonly string[];
  rigid?: readonly string[];
  /** m a unit of the file. */
  scale?: number;
  /** The axis that points up in the file, against what its format has. */
  up?: Axis;
  /** The axis that points up in the world: y. */
  worldUp?: Axis;
  /** Called with phases done, of all, and the name of the next. */
  onProgress?: (done: number, of: number, next: string) => void;
  /** Whether a worker bakes: in a page it does, unless the file is baked. */
  worker?: boolean;
}

/** What may be set while it runs; also the constants of a step, as `[settings]` of scenes has them, in camel case. */
export interface Settings {
  /** 2 is twice as soft as baked. */
  softness?: number;
  /** 0 creeps back, 0.5 as people, 1 rings. */
  bounce?: number;
  /** Of muscles: 0 relaxed, 1 tense. */
  tension?: number;
  /** A factor on all μ. */
  friction?: number;
  /** A factor on gravity as tissue feels it. */
  tissueGravity?: number;
  /** m/s²: a number against up, or a vector. */
  gravity?: number | readonly [number, number, number];
  integrator?: "bdf2" | "backwardEuler";
  solver?: "budgeted" | "oneIteration" | "converged" | { mode: string; tolerance?: number; max_iterations?: number };
  longestStep?: number;
  largestAcceleration?: number;
  reportAtEnd?: boolean;
  [constant: string]: unknown;
}

export interface ColliderOptions {
  rotation?: Rotation;
  /** μ. */
  friction?: number;
  /** Pa/m; the tissue's own where it is not said. */
  stiffness?: number;
  /** The distance at which contact begins. */
  margin?: number;
}

/** A solid that the skin cannot enter. */
export class Collider {
  private constructor();
  /** Where it is at the end of the next step: friction feels the way. Without a rotation it keeps its own. */
  moveTo(position: Vector, rotation?: Rotation): void;
  /** Puts it there. */
  placeAt(position: Vector, rotation?: Rotation): void;
  set friction(value: number);
  remove(): void;
}

export interface Joint {
  name: string;
  /** The bone that it is, or rides on. */
  bone: number;
  /** Whether it is that bone. */
  is: boolean;
}

/** A primitive of the character's file, with the vertices that seams split. */
export interface Part {
  readonly name: string;
  readonly material: string;
  /** Which of the file's materials that is; null where it has none. */
  readonly materialIndex: number | null;
  /** Whether any of it is tissue or hangs on tissue. */
  readonly soft: boolean;
  readonly triangles: Uint32Array;
  /** The skin vertex that each of its own is. */
  readonly vertices: Uint32Array;
  /** Sets of texture coordinates, two numbers a vertex. */
  readonly coordinates: readonly Float32Array[];
  /** Red, green, blue, opacity. */
  readonly colours?: Float32Array;
  /** Views of what the last step left, as those of `Avatar`. */
  readonly positions: Float32Array;
  readonly normals: Float32Array;
}

export interface Report {
  stop: string;
  iterations: number;
  contacts: number;
  contactForce: [number, number, number];
  weight: [number, number, number];
  /** What drives each bone puts on it: N, and N·m about its joint. */
  loads: { bone: string; force: [number, number, number]; torque: [number, number, number] }[];
}

/**
 * An avatar in a world of its own. Arrays that it gives are views of the wasm's memory: they hold what the last step left, cost
 * nothing, and are to be asked for again after each call, since the memory may have grown.
 */
export class Avatar {
  private constructor();
  readonly name: string;
  readonly up: Axis;
  readonly joints: readonly Joint[];
  /** Joints of each of the file's skins, in its order. */
  readonly skins: readonly Uint32Array[];
  readonly bones: readonly string[];
  readonly parts: readonly Part[];
  /** Of the welded skin. */
  readonly triangles: Uint32Array;
  readonly vertices: number;
  readonly handles: number;
  readonly cubaturePoints: number;
  /** kg. */
  readonly tissueMass: number;
  /** What was decided about the file, a sentence each. */
  readonly notes: readonly string[];

  /** Three numbers a vertex of the welded skin. */
  readonly positions: Float32Array;
  readonly normals: Float32Array;
  /** How far tissue is off the skinned shape, in the axes of the bind pose. */
  readonly displacements: Float32Array;
  /** World matrices of the joints as they are simulated, 16 numbers each. */
  readonly jointMatrices: Float32Array;
  /** N and Pa for each vertex. */
  readonly contacts: { forces: Float32Array; pressures: Float32Array };
  /** The sum of the contact forces. */
  readonly contactForce: [number, number, number];
  readonly report: Report;

  /** Moves everything on by `dt`: the time from where bones and colliders were to where they are now. */
  step(dt: number): void;
  /** Brings it into equilibrium; how far that moved it. */
  settle(): number;

  /** Number of the joint of that name, −1 of none. */
  joint(name: string): number;
  /** All bones follow world matrices of `joints`, in their order. The first say where it starts. */
  follow(matrices: Matrices): void;
  /** All bones follow skinning matrices (world · inverse bind) of one of the file's skins. */
  followSkinning(matrices: Matrices, skin?: number): void;
  /** Springs draw all bones there, which give way to what they meet. */
  track(matrices: Matrices, springs: { rotation: Spring; position: Spring }): void;
  /** The root is held and springs keep the bind pose: so it stands at first. */
  hold(): void;
  /** It falls; joints bend against N·m/rad and N·m·s. */
  ragdoll(options?: { stiffness?: number; damping?: number }): void;
  /** Springs draw one joint's bone to a world matrix, besides `hold` and `ragdoll`. */
  pull(
    joint: string | number,
    matrix: ArrayLike<number> | { elements: ArrayLike<number> },
    springs: { rotation?: Spring; position?: Spring },
  ): void;
  release(joint: string | number): void;
  /** Puts the file's own space there, with all that drives it; nothing of that is felt. */
  teleport(position: Vector, rotation?: Rotation): void;
  /** To where it is driven to, at rest. */
  reset(): void;
  sleep(): void;
  wake(): void;

  /** All that is named, or nothing where one of it is unusable. */
  set(settings: Settings): void;

  addSphere(radius: number, position: Vector, options?: ColliderOptions): Collider;
  /** Along its own z, without the caps as long as twice `halfLength`. */
  addCapsule(radius: number, halfLength: number, position: Vector, options?: ColliderOptions): Collider;
  addCylinder(radius: number, halfLength: number, position: Vector, options?: ColliderOptions): Collider;
  addBox(halfExtents: Vector, position: Vector, options?: ColliderOptions): Collider;
  /** What is behind a plane through `point`, seen along its `normal`. */
  addHalfSpace(point: Vector, normal: Vector, options?: Omit<ColliderOptions, "rotation">): Collider;
  addGround(): Collider;

  /** The baked file, with what a step reads. */
  save(): Uint8Array;
  /** Another of the same, at rest in a world of its own; they share what is constant. */
  clone(): Avatar;
  /** Gives its memory back; whatever is asked of it afterwards is an InvalidError. */
  free(): void;
}

/** Reads a character (.glb, .vrm, SMPL's .npz and .pkl, .obj) and bakes it, or a baked file. */
export function load(file: ArrayBuffer | ArrayBufferView, options?: LoadOptions): Promise<Avatar>;
/** The bytes of a baked file. */
export function bake(file: ArrayBuffer | ArrayBufferView, options?: LoadOptions): Promise<Uint8Array>;
/** Loads the wasm, which `load` does by itself: from beside the module, or from what is handed in. */
export function init(source?: URL | string | Response | BufferSource | WebAssembly.Module): Promise<void>;

/** Every error of the package. */
export class SuppleError extends Error {
  /** The file. */
  readonly path?: string;
  /** The key, section or argument at fault. */
  readonly field?: string;
  readonly problem?: string;
  readonly cure?: string;
}
/** A file that the one handed in asks for. */
export class FileError extends SuppleError {}
/** A file that is not what its format demands. */
export class FormatError extends SuppleError {}
/** An argument that cannot be used. */
export class InvalidError extends SuppleError {}
/** A linear system that could not be solved. */
export class SolveError extends SuppleError {}
/** A result that is not finite; the avatar keeps the state before it. */
export class NotFiniteError extends SuppleError {}
