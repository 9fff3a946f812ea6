// The wasm does what the native engine does: the scene hand_press, a hand of free bones that is pressed 12 mm onto a cylinder.

import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "../index.js";
import { play } from "./hand_press.js";
import { largest } from "./helpers.js";
import { reference } from "./reference.js";

// Coordinates are below 0.25 m, where neighbours in f32 are 1.5e-8 m apart: a rounding on each side, in three axes.
const ROUNDING = 3e-8;

test("hand_press has the native run's skin", async () => {
  const scene = reference();
  const count = 3 * scene.vertices;
  let force = 0;
  const off = [];
  await play(load, scene, { reportAtEnd: false }, (avatar, step) => {
    force = Math.max(force, Math.hypot(...avatar.contactForce));
    const sample = scene.samples.indexOf(step);
    if (sample < 0) return;
    const native = scene.skins.subarray(sample * count, (sample + 1) * count);
    off.push(largest(avatar.positions.map((x, i) => x - native[i])));
  });
  console.log(`largest distance from the native skin: ${Math.max(...off)} m; force ${force} N, native ${scene.largestForce} N`);
  assert.equal(off.length, scene.samples.length);
  assert.ok(scene.largestForce > 1, "the hand is pressed");
  assert.ok(Math.max(...off) <= ROUNDING, `${off} m`);
  assert.ok(Math.abs(force - scene.largestForce) < 1e-6 * scene.largestForce);
});
