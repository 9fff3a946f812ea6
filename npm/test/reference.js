// What the native run of hand_press was told and found (npm/reference wrote it).

import { readFileSync } from "node:fs";

const folder = new URL("../out/reference/", import.meta.url);

export function reference() {
  const told = JSON.parse(readFileSync(new URL("hand_press.json", folder)));
  const bytes = readFileSync(new URL("hand_press.f32", folder));
  const skins = new Float32Array(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
  return { ...told, skins, hand: readFileSync(new URL("hand.supple", folder)) };
}
