// The class `Simulation`.

import { engine, failure, Quantity, Raw, rawFilesOf } from "./engine.js";
import { fetchScene } from "./fetched.js";
import type {
  BodyInfo, ColliderInfo, Files, Pose, Report, SceneObject, SimulationOptions, Surface, Vec3, Vectors, Vertices, World,
} from "./types.js";

/** Most frames at once: they are counted in 32 bits. */
const MOST_FRAMES = 2 ** 32 - 1;

/** The names of the files that a scene reads, such as meshes. */
export function filesOf(scene: string | SceneObject, name = "scene.toml"): string[] {
  return engine(() => rawFilesOf(scene, name));
}

function whole(name: string, number: number, most = MOST_FRAMES): number {
  if (!Number.isInteger(number) || number < 0 || number > most) {
    throw failure("InputError", `${name} is ${number}; a whole number from 0 to ${most} would do`);
  }
  return number;
}

function indices(vertices: Vertices): Uint32Array {
  const all = typeof vertices === "number" ? [vertices] : Array.from(vertices);
  all.forEach((vertex) => whole("a vertex", vertex));
  return Uint32Array.from(all);
}

function entries(files: Files): [string, Uint8Array | ArrayBuffer][] {
  return files instanceof Map ? [...files] : Object.entries(files);
}

function bytes(name: string, data: unknown): Uint8Array {
  if (data instanceof Uint8Array) return data;
  if (data instanceof ArrayBuffer) return new Uint8Array(data);
  throw failure("InputError", `files: \`${name}\` is no Uint8Array or ArrayBuffer; the bytes of the file would do`);
}

/**
 * A scene that runs. Lengths are in m, masses in kg, times in s, forces in N; y is up.
 *
 * What it holds lies in the engine's memory, until {@link Simulation.free} is called or a `using` declaration ends.
 */
export class Simulation {
  /** The scene that it was built from. */
  readonly scene: string | SceneObject;
  /** The bodies, in the scene's order, as they were at the start. */
  readonly bodies: readonly BodyInfo[];
  /** The colliders, in the scene's order. */
  readonly colliders: readonly ColliderInfo[];
  /** Length of a frame [s]. */
  readonly dt: number;
  /** What should be known before it runs, such as a step that is too long. */
  readonly warnings: readonly string[];
  #raw: Raw | undefined;
  #why = "";

  /**
   * Builds a scene: TOML text, or an object with the same keys.
   *
   * Throws a `SceneError` with line and column where the scene cannot be simulated.
   */
  constructor(scene: string | SceneObject, options: SimulationOptions = {}) {
    const { files = {}, name = "scene.toml", set = [], precision = "f32", onDivergence = "stop" } = options;
    const all = entries(files);
    const names = all.map(([name]) => name);
    const data = all.map(([name, data]) => bytes(name, data));
    const raw = engine(() => new Raw(scene, name, [...set], names, data, precision, onDivergence));
    this.#raw = raw;
    this.scene = scene;
    this.bodies = raw.bodies();
    this.colliders = raw.colliders();
    this.dt = raw.dt;
    this.warnings = raw.warnings;
  }

  /** Fetches a scene and the files that it names, which lie beside it or where `files` says, and builds it. */
  static async load(url: string | URL, options: SimulationOptions & { signal?: AbortSignal } = {}): Promise<Simulation> {
    const { text, files, name } = await fetchScene(url, options);
    return new Simulation(text, { ...options, files, name });
  }

