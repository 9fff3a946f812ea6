// The scene hand_press through the package, in Node and in a page, as the native engine played it (npm/reference).

/** Plays it with `load` of the package; `seen` is called with the avatar and the number of each step, and gets its time, ms. */
export async function play(load, scene, settings, seen) {
  const avatar = await load(scene.hand, { worldUp: "z" });
  avatar.set({ integrator: "backwardEuler", solver: "oneIteration", ...settings });
  avatar.ragdoll({ stiffness: scene.bending, damping: scene.bendingDamping });
  const springs = { rotation: scene.rotation, position: scene.position };
  const pull = (step) => avatar.pull(scene.targets[step].joint, scene.targets[step].matrix, springs);
  for (const { shape, position, ...collider } of scene.colliders) {
    const { radius, half_length } = shape.Cylinder ?? shape;
    avatar.addCylinder(radius, half_length, position, collider);
  }
  pull(0);
  avatar.settle();
  for (let step = 1; step <= scene.steps; step++) {
    pull(step);
    const start = performance.now();
    avatar.step(scene.dt);
    seen(avatar, step, performance.now() - start);
  }
  avatar.free();
}
