// The wasm inside, and what its errors become.

import { initSync, Simulation as Raw, simd, version as rawVersion } from "../build/taffeta_web.js";
import wasm from "../build/wasm.js";
import type { TaffetaError } from "./types.js";

export { filesOf as rawFilesOf, Quantity } from "../build/taffeta_web.js";
export { Raw };

let started: Promise<void> | undefined;
let isReady = false;

/**
 * Starts the engine; what comes after may be called once this has ended. Called again, it is the same start.
 */
export function init(): Promise<void> {
  started ??= start();
  return started;
}

async function start(): Promise<void> {
  const packed = Uint8Array.from(atob(wasm), (letter) => letter.charCodeAt(0));
  const unpacked = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  const module = await WebAssembly.compile(await new Response(unpacked).arrayBuffer());
  initSync({ module });
  isReady = true;
}

/** The version of the package. */
export function version(): string {
  return engine(rawVersion);
}

/** The vector instructions of the engine. */
export function simdLevel(): string {
  return engine(simd);
}

const OURS = ["SceneError", "InputError", "SnapshotError", "DivergedError", "InternalError"];

/** An error of this package. */
export function failure(name: TaffetaError["name"], message: string): TaffetaError {
  const error = new Error(message) as TaffetaError;
  error.name = name;
  return error;
}

/** Calls the engine; what it throws is an error of this package. */
export function engine<T>(work: () => T): T {
  if (!isReady) {
    throw failure("InputError", "the engine has not started; `await init()` would do");
  }
  try {
    return work();
  } catch (error) {
    if (error instanceof Error && OURS.includes(error.name)) {
      throw error;
    }
    // A trap: what is no panic, as the end of memory or of the stack.
    const what = error instanceof Error ? `${error.name}: ${error.message}` : String(error);
    throw failure("InternalError", `a mistake in taffeta, or too little memory; please report it: ${what}`);
  }
}
