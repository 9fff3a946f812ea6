// The package in Node: a character of the tests' own, baked by the wasm.

import assert from "node:assert/strict";
import { before, test } from "node:test";
import {
  FormatError, InvalidError, SuppleError, bake, load,
} from "../index.js";
import { character } from "./character.js";
import { largest, worldOf } from "./helpers.js";

const file = character();
let baked;
let told;

before(async () => {
  told = [];
  baked = await bake(file, { name: "person.glb", onProgress: (...progress) => told.push(progress) });
});

/** The avatar in its bind pose, followed. */
async function standing() {
  const avatar = await load(baked);
  avatar.follow(worldOf(avatar));
  return avatar;
}

/** Presses a ball into the belly, from in front of it; gives the ball. */
function press(avatar, depth = 0.03) {
  const radius = 0.1;
  const front = beforeBelly(avatar) + radius;
  const ball = avatar.addSphere(radius, [0, 1.1, front], { friction: 0.5 });
  for (let k = 1; k <= 20; k++) {
    ball.moveTo([0, 1.1, front - (depth * k) / 20]);
    avatar.step(1 / 60);
  }
  return ball;
}

/** z of the skin's foremost vertex near (0, 1.1). */
function beforeBelly({ positions }) {
  let z = -1;
  for (let i = 0; i < positions.length; i += 3) {
    if (Math.hypot(positions[i], positions[i + 1] - 1.1) < 0.05) z = Math.max(z, positions[i + 2]);
  }
  return z;
}

test("a bake tells its phases and what it found", async () => {
  assert.deepEqual(told.map(([done, of]) => [done, of]), [0, 1, 2, 3, 4, 5, 6, 7].map((k) => [k, 7]));
  assert.equal(told[0][2], "mesh");
  const avatar = await load(baked);
  assert.equal(avatar.joints.length, 18);
  assert.ok(avatar.joints[avatar.joint("leftFoot")].name === "leftFoot" && avatar.joint("tail") === -1);
  const [body, hat] = avatar.parts;
  assert.deepEqual([body.name, body.material, body.materialIndex, body.soft], ["Body", "skin", 0, true]);
  assert.deepEqual([hat.name, hat.material, hat.materialIndex, hat.soft], ["Hat", "felt", 1, false]);
  assert.equal(body.coordinates[0].length / 2, body.positions.length / 3);
  assert.ok(body.vertices.length > new Set(body.vertices).size, "a seam has vertices twice");
  avatar.free();
});

test("untouched in the bind pose it has the file's shape, and parts are the skin's", async () => {
  const avatar = await standing();
  for (let k = 0; k < 10; k++) avatar.step(1 / 60);
  assert.ok(largest(avatar.displacements) < 1e-4, `${largest(avatar.displacements)} m`);
  const [part] = avatar.parts;
  for (const [own, all] of [[part.positions, avatar.positions], [part.normals, avatar.normals]]) {
    part.vertices.forEach((v, i) => {
      for (let axis = 0; axis < 3; axis++) assert.equal(own[3 * i + axis], all[3 * v + axis]);
    });
  }
  // The first vertex of the file, which the tests' own generator placed.
  const json = JSON.parse(file.subarray(20, 20 + file.readUInt32LE(12)));
  const view = json.bufferViews[json.accessors[json.meshes[0].primitives[0].attributes.POSITION].bufferView];
  const start = 28 + file.readUInt32LE(12) + view.byteOffset;
  for (let axis = 0; axis < 3; axis++) {
    assert.ok(Math.abs(file.readFloatLE(start + 4 * axis) - part.positions[axis]) < 1e-4);
  }
  avatar.free();
});

