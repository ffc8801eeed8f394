// The package and its page in Chromium: `node tests/browser.mjs PROGRAM USER`, where USER has the package in node_modules.
// TAFFETA_SITE is the folder of the page. Pictures are left in web/out.

import assert from "node:assert/strict";
import fs from "node:fs";
import path from "node:path";
import { fileURLToPath } from "node:url";
import { chromium } from "playwright-core";
import { serve } from "../serve.mjs";
import { filesFor, nativeHash, scenesIn } from "./hashes.mjs";
import { init } from "../package/dist/taffeta.js";

const here = path.dirname(fileURLToPath(import.meta.url));
const root = path.join(here, "..", "..");
const [program, user] = process.argv.slice(2).map((name) => path.resolve(name));
const out = path.join(here, "..", "out");
const site = path.resolve(process.env.TAFFETA_SITE);
fs.mkdirSync(out, { recursive: true });

/** What a user writes: an element, nothing else. */
const PAGE = `<!doctype html>
<html lang="en">
<title>A flag</title>
<meta charset="utf-8">
<script type="module" src="node_modules/taffeta/dist/taffeta.js"></script>
<style>taffeta-cloth { width: 40rem; height: 30rem; background: #e8edf3; }</style>
<h1>A flag</h1>
<taffeta-cloth src="flag.toml"></taffeta-cloth>
</html>`;

/** The same with three.js. */
const THREE = `<!doctype html>
<html lang="en">
<title>three.js</title>
<meta charset="utf-8">
<link rel="icon" href="data:,">
<script type="importmap">{ "imports": { "three": "./node_modules/three/build/three.module.js", "taffeta": "./node_modules/taffeta/dist/taffeta.js", "taffeta/three": "./node_modules/taffeta/dist/three.js" } }</script>
<script type="module">
import * as THREE from "three";
import { init, Simulation } from "taffeta";
import { meshesOf } from "taffeta/three";
await init();
const simulation = await Simulation.load("flag.toml");
const renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
renderer.setSize(640, 480);
document.body.append(renderer.domElement);
const scene = new THREE.Scene();
scene.background = new THREE.Color(0xe8edf3);
const camera = new THREE.PerspectiveCamera(40, 4 / 3, 0.1, 50);
camera.position.set(0.5, 1.8, 3);
camera.lookAt(0, 1.5, 0);
const light = new THREE.DirectionalLight(0xffffff, 2);
light.position.set(1, 2, 2);
const material = (color) => new THREE.MeshStandardMaterial({ color, side: THREE.DoubleSide, roughness: 0.8 });
const meshes = meshesOf(simulation, { body: material(0x1d4f91), collider: material(0x888888) });
scene.add(light, new THREE.HemisphereLight(0xffffff, 0x888888, 1.5), ...meshes);
let frames = 0;
renderer.setAnimationLoop(() => {
  simulation.step();
  meshes.forEach((mesh) => mesh.update());
  renderer.render(scene, camera);
  document.documentElement.dataset.frames = String(++frames);
});
</script>
</html>`;

/** Whether two pictures of the element differ, by its own pixels. */
const bytesOf = async (target) => target.screenshot({ animations: "allow" });

const browser = await chromium.launch({
  executablePath: process.env.TAFFETA_CHROMIUM || "/usr/bin/chromium",
  args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"],
});
const servers = [];
const open = async (folder, name, options = {}) => {
  const server = await serve(folder);
  servers.push(server);
  const context = await browser.newContext(options);
  const page = await context.newPage();
  const complaints = [];
  page.on("console", (message) => {
    // What the driver says of its own speed is not ours.
    // Meshes that were not fetched into models/ have stand-ins.
    const { pathname } = new URL(message.location().url || "http://none/");
    const isMissing = /\.(ply|obj)$/.test(pathname) && !fs.existsSync(path.join(folder, pathname));
    if (["error", "warning"].includes(message.type()) && !message.text().includes("GPU stall") && !isMissing) complaints.push(message.text());
  });
  page.on("pageerror", (error) => complaints.push(String(error)));
  await page.goto(`http://127.0.0.1:${server.address().port}/${name}`);
  return { page, complaints };
};

