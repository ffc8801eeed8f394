/** A vector of three numbers. */
export type Vec3 = readonly [number, number, number];

/** A scene as an object: the keys, units and defaults are those of a TOML scene. */
export interface SceneObject {
  title?: string;
  [key: string]: unknown;
}

/** Files that a scene names, such as meshes, by the names that it has for them. */
export type Files = Readonly<Record<string, Uint8Array | ArrayBuffer>> | ReadonlyMap<string, Uint8Array | ArrayBuffer>;

/** How to run a scene, apart from what it is. */
export interface SimulationOptions {
  /** Files that the scene names. */
  files?: Files;
  /** What messages call the scene's text; `scene.toml` where it is not given. */
  name?: string;
  /** Overrides, each `PATH=VALUE`, as `body.flag.material.preset=silk`. */
  set?: readonly string[];
  /** Arithmetic: 32 bits, or 64 to compare with. */
  precision?: "f32" | "f64";
  /** What becomes of a body that diverges: `stop` throws, `freeze` has it stand still while others go on. */
  onDivergence?: "stop" | "freeze";
}

/** Which `Error` it is: `error.name` of what this package throws. */
export type ErrorName = "SceneError" | "InputError" | "SnapshotError" | "DivergedError" | "InternalError";

/** What this package throws. */
export interface TaffetaError extends Error {
  name: ErrorName;
  /** Of a `SceneError`: where in the text the mistake was written. Line and column count from 1. */
  file?: string;
  line?: number;
  column?: number;
  /** Of a `DivergedError`: the frame, the body and its vertex, what was found, and its likely cause. */
  frame?: number;
  first?: number;
  body?: string;
  vertex?: number;
  what?: string;
  /** In words. */
  cause?: string;
}

/** A frame in numbers, with the names of docs/outputs.md. */
export interface Report {
  frame: number;
  /** Time since the start [s]. */
  time: number;
  substeps: number;
  /** Energies [J]; those of other elements have the names of their kinds. */
  energy: number;
  kinetic: number;
  gravitational: number;
  springs: number;
  /** [kg·m/s]. */
  momentum: Vec3;
  /** [kg·m²/s]. */
  angular_momentum: Vec3;
  /** Largest length of a spring or thread, in lengths at rest. */
  max_stretch: number;
  /** Of fabrics: least and largest strain along warp and weft, and largest shear. */
  strain: { warp: [number, number]; weft: [number, number]; shear: number } | null;
  /** Nodes that touch colliders. */
  contacts: number;
  pairs: number;
  nearest_pair: number | null;
  pair_searches: number;
  intersections: number | null;
  iterations: number;
  residual: number;
  active_fraction: number;
  capped: number;
  broken: number;
  asleep: number;
  /** [m³] by body. */
  volumes: Record<string, number>;
  volume_targets: Record<string, number>;
  /** Forces of pins [N] by body and pin. */
  reactions: Record<string, (Vec3 | null)[]>;
  squeezed: { body: string | null; vertex: number; colliders: string[] } | null;
  /** Energies [J] of kinds of elements. */
  [kind: string]: unknown;
}

/** A body of a running scene. */
export interface BodyInfo {
  name: string;
  /** Where its first vertex is among those of all bodies. */
  first: number;
  vertices: number;
  nodes: number;
  triangles: number;
  springs: number;
  pins: number;
  pinned: number;
  /** [kg]. */
  mass: number;
  /** [m³], of a closed body. */
  restVolume: number | null;
  /** What was repaired in its mesh, in words. */
  repairs: string[];
}

/** A collider of a running scene. */
export interface ColliderInfo {
  name: string;
  shape: "sphere" | "plane" | "box" | "capsule" | "cylinder" | "mesh" | "convex" | "heightfield";
  keyframes: number;
  poses: number;
  repairs: string[];
}

/** Gravity, drag, wind and air, with the keys of `[world]`. */
export interface World {
  /** [m/s²]. */
  gravity?: Vec3;
  /** [kg/s]. */
  drag?: number;
  /** [N]. */
  wind_force?: Vec3;
  air?: Record<string, unknown>;
}

/** One vertex, or several. */
export type Vertices = number | ArrayLike<number>;

/** Three numbers, or three for each vertex, flat or by row. */
export type Vectors = ArrayLike<number> | ArrayLike<ArrayLike<number>>;

/** A motion from the start: a shift of 3 numbers [m], or a rigid matrix of 16, column by column as `Matrix4.elements` of three.js. */
export type Pose = ArrayLike<number>;

/** Triangles to draw. */
export interface Surface {
  /** [m], three for each vertex. */
  positions: Float32Array;
  /** Three for each triangle. */
  indices: Uint32Array;
}
