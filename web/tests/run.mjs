// All tests of the package: `node tests/run.mjs PROGRAM TARBALL`. TAFFETA_CHROMIUM names the browser.

import { execFileSync } from "node:child_process";
import fs from "node:fs";
import os from "node:os";
import path from "node:path";
import { fileURLToPath } from "node:url";

const web = path.join(path.dirname(fileURLToPath(import.meta.url)), "..");
const [program, tarball] = process.argv.slice(2).map((name) => path.resolve(name));

function part(name, work) {
  const start = performance.now();
  console.log(`web: ${name}`);
  work();
  console.log(`web: ${name}: ${((performance.now() - start) / 1e3).toFixed(1)} s`);
}
const run = (file, words, cwd = web) => execFileSync(file, words, { stdio: "inherit", cwd });

part("what the package promises", () => run("node", ["--test", "--test-reporter=dot", "tests/api.test.mjs"]));
part("bits of all scenes", () => run("node", ["tests/hashes.mjs", program]));

// A user's folder, outside of the repository.
const user = fs.mkdtempSync(path.join(os.tmpdir(), "taffeta-user-"));
fs.writeFileSync(path.join(user, "package.json"), JSON.stringify({ private: true, type: "module" }));
part("the tarball where nothing else is", () => {
  fs.mkdirSync(path.join(user, "node_modules", "taffeta"), { recursive: true });
  run("tar", ["xzf", tarball, "--strip-components=1", "-C", path.join(user, "node_modules", "taffeta")]);
  for (const name of ["three", "@types", "undici-types", "@dimforge", "@tweenjs", "fflate", "meshoptimizer"]) {
    const from = path.join(web, "node_modules", name);
    if (fs.existsSync(from)) fs.symlinkSync(from, path.join(user, "node_modules", name));
  }
  fs.copyFileSync(path.join(web, "tests", "types.ts"), path.join(user, "types.ts"));
  const options = ["--strict", "--noEmit", "--module", "nodenext", "--target", "es2022", "--skipLibCheck", "--noUncheckedIndexedAccess"];
  run(path.join(web, "node_modules", ".bin", "tsc"), [...options, "types.ts"], user);
});
part("examples of the guide", () => {
  const guide = fs.readFileSync(path.join(web, "..", "docs", "web.md"), "utf8");
  const examples = [...guide.matchAll(/^```js\n(.*?)^```/gms)].map(([, code]) => code);
  if (examples.length === 0) throw new Error("docs/web.md has no examples");
  examples.forEach((code, index) => {
    fs.writeFileSync(path.join(user, `example${index}.mjs`), code);
    run("node", [`example${index}.mjs`], user);
  });
});
part("a browser", () => run("node", ["tests/browser.mjs", program, user]));
fs.rmSync(user, { recursive: true });
