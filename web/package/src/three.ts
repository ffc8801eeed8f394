// Bodies of a simulation as meshes of three.js.

import { BufferAttribute, BufferGeometry, DynamicDrawUsage, type Material, Mesh, type Object3D } from "three";
import type { Simulation } from "./simulation.js";

/** A body as a mesh whose geometry follows the simulation. Give it a material with `side: DoubleSide`. */
export class BodyMesh<M extends Material = Material> extends Mesh<BufferGeometry, M> {
  readonly body: string;
  readonly simulation: Simulation;
  readonly #places: BufferAttribute;
  readonly #normals: BufferAttribute;

  /** A mesh of the body with this name; of the first where none is given. */
  constructor(simulation: Simulation, material: M, body = simulation.bodies[0]?.name ?? "") {
    const geometry = new BufferGeometry();
    const attribute = (numbers: Float32Array) => new BufferAttribute(numbers, 3).setUsage(DynamicDrawUsage);
    const places = attribute(simulation.positions(body));
    const normals = attribute(simulation.normals(body));
    geometry.setAttribute("position", places);
    geometry.setAttribute("normal", normals);
    geometry.setIndex(new BufferAttribute(simulation.indices(body), 1));
    super(geometry, material);
    this.body = body;
    this.simulation = simulation;
    this.#places = places;
    this.#normals = normals;
    // What moves is not where its ball was.
    this.frustumCulled = false;
  }

  /** Brings places and normals up to date; after `simulation.step()`. */
  update(): void {
    this.simulation.positions(this.body, this.#places.array as Float32Array);
    this.simulation.normals(this.body, this.#normals.array as Float32Array);
    this.#places.needsUpdate = true;
    this.#normals.needsUpdate = true;
    this.geometry.boundingSphere = null;
    this.geometry.boundingBox = null;
  }
}

/** A collider as a mesh that follows its pose. */
export class ColliderMesh<M extends Material = Material> extends Mesh<BufferGeometry, M> {
  readonly collider: string;
  readonly simulation: Simulation;

  constructor(simulation: Simulation, material: M, collider: string) {
    const { positions, indices } = simulation.colliderSurface(collider);
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(positions, 3));
    geometry.setIndex(new BufferAttribute(indices, 1));
    geometry.computeVertexNormals();
    super(geometry, material);
    this.collider = collider;
    this.simulation = simulation;
    this.matrixAutoUpdate = false;
    this.update();
  }

  /** Brings the pose up to date; after `simulation.step()`. */
  update(): void {
    this.matrix.fromArray(Array.from(this.simulation.colliderPose(this.collider)));
    this.matrixWorldNeedsUpdate = true;
  }
}

/** Meshes of all bodies and colliders, which `update()` of each brings up to date. */
export function meshesOf<M extends Material>(
  simulation: Simulation, materials: { body: M; collider: M },
): (Object3D & { update(): void })[] {
  return [
    ...simulation.bodies.map(({ name }) => new BodyMesh(simulation, materials.body, name)),
    ...simulation.colliders.map(({ name }) => new ColliderMesh(simulation, materials.collider, name)),
  ];
}
