// Makes the npm package of what wasm-bindgen has left in package/build: `node build.mjs`.

import { execFileSync } from "node:child_process";
import fs from "node:fs";
import path from "node:path";
import { fileURLToPath } from "node:url";
import zlib from "node:zlib";
import { build } from "esbuild";

const here = path.dirname(fileURLToPath(import.meta.url));
const inPackage = (...names) => path.join(here, "package", ...names);
const wasm = inPackage("build", "taffeta_web_bg.wasm");

const bin = (name) => path.join(here, "node_modules", ".bin", name);
// One module has it inside, packed: browsers unpack it while it is compiled.
const packed = zlib.deflateRawSync(fs.readFileSync(wasm), { level: 9 });
fs.writeFileSync(inPackage("build", "wasm.js"), `export default "${packed.toString("base64")}";\n`);
fs.writeFileSync(inPackage("build", "wasm.d.ts"), "declare const wasm: string;\nexport default wasm;\n");

fs.rmSync(inPackage("dist"), { recursive: true, force: true });
const common = { bundle: true, format: "esm", target: "es2022", minifySyntax: true, minifyIdentifiers: true, legalComments: "none", logLevel: "warning" };
await build({ ...common, entryPoints: [inPackage("src", "index.ts")], outfile: inPackage("dist", "taffeta.js") });
await build({ ...common, entryPoints: [inPackage("src", "three.ts")], outfile: inPackage("dist", "three.js"), external: ["three"] });
execFileSync(bin("tsc"), ["-p", inPackage()], { stdio: "inherit" });

for (const name of ["LICENSE-APACHE", "LICENSE-MIT"]) fs.copyFileSync(path.join(here, "..", name), inPackage(name));
const sizes = [["wasm", wasm], ["module", inPackage("dist", "taffeta.js")]].map(([name, file]) => {
  const bytes = fs.readFileSync(file);
  return `${name} ${bytes.length} bytes, ${zlib.brotliCompressSync(bytes).length} in brotli`;
});
console.log(sizes.join("; "));
