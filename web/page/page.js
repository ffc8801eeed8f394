// The page: a gallery, a viewer, sliders, and the scene's text beside it.

import { filesOf, init, Simulation, Viewer } from "./taffeta.js";

/** Fabrics with their mass [kg/m²] and stiffness in bending along the warp [µN·m]: what `taffeta materials` prints. */
const FABRICS = {
  cotton: [0.15, 16], silk: [0.06, 1.2], wool: [0.22, 16], linen: [0.185, 32], denim: [0.324, 16], jersey: [0.187, 5.8],
  ponte: [0.284, 9], rib: [0.276, 11.5], polyester: [0.128, 13], blanket: [0.228, 29.2],
};
/** How long nothing is written before the scene is built again [ms]. */
const PAUSE = 350;

const at = (id) => document.getElementById(id);
const [canvas, text, lines, said, times] = ["canvas", "text", "lines", "said", "times"].map(at);
const files = new Map();
let simulation;
let viewer;
let timer;
let turn = 0;
let shown = 0;
// Wind and gravity as the sliders have them, and as the text has them.
let byHand = {};
let written;

// Light and dark.
const dark = matchMedia("(prefers-color-scheme: dark)");
const isDark = () => (document.documentElement.dataset.theme ?? (dark.matches ? "dark" : "light")) === "dark";
const showTheme = () => {
  at("theme").textContent = isDark() ? "Light" : "Dark";
  at("theme").setAttribute("aria-pressed", String(isDark()));
};
at("theme").addEventListener("click", () => {
  document.documentElement.dataset.theme = isDark() ? "light" : "dark";
  showTheme();
});
dark.addEventListener("change", showTheme);
showTheme();

// Links hold the scene, packed.
const through = async (bytes, stream) => new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(stream)).arrayBuffer());
async function pack(scene) {
  const bytes = await through(new TextEncoder().encode(scene), new CompressionStream("deflate-raw"));
  const letters = Array.from(bytes, (byte) => String.fromCharCode(byte)).join("");
  return btoa(letters).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
}
async function unpack(packed) {
  const letters = atob(packed.replaceAll("-", "+").replaceAll("_", "/"));
  const bytes = Uint8Array.from(letters, (letter) => letter.charCodeAt(0));
  return new TextDecoder().decode(await through(bytes, new DecompressionStream("deflate-raw")));
}
at("link").addEventListener("click", async () => {
  const url = new URL(location.href);
  url.hash = `scene=${await pack(text.value)}`;
  history.replaceState(null, "", url);
  const copied = await navigator.clipboard?.writeText(url.href).then(() => true, () => false);
  at("linked").textContent = copied ? "Copied." : "The link is in the address bar.";
});

// The text.
function showLines(bad) {
  const count = text.value.split("\n").length;
  lines.replaceChildren(...Array.from({ length: count }, (_, index) => {
    const line = document.createElement(index + 1 === bad ? "mark" : "span");
    line.textContent = `${index + 1}\n`;
    return line;
  }));
  lines.scrollTop = text.scrollTop;
}
text.addEventListener("scroll", () => { lines.scrollTop = text.scrollTop; });
text.addEventListener("input", () => {
  showLines();
  later(() => build({ adopts: true }));
});

function goTo(line, column) {
  const before = text.value.split("\n").slice(0, line - 1).join("\n").length + (line > 1 ? 1 : 0);
  text.focus();
  text.setSelectionRange(before + column - 1, before + column);
  text.scrollTop = Math.max(0, (line - 4) * parseFloat(getComputedStyle(text).lineHeight));
}

function say(error) {
  said.replaceChildren();
  text.setAttribute("aria-invalid", String(Boolean(error)));
  showLines(error?.line);
  if (!error) return;
  if (error.line) {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = `Line ${error.line}`;
    button.addEventListener("click", () => goTo(error.line, error.column));
    said.append(button);
  }
  said.append(error.message);
}

function later(work) {
  clearTimeout(timer);
  timer = setTimeout(work, PAUSE);
}

/** Builds the scene of the text; with `adopts` it goes on from where the other one is. */
async function build({ adopts = false } = {}) {
  clearTimeout(timer);
  const mine = ++turn;
  const scene = text.value;
  try {
    const missing = filesOf(scene).filter((name) => !files.has(name));
    await Promise.all(missing.map(async (name) => {
      const answer = await fetch(new URL(name, new URL("scenes/", location.href)));
      if (answer.ok) files.set(name, await answer.arrayBuffer());
    }));
    if (mine !== turn) return;
    const next = new Simulation(scene, { files });
    const before = simulation;
    const goesOn = adopts && before !== undefined;
    viewer.show(next, { keepsView: goesOn });
    if (goesOn) next.adoptState(before);
    const world = JSON.stringify(next.world);
    if (!goesOn || world !== written) byHand = {};
    next.setWorld(byHand);
    written = world;
    simulation = next;
    before?.free();
    say();
    at("loading").textContent = "";
    canvas.setAttribute("aria-label", `Simulation of ${next.bodies.map(({ name }) => name).join(", ")}`);
    showControls();
  } catch (error) {
    if (mine !== turn) return;
    at("loading").textContent = simulation ? "" : "This scene has a mistake.";
    say(error);
  }
}

// Fabric: lines of the text.
const PRESET = /^(\s*(?:material\.)?preset\s*=\s*)"(\w+)"/m;
const number = (key) => new RegExp(`^(\\s*(?:material\\.)?${key}\\s*=\\s*)([0-9.e-]+)[^\\n]*$`, "m");

