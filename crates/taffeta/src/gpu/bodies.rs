//! Some whole bodies of a scene, whose nodes are counted from the first of them.

use crate::assembly::Assembly;
use crate::assembly::body::BodyAssembly;
use crate::gpu::layout::Four;
use crate::topology::LANES;
use std::ops::Range;

/// Some whole bodies of a scene that go to the device together.
#[derive(Clone)]
pub struct Bodies<'a> {
    /// The scene.
    pub assembly: &'a Assembly,
    /// Which of its bodies.
    pub range: Range<usize>,
    /// Their places among those of the scene.
    pub places: Range<usize>,
}

impl<'a> Bodies<'a> {
    /// Those of a range.
    pub fn new(assembly: &'a Assembly, range: Range<usize>) -> Self {
        let chosen = &assembly.bodies[range.clone()];
        let first = chosen.first().map_or(0, |body| body.first);
        let end = chosen.last().map_or(0, |body| body.first + body.places());
        Self { assembly, range, places: first..end }
    }

    /// The bodies with their numbers in the scene.
    pub fn iter(&self) -> impl Iterator<Item = (usize, &'a BodyAssembly)> + use<'a> {
        self.range.clone().zip(&self.assembly.bodies[self.range.clone()])
    }

    /// Number of places.
    #[allow(clippy::len_without_is_empty, reason = "bodies have places")]
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Number of slices of [`LANES`] places.
    pub fn slices(&self) -> usize {
        self.len() / LANES
    }

    /// Whether a place of the scene is one of theirs.
    pub fn has(&self, node: u32) -> bool {
        self.places.contains(&(node as usize))
    }

    /// Position [m] and inverse mass [1/kg], velocity [m/s] and mass [kg], by place.
    pub fn state(&self) -> [Vec<Four>; 2] {
        let [mut position, mut velocity] = [0, 1].map(|_| Vec::with_capacity(self.len()));
        for (_, body) in self.iter() {
            let masses = body.mass.iter().zip(&body.free);
            for (local, (place, (&mass, &free))) in body.start.iter().zip(masses).enumerate() {
                let [x, y, z] = place.map(|c| c as f32);
                position.push([x, y, z, if free { (1.0 / mass) as f32 } else { 0.0 }]);
                let [u, v, w] = body.start_velocity.get(local).copied().unwrap_or_default().map(|c| c as f32);
                velocity.push([u, v, w, mass as f32]);
            }
            let end = self.local(body.first + body.places()) as usize;
            position.resize(end, [0.0; 4]);
            velocity.resize(end, [0.0; 4]);
        }
        [position, velocity]
    }

    /// A place's number among theirs.
    pub fn local(&self, node: usize) -> u32 {
        (node - self.places.start) as u32
    }
}
