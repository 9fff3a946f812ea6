// Soft skin for three.js: takes the place of the skinned meshes of GLTFLoader or three-vrm and follows their skeleton.

import { BufferAttribute, BufferGeometry, DynamicDrawUsage, Matrix4, Mesh, Quaternion, Vector3 } from "three";
import { InvalidError, load } from "./index.js";

const place = new Vector3();
const turn = new Quaternion();
const size = new Vector3();
const matrix = new Matrix4();
// three's capsules lie along y, its planes face z; a collider's axis is z.
const fromY = new Quaternion().setFromAxisAngle(new Vector3(1, 0, 0), -Math.PI / 2);

export class SoftAvatar {
  #root;
  #nodes;
  #matrices;
  #drawn = [];
  #touched = new Map();

  // Makes the skin of a model soft. `model` is what GLTFLoader gives (with three-vrm or without), a VRM, or any object with the
  // character's bones below it; `file` its bytes, or a baked file of them. Options are those of `load`.
  static async from(model, file, options) {
    const root = model.scene ?? model;
    root.updateWorldMatrix(true, true);
    const soft = new SoftAvatar(await load(file, options), root);
    try {
      await soft.#findNodes(model.parser);
      soft.#replace();
      soft.#follow();
      return soft;
    } catch (error) {
      soft.dispose();
      throw error;
    }
  }