function showControls() {
  const preset = PRESET.exec(text.value)?.[2];
  const fabric = FABRICS[preset];
  for (const id of ["preset", "density", "bending"]) at(id).disabled = !fabric;
  if (fabric) {
    const after = text.value.slice(PRESET.exec(text.value).index);
    at("preset").value = preset;
    at("density").value = number("density").exec(after)?.[2] ?? fabric[0];
    at("bending").value = Math.log10(1e6 * (number("bending").exec(after)?.[2] ?? 1e-6 * fabric[1]));
  }
  const { air, gravity } = simulation.world;
  for (const id of ["wind", "way"]) at(id).disabled = !air;
  const [x = 0, , z = 0] = air?.velocity ?? [];
  at("wind").value = Math.hypot(x, z);
  if (x !== 0 || z !== 0) at("way").value = (Math.atan2(z, x) * 180) / Math.PI;
  at("gravity").value = Math.hypot(...gravity);
  showNumbers();
}

function showNumbers() {
  const bending = 10 ** Number(at("bending").value);
  const out = {
    density: at("density").disabled ? "–" : `${(1e3 * at("density").value).toFixed(0)} g/m²`,
    bending: at("bending").disabled ? "–" : `${bending.toPrecision(2)} µN·m`,
    wind: at("wind").disabled ? "no air in this scene" : `${Number(at("wind").value).toFixed(1)} m/s`,
    way: at("way").disabled ? "–" : `${at("way").value}°`,
    gravity: `${Number(at("gravity").value).toFixed(1)} m/s²`,
  };
  for (const [id, words] of Object.entries(out)) {
    at(`${id}-out`).textContent = words;
    at(id).setAttribute("aria-valuetext", words);
  }
}

/** Changes a number of the fabric in the text, or adds it after the preset. */
function write(key, value) {
  const start = PRESET.exec(text.value).index;
  const [before, after] = [text.value.slice(0, start), text.value.slice(start)];
  const found = number(key).exec(after);
  const lead = /^\s*(material\.)?/.exec(PRESET.exec(text.value)[1])[1] ?? "";
  const changed = found ? after.replace(number(key), `$1${value}`) : after.replace(/\n|$/, `\n${lead}${key} = ${value}\n`);
  text.value = before + changed;
  later(() => build({ adopts: true }));
  showLines();
}

at("preset").append(...Object.keys(FABRICS).map((name) => new Option(name)));
at("preset").addEventListener("change", () => {
  const start = PRESET.exec(text.value).index;
  const after = text.value.slice(start).replace(PRESET, `$1"${at("preset").value}"`);
  const own = ["density", "bending"].reduce((rest, key) => rest.replace(new RegExp(`${number(key).source}\\n?`, "m"), ""), after);
  text.value = text.value.slice(0, start) + own;
  build({ adopts: true });
});
at("density").addEventListener("input", () => { showNumbers(); write("density", Number(at("density").value)); });
at("bending").addEventListener("input", () => { showNumbers(); write("bending", Number((1e-6 * 10 ** at("bending").value).toPrecision(3))); });
function blow() {
  showNumbers();
  const way = (at("way").value * Math.PI) / 180;
  const speed = Number(at("wind").value);
  const { air } = simulation.world;
  if (!air) return;
  byHand.air = { ...air, velocity: [speed * Math.cos(way), 0, speed * Math.sin(way)] };
  simulation.setWorld({ air: byHand.air });
}
for (const id of ["wind", "way"]) at(id).addEventListener("input", blow);
at("gravity").addEventListener("input", () => {
  showNumbers();
  byHand.gravity = [0, -Number(at("gravity").value), 0];
  simulation?.setWorld({ gravity: byHand.gravity });
});

// The picture.
at("play").addEventListener("click", () => (viewer.isPlaying ? viewer.pause() : viewer.play()));
at("restart").addEventListener("click", () => build());
at("frame").addEventListener("click", () => viewer.frame());

function showTimes({ fps, step, time }) {
  const now = performance.now();
  if (now - shown < 250) return;
  shown = now;
  times.textContent = `${fps.toFixed(0)} fps · ${step.toFixed(1)} ms a frame · ${time.toFixed(1)} s`;
  at("hash").textContent = viewer.isPlaying ? "–" : simulation.stateHash();
}

async function open(name) {
  for (const button of at("gallery").children) button.setAttribute("aria-pressed", String(button.dataset.name === name));
  text.value = await (await fetch(`scenes/${name}`)).text();
  text.scrollTop = 0;
  history.replaceState(null, "", location.pathname + location.search);
  await build();
}

async function start() {
  const [gallery] = await Promise.all([fetch("scenes/gallery.json").then((answer) => answer.json()), init()]);
  viewer = new Viewer(canvas, {
    frame: showTimes,
    error: say,
    playing: (isPlaying) => { at("play").textContent = isPlaying ? "Pause" : "Play"; shown = 0; viewer?.redraw(); },
  });
  at("gallery").append(...gallery.map(({ name, title, about }) => {
    const button = document.createElement("button");
    button.type = "button";
    button.dataset.name = name;
    button.setAttribute("aria-pressed", "false");
    const small = document.createElement("small");
    small.textContent = about;
    button.append(title, small);
    button.addEventListener("click", () => open(name));
    return button;
  }));
  const held = /^#scene=(.+)$/.exec(location.hash)?.[1];
  const scene = held && (await unpack(held).catch(() => undefined));
  if (scene !== undefined && held) {
    text.value = scene;
    await build();
  } else {
    await open(gallery[0].name);
  }
  if (matchMedia("(prefers-reduced-motion: reduce)").matches) {
    at("play").textContent = "Play";
    at("loading").textContent = "It waits, as this machine asks for less motion: Play starts it.";
  } else {
    viewer.play();
  }
  document.documentElement.dataset.ready = "true";
}

start().catch((error) => {
  at("loading").textContent = `It cannot start: ${error.message}`;
});
