// A character made from formulas, as GLB or VRM: a person of capsules with a seam, a texture, a hat that is no tissue, a clip.

import { deflateSync } from "node:zlib";
import { meshOf } from "./marching.js";

const side = (s) => (s > 0 ? "left" : "right");
const limbs = (s) => [
  // Name, parent, joint, far end, radius (m).
  [`${side(s)}UpperLeg`, "hips", [0.1 * s, 0.9, 0], [0.1 * s, 0.5, 0], 0.085],
  [`${side(s)}LowerLeg`, `${side(s)}UpperLeg`, [0.1 * s, 0.5, 0], [0.1 * s, 0.1, 0], 0.06],
  [`${side(s)}Foot`, `${side(s)}LowerLeg`, [0.1 * s, 0.08, 0], [0.1 * s, 0.06, 0.12], 0.05],
  [`${side(s)}UpperArm`, "chest", [0.19 * s, 1.38, 0], [0.42 * s, 1.38, 0], 0.06],
  [`${side(s)}LowerArm`, `${side(s)}UpperArm`, [0.42 * s, 1.38, 0], [0.66 * s, 1.38, 0], 0.05],
  [`${side(s)}Hand`, `${side(s)}LowerArm`, [0.66 * s, 1.38, 0], [0.76 * s, 1.38, 0], 0.045],
];
const bones = [
  ["hips", null, [0, 0.95, 0], [0, 1.0, 0.01], 0.15],
  ["spine", "hips", [0, 1.05, 0], [0, 1.12, 0.05], 0.15],
  ["chest", "spine", [0, 1.2, 0], [0, 1.33, 0], 0.15],
  ["neck", "chest", [0, 1.42, 0], [0, 1.5, 0], 0.06],
  ["head", "neck", [0, 1.5, 0], [0, 1.63, 0.01], 0.1],
  ...limbs(1),
  ...limbs(-1),
];

/** Distance (m) of p from the skin of one bone's capsule. */
function capsule(p, [, , a, b, radius]) {
  const along = a.map((x, i) => b[i] - x);
  const to = p.map((x, i) => x - a[i]);
  const dot = (u, v) => u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
  const t = Math.min(1, Math.max(0, dot(to, along) / dot(along, along)));
  return Math.hypot(...to.map((x, i) => x - t * along[i])) - radius;
}

/** All capsules as one, their joins rounded over 2 cm. */
const person = (p) => -0.02 * Math.log(bones.reduce((sum, bone) => sum + Math.exp(-capsule(p, bone) / 0.02), 0));

/** The four nearest bones of a vertex, and their shares. */
function weights(p) {
  const near = bones.map((bone, i) => [i, Math.max(capsule(p, bone) + bone[4], 1e-3) ** -6]);
  near.sort((a, b) => b[1] - a[1]);
  const four = near.slice(0, 4);
  const sum = four.reduce((s, [, w]) => s + w, 0);
  return [four.map(([i]) => i), four.map(([, w]) => w / sum)];
}

/** A chequered PNG of 64 by 64. */
function picture() {
  const raw = Buffer.alloc(64 * (1 + 3 * 64));
  for (let y = 0; y < 64; y++) {
    for (let x = 0; x < 64; x++) {
      const dark = ((x >> 3) + (y >> 3)) % 2;
      raw.set(dark ? [205, 140, 110] : [240, 190, 160], y * 193 + 1 + 3 * x);
    }
  }
  const crcTable = Array.from({ length: 256 }, (_, n) => {
    for (let k = 0; k < 8; k++) n = n & 1 ? 0xedb88320 ^ (n >>> 1) : n >>> 1;
    return n >>> 0;
  });
  const chunk = (name, data) => {
    const body = Buffer.concat([Buffer.from(name), data]);
    let crc = 0xffffffff;
    for (const byte of body) crc = crcTable[(crc ^ byte) & 255] ^ (crc >>> 8);
    const out = Buffer.alloc(12 + data.length);
    out.writeUInt32BE(data.length, 0);
    body.copy(out, 4);
    out.writeUInt32BE((crc ^ 0xffffffff) >>> 0, 8 + data.length);
    return out;
  };
  const size = Buffer.from([0, 0, 0, 64, 0, 0, 0, 64, 8, 2, 0, 0, 0]);
  const signature = Buffer.from([137, 80, 78, 71, 13, 10, 26, 10]);
  return Buffer.concat([signature, chunk("IHDR", size), chunk("IDAT", deflateSync(raw)), chunk("IEND", Buffer.alloc(0))]);
}