  constructor(avatar, root) {
    [this.avatar, this.#root, this.meshes] = [avatar, root, []];
    // The engine's lengths are the file's; a model that is scaled in the scene is drawn scaled.
    root.matrixWorld.decompose(place, turn, size);
    if (Math.max(size.x, size.y, size.z) > 1.001 * Math.min(size.x, size.y, size.z)) {
      throw wrong("model", "is scaled unevenly", "scale it alike along x, y and z");
    }
    this.scale = size.x;
  }

  /** The node of each joint: by the file's own numbers where its parser is there, else by name. */
  async #findNodes(parser) {
    const { joints, skins } = this.avatar;
    this.#nodes = new Array(joints.length);
    const told = parser?.json.skins ?? [];
    for (const [s, own] of skins.entries()) {
      for (const [k, joint] of own.entries()) {
        const node = told[s]?.joints[k];
        if (node !== undefined) this.#nodes[joint] ??= await parser.getDependency("node", node);
      }
    }
    const named = new Map();
    this.#root.traverse((object) => {
      for (const name of [object.name, object.userData.name]) {
        if (name && !object.isMesh) named.set(name, named.get(name) ?? object);
      }
    });
    joints.forEach((joint, j) => {
      this.#nodes[j] ??= named.get(joint.name);
      if (!this.#nodes[j] && joint.is) {
        throw wrong(`joint "${joint.name}"`, "is not in the model", "hand in the model that this file is loaded as");
      }
    });
    this.#matrices = new Float32Array(16 * joints.length);
    joints.forEach((_, j) => matrix.identity().toArray(this.#matrices, 16 * j));
  }

  /** Puts a mesh of the avatar's own in the place of each that has tissue or hangs on some. */
  #replace() {
    const free = new Set();
    this.#root.traverse((object) => object.isMesh && free.add(object));
    for (const part of this.avatar.parts) {
      const old = best(part, free);
      if (!old) continue;
      free.delete(old);
      if (!part.soft) continue;
      const geometry = new BufferGeometry();
      const attribute = (name, array, width) => geometry.setAttribute(name, new BufferAttribute(array, width));
      geometry.setIndex(new BufferAttribute(part.triangles, 1));
      attribute("position", part.positions, 3).attributes.position.setUsage(DynamicDrawUsage);
      attribute("normal", part.normals, 3).attributes.normal.setUsage(DynamicDrawUsage);
      part.coordinates.forEach((uv, set) => attribute(set ? `uv${set}` : "uv", uv, 2));
      if (part.colours) attribute("color", part.colours, 4);
      old.geometry.groups.forEach((g) => geometry.addGroup(g.start, g.count, g.materialIndex));
      const mesh = new Mesh(geometry, old.material);
      const { name, castShadow, receiveShadow, renderOrder, visible, layers } = old;
      Object.assign(mesh, { name, castShadow, receiveShadow, renderOrder, visible, layers, frustumCulled: false });
      // Its vertices are in the world already.
      mesh.matrixAutoUpdate = mesh.matrixWorldAutoUpdate = false;
      mesh.matrixWorld.makeScale(this.scale, this.scale, this.scale);
      old.parent.add(mesh);
      old.removeFromParent();
      this.#drawn.push({ part, geometry, mesh, old });
      this.meshes.push(mesh);
    }
    if (!this.meshes.length) {
      throw wrong("model", "has no mesh of the avatar's", "hand in the model that this file is loaded as");
    }
  }

  /** Bones are where the skeleton is. */
  #follow() {
    this.#root.updateWorldMatrix(true, true);
    const unscale = 1 / this.scale;
    this.#nodes.forEach((node, j) => {
      if (!node) return;
      matrix.makeScale(unscale, unscale, unscale).multiply(node.matrixWorld).toArray(this.#matrices, 16 * j);
    });
    this.avatar.follow(this.#matrices);
  }

  /** Once a frame, after mixers and `vrm.update`: `dt` is the time (s) from the skeleton's last pose to this one. */
  update(dt) {
    this.#follow();
    for (const { move } of this.#touched.values()) move();
    if (dt > 0) this.avatar.step(dt);
    for (const { part, geometry: { attributes: { position, normal } } } of this.#drawn) {
      // The wasm's memory may have grown.
      [position.array, normal.array] = [part.positions, part.normals];
      position.needsUpdate = normal.needsUpdate = true;
    }
  }

  /** The skin meets `mesh`, of a sphere, capsule, box or plane, wherever it is moved. Options: friction, stiffness, margin. */
  touch(mesh, options) {
    const { type, parameters: p = {} } = mesh.geometry;
    mesh.updateWorldMatrix(true, false);
    const world = mesh.getWorldScale(size).x / this.scale;
    const at = () => {
      mesh.matrixWorld.decompose(place, turn, size);
      if (type === "CapsuleGeometry") turn.multiply(fromY);
      return [place.divideScalar(this.scale), turn];
    };
    const [position, rotation] = at();
    const [said, { avatar }] = [{ ...options, rotation }, this];
    const add = {
      SphereGeometry: () => avatar.addSphere(world * p.radius, position, said),
      CapsuleGeometry: () => avatar.addCapsule(world * p.radius, (world * (p.height ?? p.length)) / 2, position, said),
      BoxGeometry: () => avatar.addBox([p.width, p.height, p.depth].map((l) => (world * l) / 2), position, said),
      PlaneGeometry: () => avatar.addHalfSpace(position, new Vector3(0, 0, 1).applyQuaternion(rotation), options),
    }[type];
    if (!add) throw wrong("mesh", `a ${type} is no collider`, "use a sphere, capsule, box or plane, or avatar.addCylinder");
    const collider = add();
    const move = () => {
      mesh.updateWorldMatrix(true, false);
      const [position, rotation] = at();
      collider.moveTo(position, type === "PlaneGeometry" ? undefined : rotation);
    };
    this.#touched.set(mesh, { collider, move });
    return collider;
  }

  /** The skin meets it no more. */
  release(mesh) {
    this.#touched.get(mesh)?.collider.remove();
    this.#touched.delete(mesh);
  }

  /** After a cut: where the skeleton is now, at rest. */
  reset() {
    this.#follow();
    this.avatar.reset();
  }

  /** Puts the skinned meshes back, and frees the avatar. */
  dispose() {
    for (const { mesh, old, geometry } of this.#drawn) {
      mesh.parent?.add(old);
      mesh.removeFromParent();
      geometry.dispose();
    }
    this.avatar.free();
  }
}

/** An error about what was handed in. */
function wrong(field, problem, cure) {
  return new InvalidError(`${field}: ${problem}; ${cure}`, { field, problem, cure });
}

/** The mesh of `free` that a part is: as many triangles, and by name, material and texture coordinates the likest. */
function best(part, free) {
  const likeness = (mesh) => {
    const { index, attributes } = mesh.geometry;
    const material = [mesh.material].flat()[0];
    const corner = index ? index.getX(0) : 0;
    const [uv, own] = [attributes.uv, part.coordinates[0]];
    const sameUv = uv && own && Math.abs(uv.getX(corner) - own[2 * part.triangles[0]]) < 1e-4;
    return (sameUv ? 4 : 0) + (material?.name === part.material ? 2 : 0) + (mesh.name.startsWith(part.name) ? 1 : 0);
  };
  const count = (mesh) => (mesh.geometry.index ?? mesh.geometry.attributes.position).count;
  const fitting = [...free].filter((mesh) => count(mesh) === part.triangles.length);
  return fitting.sort((a, b) => likeness(b) - likeness(a))[0];
}
