// What the package promises, in node: `node --test tests/api.test.mjs`.

import assert from "node:assert/strict";
import fs from "node:fs";
import { before, test } from "node:test";
import * as raw from "../package/build/taffeta_web.js";
import { filesOf, init, Simulation, simdLevel, version } from "../package/dist/taffeta.js";

const TEXT = `
[time]
dt = 0.01
max_step = 0.001
[[body]]
name = "cloth"
mesh.grid = { rows = 5, cols = 6, size = [0.5, 0.4] }
area_density = 0.2
springs.structural = { k = 20.0, d = 0.01 }
[[body.pin]]
select = { rows = [0, 0] }
[[collider]]
name = "ball"
sphere = { center = [0.0, -0.4, 0.0], radius = 0.1 }
`;
const OBJECT = {
  time: { dt: 0.01, max_step: 0.001 },
  body: [{
    name: "cloth", mesh: { grid: { rows: 5, cols: 6, size: [0.5, 0.4] } }, area_density: 0.2,
    springs: { structural: { k: 20, d: 0.01 } }, pin: [{ select: { rows: [0, 0] } }],
  }],
  collider: [{ name: "ball", sphere: { center: [0, -0.4, 0], radius: 0.1 } }],
};

const named = (name, ...words) => (error) => {
  assert.equal(error.name, name, error.message);
  for (const word of words) assert.ok(error.message.includes(word), error.message);
  return true;
};

test("nothing runs before the start", () => {
  assert.throws(() => new Simulation(TEXT), named("InputError", "await init()"));
});