  /** Runs frames, and reports the last. Throws a `DivergedError` where a body diverged; the state is the last good one then. */
  step(frames = 1): Report {
    whole("frames", frames);
    return this.#call((raw) => {
      raw.step(frames);
      return raw.report();
    });
  }

  /** Runs as many whole frames as last `seconds` [s], or the first number that lasts longer. */
  advance(seconds: number): Report {
    // What is a whole number of frames but for roundings is one.
    const frames = Math.ceil((seconds / this.dt) * (1 - 1e-9));
    if (!(frames >= 0 && frames <= MOST_FRAMES)) {
      throw failure("InputError", `seconds is ${seconds}; 0 to ${MOST_FRAMES * this.dt} would do`);
    }
    return this.step(frames);
  }

  /** Runs a frame, and says how long each of its stages took [ms]. */
  stepTimed(): Record<string, number> {
    return this.#call((raw) => raw.stepTimed());
  }

  /** Report of the last frame, or of the start. */
  get report(): Report {
    return this.#call((raw) => raw.report());
  }

  /** Number of frames done. */
  get frame(): number {
    return this.#call((raw) => raw.frame);
  }

  /** Time since the start [s]. */
  get time(): number {
    return this.frame * this.dt;
  }

  /** Where it runs. */
  get backend(): "cpu" {
    return "cpu";
  }

  /** Memory that state, springs and lists of contacts take [byte]. */
  get memory(): number {
    return this.#call((raw) => raw.memory);
  }

  /** Names of bodies that diverged and stand still. */
  get frozen(): string[] {
    return this.#call((raw) => raw.frozen);
  }

  /** 64-bit hash of positions and velocities as 16 hexadecimal digits: that of the same scene on a desktop, bit by bit. */
  stateHash(): string {
    return this.#call((raw) => raw.stateHash());
  }

  /**
   * Positions of all vertices [m], three numbers each, bodies one after the other, or of one body's. They are written to `out`,
   * if it is given, and nothing is allocated then.
   */
  positions(body?: string, out?: Float32Array): Float32Array {
    return this.#call((raw) => raw.read(Quantity.Positions, body, out));
  }

  /** Velocities [m/s], as {@link Simulation.positions}. */
  velocities(body?: string, out?: Float32Array): Float32Array {
    return this.#call((raw) => raw.read(Quantity.Velocities, body, out));
  }

  /** Unit normals, weighted by area, as {@link Simulation.positions}. */
  normals(body?: string, out?: Float32Array): Float32Array {
    return this.#call((raw) => raw.read(Quantity.Normals, body, out));
  }

  /** Positions without a copy: a view of the engine's memory that the next call of anything in this package makes invalid. */
  positionsView(body?: string): Float32Array {
    return this.#call((raw) => raw.view(Quantity.Positions, body));
  }

  /** Normals without a copy, as {@link Simulation.positionsView}. */
  normalsView(body?: string): Float32Array {
    return this.#call((raw) => raw.view(Quantity.Normals, body));
  }

  /** Positions in 64 bits [m]: all digits of a run with `precision: "f64"`. */
  positions64(body?: string): Float64Array {
    return this.#call((raw) => raw.positions64(body));
  }

  /** Triangles by their vertices, three each: those of a body, counted from its first vertex, or those of all. */
  indices(body?: string): Uint32Array {
    return this.#call((raw) => raw.faces(body));
  }

  /** Pins vertices, and moves them to places [m] during the next frame; there they stay until `unpin`. Without places: where they are. */
  pin(body: string, vertices: Vertices, to?: Vectors): void {
    const all = indices(vertices);
    this.#call((raw) => raw.pin(body, all, to));
  }

  /** Frees vertices that `pin` has pinned. What a pin of the scene holds stays pinned. */
  unpin(body: string, vertices: Vertices): void {
    const all = indices(vertices);
    this.#call((raw) => raw.unpin(body, all));
  }

  /** Applies a force to each of the vertices during the next frame [N]. */
  applyForce(body: string, vertices: Vertices, force: Vectors): void {
    const all = indices(vertices);
    this.#call((raw) => raw.applyForce(body, all, force));
  }

  /** Brings the nodes of a movable pin of the scene to a pose during the next frame. `pin` counts the body's pins from 0. */
  movePin(body: string, pin: number, pose: Pose): void {
    whole("pin", pin);
    this.#call((raw) => raw.movePin(body, pin, pose));
  }

  /** Brings a collider to a pose during the next frame, so that it has the velocity of that motion. */
  moveCollider(collider: string, pose: Pose): void {
    this.#call((raw) => raw.moveCollider(collider, pose));
  }

  /** Where a collider has been brought from its start, column by column, when a `fraction` of the last frame has gone by. */
  colliderPose(collider: string, fraction = 1): Float64Array {
    return this.#call((raw) => raw.colliderPose(collider, fraction));
  }

  /** Triangles of a collider at its start, to be drawn in its {@link Simulation.colliderPose}. */
  colliderSurface(collider: string): Surface {
    return this.#call((raw) => {
      const surface = raw.colliderSurface(collider);
      const { positions, indices } = surface;
      surface.free();
      return { positions, indices };
    });
  }

  /** Distances of all vertices from colliders [m], less the colliders' offsets, up to `reach` [m]. */
  colliderDistances(reach: number): Float32Array {
    return this.#call((raw) => raw.colliderDistances(reach));
  }

  /** Counts where bodies pass through themselves, each other and colliders made of triangles, by exact arithmetic. */
  intersections(): { pairs: number; first: string | null; complete: boolean } {
    return this.#call((raw) => raw.intersections());
  }

  /** Changes gravity, drag, wind and air from the next frame on. What is not given stays. */
  setWorld(changes: World): void {
    this.#call((raw) => raw.setWorld(changes));
  }

  /** Gravity, drag, wind and air as they are now. */
  get world(): World {
    return this.#call((raw) => raw.world());
  }

  /** Moves every free node by up to `amplitude` [m] along each axis, at random but the same for the same seed. */
  disturb(amplitude: number, seed = 1): void {
    whole("seed", seed);
    this.#call((raw) => raw.disturb(amplitude, seed));
  }

  /** Force with which a pin of the scene holds its nodes [N]; null at the start, and for pins that break. */
  reaction(body: string, pin = 0): Vec3 | null {
    whole("pin", pin);
    const force = this.#call((raw) => raw.reaction(body, pin));
    return force ? ([...force] as unknown as Vec3) : null;
  }

  /** The state as bytes, in the format of the program's checkpoints. */
  snapshot(): Uint8Array {
    return this.#call((raw) => raw.snapshot());
  }

  /** Takes up a state of the same scene. From there it goes on bit by bit as the other one did. */
  restore(snapshot: Uint8Array): void {
    this.#call((raw) => raw.restore(snapshot));
  }

  /** Goes on where a simulation of another scene is: with its time, and the state of bodies with the same name and as many nodes. */
  adoptState(other: Simulation): void {
    if (other === this) return;
    this.#call((raw) => other.#call((from) => raw.adoptState(from)));
  }

  /** Whether it has been freed. */
  get isFreed(): boolean {
    return this.#raw === undefined;
  }

  /** Gives its memory back. Nothing may be asked of it any more. */
  free(): void {
    const raw = this.#raw;
    this.#raw = undefined;
    // What a mistake of ours has stopped is held by it.
    if (raw && this.#why === "") raw.free();
  }

  [Symbol.dispose](): void {
    this.free();
  }

  #call<T>(work: (raw: Raw) => T): T {
    const raw = this.#raw;
    if (raw === undefined) {
      throw failure("InputError", "this simulation was freed; a new one would do");
    }
    if (this.#why !== "") {
      throw failure("InternalError", `${this.#why}. It has stopped this simulation; a new one would do`);
    }
    try {
      return engine(() => work(raw));
    } catch (error) {
      if (error instanceof Error && error.name === "InternalError") this.#why = error.message;
      throw error;
    }
  }
}
