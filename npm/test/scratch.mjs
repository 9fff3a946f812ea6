import { readFileSync, writeFileSync } from "node:fs";
import { load } from "../index.js";
const f = readFileSync("out/character.glb");
let t = performance.now();
const a = await load(f, { name: "character.glb", onProgress: (...p) => console.log(p, Math.round(performance.now() - t)) });
console.log("bake ms", performance.now() - t, a.name, a.vertices, a.handles, a.cubaturePoints, a.tissueMass, a.notes, a.parts.map(p => [p.name, p.material, p.materialIndex, p.soft, p.triangles.length, p.positions.length, p.coordinates.length]));
writeFileSync("out/character.supple", a.save());
for (let i = 0; i < 60; i++) { a.step(1/60); }
t = performance.now();
for (let i = 0; i < 60; i++) { a.step(1/60); }
console.log("step", (performance.now() - t) / 60, a.report.stop, a.report.iterations);
const d = a.displacements; let m = 0; for (let i = 0; i < d.length; i += 3) m = Math.max(m, Math.hypot(d[i], d[i+1], d[i+2]));
console.log("max displacement", m);
