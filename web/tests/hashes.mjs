// Every scene has the same bits here as in the program: `node tests/hashes.mjs PROGRAM [SCENE...]`.

import { execFileSync } from "node:child_process";
import fs from "node:fs";
import os from "node:os";
import path from "node:path";
import { fileURLToPath } from "node:url";
import { filesOf, init, Simulation } from "../package/dist/taffeta.js";

const root = path.join(path.dirname(fileURLToPath(import.meta.url)), "..", "..");
const FRAMES = 3;

/** All scenes of a folder and of those in it. */
export function scenesIn(folder) {
  const all = fs.readdirSync(folder, { recursive: true }).map((name) => path.join(folder, name));
  return all.filter((name) => name.endsWith(".toml")).sort();
}

/** The bytes of the files that a scene names, as far as they are there: beside it, or among the models. */
export function filesFor(scene, text) {
  const found = filesOf(text, path.basename(scene)).flatMap((name) => {
    const places = [path.join(path.dirname(scene), name), path.join(root, "models", name)];
    const file = places.find((place) => fs.existsSync(place));
    return file ? [[name, new Uint8Array(fs.readFileSync(file))]] : [];
  });
  return Object.fromEntries(found);
}

/** The hash that the program prints. */
export function nativeHash(program, scene, frames, more = []) {
  const out = fs.mkdtempSync(path.join(os.tmpdir(), "taffeta-"));
  const words = ["run", scene, "--frames", String(frames), "--backend", "cpu", "--threads", "1", "--out", out, ...more];
  const said = execFileSync(program, words, { cwd: root, encoding: "utf8", stdio: ["ignore", "pipe", "inherit"] });
  fs.rmSync(out, { recursive: true });
  return /state ([0-9a-f]{16})/.exec(said)?.[1];
}

async function main([program, ...chosen]) {
  await init();
  const scenes = chosen.length > 0 ? chosen : scenesIn(path.join(root, "scenes"));
  let differ = 0;
  for (const scene of scenes) {
    const text = fs.readFileSync(scene, "utf8");
    const frames = Math.min(FRAMES, Number(/^frames = (\d+)/m.exec(text)?.[1] ?? FRAMES));
    const start = performance.now();
    const simulation = new Simulation(text, { name: path.basename(scene), files: filesFor(scene, text) });
    simulation.step(frames);
    const [here, there] = [simulation.stateHash(), nativeHash(program, scene, frames)];
    simulation.free();
    const took = `${((performance.now() - start) / 1e3).toFixed(1)} s`;
    console.log(`${here === there ? "same  " : "DIFFER"} ${path.relative(root, scene)} ${here} ${there} (${took})`);
    differ += here === there ? 0 : 1;
  }
  if (differ > 0) throw new Error(`${differ} of ${scenes.length} scenes have other bits than the program`);
  console.log(`${scenes.length} scenes have the bits of the program`);
}

if (process.argv[1] === fileURLToPath(import.meta.url)) await main(process.argv.slice(2));
