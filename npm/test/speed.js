// Milliseconds a step of hand_press, native and in the wasm, in Node and in Chromium: node test/speed.js [folder of a build]…
// The native ones are those of the run that wrote the reference.

import { readFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { serve } from "../examples/serve.js";
import { launch } from "./browser.js";
import { median } from "./helpers.js";
import { reference } from "./reference.js";

const { hand, milliseconds, samples: _, skins: __, ...scene } = reference();
const builds = process.argv.slice(2);
if (!builds.length) builds.push("wasm");

function tell(name, times) {
  const pressed = times.slice(150, 350);
  console.log(`${name}: ${median(times).toFixed(2)} ms a step, pressed ${median(pressed).toFixed(2)} ms (medians)`);
}

/** Plays the scene with the wasm at `bytes`; runs in Node and in a page. */
async function times(root, bytes, scene, hand, settings) {
  const { init, load } = await import(`${root}index.js`);
  const { play } = await import(`${root}test/hand_press.js`);
  await init(bytes);
  const found = [];
  await play(load, { ...scene, hand }, settings, (_, __, ms) => found.push(ms));
  return found;
}

tell("native, one thread", milliseconds);
const site = await serve(fileURLToPath(new URL("../out/reference", import.meta.url)));
const browser = await launch();
for (const build of builds) {
  const wasm = new URL(`../${build}/supple_bg.wasm`, import.meta.url);
  // A build a module: each import has its own wasm.
  if (build === builds[0]) {
    const root = new URL("../", import.meta.url).href;
    tell(`Node ${process.version}, ${build}`, await times(root, readFileSync(wasm), scene, hand, { reportAtEnd: false }));
  }
  for (const reportAtEnd of [false, true]) {
    const page = await browser.newPage();
    await page.goto(`${site.address}/examples/three.html?file=none`);
    const run = `(async () => {
      const bytes = async (name) => new Uint8Array(await (await fetch(name)).arrayBuffer());
      const times = ${times};
      return times("${site.address}/", await bytes("/${build}/supple_bg.wasm"), ${JSON.stringify(scene)},
        await bytes("/examples/hand.supple"), { reportAtEnd: ${reportAtEnd} });
    })()`;
    tell(`Chromium ${browser.version()}, ${build}${reportAtEnd ? ", with forces of the step's end" : ""}`, await page.evaluate(run));
    await page.close();
  }
}
await browser.close();
site.server.close();
