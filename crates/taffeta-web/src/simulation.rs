//! The class `Simulation`, as JavaScript sees it; `web/package` wraps it.

use crate::document::{self, Document};
use crate::errors::{Failure, advised};
use crate::mesh::flat;
use crate::scene::{Read, given};
use crate::{colliders, report};
use js_sys::Uint8Array;
use taffeta::glam::{DAffine3, DMat4};
use taffeta::scene::{Scene, World, identity};
use taffeta::{BodyHandle, InputError, OnDivergence, Options, Pose, Precision};
use taffeta_io::Checkpoint;
use taffeta_io::checkpoint::difference;
use taffeta_io::program::{changed, pose};
use wasm_bindgen::JsValue;
use wasm_bindgen::prelude::wasm_bindgen;

/// A scene that runs.
#[wasm_bindgen]
pub struct Simulation {
    pub(crate) simulation: taffeta::Simulation,
    pub(crate) rows: Vec<[f32; 3]>,
    scene: Scene,
    /// The world as it is.
    world: World,
    /// What was said when the scene was read.
    notes: Vec<String>,
}

/// A word among choices.
fn chosen<T: Copy>(name: &str, word: &str, all: &[(&str, T)]) -> Result<T, Failure> {
    all.iter().find(|(one, _)| *one == word).map(|(_, choice)| *choice).ok_or_else(|| {
        let words: Vec<String> = all.iter().map(|(one, _)| format!("\"{one}\"")).collect();
        Failure::input(format!("{name} is {word:?}; {} would do", words.join(" or ")))
    })
}

/// A pose: a shift of three numbers, or a rigid matrix of sixteen, column by column as three.js and WebGL have them.
fn pose_of(value: &JsValue) -> Result<Pose, Failure> {
    let numbers = flat(value);
    if let Ok(shift) = <[f64; 3]>::try_from(&numbers[..]) {
        return Ok(pose::shift(shift));
    }
    let Ok(numbers) = <[f64; 16]>::try_from(numbers) else {
        let what = "a pose is a shift of 3 numbers, or a rigid matrix of 16, column by column";
        return Err(Failure::input(what));
    };
    pose::rigid(DMat4::from_cols_array(&numbers).transpose().to_cols_array_2d()).map_err(Failure::Input)
}

/// Vectors for so many vertices: one for all, or one each.
fn vectors(value: &JsValue, count: usize, what: &str) -> Result<Vec<[f64; 3]>, Failure> {
    let numbers = flat(value);
    match numbers.as_chunks() {
        ([one], []) => Ok(vec![*one; count]),
        (rows, []) if rows.len() == count => Ok(rows.to_vec()),
        _ => {
            let found = numbers.len();
            Err(Failure::input(format!(
                "{what} has {found} numbers; 3, or 3 for each of {count} vertices, would do"
            )))
        }
    }
}

impl Simulation {
    /// A body that has all these vertices, so that nothing is done by half.
    fn checked(&self, body: &str, vertices: &[u32]) -> Result<BodyHandle, Failure> {
        let handle = self.simulation.body(body)?;
        let count = self.simulation.bodies()[handle.index()].vertices;
        match vertices.iter().find(|vertex| **vertex as usize >= count) {
            Some(&vertex) => {
                let (body, vertex) = (body.to_owned(), vertex as usize);
                Err(InputError::NoVertex { body, vertex, vertices: count }.into())
            }
            None => Ok(handle),
        }
    }
}

#[wasm_bindgen]
impl Simulation {
    /// Builds a scene: TOML text that messages call `name`, or an object. `names` and `bytes` are the files that it names.
    #[wasm_bindgen(constructor)]
    pub fn new(
        scene: &JsValue,
        name: &str,
        sets: Vec<String>,
        names: Vec<String>,
        bytes: Vec<Uint8Array>,
        precision: &str,
        on_divergence: &str,
    ) -> Result<Self, JsValue> {
        let precisions = [("f32", Precision::F32), ("f64", Precision::F64)];
        let endings = [("stop", OnDivergence::Stop), ("freeze", OnDivergence::Freeze)];
        let options = Options {
            threads: Some(1),
            precision: chosen("precision", precision, &precisions)?,
            on_divergence: chosen("onDivergence", on_divergence, &endings)?,
            ..Options::default()
        };
        let read = Read::of(scene, name, &sets, &given(names, &bytes))?;
        let simulation = read.build(&options)?;
        let (scene, notes) = (read.loaded.scene, read.loaded.notes);
        let world = scene.world.clone();
        Ok(Self { simulation, rows: Vec::new(), scene, world, notes })
    }

