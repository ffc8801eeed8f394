// The sheet in Jolt: node jolt.mjs NODE_MODULES FOLDER FRAMES FRAME GRAVITY NODE_MASS PIN PIN ITERATIONS COMPLIANCE SHEAR TETHERS.
// FOLDER has start.f32 and faces.u32; it gets frames.f32 and times.json.
import { readFileSync, writeFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const [modules, folder, ...words] = process.argv.slice(2);
const [frames, duration, gravity, nodeMass, firstPin, secondPin, iterations, compliance, shear, tethers] = words.map(Number);
const build = `${modules}/jolt-physics/dist/jolt-physics.wasm-compat.js`;
const Jolt = await (await import(pathToFileURL(build))).default();

const start = new Float32Array(new Uint8Array(readFileSync(`${folder}/start.f32`)).buffer);
const faces = new Uint32Array(new Uint8Array(readFileSync(`${folder}/faces.u32`)).buffer);

// A world with one kind of object.
const config = new Jolt.JoltSettings();
const pairs = new Jolt.ObjectLayerPairFilterTable(1);
const layers = new Jolt.BroadPhaseLayerInterfaceTable(1, 1);
layers.MapObjectToBroadPhaseLayer(0, new Jolt.BroadPhaseLayer(0));
config.mObjectLayerPairFilter = pairs;
config.mBroadPhaseLayerInterface = layers;
config.mObjectVsBroadPhaseLayerFilter = new Jolt.ObjectVsBroadPhaseLayerFilterTable(layers, 1, pairs, 1);
const jolt = new Jolt.JoltInterface(config);
jolt.GetPhysicsSystem().SetGravity(new Jolt.Vec3(0, -gravity, 0));
const bodies = jolt.GetPhysicsSystem().GetBodyInterface();

function sheet() {
  const shared = new Jolt.SoftBodySharedSettings();
  const vertex = new Jolt.SoftBodySharedSettingsVertex();
  for (let i = 0; i < start.length; i += 3) {
    vertex.mPosition = new Jolt.Float3(...start.subarray(i, i + 3));
    vertex.mInvMass = [firstPin, secondPin].includes(i / 3) ? 0 : 1 / nodeMass;
    shared.mVertices.push_back(vertex);
  }
  for (let i = 0; i < faces.length; i += 3) {
    shared.AddFace(new Jolt.SoftBodySharedSettingsFace(...faces.subarray(i, i + 3), 0));
  }
  const attributes = new Jolt.SoftBodySharedSettingsVertexAttributes();
  attributes.mCompliance = compliance;
  attributes.mShearCompliance = shear;
  const { SoftBodySharedSettings_ELRAType_None: none, SoftBodySharedSettings_ELRAType_GeodesicDistance: along } = Jolt;
  attributes.mLRAType = tethers ? along : none;
  shared.CreateConstraints(attributes, 1, Jolt.SoftBodySharedSettings_EBendType_None);
  shared.Optimize();
  const creation = new Jolt.SoftBodyCreationSettings(shared, new Jolt.RVec3(0, 0, 0), new Jolt.Quat(0, 0, 0, 1), 0);
  creation.mNumIterations = iterations;
  creation.mLinearDamping = 0;
  creation.mUpdatePosition = false;
  creation.mAllowSleeping = false;
  const body = bodies.CreateSoftBody(creation);
  bodies.AddBody(body.GetID(), Jolt.EActivation_Activate);
  return body;
}

const out = new Float32Array((frames + 1) * start.length);

function swing(body) {
  const vertices = Jolt.castObject(body.GetMotionProperties(), Jolt.SoftBodyMotionProperties).GetVertices();
  let [cpu, wall] = [0, 0];
  for (let frame = 0; frame <= frames; frame++) {
    if (frame > 0) {
      const [before, since] = [process.cpuUsage(), performance.now()];
      jolt.Step(duration, 1);
      wall += (performance.now() - since) / 1e3;
      const { user, system } = process.cpuUsage(before);
      cpu += (user + system) / 1e6;
    }
    for (let i = 0; i < vertices.size(); i++) {
      const at = vertices.at(i).mPosition;
      out.set([at.GetX(), at.GetY(), at.GetZ()], frame * start.length + 3 * i);
    }
  }
  return { cpu, wall };
}

// In a first run node compiles what it runs often; the second one counts.
const first = sheet();
swing(first);
bodies.RemoveBody(first.GetID());
const times = swing(sheet());
writeFileSync(`${folder}/frames.f32`, out);
writeFileSync(`${folder}/times.json`, JSON.stringify(times));