/** Runs the tests of a page, and closes it. */
async function part(name, folder, file, work, options) {
  const start = performance.now();
  const { page, complaints } = await open(folder, file, options);
  try {
    await work(page);
    assert.deepEqual(complaints, [], `${name}: the browser complains`);
  } catch (error) {
    await page.screenshot({ path: path.join(out, "failed.png") }).catch(() => {});
    console.error(complaints.slice(0, 5).map((words) => words.slice(0, 500)).join("\n"));
    throw error;
  } finally {
    await page.context().close();
  }
  console.log(`  ${name}: ${((performance.now() - start) / 1e3).toFixed(1)} s`);
}

/** Middle and size of what a viewer shows on the page, and where a vertex of its first body is. */
const vertexAt = (page, how, vertex) => page.evaluate(({ how, vertex }) => {
  const viewer = how === "element" ? document.querySelector("taffeta-cloth").viewer : globalThis.viewerForTest;
  const [x, y, z] = viewer.simulation.positions(viewer.simulation.bodies[0].name).slice(3 * vertex, 3 * vertex + 3);
  const { camera, canvas } = viewer;
  const times = (m, v) => [0, 1, 2, 3].map((row) => m[row] * v[0] + m[4 + row] * v[1] + m[8 + row] * v[2] + m[12 + row] * v[3]);
  const clip = times(camera.projection(), times(camera.view(), [x, y, z, 1]));
  const box = canvas.getBoundingClientRect();
  return {
    place: [x, y, z],
    at: [box.left + (clip[0] / clip[3] + 1) / 2 * box.width, box.top + (1 - clip[1] / clip[3]) / 2 * box.height],
  };
}, { how, vertex });

const flagFile = path.join(root, "scenes", "flag_gusts.toml");

async function element(page) {
  const cloth = page.locator("taffeta-cloth");
  const toFirst = await page.evaluate(async () => {
    const cloth = document.querySelector("taffeta-cloth");
    if (!cloth.simulation) await new Promise((done) => cloth.addEventListener("ready", done, { once: true }));
    while (cloth.simulation.frame < 1) await new Promise(requestAnimationFrame);
    return performance.now();
  });
  console.log(`  the first frame of the flag is there ${toFirst.toFixed(0)} ms after the page was asked for`);
  await page.waitForFunction(() => document.querySelector("taffeta-cloth").simulation.frame > 20);
  await page.evaluate(() => document.querySelector("taffeta-cloth").viewer.pause());
  const before = await bytesOf(cloth);
  fs.writeFileSync(path.join(out, "element.png"), before);
  // A vertex amid the flag is dragged to the left.
  const vertex = 15 * 46 + 23;
  const { at, place } = await vertexAt(page, "element", vertex);
  await page.mouse.move(...at);
  await page.mouse.down();
  await page.mouse.move(at[0] - 60, at[1] - 40, { steps: 4 });
  await page.evaluate(() => { for (let i = 0; i < 12; i++) document.querySelector("taffeta-cloth").viewer.stepOnce(); });
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  const dragged = await vertexAt(page, "element", vertex);
  fs.writeFileSync(path.join(out, "element_dragged.png"), await bytesOf(cloth));
  const pulled = Math.hypot(dragged.at[0] - (at[0] - 60), dragged.at[1] - (at[1] - 40));
  assert.ok(pulled < 25, `the cloth at ${dragged.at} is ${pulled} pixels from the pointer`);
  await page.mouse.up();
  await page.evaluate(() => { for (let i = 0; i < 30; i++) document.querySelector("taffeta-cloth").viewer.stepOnce(); });
  const free = await vertexAt(page, "element", vertex);
  assert.ok(Math.hypot(...free.place.map((x, i) => x - dragged.place[i])) > 0.01, "it is held after the pointer let go");
  assert.ok(Math.hypot(...free.place.map((x, i) => x - place[i])) < 1);
  // A scene that is not there, and one with a mistake, are said on the page.
  await page.evaluate(() => {
    const cloth = document.querySelector("taffeta-cloth");
    return new Promise((done) => {
      cloth.addEventListener("error", done, { once: true });
      cloth.setAttribute("set", "body.flag.area_density=-1");
    });
  });
  const said = await page.evaluate(() => document.querySelector("taffeta-cloth").shadowRoot.querySelector("p").textContent);
  assert.match(said, /area_density/);
  // Taken off the page, it gives everything back.
  const isFreed = await page.evaluate(() => {
    const cloth = document.querySelector("taffeta-cloth");
    const { simulation } = cloth;
    cloth.remove();
    return simulation.isFreed && cloth.simulation === undefined;
  });
  assert.ok(isFreed);
}

