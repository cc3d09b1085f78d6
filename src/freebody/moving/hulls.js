// Convex hulls as triangles: an edge between faces that differ little is shaded as if it were round.

const CREASE = 0.75;
class Hull {
  constructor([role, a, b, radius, corners, faces, bodies]) {
    const places = triples(corners), sides = triples(faces);
    const normals = sides.map(([i, j, k]) => unit(cross(minus(places[j], places[i]), minus(places[k], places[i]))));
    const around = (corner, own) => unit(sides.reduce((sum, side, k) => (side.includes(corner) && dot(normals[k], own) > CREASE ? plus(sum, normals[k]) : sum), [0, 0, 0]));
    Object.assign(this, {role, a, b, bodies, wide: true, size: faces.length, triangles: faces.map((_, k) => k), middle: plus(a, minus(b, a), 0.5).slice(1)});
    this.local = sides.flatMap((side, k) => side.flatMap((corner) => [...places[corner], ...around(corner, normals[k])]));
  }
  // Writes places and normals of its corners, from number `first` on; swell: how much larger it is.
  place(frames, points, normals, first, swell) {
    const {local, middle: [mx, my, mz]} = this, R = frames.subarray(FRAME * this.a[0], FRAME * this.a[0] + FRAME);
    for (let k = 0, i = 3 * first; k < local.length; k += 6, i += 3) {
      const x = mx + swell * (local[k] - mx), y = my + swell * (local[k + 1] - my), z = mz + swell * (local[k + 2] - mz);
      for (let row = 0; row < 3; row++) {
        points[i + row] = R[9 + row] + R[3 * row] * x + R[3 * row + 1] * y + R[3 * row + 2] * z;
        normals[i + row] = R[3 * row] * local[k + 3] + R[3 * row + 1] * local[k + 4] + R[3 * row + 2] * local[k + 5];
      }
    }
  }
}
const triples = (numbers) => Array.from({length: numbers.length / 3}, (_, k) => numbers.slice(3 * k, 3 * k + 3));