/** A box about the origin, with normals. */
function box(half) {
  const positions = [];
  const triangles = [];
  for (let axis = 0; axis < 3; axis++) {
    for (const s of [1, -1]) {
      const first = positions.length;
      for (const [u, v] of [[-1, -1], [1, -1], [1, 1], [-1, 1]]) {
        const p = [0, 0, 0];
        [p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]] = [s * half[axis], u * half[(axis + 1) % 3], v * half[(axis + 2) % 3]];
        positions.push(p);
      }
      const [a, b, c, d] = [0, 1, 2, 3].map((k) => first + k);
      triangles.push(...(s > 0 ? [[a, b, c], [a, c, d]] : [[a, c, b], [a, d, c]]));
    }
  }
  return { positions, triangles };
}

/** The character's file; as a VRM 1.0 with outlines where `vrm` says so. */
export function character({ vrm = false, spacing = 0.04 } = {}) {
  const skin = meshOf(person, [-0.88, -0.04, -0.24], [0.88, 1.8, 0.28], spacing);
  // The texture is laid on front and back each by itself: vertices between the two are there twice.
  const own = new Map();
  const vertices = [];
  const triangles = skin.triangles.map((t) => {
    const [a, b, c] = t.map((v) => skin.positions[v]);
    const front = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0;
    return t.map((v) => {
      const key = `${v} ${front}`;
      if (!own.has(key)) own.set(key, vertices.push([v, front]) - 1);
      return own.get(key);
    });
  });
  const chunks = [];
  const views = [];
  const accessors = [];
  const view = (bytes) => {
    const offset = chunks.reduce((sum, c) => sum + c.length, 0);
    chunks.push(bytes, Buffer.alloc((4 - (bytes.length % 4)) % 4));
    return views.push({ buffer: 0, byteOffset: offset, byteLength: bytes.length }) - 1;
  };
  const accessor = (array, type, width, componentType, extra) => {
    const bytes = Buffer.from(array.buffer, array.byteOffset, array.byteLength);
    return accessors.push({ bufferView: view(bytes), componentType, count: array.length / width, type, ...extra }) - 1;
  };
  const floats = (rows, type, extra) => accessor(Float32Array.from(rows.flat()), type, rows[0].length ?? 1, 5126, extra);
  const scalars = (list, extra) => accessor(Float32Array.from(list), "SCALAR", 1, 5126, extra);
  const bounds = (rows) => ({
    min: [0, 1, 2].map((i) => Math.fround(Math.min(...rows.map((p) => p[i])))),
    max: [0, 1, 2].map((i) => Math.fround(Math.max(...rows.map((p) => p[i])))),
  });
  const places = vertices.map(([v]) => skin.positions[v]);
  const bound = places.map(weights);
  const uv = vertices.map(([v, front]) => [skin.positions[v][0] * (front ? 1 : -1) + 0.5, 1 - skin.positions[v][1] / 1.8]);
  const hat = box([0.12, 0.03, 0.12]);
  const joint = (name) => bones.findIndex(([own]) => own === name);
  const nodes = bones.map(([name, parent, at]) => {
    const origin = parent ? bones[joint(parent)][2] : [0, 0, 0];
    const children = bones.flatMap(([, of], i) => (of === name ? [i] : []));
    return { name, translation: at.map((x, i) => x - origin[i]), ...(children.length && { children }) };
  });
  const body = nodes.push({ name: "Body", mesh: 0, skin: 0 }) - 1;
  const hatNode = nodes.push({ name: "Hat", mesh: 1, translation: [0, 0.25, 0] }) - 1;
  nodes[joint("head")].children = [hatNode];
  const inverse = bones.map(([, , [x, y, z]]) => [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -x, -y, -z, 1]);
  const frames = Array.from({ length: 31 }, (_, k) => k / 30);
  const bob = frames.map((t) => [0, 0.95 + 0.04 * Math.sin(4 * Math.PI * t), 0.03 * Math.sin(2 * Math.PI * t)]);
  const toon = {
    specVersion: "1.0", shadeColorFactor: [0.6, 0.4, 0.4], shadingToonyFactor: 0.6,
    outlineWidthMode: "worldCoordinates", outlineWidthFactor: 0.003, outlineColorFactor: [0.1, 0.1, 0.2],
  };
  const json = {
    asset: { version: "2.0", generator: "supple's tests" },
    scene: 0,
    scenes: [{ nodes: [joint("hips"), body] }],
    nodes,
    meshes: [
      {
        name: "Body",
        primitives: [{
          attributes: {
            POSITION: floats(places, "VEC3", bounds(places)),
            NORMAL: floats(vertices.map(([v]) => skin.normals[v]), "VEC3"),
            TEXCOORD_0: floats(uv, "VEC2"),
            JOINTS_0: accessor(Uint16Array.from(bound.flatMap(([b]) => b)), "VEC4", 4, 5123),
            WEIGHTS_0: floats(bound.map(([, w]) => w), "VEC4"),
          },
          indices: accessor(Uint32Array.from(triangles.flat()), "SCALAR", 1, 5125),
          material: 0,
        }],
      },
      {
        name: "Hat",
        primitives: [{
          attributes: { POSITION: floats(hat.positions, "VEC3", bounds(hat.positions)) },
          indices: accessor(Uint32Array.from(hat.triangles.flat()), "SCALAR", 1, 5125),
          material: 1,
        }],
      },
    ],
    skins: [{ joints: bones.map((_, i) => i), inverseBindMatrices: floats(inverse, "MAT4"), skeleton: joint("hips") }],
    materials: [
      {
        name: "skin",
        pbrMetallicRoughness: { baseColorTexture: { index: 0 }, metallicFactor: 0, roughnessFactor: 0.8 },
        ...(vrm && { extensions: { VRMC_materials_mtoon: toon } }),
      },
      { name: "felt", pbrMetallicRoughness: { baseColorFactor: [0.1, 0.2, 0.5, 1], metallicFactor: 0 } },
    ],
    textures: [{ source: 0 }],
    images: [{ bufferView: view(picture()), mimeType: "image/png" }],
    animations: [{
      name: "bob",
      samplers: [{ input: scalars(frames, { min: [0], max: [1] }), output: floats(bob, "VEC3") }],
      channels: [{ sampler: 0, target: { node: joint("hips"), path: "translation" } }],
    }],
    ...(vrm && {
      extensionsUsed: ["VRMC_vrm", "VRMC_materials_mtoon"],
      extensions: {
        VRMC_vrm: {
          specVersion: "1.0",
          meta: { name: "test", version: "1", authors: ["supple"], licenseUrl: "https://vrm.dev/licenses/1.0/" },
          humanoid: { humanBones: Object.fromEntries(bones.map(([name], node) => [name, { node }])) },
        },
      },
    }),
  };
  const binary = Buffer.concat(chunks);
  json.buffers = [{ byteLength: binary.length }];
  json.bufferViews = views;
  json.accessors = accessors;
  return glb(json, binary);
}

/** A GLB of a document and its buffer. */
function glb(json, binary) {
  let text = Buffer.from(JSON.stringify(json));
  text = Buffer.concat([text, Buffer.alloc((4 - (text.length % 4)) % 4, " ")]);
  const head = (length, name) => {
    const out = Buffer.alloc(8);
    out.writeUInt32LE(length, 0);
    out.write(name, 4, "latin1");
    return out;
  };
  const start = Buffer.alloc(12);
  start.write("glTF");
  start.writeUInt32LE(2, 4);
  start.writeUInt32LE(28 + text.length + binary.length, 8);
  return Buffer.concat([start, head(text.length, "JSON"), text, head(binary.length, "BIN\0"), binary]);
}