/** Bits of scenes in the browser: those of the program. */
async function hashes(page) {
  await init();
  const light = ["flag", "flag_gusts", "hanging_ice", "knot", "sewn", "chain", "balloon", "twist_pins", "torn", "needles", "skirt", "press_bunny"];
  const chosen = scenesIn(path.join(root, "scenes")).filter((name) => light.includes(path.basename(name, ".toml")));
  assert.equal(chosen.length, light.length);
  for (const scene of chosen) {
    const text = fs.readFileSync(scene, "utf8");
    const files = Object.entries(filesFor(scene, text)).map(([name, data]) => [name, Buffer.from(data).toString("base64")]);
    const found = await page.evaluate(async ({ text, files }) => {
      const { init, Simulation } = await import("./node_modules/taffeta/dist/taffeta.js");
      await init();
      const bytes = (data) => Uint8Array.from(atob(data), (letter) => letter.charCodeAt(0));
      const simulation = new Simulation(text, { files: new Map(files.map(([name, data]) => [name, bytes(data)])) });
      simulation.step(3);
      const hash = simulation.stateHash();
      simulation.free();
      return hash;
    }, { text, files });
    assert.equal(found, nativeHash(program, scene, 3), path.relative(root, scene));
  }
}

async function three(page) {
  await page.waitForFunction(() => Number(document.documentElement.dataset.frames) > 15);
  fs.writeFileSync(path.join(out, "three.png"), await bytesOf(page.locator("canvas")));
}

/** What the page's viewer is called, for tests. */
async function ready(page) {
  await page.waitForFunction(() => document.documentElement.dataset.ready === "true");
}

async function accessible(page) {
  await page.addScriptTag({ path: path.join(here, "..", "node_modules", "axe-core", "axe.min.js") });
  const { violations } = await page.evaluate(() => globalThis.axe.run());
  const said = violations.map(({ id, nodes }) => `${id}: ${nodes.map(({ html }) => html).join(" ")}`);
  assert.deepEqual(said, []);
}