    /// Runs frames.
    pub fn step(&mut self, frames: u32) -> Result<(), JsValue> {
        Ok(self.simulation.advance(frames).map(drop).map_err(Failure::from)?)
    }

    /// Runs a frame, and says how long each stage took [ms], by name.
    #[wasm_bindgen(js_name = stepTimed)]
    pub fn step_timed(&mut self) -> Result<JsValue, JsValue> {
        let times = self.simulation.step_timed().map_err(Failure::from)?;
        let object = crate::object::Object::new();
        Ok(times.into_iter().fold(object, |object, (stage, time)| object.with(stage, 1e3 * time)).into())
    }

    /// Report of the last frame, or of the start.
    pub fn report(&self) -> JsValue {
        report::object(&self.simulation)
    }

    /// Hash of positions and velocities, as the program prints it.
    #[wasm_bindgen(js_name = stateHash)]
    pub fn state_hash(&self) -> String {
        format!("{:016x}", self.simulation.state_hash())
    }

    /// Number of frames done.
    #[wasm_bindgen(getter)]
    pub fn frame(&self) -> u32 {
        self.simulation.frame()
    }

    /// Length of a frame [s].
    #[wasm_bindgen(getter)]
    pub fn dt(&self) -> f64 {
        self.simulation.dt()
    }

    /// What should be known before it runs.
    #[wasm_bindgen(getter)]
    pub fn warnings(&self) -> Vec<String> {
        let warnings = self.simulation.warnings().iter();
        self.notes.iter().cloned().chain(warnings.map(|warning| advised(warning, &warning.advice))).collect()
    }

    /// Names of bodies that diverged and stand still.
    #[wasm_bindgen(getter)]
    pub fn frozen(&self) -> Vec<String> {
        self.simulation.frozen().iter().map(|one| one.why.body.clone()).collect()
    }

    /// Memory that state, springs and lists of contacts take [byte].
    #[wasm_bindgen(getter)]
    pub fn memory(&self) -> f64 {
        self.simulation.memory() as f64
    }

    /// Pins vertices, and moves them to places [m] during the next frame; where they are, if there are none.
    pub fn pin(&mut self, body: &str, vertices: Vec<u32>, to: &JsValue) -> Result<(), JsValue> {
        let handle = self.checked(body, &vertices)?;
        let to = if to.is_undefined() || to.is_null() {
            let first = self.rows_of(Some(body))?.start;
            let mut all: Vec<[f64; 3]> = Vec::new();
            self.simulation.positions_f64(&mut all);
            vertices.iter().map(|&vertex| all[first + vertex as usize]).collect()
        } else {
            vectors(to, vertices.len(), "to")?
        };
        for (&vertex, place) in vertices.iter().zip(to) {
            self.simulation.pin_vertex(handle, vertex as usize, place).map_err(Failure::from)?;
        }
        Ok(())
    }

    /// Frees vertices that `pin` has pinned.
    pub fn unpin(&mut self, body: &str, vertices: Vec<u32>) -> Result<(), JsValue> {
        let handle = self.checked(body, &vertices)?;
        for vertex in vertices {
            self.simulation.unpin_vertex(handle, vertex as usize).map_err(Failure::from)?;
        }
        Ok(())
    }

    /// Applies forces [N] to vertices during the next frame.
    #[wasm_bindgen(js_name = applyForce)]
    pub fn apply_force(&mut self, body: &str, vertices: Vec<u32>, force: &JsValue) -> Result<(), JsValue> {
        let handle = self.checked(body, &vertices)?;
        let forces = vectors(force, vertices.len(), "force")?;
        for (&vertex, force) in vertices.iter().zip(forces) {
            self.simulation.apply_force(handle, vertex as usize, force).map_err(Failure::from)?;
        }
        Ok(())
    }

    /// Brings the nodes of a pin of the scene to a pose during the next frame.
    #[wasm_bindgen(js_name = movePin)]
    pub fn move_pin(&mut self, body: &str, pin: u32, to: &JsValue) -> Result<(), JsValue> {
        let to = pose_of(to)?;
        let body = self.simulation.body(body).map_err(Failure::from)?;
        let pin = self.simulation.pin(body, pin as usize).map_err(Failure::from)?;
        Ok(self.simulation.move_pin(pin, to).map_err(Failure::from)?)
    }

    /// Brings a collider to a pose during the next frame.
    #[wasm_bindgen(js_name = moveCollider)]
    pub fn move_collider(&mut self, collider: &str, to: &JsValue) -> Result<(), JsValue> {
        let to = pose_of(to)?;
        let collider = self.simulation.collider(collider).map_err(Failure::from)?;
        Ok(self.simulation.move_collider(collider, to).map_err(Failure::from)?)
    }