test("a ball dents it, and the skin's forces are the contact force", async () => {
  const avatar = await standing();
  const still = avatar.positions.slice();
  const ball = press(avatar);
  const moved = avatar.positions.map((x, i) => x - still[i]);
  assert.ok(largest(moved) > 0.01, `${largest(moved)} m`);
  const force = avatar.contactForce;
  assert.ok(force[2] < -0.5, `${force} N: the ball pushes back along −z`);
  const { forces, pressures } = avatar.contacts;
  for (let axis = 0; axis < 3; axis++) {
    const sum = forces.reduce((total, f, i) => (i % 3 === axis ? total + f : total), 0);
    assert.ok(Math.abs(sum - force[axis]) < 1e-3 * Math.hypot(...force), `${sum} and ${force[axis]} N`);
  }
  assert.ok(pressures.some((p) => p > 0) && avatar.report.contacts > 0);
  ball.remove();
  for (let k = 0; k < 120; k++) avatar.step(1 / 60);
  assert.deepEqual(avatar.contactForce, [0, 0, 0]);
  assert.ok(largest(avatar.displacements) < 1e-3, "the dent is gone");
  assert.throws(() => ball.moveTo([0, 0, 0]), InvalidError);
  avatar.free();
});

test("each collider holds the skin off", async () => {
  const shapes = {
    sphere: (a, z) => a.addSphere(0.1, [0, 1.1, z + 0.1]),
    // Along z by itself; lain along x.
    capsule: (a, z) => a.addCapsule(0.05, 0.1, [0, 1.1, z + 0.05], { rotation: [0, Math.SQRT1_2, 0, Math.SQRT1_2] }),
    cylinder: (a, z) => a.addCylinder(0.05, 0.1, [0, 1.1, z + 0.1]),
    box: (a, z) => a.addBox([0.05, 0.05, 0.05], [0, 1.1, z + 0.05]),
    halfSpace: (a, z) => a.addHalfSpace([0, 0, z], [0, 0, -1]),
  };
  for (const [name, add] of Object.entries(shapes)) {
    const avatar = await standing();
    const z = beforeBelly(avatar);
    const collider = add(avatar, z + 0.002);
    avatar.step(1 / 60);
    assert.equal(Math.hypot(...avatar.contactForce), 0, `${name} touches before it is moved`);
    collider.placeAt([0, name === "halfSpace" ? 0 : 1.1, { sphere: z + 0.09, capsule: z + 0.04, cylinder: z + 0.09, box: z + 0.04, halfSpace: z - 0.01 }[name]]);
    for (let k = 0; k < 10; k++) avatar.step(1 / 60);
    assert.ok(avatar.contactForce[2] < -0.1, `${name}: ${avatar.contactForce} N`);
    avatar.free();
  }
});

test("a softer one gives way further, and settings are all or nothing", async () => {
  const depth = {};
  for (const softness of [1, 4]) {
    const avatar = await standing();
    avatar.set({ softness, bounce: 0.3, gravity: 9.81, solver: "budgeted", longestStep: 0.02 });
    press(avatar, 0.02);
    depth[softness] = Math.hypot(...avatar.contactForce);
    avatar.free();
  }
  assert.ok(depth[4] < 0.7 * depth[1], `${depth[4]} and ${depth[1]} N`);
  const avatar = await standing();
  for (const [bad, field] of [
    [{ softness: 0 }, "softness"], [{ bounce: 2 }, "bounce"], [{ sofness: 1 }, "sofness"], [{ gravity: "down" }, "gravity"],
    [{ solver: "newton" }, "settings"], [{ longestStep: -1 }, "settings.longest_step"],
  ]) {
    assert.throws(() => avatar.set(bad), (error) => error instanceof InvalidError && error.field.includes(field), field);
  }
  avatar.free();
});

