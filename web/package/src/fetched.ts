// Scenes from the network.

import { engine, failure, rawFilesOf } from "./engine.js";
import type { Files } from "./types.js";

async function fetched(url: URL, what: string, signal?: AbortSignal): Promise<Response> {
  const answer = await fetch(url, { signal: signal ?? null }).catch((error: unknown) => {
    if (signal?.aborted) throw error;
    throw failure("SceneError", `${what} cannot be fetched from ${url.href}: ${String(error)}`);
  });
  if (!answer.ok) {
    throw failure("SceneError", `${what} cannot be fetched from ${url.href}: ${answer.status} ${answer.statusText}`);
  }
  return answer;
}

/**
 * Fetches a scene and the files that it names. Those that `files` has are not fetched; of the others, those that are not there are
 * left out, as the scene may have stand-ins for them.
 */
export async function fetchScene(
  url: string | URL,
  options: { files?: Files; signal?: AbortSignal } = {},
): Promise<{ text: string; name: string; files: Map<string, Uint8Array | ArrayBuffer> }> {
  const { signal } = options;
  const from = new URL(url, globalThis.document?.baseURI);
  const text = await (await fetched(from, "the scene", signal)).text();
  const name = decodeURIComponent(from.pathname.split("/").pop() ?? "") || "scene.toml";
  const given = options.files ?? {};
  const files = new Map(given instanceof Map ? given : Object.entries(given));
  const missing = engine(() => rawFilesOf(text, name)).filter((file) => !files.has(file));
  await Promise.all(missing.map(async (file) => {
    const answer = await fetch(new URL(file, from), { signal: signal ?? null });
    // Hosts that answer with a page for what is not there say so by its type.
    const isPage = answer.headers.get("content-type")?.startsWith("text/html") ?? false;
    if (answer.ok && !isPage) files.set(file, await answer.arrayBuffer());
  }));
  return { text, name, files };
}
