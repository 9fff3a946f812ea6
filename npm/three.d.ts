import type { Mesh, Object3D } from "three";
import type { Avatar, Collider, ColliderOptions, LoadOptions } from "./index.js";

/** What GLTFLoader gives, a VRM, or an object with the character's bones below it. */
export type Model = Object3D | { scene: Object3D; parser?: unknown };

/** Soft skin in the place of a model's skinned meshes, which follows its skeleton. */
export class SoftAvatar {
  private constructor();
  /** Makes a model's skin soft; `file` is what it was loaded from, or a baked file of that. */
  static from(model: Model, file: ArrayBuffer | ArrayBufferView, options?: LoadOptions): Promise<SoftAvatar>;
  readonly avatar: Avatar;
  /** The meshes that are drawn in place of the skinned ones, with their materials. */
  readonly meshes: readonly Mesh[];
  /** How large the model is in the scene: m of the scene a m of the file. */
  readonly scale: number;
  /** Once a frame, after mixers and `vrm.update`. */
  update(dt: number): void;
  /** The skin meets a mesh of a sphere, capsule, box or plane, wherever it is moved. */
  touch(mesh: Mesh, options?: Omit<ColliderOptions, "rotation">): Collider;
  release(mesh: Mesh): void;
  /** After a cut: where the skeleton is now, at rest. */
  reset(): void;
  /** Puts the skinned meshes back, and frees the avatar. */
  dispose(): void;
}