test("once started", async (suite) => {
  await init();

  await suite.test("it has vector instructions", () => {
    assert.equal(simdLevel(), "simd128");
    assert.equal(version(), JSON.parse(fs.readFileSync(new URL("../package/package.json", import.meta.url))).version);
  });

  await suite.test("an object is the same scene as its text", () => {
    const [a, b] = [TEXT, OBJECT].map((scene) => new Simulation(scene));
    a.step(10);
    b.advance(0.1);
    assert.equal(b.frame, 10);
    assert.equal(a.stateHash(), b.stateHash());
    assert.match(a.stateHash(), /^[0-9a-f]{16}$/);
    const report = a.report;
    assert.ok(Math.abs(report.time - 0.1) < 1e-12 && report.max_stretch > 1 && report.momentum.length === 3);
    assert.equal(report.reactions.cloth.length, 1);
  });

  await suite.test("a mistake is named at its line", () => {
    assert.throws(() => new Simulation(TEXT.replace("area_density", "area_densty")), (error) => {
      named("SceneError", "scene.toml:8:1", "did you mean `area_density`?")(error);
      assert.deepEqual([error.file, error.line, error.column], ["scene.toml", 8, 1]);
      return true;
    });
    assert.throws(() => new Simulation({ ...OBJECT, tim: {} }), named("SceneError", "unknown key `tim`"));
    assert.throws(() => new Simulation(7), named("SceneError", "a scene is TOML text, or an object"));
    assert.throws(() => new Simulation({ body: [{ mesh: () => 1 }] }), named("SceneError", "`body[0].mesh` is a function"));
    const circle = {};
    circle.body = circle;
    assert.throws(() => new Simulation(circle), named("SceneError", "nested"));
    assert.throws(() => new Simulation(TEXT, { precision: "f16" }), named("InputError", '"f32" or "f64"'));
  });

  await suite.test("arrays are copies, given arrays are filled, and views see the same", () => {
    const simulation = new Simulation(TEXT);
    const start = simulation.positions("cloth");
    assert.equal(start.length, 90);
    simulation.step(5);
    const out = new Float32Array(90);
    assert.equal(simulation.positions("cloth", out), out);
    assert.notDeepEqual(start, out);
    assert.deepEqual(simulation.positionsView().slice(), out);
    assert.ok(simulation.velocities().some((v) => v !== 0));
    const normals = simulation.normals();
    assert.ok(Math.abs(Math.hypot(...normals.slice(0, 3)) - 1) < 1e-6);
    assert.equal(simulation.indices("cloth").length, 3 * simulation.bodies[0].triangles);
    assert.throws(() => simulation.positions("cloth", new Float32Array(3)), named("InputError", "out has 3 numbers; 90 would do"));
    assert.throws(() => simulation.positions("sheet"), named("InputError", "there is no body `sheet`"));
    const exact = new Simulation(TEXT, { precision: "f64" });
    exact.step(5);
    assert.ok(exact.positions64().every((x, i) => Math.abs(x - out[i]) < 1e-5));
  });

  await suite.test("pins hold and move, and let go", () => {
    const simulation = new Simulation(TEXT);
    simulation.pin("cloth", [29]);
    simulation.pin("cloth", 24, [0.1, 0.05, 0.2]);
    simulation.step();
    const places = simulation.positions("cloth");
    assert.deepEqual([...places.slice(72, 75)], [0.1, 0.05, 0.2].map(Math.fround));
    simulation.unpin("cloth", [24, 29]);
    simulation.step(20);
    assert.ok(simulation.positions("cloth")[73] < 0.04);
    assert.throws(() => simulation.pin("cloth", 30), named("InputError", "vertices 0 to 29, not 30"));
    assert.throws(() => simulation.pin("cloth", -1), named("InputError", "a vertex is -1"));
    assert.throws(() => simulation.pin("cloth", [1, 2], [1, 2]), named("InputError", "to has 2 numbers"));
    simulation.applyForce("cloth", [20, 21], [0, 1, 0]);
    simulation.step();
  });

  await suite.test("colliders move, and have a surface", () => {
    const simulation = new Simulation(TEXT);
    simulation.moveCollider("ball", [0, 0.02, 0]);
    simulation.step();
    assert.deepEqual([...simulation.colliderPose("ball")], [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0.02, 0, 1]);
    const turned = [0, 0, -1, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0.02, 0, 1];
    simulation.moveCollider("ball", turned);
    simulation.step();
    simulation.colliderPose("ball").forEach((x, i) => assert.ok(Math.abs(x - turned[i]) < 1e-12));
    const { positions } = simulation.colliderSurface("ball");
    for (let i = 0; i < positions.length; i += 3) {
      const far = Math.hypot(positions[i], positions[i + 1] + 0.4, positions[i + 2]);
      assert.ok(Math.abs(far - 0.1) < 1e-6);
    }
    assert.throws(() => simulation.moveCollider("ball", [1, 2]), named("InputError", "a pose is a shift of 3 numbers"));
    assert.throws(() => simulation.moveCollider("ball", new Array(16).fill(2)), named("InputError", "last row"));
  });

  await suite.test("every shape of a collider has a surface that turns outward", () => {
    const box = { vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], faces: [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]] };
    const shapes = {
      sphere: { center: [0, 0, 0], radius: 0.5 }, box: { center: [0, 0, 0], half: [0.5, 0.4, 0.3] },
      capsule: { a: [0, 0, 0], b: [0.3, 0.5, 0], radius: 0.2 }, cylinder: { a: [0, 0, 0], b: [0, 0, 0.4], radius: 0.2 },
      mesh: box, convex: box,
    };
    const collider = Object.entries(shapes).map(([key, shape]) => ({ name: key, [key]: shape, place: { position: [5, 0, 0] } }));
    const simulation = new Simulation({ ...OBJECT, collider });
    for (const { name } of simulation.colliders) {
      const { positions, indices } = simulation.colliderSurface(name);
      let volume = 0;
      for (let t = 0; t < indices.length; t += 3) {
        const [a, b, c] = [0, 1, 2].map((k) => positions.slice(3 * indices[t + k], 3 * indices[t + k] + 3));
        volume += (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])) / 6;
      }
      const known = {
        sphere: (4 / 3) * Math.PI * 0.125, box: 8 * 0.06, capsule: Math.PI * 0.04 * (Math.hypot(0.3, 0.5) + (4 / 3) * 0.2),
        cylinder: Math.PI * 0.04 * 0.4, mesh: 1 / 6, convex: 1 / 6,
      };
      assert.ok(Math.abs(volume / known[name] - 1) < 0.02, `${name}: ${volume} in place of ${known[name]}`);
    }
  });

  await suite.test("meshes come as bytes or as arrays", () => {
    const obj = new TextEncoder().encode("v 0 0 0\nv 1 0 0\nv 0 0 1\nv 1 0 1\nf 1 3 2\nf 2 3 4\n");
    const body = (mesh) => ({ ...OBJECT, collider: [], body: [{ ...OBJECT.body[0], mesh, pin: [] }] });
    assert.deepEqual(filesOf(body({ file: "kite.obj" })), ["kite.obj"]);
    const hashes = [
      new Simulation(body({ file: "kite.obj" }), { files: { "kite.obj": obj } }),
      new Simulation(body({ file: "kite.obj" }), { files: new Map([["kite.obj", obj.buffer]]) }),
      new Simulation(body({ vertices: [[0, 0, 0], [1, 0, 0], [0, 0, 1], [1, 0, 1]], faces: [[0, 2, 1], [1, 2, 3]] })),
      new Simulation(body({ vertices: new Float32Array([0, 0, 0, 1, 0, 0, 0, 0, 1, 1, 0, 1]), faces: new Uint16Array([0, 2, 1, 1, 2, 3]) })),
    ].map((simulation) => {
      simulation.step(3);
      return simulation.stateHash();
    });
    assert.equal(new Set(hashes).size, 1, hashes.join());
    assert.throws(() => new Simulation(body({ file: "kite.obj" })), named("SceneError", "`kite.obj` was not given"));
    assert.throws(() => new Simulation(body({ vertices: [0, 0], faces: [0] })), named("SceneError", "`body[0].mesh.vertices` has 2 numbers"));
    assert.throws(() => new Simulation(body({ vertices: [[0, 0, 0]], faces: [[0, 0.5, 1]] })), named("SceneError", "names vertex 0.5"));
    assert.throws(() => new Simulation(TEXT, { files: { a: "text" } }), named("InputError", "`a` is no Uint8Array"));
  });

  await suite.test("the world changes while it runs", () => {
    const simulation = new Simulation(TEXT);
    simulation.setWorld({ gravity: [0, 2, 0] });
    assert.deepEqual(simulation.world.gravity, [0, 2, 0]);
    simulation.step(10);
    assert.ok(simulation.positions("cloth")[85] > 0);
    assert.throws(() => simulation.setWorld({ gravty: 1 }), named("InputError", "did you mean `gravity`?"));
    assert.throws(() => simulation.setWorld({ air: {} }), named("InputError", "without air"));
  });

  await suite.test("a snapshot is taken up bit by bit", () => {
    const simulation = new Simulation(TEXT);
    simulation.step(3);
    const kept = simulation.snapshot();
    simulation.step(4);
    const hash = simulation.stateHash();
    simulation.restore(kept);
    assert.equal(simulation.frame, 3);
    simulation.step(4);
    assert.equal(simulation.stateHash(), hash);
    assert.throws(() => simulation.restore(kept.slice(10)), named("SnapshotError", "the snapshot is"));
    const stiff = new Simulation(TEXT, { set: ["body.cloth.springs.structural.k=21"] });
    assert.throws(() => stiff.restore(kept), named("SnapshotError", "of another scene"));
    stiff.adoptState(simulation);
    assert.deepEqual(stiff.positions(), simulation.positions());
  });

  await suite.test("what diverges says so", () => {
    const simulation = new Simulation(TEXT, { set: ["body.cloth.springs.structural.k=1e7"] });
    assert.ok(simulation.warnings.some((words) => words.includes("step")));
    assert.throws(() => simulation.step(50), (error) => {
      named("DivergedError", "cloth", "max_step")(error);
      return error.body === "cloth" && error.frame > 0 && error.cause.length > 0;
    });
  });

  await suite.test("what is freed is gone, and its memory is used again", () => {
    const simulation = new Simulation(TEXT);
    simulation.free();
    simulation.free();
    assert.ok(simulation.isFreed);
    assert.throws(() => simulation.step(), named("InputError", "was freed"));
    assert.throws(() => new Simulation(TEXT).step(-1), named("InputError", "frames is -1"));
  });

  await suite.test("a mistake of ours is an error that says so", () => {
    raw.initSync({ module: fs.readFileSync(new URL("../package/build/taffeta_web_bg.wasm", import.meta.url)) });
    assert.throws(() => raw.panicForTest(), named("InternalError", "a mistake in taffeta, please report it", "on purpose"));
  });
});
