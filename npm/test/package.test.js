// What is published is all that is needed: packed, unpacked elsewhere, and used by its name.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { cpSync, existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";
import { test } from "node:test";
import { character } from "./character.js";

const root = fileURLToPath(new URL("..", import.meta.url));
const told = JSON.parse(readFileSync(join(root, "package.json")));

test("npm pack gives what is published, and that works alone", () => {
  const folder = mkdtempSync(join(tmpdir(), "supple-"));
  try {
    const [{ filename, files, size }] = JSON.parse(
      execFileSync("npm", ["pack", "--json", "--pack-destination", folder], { cwd: root, stdio: ["ignore", "pipe", "ignore"] }),
    );
    assert.deepEqual(files.map(({ path }) => path).sort(), [
      "LICENSE-APACHE", "LICENSE-MIT", "README.md", "errors.js", "examples/serve.js", "examples/stage.js",
      "examples/three-vrm.html", "examples/three.html", "index.d.ts", "index.js", "package.json", "three.d.ts", "three.js",
      "wasm/supple.d.ts", "wasm/supple.js", "wasm/supple_bg.wasm", "worker.js",
    ]);
    assert.ok(size < 1.3e6, `${size} bytes`);
    execFileSync("tar", ["xzf", filename], { cwd: folder });
    const own = join(folder, "node_modules", told.name);
    mkdirSync(join(folder, "node_modules"));
    cpSync(join(folder, "package"), own, { recursive: true });
    cpSync(join(root, "node_modules/three"), join(folder, "node_modules/three"), { recursive: true });
    writeFileSync(join(folder, "me.glb"), character({ spacing: 0.06 }));
    writeFileSync(join(folder, "use.mjs"), `
      import { readFileSync } from "node:fs";
      import { load } from "${told.name}";
      import { SoftAvatar } from "${told.name}/three";
      const avatar = await load(readFileSync("me.glb"), { name: "me.glb" });
      avatar.step(1 / 60);
      console.log(avatar.positions.length / 3 === avatar.vertices && avatar.positions.every(Number.isFinite), typeof SoftAvatar.from);
    `);
    const said = execFileSync("node", ["use.mjs"], { cwd: folder, encoding: "utf8" });
    assert.equal(said.trim(), "true function");
  } finally {
    rmSync(folder, { recursive: true });
  }
});

test("the wasm is small", () => {
  const bytes = gzipSync(readFileSync(join(root, "wasm/supple_bg.wasm")), { level: 9 }).length;
  console.log(`wasm: ${bytes} bytes gzipped`);
  assert.ok(bytes <= 1.2e6, `${bytes} bytes`);
});

test("every export is there", () => {
  for (const place of Object.values(told.exports).flatMap((to) => (typeof to === "string" ? [to] : Object.values(to)))) {
    assert.ok(existsSync(join(root, place)), place);
  }
});
