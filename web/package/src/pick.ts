// Which vertex is under the pointer.

import { add, cross, dot, type Point } from "./camera.js";
import type { Simulation } from "./simulation.js";

/** A vertex that was hit, and how far along the ray [m]. */
export interface Hit {
  body: string;
  vertex: number;
  /** Where it is [m]. */
  place: Point;
  distance: number;
}

const corner = (places: Float32Array, vertex: number): Point => [
  places[3 * vertex]!, places[3 * vertex + 1]!, places[3 * vertex + 2]!,
];

/** The vertex of a body that is nearest to where a ray meets its surface; null where it meets none. */
export function pick(
  simulation: Simulation, triangles: ReadonlyMap<string, Uint32Array>, eye: Point, way: Point,
): Hit | null {
  let nearest: Hit | null = null;
  for (const { name } of simulation.bodies) {
    const faces = triangles.get(name) ?? new Uint32Array();
    const places = simulation.positionsView(name);
    for (let face = 0; face < faces.length; face += 3) {
      const corners = [0, 1, 2].map((k) => corner(places, faces[face + k]!)) as [Point, Point, Point];
      const distance = meets(eye, way, corners);
      if (distance === null || (nearest && distance >= nearest.distance)) continue;
      const at = add(eye, way, distance);
      const far = corners.map((place) => Math.hypot(...add(place, at, -1)));
      const k = far.indexOf(Math.min(...far));
      nearest = { body: name, vertex: faces[face + k]!, place: corners[k]!, distance };
    }
  }
  return nearest;
}

/** How far along a ray a triangle is (Möller and Trumbore 1997); null where the ray passes it. */
function meets(eye: Point, way: Point, [a, b, c]: [Point, Point, Point]): number | null {
  const [along, across] = [add(b, a, -1), add(c, a, -1)];
  const normal = cross(way, across);
  const area = dot(along, normal);
  if (Math.abs(area) < 1e-15) return null;
  const from = add(eye, a, -1);
  const u = dot(from, normal) / area;
  const other = cross(from, along);
  const v = dot(way, other) / area;
  const distance = dot(across, other) / area;
  return u >= 0 && v >= 0 && u + v <= 1 && distance > 0 ? distance : null;
}