async function gallery(page) {
  await ready(page);
  const times = () => page.locator("#times").textContent();
  await page.waitForFunction(() => Number(/· ([\d.]+) s/.exec(document.querySelector("#times").textContent)?.[1]) > 0.5);
  await page.screenshot({ path: path.join(out, "page.png") });
  console.log(`  ${await times()}`);
  await accessible(page);
  await page.locator("#theme").click();
  await accessible(page);
  await page.screenshot({ path: path.join(out, "page_dark.png") });
  // A mistake in the text is said at its line, and mended.
  const text = page.locator("#text");
  const scene = await text.inputValue();
  await text.fill(scene.replace("preset =", "prest ="));
  await page.locator("#said button").waitFor();
  const line = scene.split("\n").findIndex((line) => line.includes("preset =")) + 1;
  assert.equal(await page.locator("#said button").textContent(), `Line ${line}`);
  assert.equal((await page.locator("#lines mark").textContent()).trim(), String(line));
  await page.locator("#said button").click();
  assert.ok(await text.evaluate((text) => document.activeElement === text));
  await accessible(page);
  await page.screenshot({ path: path.join(out, "page_mistake.png") });
  await text.fill(scene);
  await page.waitForFunction(() => document.querySelector("#said").textContent === "");
  // Fabric and wind.
  await page.locator("#preset").selectOption("silk");
  assert.match(await text.inputValue(), /preset = "silk"/);
  await page.waitForFunction(() => document.querySelector("#density-out").textContent === "60 g/m²");
  await page.locator("#density").focus();
  await page.keyboard.press("ArrowRight");
  assert.match(await text.inputValue(), /^density = 0.065$/m);
  await page.locator("#wind").focus();
  for (let i = 0; i < 20; i++) await page.keyboard.press("ArrowRight");
  assert.match(await page.locator("#wind-out").textContent(), /5\.5 m\/s/);
  // It stays when the scene is built anew for another fabric, and is that of the text once the text has another.
  await page.locator("#preset").selectOption("wool");
  await page.waitForFunction(() => document.querySelector("#density-out").textContent === "220 g/m²");
  assert.match(await page.locator("#wind-out").textContent(), /5\.5 m\/s/);
  await text.fill((await text.inputValue()).replace(/^(\s*(?:air\.)?velocity = )\[[^\]]*\]/m, "$1[2.0, 0.0, 0.0]"));
  await page.waitForFunction(() => document.querySelector("#wind-out").textContent === "2.0 m/s");
  // A link holds the scene.
  await page.locator("#link").click();
  await page.waitForFunction(() => location.hash.startsWith("#scene="));
  const held = await text.inputValue();
  await page.reload();
  await ready(page);
  assert.equal(await text.inputValue(), held);
  // Keys on the picture.
  await page.locator("#canvas").focus();
  await page.keyboard.press("Space");
  assert.equal(await page.locator("#play").textContent(), "Play");
  await page.keyboard.press("ArrowLeft");
  await page.keyboard.press("+");
  await page.keyboard.press(".");
  await page.waitForFunction(() => /^[0-9a-f]{16}$/.test(document.querySelector("#hash").textContent));
  await page.keyboard.press("Space");
  // Every scene of the gallery runs.
  const names = await page.locator("#gallery button").count();
  for (let i = 0; i < names; i++) {
    const button = page.locator("#gallery button").nth(i);
    await button.click();
    await page.waitForFunction((i) => document.querySelectorAll("#gallery button")[i].getAttribute("aria-pressed") === "true", i);
    await page.waitForFunction(() => document.querySelector("#loading").textContent === "");
    await page.waitForTimeout(0);
    await page.waitForFunction(() => Number(/· ([\d.]+) s$/.exec(document.querySelector("#times").textContent)?.[1]) > 0.3, undefined, { timeout: 60000 });
    assert.equal(await page.locator("#said").textContent(), "");
    const name = await button.getAttribute("data-name");
    console.log(`  ${name}: ${await times()}`);
    await page.locator(".canvas").screenshot({ path: path.join(out, `scene_${path.basename(name, ".toml")}.png`) });
  }
}

async function phone(page) {
  await ready(page);
  await page.waitForFunction(() => Number(/· ([\d.]+) s/.exec(document.querySelector("#times").textContent)?.[1]) > 0.3);
  await page.screenshot({ path: path.join(out, "phone.png"), fullPage: true });
  const width = await page.evaluate(() => document.documentElement.scrollWidth);
  assert.ok(width <= 390, `the page is ${width} pixels wide`);
  await accessible(page);
}

try {
  fs.writeFileSync(path.join(user, "index.html"), PAGE);
  fs.writeFileSync(path.join(user, "three.html"), THREE);
  fs.copyFileSync(flagFile, path.join(user, "flag.toml"));
  fs.writeFileSync(path.join(user, "favicon.ico"), "");
  await part("the element", user, "index.html", element);
  await part("bits", user, "index.html", hashes);
  await part("three.js", user, "three.html", three);
  await part("the page", site, "", gallery, { viewport: { width: 1280, height: 900 } });
  await part("on a phone", site, "", phone, { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true, deviceScaleFactor: 2 });
} finally {
  await browser.close();
  servers.forEach((server) => server.close());
}
