// Serves the package's folder on localhost, and a folder of characters as if it lay in examples:
// node examples/serve.js [folder of characters] [port]

import { createReadStream } from "node:fs";
import { stat } from "node:fs/promises";
import { createServer } from "node:http";
import { extname, join, normalize } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";

const root = fileURLToPath(new URL("..", import.meta.url));
const kinds = {
  ".html": "text/html", ".js": "text/javascript", ".wasm": "application/wasm", ".json": "application/json",
};

/** A server of the package and of `characters`, on a port of its own choice unless one is given. */
export function serve(characters, port = 0) {
  const find = async (path) => {
    const inside = normalize(decodeURIComponent(path)).replace(/^([/\\]|\.\.)+/, "");
    const name = inside.replace(/^examples[/\\]/, "");
    const places = [join(root, inside), ...(characters && name !== inside ? [join(characters, name)] : [])];
    for (const place of places) {
      const found = await stat(place).catch(() => undefined);
      if (found?.isFile()) return place;
    }
  };
  const server = createServer(async (request, response) => {
    const place = await find(new URL(request.url, "http://localhost").pathname).catch(() => undefined);
    if (!place) return response.writeHead(404).end();
    response.writeHead(200, { "content-type": kinds[extname(place)] ?? "application/octet-stream" });
    createReadStream(place).pipe(response);
  });
  return new Promise((resolve) => {
    server.listen(port, "127.0.0.1", () => resolve({ server, address: `http://127.0.0.1:${server.address().port}` }));
  });
}

if (import.meta.url === pathToFileURL(process.argv[1] ?? "").href) {
  const { address } = await serve(process.argv[2] ?? ".", Number(process.argv[3] ?? 8000));
  console.log(`${address}/examples/three.html?file=me.glb and ${address}/examples/three-vrm.html?file=me.vrm`);
}
