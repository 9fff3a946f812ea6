// The examples in a real browser: what is loaded is drawn, moves, and gives way where a ball presses it; seen in the geometry and in
// the pixels. Pictures are left in out/pictures.

import assert from "node:assert/strict";
import { existsSync, mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { after, before, test } from "node:test";
import { fileURLToPath } from "node:url";
import { serve } from "../examples/serve.js";
import { launch } from "./browser.js";
import { character } from "./character.js";

const out = fileURLToPath(new URL("../out/", import.meta.url));
const shared = fileURLToPath(new URL("../../../shared/assets/", import.meta.url));
// Real characters, and where they are pressed.
const real = { "khronos-CesiumMan.glb": { x: 0, y: 0.62 }, "makehuman-female-cmu-02_01.glb": { x: 0.04, y: 0.73 } };
let browser;
let site;

before(async () => {
  mkdirSync(`${out}pictures`, { recursive: true });
  mkdirSync(`${out}characters`, { recursive: true });
  writeFileSync(`${out}characters/character.glb`, character());
  writeFileSync(`${out}characters/character.vrm`, character({ vrm: true }));
  // Real characters, where they are at hand.
  for (const name of Object.keys(real)) {
    if (existsSync(shared + name)) writeFileSync(`${out}characters/${name}`, readFileSync(shared + name));
  }
  site = await serve(`${out}characters`);
  browser = await launch();
});
after(async () => {
  await browser?.close();
  site?.server.close();
});

/** Opens an example; its loop runs until it is held, and what the page says wrong is an error here. */
async function open(address) {
  const page = await browser.newPage({ viewport: { width: 480, height: 640 } });
  const faults = [];
  page.on("pageerror", (error) => faults.push(String(error)));
  page.on("console", (message) => message.type() === "error" && faults.push(message.text()));
  // Nothing is fetched from elsewhere.
  page.on("request", (request) => {
    const { url } = { url: request.url() };
    if (!/^(blob:|data:)/.test(url) && !url.startsWith(site.address)) faults.push(`asks for ${url}`);
  });
  const start = Date.now();
  await page.goto(`${site.address}/examples/${address}`);
  await page.waitForFunction(() => window.soft, undefined, { timeout: 120_000 }).catch((error) => {
    throw new Error(`${address}: ${faults.join("; ") || error}`);
  });
  const seconds = (Date.now() - start) / 1000;
  // From here on the test makes the frames, one sixtieth each.
  await page.evaluate(() => {
    window.renderer.setAnimationLoop(null);
    window.frames_ = (count, each = () => {}) => {
      for (let k = 1; k <= count; k++) {
        each(k / count);
        window.mixer?.update(window.playing ? 1 / 60 : 0);
        window.vrm?.update(1 / 60);
        window.soft.update(1 / 60);
      }
      window.renderer.render(window.scene, window.camera);
    };
    window.skin = () => window.soft.meshes.flatMap((mesh) => [...mesh.geometry.attributes.position.array]);
    window.mixer?.setTime(0);
    window.soft.reset();
  });
  return { page, faults, seconds };
}

/** What is drawn, as a file and as pixels. */
async function picture(page, name) {
  writeFileSync(`${out}pictures/${name}.png`, await page.locator("canvas").screenshot());
  return page.evaluate(() => {
    const { domElement } = window.renderer;
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [domElement.width, domElement.height];
    const context = canvas.getContext("2d");
    context.drawImage(domElement, 0, 0);
    return [...context.getImageData(0, 0, canvas.width, canvas.height).data];
  });
}

/** How many pixels differ clearly. */
function differing(a, b) {
  let count = 0;
  for (let i = 0; i < a.length; i += 4) {
    if (Math.abs(a[i] - b[i]) + Math.abs(a[i + 1] - b[i + 1]) + Math.abs(a[i + 2] - b[i + 2]) > 24) count++;
  }
  return count;
}

/** Presses the example's ball into the front of the character, and looks. */
async function press(address, name, spot = { x: 0, y: 0.62 }) {
  const { page, faults, seconds } = await open(address);
  const still = await page.evaluate((place) => {
    const { touching, soft, camera } = window;
    touching.visible = false;
    // From the side, where a dent shows.
    camera.position.set(2.6, 1.4, 2.2);
    camera.lookAt(0, 0.95, 0);
    // In front of the skin's foremost point near a place that is given in heights of the character.
    window.frames_(5);
    const p = window.skin();
    let [low, high] = [Infinity, -Infinity];
    for (let i = 1; i < p.length; i += 3) [low, high] = [Math.min(low, p[i]), Math.max(high, p[i])];
    const size = high - low;
    const [x, y] = [place.x * size, low + place.y * size];
    let z = -Infinity;
    for (let i = 0; i < p.length; i += 3) {
      if (Math.abs(p[i] - x) < 0.03 * size && Math.abs(p[i + 1] - y) < 0.03 * size) z = Math.max(z, p[i + 2]);
    }
    window.start = z + 0.12;
    touching.position.set(x, y, window.start);
    window.frames_(5);
    return { skin: window.skin(), size, meshes: soft.meshes.length, skinned: window.scene.getObjectsByProperty("isSkinnedMesh", true).length };
  }, spot);
  const before = await picture(page, `${name}-still`);
  const pressed = await page.evaluate(() => {
    const { touching, soft } = window;
    window.frames_(30, (part) => touching.position.setZ(window.start - part * 0.045));
    const d = soft.avatar.displacements;
    let most = 0;
    for (let i = 0; i < d.length; i += 3) most = Math.max(most, Math.hypot(d[i], d[i + 1], d[i + 2]));
    const inside = [];
    const p = window.skin();
    for (let i = 0; i < p.length; i += 3) {
      inside.push(Math.hypot(p[i] - touching.position.x, p[i + 1] - touching.position.y, p[i + 2] - touching.position.z));
    }
    return { skin: p, most, nearest: Math.min(...inside), force: soft.avatar.contactForce };
  });
  const dented = await picture(page, `${name}-pressed`);
  await page.evaluate(() => {
    window.touching.visible = true;
    window.renderer.render(window.scene, window.camera);
  });
  await picture(page, `${name}-ball`);
  let moved = 0;
  for (let i = 0; i < still.skin.length; i += 3) {
    moved = Math.max(moved, Math.hypot(...[0, 1, 2].map((k) => pressed.skin[i + k] - still.skin[i + k])));
  }
  const pixels = differing(before, dented);
  console.log(`${name}: ready in ${seconds.toFixed(1)} s; pressed ${(1e3 * moved).toFixed(1)} mm, tissue ${(1e3 * pressed.most).toFixed(1)} mm, ${pixels} pixels differ, ${Math.hypot(...pressed.force).toFixed(1)} N`);
  assert.deepEqual(faults, []);
  assert.ok(still.meshes > 0);
  assert.equal(still.skinned, 0, "no skinned mesh is left");
  assert.ok(moved > 0.008 && moved < 0.05, `${moved} m of ${still.size} m`);
  assert.ok(pressed.most > 0.008, `${pressed.most} m`);
  assert.ok(pressed.nearest > 0.09, `the skin is ${pressed.nearest} m from the middle of a ball of 0.1 m`);
  assert.ok(pressed.force[2] < -0.1, `${pressed.force} N`);
  assert.ok(pixels > 100, `${pixels} pixels differ`);
  return page;
}

test("three.html: a GLB is soft, and its clip moves it", async () => {
  const page = await press("three.html", "three");
  const swung = await page.evaluate(() => {
    window.touching.position.set(0, 1, 9);
    window.soft.avatar.set({ softness: 2 });
    window.playing = true;
    let most = 0;
    window.frames_(60, () => {
      const d = window.soft.avatar.displacements;
      for (let i = 0; i < d.length; i += 3) most = Math.max(most, Math.hypot(d[i], d[i + 1], d[i + 2]));
    });
    return most;
  });
  assert.ok(swung > 0.002, `${swung} m: it swings`);
  const back = await page.evaluate(() => {
    window.soft.dispose();
    return window.scene.getObjectsByProperty("isSkinnedMesh", true).length;
  });
  assert.equal(back, 1, "the skinned mesh is back");
  await page.close();
});

test("three-vrm.html: a VRM is soft, with its outlines", async () => {
  const page = await press("three-vrm.html", "three-vrm");
  const materials = await page.evaluate(() => window.soft.meshes.map((mesh) => [mesh.material].flat().map((m) => m.type)));
  assert.deepEqual(materials, [["ShaderMaterial", "ShaderMaterial"]]);
  const lifted = await page.evaluate(() => {
    const highest = () => Math.max(...window.skin().filter((_, i) => i % 3 === 1));
    const before = highest();
    window.vrm.humanoid.getNormalizedBoneNode("leftUpperArm").rotation.z = 1.4;
    window.frames_(10);
    window.frames_(30);
    return { before, after: highest() };
  });
  await picture(page, "three-vrm-arm");
  assert.ok(lifted.after > lifted.before, "the arm is above the head");
  await page.close();
});

test("a model that is scaled in the scene stays where it is drawn", async () => {
  const { page } = await open("three.html");
  const found = await page.evaluate(async () => {
    const { SoftAvatar } = await import("supple-avatar/three");
    const { GLTFLoader } = await import("three/addons/loaders/GLTFLoader.js");
    const file = await (await fetch("character.glb")).arrayBuffer();
    const gltf = await new GLTFLoader().parseAsync(file, "");
    gltf.scene.scale.setScalar(2);
    gltf.scene.position.set(3, 0, 0);
    window.scene.add(gltf.scene);
    const big = await SoftAvatar.from(gltf, file, { worker: false });
    big.update(1 / 60);
    // Their memory is one, which has grown.
    window.soft.update(1 / 60);
    const mesh = big.meshes[0];
    const at = (p, i) => [p[3 * i], p[3 * i + 1], p[3 * i + 2]];
    const small = window.soft.meshes[0].geometry.attributes.position.array;
    const own = mesh.geometry.attributes.position.array;
    let off = 0;
    for (let i = 0; i < own.length / 3; i += 97) {
      const [a, b] = [at(small, i), at(own, i)];
      off = Math.max(off, Math.hypot(2 * a[0] + 3 - 2 * b[0], 2 * a[1] - 2 * b[1], 2 * a[2] - 2 * b[2]));
    }
    return { off, scale: big.scale, drawn: mesh.matrixWorld.elements[0] };
  });
  assert.deepEqual([found.scale, found.drawn], [2, 2]);
  assert.ok(found.off < 1e-3, `${found.off} m`);
  await page.close();
});

for (const [name, spot] of Object.entries(real)) {
  test(`a real character: ${name}`, { skip: !existsSync(shared + name) }, async () => {
    const page = await press(`three.html?file=${name}`, name.replace(".glb", ""), spot);
    await page.close();
  });
}

test("errors are of their classes in the page, from a worker too", async () => {
  const { page } = await open("three.html");
  const error = await page.evaluate(async () => {
    const { FormatError, bake } = await import("supple-avatar");
    return bake(new Uint8Array(9), { name: "me.fbx" }).then(() => null, ({ constructor, path, cure }) => [constructor === FormatError, path, cure]);
  });
  assert.deepEqual(error.slice(0, 2), [true, "me.fbx"]);
  assert.match(error[2], /\.glb/);
  const others = await page.evaluate(async () => {
    const { InvalidError } = await import("supple-avatar");
    const { SoftAvatar } = await import("supple-avatar/three");
    const { Mesh, Object3D, TorusGeometry } = await import("three");
    const told = (found) => [found instanceof InvalidError, String(found)];
    const baked = window.soft.avatar.save();
    const stranger = await SoftAvatar.from(new Object3D(), baked).catch((found) => found);
    let torus;
    try { window.soft.touch(new Mesh(new TorusGeometry())); } catch (found) { torus = found; }
    window.soft.release(window.touching);
    window.touching.position.copy({ x: 0, y: 1.1, z: 0 });
    window.frames_(5);
    return { stranger: told(stranger), torus: told(torus), force: window.soft.avatar.contactForce };
  });
  assert.ok(others.stranger[0] && others.torus[0], `${others.stranger} ${others.torus}`);
  assert.match(others.stranger[1], /joint "hips": is not in the model; hand in/);
  assert.match(others.torus[1], /TorusGeometry is no collider; use a sphere/);
  assert.deepEqual(others.force, [0, 0, 0], "what is released touches no more");
  await page.close();
});
