// What programs in TypeScript write; it is compiled and not run.

import { DoubleSide, MeshStandardMaterial, Scene } from "three";
import { init, Simulation, type TaffetaError, Viewer } from "taffeta";
import { BodyMesh, meshesOf } from "taffeta/three";

await init();
const simulation: Simulation = new Simulation({ body: [] }, { files: { "a.obj": new Uint8Array() }, precision: "f64" });
const places: Float32Array = simulation.positions("cloth", new Float32Array(9));
const stretch: number = simulation.step(3).max_stretch;
simulation.pin("cloth", [0, 1], [[0, 0, 0], [1, 1, places[0]! + stretch]]);
try {
  simulation.moveCollider("ball", [0, 1, 0]);
} catch (error) {
  const line: number | undefined = (error as TaffetaError).line;
  console.log(line);
}
const material = new MeshStandardMaterial({ side: DoubleSide });
const flag = new BodyMesh(simulation, material, "flag");
const scene = new Scene().add(flag, ...meshesOf(simulation, { body: material, collider: material }));
flag.update();
new Viewer(document.createElement("canvas"), { error: (error: Error) => console.log(error) }).show(simulation);
document.createElement("taffeta-cloth").simulation?.free();
// @ts-expect-error: a precision that there is not
new Simulation("", { precision: "f16" });
console.log(scene);
