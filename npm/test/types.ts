// Is compiled and never run: the types say what the package takes and gives.

import { Matrix4, Mesh, Vector3, type Object3D } from "three";
import { bake, FormatError, load, SuppleError, type Avatar } from "../index.js";
import { SoftAvatar } from "../three.js";

export async function host(file: ArrayBuffer, scene: Object3D, ball: Mesh): Promise<number> {
  const baked: Uint8Array = await bake(file, { onProgress: (done, of, next) => console.log(done / of, next) });
  const avatar: Avatar = await load(baked, { worldUp: "z", recipe: { bounce: 0.7 } });
  avatar.follow([new Matrix4()]);
  avatar.follow(new Float32Array(16));
  avatar.set({ softness: 2, gravity: [0, 0, -9.81], solver: "oneIteration" });
  const sphere = avatar.addSphere(0.1, new Vector3(), { friction: 0.5 });
  sphere.moveTo([0, 0, 1], [0, 0, 0, 1]);
  sphere.friction = 0.3;
  avatar.step(1 / 60);
  const positions: Float32Array = avatar.parts[0].positions;
  const soft: SoftAvatar = await SoftAvatar.from({ scene }, file);
  soft.touch(ball, { friction: 0.5 }).remove();
  soft.update(1 / 60);
  // @ts-expect-error a name is no file
  await load("me.glb");
  // @ts-expect-error there is no such axis
  await load(file, { up: "w" });
  // @ts-expect-error two numbers are no place
  sphere.moveTo([0, 0]);
  // @ts-expect-error views are not to be replaced
  avatar.positions = positions;
  try {
    avatar.pull("hips", new Matrix4(), { position: { stiffness: 1e5 } });
  } catch (error) {
    if (error instanceof FormatError) console.log(error.path, error.field);
    if (error instanceof SuppleError) console.log(error.cure);
  }
  return avatar.contactForce[2] + avatar.report.contacts;
}