test("it follows world and skinning matrices alike, and springs draw it", async () => {
  const [a, b, c] = [await load(baked), await load(baked), await load(baked)];
  const shifted = worldOf(a, [0.3, 0.1, -0.2]);
  a.follow(shifted);
  // Skinning matrices of a pure shift.
  const skinning = Array.from({ length: 17 }, () => ({ elements: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0.3, 0.1, -0.2, 1] }));
  b.followSkinning(skinning);
  c.track(shifted, { rotation: { stiffness: 1e3, damping: 10 }, position: { stiffness: 1e5, damping: 100 } });
  for (const avatar of [a, b, c]) avatar.step(1 / 60);
  assert.ok(largest(a.positions.map((x, i) => x - b.positions[i])) < 1e-6);
  assert.ok(largest(a.positions.map((x, i) => x - c.positions[i])) < 1e-3);
  const back = a.jointMatrices;
  shifted.forEach((x, i) => assert.ok(Math.abs(x - back[i]) < 1e-6));
  [a, b, c].forEach((avatar) => avatar.free());
});

test("a pulled hand goes where it is pulled, let go it falls", async () => {
  const avatar = await load(baked);
  const joint = avatar.joint("leftHand");
  avatar.ragdoll({ stiffness: 20, damping: 2 });
  const matrix = [...worldOf(avatar).subarray(16 * joint, 16 * joint + 16)];
  matrix[13] += 0.1;
  const position = { stiffness: 1e5, damping: 1e3 };
  for (let k = 0; k < 60; k++) {
    avatar.pull("leftHand", matrix, { position });
    avatar.step(1 / 60);
  }
  const height = avatar.jointMatrices[16 * joint + 13];
  assert.ok(Math.abs(height - matrix[13]) < 0.05, `${height} m`);
  avatar.release("leftHand");
  for (let k = 0; k < 60; k++) avatar.step(1 / 60);
  assert.ok(avatar.jointMatrices[16 * joint + 13] < height - 1, "it fell");
  assert.throws(() => avatar.pull("tail", matrix, { position }), /none is called "tail"; there are hips/);
  avatar.follow(worldOf(avatar));
  assert.throws(() => avatar.pull(joint, matrix, { position }), InvalidError);
  avatar.free();
});

test("teleport and reset are not felt", async () => {
  const avatar = await load(baked);
  avatar.step(1 / 60);
  const before = avatar.positions.slice();
  avatar.teleport([5, 0, 0]);
  assert.ok(largest(avatar.positions.map((x, i) => x - before[i] - (i % 3 === 0 ? 5 : 0))) < 1e-5);
  avatar.step(1 / 60);
  assert.ok(largest(avatar.displacements) < 1e-4);
  avatar.follow(worldOf(avatar, [0, 0, 0]));
  avatar.step(1 / 60);
  assert.ok(largest(avatar.displacements) > 1e-3, "a jump without a word is felt");
  avatar.reset();
  assert.equal(largest(avatar.displacements), 0);
  avatar.free();
});

test("a clone is the same and by itself, and a saved one is", async () => {
  const avatar = await standing();
  const clone = avatar.clone();
  const again = await load(avatar.save());
  for (const one of [clone, again]) {
    one.follow(worldOf(one));
    press(one);
  }
  press(avatar);
  assert.deepEqual(clone.positions, avatar.positions);
  assert.deepEqual(again.positions, avatar.positions);
  clone.step(1 / 60);
  [clone, again, avatar].forEach((one) => one.free());
});