    /// Where a collider has been brought from its start: a matrix, column by column.
    #[wasm_bindgen(js_name = colliderPose)]
    pub fn collider_pose(&self, collider: &str, fraction: f64) -> Result<Vec<f64>, JsValue> {
        if !(0.0..=1.0).contains(&fraction) {
            return Err(Failure::input(format!("fraction is {fraction}; 0 to 1 would do")).into());
        }
        let collider = self.simulation.collider(collider).map_err(Failure::from)?;
        let pose: DAffine3 = self.simulation.collider_pose(collider, fraction).map_err(Failure::from)?;
        Ok(DMat4::from(pose).to_cols_array().to_vec())
    }

    /// The surface of a collider, to be drawn: where its vertices are at the start, or now if they move of themselves.
    #[wasm_bindgen(js_name = colliderSurface)]
    pub fn collider_surface(&self, collider: &str) -> Result<colliders::Surface, JsValue> {
        let handle = self.simulation.collider(collider).map_err(Failure::from)?;
        let mut surface =
            colliders::surface(&self.scene.colliders[handle.index()]).map_err(Failure::scene)?;
        let nodes = self.simulation.collider_nodes(handle, 1.0).map_err(Failure::from)?;
        if let Some(nodes) = nodes {
            surface.places = nodes;
        }
        Ok(surface)
    }

    /// The colliders, in the scene's order.
    pub fn colliders(&self) -> JsValue {
        colliders::list(self.simulation.colliders())
    }

    /// Changes gravity, drag, wind and air from the next frame on.
    #[wasm_bindgen(js_name = setWorld)]
    pub fn set_world(&mut self, changes: &JsValue) -> Result<(), JsValue> {
        let world = changed(Document::of(changes)?.table, &self.world).map_err(Failure::Input)?;
        self.simulation.set_world(&world).map_err(Failure::from)?;
        self.world = world;
        Ok(())
    }

    /// Gravity, drag, wind and air as they are now.
    pub fn world(&self) -> Result<JsValue, JsValue> {
        let world = toml::Value::try_from(&self.world);
        Ok(document::to_js(&world.map_err(|error| Failure::Internal(error.to_string()))?))
    }

    /// Moves every free node by up to `amplitude` [m] along each axis, at random but the same for the same seed.
    pub fn disturb(&mut self, amplitude: f64, seed: u32) -> Result<(), JsValue> {
        if !amplitude.is_finite() {
            return Err(Failure::input(format!("amplitude is {amplitude}; a finite number would do")).into());
        }
        self.simulation.disturb(amplitude, seed.into());
        Ok(())
    }

    /// Force with which a pin of the scene holds its nodes [N]; undefined at the start, and for pins that break.
    pub fn reaction(&self, body: &str, pin: u32) -> Result<Option<Vec<f64>>, JsValue> {
        let body = self.simulation.body(body).map_err(Failure::from)?;
        let pin = self.simulation.pin(body, pin as usize).map_err(Failure::from)?;
        let force = self.simulation.reaction(pin).map_err(Failure::from)?;
        Ok(force.map(|force| force.to_array().to_vec()))
    }

    /// The state as the bytes of a checkpoint.
    pub fn snapshot(&self) -> Result<Vec<u8>, JsValue> {
        let snapshot = self.simulation.snapshot();
        if snapshot.halted {
            let frame = snapshot.report.frame;
            let what = format!(
                "the frame after frame {frame} diverged, and none goes on from there; a snapshot from before would do"
            );
            return Err(Failure::Snapshot(what).into());
        }
        let checkpoint = Checkpoint { scene: identity(&self.scene), snapshot, run: () };
        Ok(checkpoint.to_bytes().map_err(Failure::Snapshot)?)
    }

    /// Takes up the state of a checkpoint of the same scene.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), JsValue> {
        let refuse = |what: String| Failure::Snapshot(format!("the snapshot is {what}"));
        let checkpoint = Checkpoint::<()>::parse(bytes).map_err(refuse)?;
        if let Some(difference) = difference(&checkpoint.scene, &identity(&self.scene)) {
            return Err(refuse(format!("of another scene: {difference}")).into());
        }
        self.simulation.restore(&checkpoint.snapshot).map_err(Failure::from)?;
        self.world = checkpoint.snapshot.changes.world.clone();
        Ok(())
    }

    /// Goes on where a simulation of another scene is.
    #[wasm_bindgen(js_name = adoptState)]
    pub fn adopt_state(&mut self, other: &Self) {
        self.simulation.adopt_state(&other.simulation);
    }
}
