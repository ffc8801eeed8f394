// Lays out the page as static files: `node site.mjs FOLDER`.

import fs from "node:fs";
import path from "node:path";
import { fileURLToPath } from "node:url";

const here = path.dirname(fileURLToPath(import.meta.url));
const root = path.join(here, "..");
const out = process.argv[2];

/** Scenes of the gallery, made small enough to run by the clock in one thread: what is replaced in each. */
const GALLERY = [
  { file: "flag.toml", title: "Flag in gusts", about: "Cotton on its pole, in wind with gusts", change: [["rows = 31, cols = 46", "rows = 19, cols = 28"], ["thickness = 0.005", "thickness = 0.008"]] },
  { file: "drape.toml", title: "Cloth on a ball", about: "A square of jersey falls and folds", change: [["rows = 64\ncols = 64", "rows = 36\ncols = 36"], ["thickness = 0.005", "thickness = 0.008"]] },
  { file: "curtain.toml", title: "Curtain", about: "It is drawn together and opens", change: [["rows = 41", "rows = 26"], ["cols = 61", "cols = 38"]] },
  { file: "skirt.toml", title: "A skirt", about: "Wool on a human who turns", change: [] },
  { file: "contact/knot.toml", title: "A knot", about: "A hose is pulled tight; nothing passes through", change: [] },
  { file: "contact/twist_tube.toml", title: "A tube is wrung", about: "Three turns of cloth on cloth", change: [] },
  { file: "press_bunny.toml", title: "A bunny in a press", about: "Soft, and its volume is kept", change: [] },
  { file: "trampoline.toml", title: "Trampoline", about: "A ball on stretched cloth", change: [] },
];
/** Meshes that those name; what is not there has a stand-in. */
const MESHES = [["models", "human.ply"], ["models", "skirt.ply"], ["models", "bunny.ply"], ["scenes/contact", "rope.obj"]];

fs.rmSync(out, { recursive: true, force: true });
fs.mkdirSync(path.join(out, "scenes"), { recursive: true });
for (const name of fs.readdirSync(path.join(here, "page"))) fs.copyFileSync(path.join(here, "page", name), path.join(out, name));
fs.copyFileSync(path.join(here, "package", "dist", "taffeta.js"), path.join(out, "taffeta.js"));
const list = GALLERY.map(({ file, title, about, change }) => {
  let text = fs.readFileSync(path.join(root, "scenes", file), "utf8");
  for (const [from, to] of change) {
    if (!text.includes(from)) throw new Error(`scenes/${file} has no \`${from}\` any more`);
    text = text.replace(from, to);
  }
  const name = path.basename(file);
  fs.writeFileSync(path.join(out, "scenes", name), text);
  return { name, title, about };
});
fs.writeFileSync(path.join(out, "scenes", "gallery.json"), JSON.stringify(list));
for (const [folder, name] of MESHES) {
  const from = path.join(root, folder, name);
  if (fs.existsSync(from)) fs.copyFileSync(from, path.join(out, "scenes", name));
}
