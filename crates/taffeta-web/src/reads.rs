//! What a program reads of a simulation: bodies, places, normals, triangles.

use crate::errors::Failure;
use crate::object::{Object, list, or_null};
use crate::simulation::Simulation;
use js_sys::Float32Array;
use std::ops::Range;
use taffeta_io::output::triangles_of;
use wasm_bindgen::JsValue;
use wasm_bindgen::prelude::wasm_bindgen;

/// What has three numbers a vertex.
#[wasm_bindgen]
#[derive(Clone, Copy)]
pub enum Quantity {
    /// Places [m].
    Positions,
    /// Velocities [m/s].
    Velocities,
    /// Unit normals, area-weighted.
    Normals,
}

impl Simulation {
    /// The vertices of a body, or all, among those of all bodies one after the other.
    pub(crate) fn rows_of(&self, body: Option<&str>) -> Result<Range<usize>, Failure> {
        let counts = self.simulation.bodies().iter().map(|body| body.vertices);
        let Some(name) = body else { return Ok(0..counts.sum()) };
        let index = self.simulation.body(name)?.index();
        let first: usize = counts.take(index).sum();
        Ok(first..first + self.simulation.bodies()[index].vertices)
    }

    fn fill(&mut self, quantity: Quantity, body: Option<&str>) -> Result<Range<usize>, Failure> {
        let chosen = self.rows_of(body)?;
        let Self { simulation, rows, .. } = self;
        match quantity {
            Quantity::Positions => simulation.positions_f32(rows),
            Quantity::Velocities => simulation.velocities_f32(rows),
            Quantity::Normals => {
                rows.clear();
                for body in simulation.bodies() {
                    rows.extend(simulation.normals::<[f32; 3]>(body.handle)?);
                }
            }
        }
        Ok(chosen)
    }
}

#[wasm_bindgen]
impl Simulation {
    /// A quantity of a body's vertices, or of all: a new array, or `out`, which must have as many numbers.
    pub fn read(
        &mut self,
        quantity: Quantity,
        body: Option<String>,
        out: Option<Float32Array>,
    ) -> Result<Float32Array, JsValue> {
        let chosen = self.fill(quantity, body.as_deref())?;
        let numbers = self.rows[chosen].as_flattened();
        let Some(out) = out else { return Ok(Float32Array::from(numbers)) };
        if out.length() as usize != numbers.len() {
            let (has, needs) = (out.length(), numbers.len());
            return Err(Failure::input(format!("out has {has} numbers; {needs} would do")).into());
        }
        out.copy_from(numbers);
        Ok(out)
    }

    /// The same without a copy: a view of the engine's memory, which whatever is called next may move or change.
    pub fn view(&mut self, quantity: Quantity, body: Option<String>) -> Result<Float32Array, JsValue> {
        let chosen = self.fill(quantity, body.as_deref())?;
        // SAFETY: what it views lives in `self`; that it is not used after the next call is what its documentation asks for.
        Ok(unsafe { Float32Array::view(self.rows[chosen].as_flattened()) })
    }

    /// Positions of a body's vertices, or of all, in 64 bits [m].
    #[wasm_bindgen(js_name = positions64)]
    pub fn positions_64(&self, body: Option<String>) -> Result<Vec<f64>, JsValue> {
        let chosen = self.rows_of(body.as_deref())?;
        let mut all: Vec<[f64; 3]> = Vec::new();
        self.simulation.positions_f64(&mut all);
        Ok(all[chosen].as_flattened().to_vec())
    }

    /// Triangles by their vertices: those of a body, counted from its first vertex, or those of all.
    pub fn faces(&self, body: Option<String>) -> Result<Vec<u32>, JsValue> {
        if let Some(name) = body {
            let handle = self.simulation.body(&name).map_err(Failure::from)?;
            let surface = self.simulation.surface(handle).map_err(Failure::from)?;
            return Ok(triangles_of(&surface).into_flattened());
        }
        let (mut all, mut first) = (Vec::new(), 0);
        for body in self.simulation.bodies() {
            let surface = self.simulation.surface(body.handle).map_err(Failure::from)?;
            all.extend(triangles_of(&surface).as_flattened().iter().map(|vertex| vertex + first));
            first += body.vertices as u32;
        }
        Ok(all)
    }

    /// The bodies, in the scene's order.
    pub fn bodies(&self) -> JsValue {
        let mut first = 0;
        list(self.simulation.bodies().iter().map(|body| {
            let springs: usize = body.springs.iter().map(|(_, count)| count).sum();
            let object = Object::new()
                .with("name", &body.name)
                .with("first", first as u32)
                .with("vertices", body.vertices as u32)
                .with("nodes", body.nodes as u32)
                .with("triangles", body.triangles as u32)
                .with("springs", springs as u32)
                .with("pins", body.pins as u32)
                .with("pinned", body.pinned as u32)
                .with("mass", body.mass)
                .with("restVolume", or_null(body.rest_volume))
                .with("repairs", body.repairs.clone());
            first += body.vertices;
            object
        }))
    }

    /// Distances of all vertices from colliders [m], up to `reach` [m].
    #[wasm_bindgen(js_name = colliderDistances)]
    pub fn collider_distances(&self, reach: f64) -> Vec<f32> {
        let mut distances = Vec::new();
        self.simulation.collider_distances(reach, &mut distances);
        distances
    }

    /// Where bodies pass through themselves, each other and colliders made of triangles, by exact arithmetic.
    pub fn intersections(&self) -> JsValue {
        let found = self.simulation.intersections();
        Object::new()
            .with("pairs", found.pairs as f64)
            .with("first", or_null(found.first))
            .with("complete", found.complete)
            .into()
    }
}
