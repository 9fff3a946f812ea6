// The closed surface where a function is 0, by marching tetrahedra: each cube of a lattice as six tets about its diagonal.

const TETS = [[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]];

/** Positions, triangles (counter-clockwise seen from where the function is positive) and unit normals. */
export function meshOf(distance, low, high, spacing) {
  const counts = low.map((x, i) => Math.ceil((high[i] - x) / spacing) + 1);
  const [nx, ny, nz] = counts;
  const at = (n) => [n % nx, Math.floor(n / nx) % ny, Math.floor(n / (nx * ny))].map((k, i) => low[i] + spacing * k);
  const values = Float64Array.from({ length: nx * ny * nz }, (_, n) => distance(at(n)));
  const positions = [];
  const triangles = [];
  const known = new Map();
  const cut = (a, b) => {
    const key = a < b ? `${a} ${b}` : `${b} ${a}`;
    if (!known.has(key)) {
      // Not too near a corner: no triangle without area.
      const t = Math.min(0.9, Math.max(0.1, values[a] / (values[a] - values[b])));
      const [p, q] = [at(a), at(b)];
      known.set(key, positions.push(p.map((x, i) => x + t * (q[i] - x))) - 1);
    }
    return known.get(key);
  };
  const gradient = (p) => {
    const h = 1e-4;
    const g = [0, 1, 2].map((i) => {
      const [a, b] = [p.slice(), p.slice()];
      a[i] += h;
      b[i] -= h;
      return distance(a) - distance(b);
    });
    const length = Math.hypot(...g);
    return g.map((x) => x / length);
  };
  const add = (a, b, c) => {
    const [p, q, r] = [a, b, c].map((v) => positions[v]);
    const [u, v] = [q, r].map((x) => x.map((y, i) => y - p[i]));
    const normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    const out = gradient(p.map((x, i) => (x + q[i] + r[i]) / 3));
    const along = normal[0] * out[0] + normal[1] * out[1] + normal[2] * out[2];
    triangles.push(along > 0 ? [a, b, c] : [a, c, b]);
  };
  for (let z = 0; z + 1 < nz; z++) {
    for (let y = 0; y + 1 < ny; y++) {
      for (let x = 0; x + 1 < nx; x++) {
        const corner = (k) => x + (k & 1) + nx * (y + ((k >> 1) & 1) + ny * (z + (k >> 2)));
        for (const tet of TETS) {
          const all = tet.map(corner);
          const inside = all.filter((n) => values[n] < 0);
          const outside = all.filter((n) => values[n] >= 0);
          if (inside.length === 2) {
            const [[a, b], [c, d]] = [inside, outside];
            add(cut(a, c), cut(a, d), cut(b, d));
            add(cut(a, c), cut(b, d), cut(b, c));
          } else if (inside.length && outside.length) {
            const [apex, base] = inside.length === 1 ? [inside[0], outside] : [outside[0], inside];
            add(...base.map((n) => cut(apex, n)));
          }
        }
      }
    }
  }
  return { positions, triangles, normals: positions.map(gradient) };
}