test("errors are of their class, with place and cure", async () => {
  const is = (kind, wanted) => (error) => {
    assert.ok(error instanceof kind && error instanceof SuppleError && error instanceof Error, `${error}`);
    assert.equal(error.name, kind.name);
    for (const [key, value] of Object.entries(wanted)) {
      assert.match(String(error[key]), value, `${key} of ${error}`);
    }
    return true;
  };
  await assert.rejects(load(new Uint8Array([1, 2, 3]), { name: "me.fbx" }), is(FormatError, { path: /^me\.fbx$/, field: /format/, cure: /\.glb/ }));
  await assert.rejects(load(new ArrayBuffer(0), { name: "me.glb" }), is(FormatError, { problem: /is empty/ }));
  await assert.rejects(load(file.subarray(0, 5000), { name: "me.glb" }), is(FormatError, { path: /^me\.glb$/ }));
  await assert.rejects(load("me.glb"), is(InvalidError, { field: /^file$/, cure: /arrayBuffer/ }));
  await assert.rejects(load(baked, { betas: [1] }), is(InvalidError, { field: /options/, cure: /leave/ }));
  await assert.rejects(load(file, { recipe: { bouncy: 1 } }), is(InvalidError, { message: /bouncy/ }));
  await assert.rejects(load(file, { betas: [1] }), is(FormatError, { message: /1 numbers are given; the model has 0/ }));
  const outside = JSON.stringify({ asset: { version: "2.0" }, buffers: [{ byteLength: 4, uri: "me.bin" }] });
  await assert.rejects(load(Buffer.from(outside), { name: "me.gltf" }), SuppleError);
  const harmed = baked.slice();
  harmed[harmed.length >> 1] ^= 1;
  await assert.rejects(load(harmed), is(FormatError, {}));
  const avatar = await standing();
  const before = avatar.positions.slice();
  assert.throws(() => avatar.follow(new Float32Array(16)), is(InvalidError, { message: /1 matrices for 18 joints/ }));
  assert.throws(() => avatar.follow(new Float32Array(17)), is(InvalidError, { field: /matrices/, cure: /16 a joint/ }));
  const scaled = worldOf(avatar);
  scaled[0] = 2;
  assert.throws(() => avatar.follow(scaled), is(InvalidError, { message: /hips/ }));
  for (const bad of [0, -1, NaN, Infinity]) assert.throws(() => avatar.step(bad), is(InvalidError, { field: /time_step/ }));
  assert.throws(() => avatar.addSphere(-1, [0, 0, 0]), is(InvalidError, { field: /collider\.shape\.radius/ }));
  assert.throws(() => avatar.addSphere(1, [0, 0]), is(InvalidError, { field: /position/, cure: /3 numbers/ }));
  assert.throws(() => avatar.addSphere(1, [0, 0, NaN]), is(InvalidError, { field: /position/ }));
  assert.throws(() => avatar.addBox([1, 1, 1], [0, 0, 0], { rotation: [0, 0, 0, 2] }), is(InvalidError, { field: /rotation/ }));
  assert.deepEqual(avatar.positions, before, "after an error it is as it was");
  avatar.step(1 / 60);
  avatar.free();
});

test("views are of the memory as it is, also where it has grown", async () => {
  const avatar = await standing();
  press(avatar);
  const [positions, part] = [avatar.positions, avatar.parts[0].positions];
  assert.equal(avatar.positions, positions, "the same view where nothing has changed");
  const kept = positions.slice();
  const crowd = [];
  while (positions.length > 0 && crowd.length < 500) crowd.push(avatar.clone());
  assert.equal(positions.length, 0, "the memory has grown, which detaches its views");
  assert.equal(part.length, 0);
  assert.deepEqual(avatar.positions, kept);
  assert.equal(avatar.parts[0].positions.length, 3 * avatar.parts[0].vertices.length);
  avatar.step(1 / 60);
  assert.ok(avatar.positions.every(Number.isFinite));
  [...crowd, avatar].forEach((one) => one.free());
});

test("what is freed is gone, and its memory is used again", async () => {
  const avatar = await standing();
  const ball = press(avatar);
  avatar.free();
  avatar.free();
  const gone = (error) => error instanceof InvalidError && error.cure === "load it again";
  for (const use of [() => avatar.step(0.01), () => avatar.positions, () => avatar.parts[0].normals, () => ball.remove(), () => avatar.clone()]) {
    assert.throws(use, gone);
  }
  const size = async () => {
    const one = await load(baked);
    one.step(1 / 60);
    const bytes = one.positions.buffer.byteLength;
    one.free();
    return bytes;
  };
  const first = await size();
  for (let k = 0; k < 20; k++) await size();
  assert.equal(await size(), first);
});
