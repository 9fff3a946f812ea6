// What several tests need.

/** The longest of vectors of three numbers one after the other. */
export function largest(vectors) {
  let most = 0;
  for (let i = 0; i < vectors.length; i += 3) most = Math.max(most, Math.hypot(vectors[i], vectors[i + 1], vectors[i + 2]));
  return most;
}

/** World matrices of an avatar's joints in its bind pose, shifted by `shift`. */
export function worldOf(avatar, shift = [0, 0, 0]) {
  const clone = avatar.clone();
  const matrices = clone.jointMatrices.slice();
  clone.free();
  for (let j = 0; j < matrices.length; j += 16) shift.forEach((x, i) => { matrices[j + 12 + i] += x; });
  return matrices;
}

/** The middle one. */
export const median = (times) => Float64Array.from(times).sort()[times.length >> 1];
