//! Friction of pairs that a scene names.

use crate::assembly::Assembly;
use crate::scene::Scene;
use crate::scene::Side;
use std::collections::HashMap;

/// The friction of some pairs.
#[derive(Clone, Debug, Default)]
pub struct Frictions {
    /// Of two bodies, the lower number first.
    bodies: HashMap<[usize; 2], f64>,
    /// Of a body and a collider.
    colliders: HashMap<[usize; 2], f64>,
}

impl Frictions {
    /// Of two bodies, if the scene says it.
    pub fn of_bodies(&self, a: usize, b: usize) -> Option<f64> {
        self.bodies.get(&[a.min(b), a.max(b)]).copied()
    }

    /// Of a body and a collider, if the scene says it.
    pub fn of_collider(&self, body: usize, collider: usize) -> Option<f64> {
        self.colliders.get(&[body, collider]).copied()
    }

    /// Bodies that have another friction with some collider than others, ascending.
    pub fn bodies_with_colliders(&self) -> Vec<usize> {
        let mut all: Vec<usize> = self.colliders.keys().map(|&[body, _]| body).collect();
        all.sort_unstable();
        all.dedup();
        all
    }
}

impl Assembly {
    /// The friction of pairs that the scene names.
    pub fn frictions(&self) -> &Frictions {
        static NONE: std::sync::LazyLock<Frictions> = std::sync::LazyLock::new(Frictions::default);
        self.extensions.get().unwrap_or(&NONE)
    }

    /// Adds those of a scene that was checked.
    pub(crate) fn add_frictions(&mut self, scene: &Scene) {
        let mut all = Frictions::default();
        for pair in &scene.frictions {
            match scene.sides(pair) {
                Some([Side::Body(a), Side::Body(b)]) => all.bodies.insert([a, b], pair.value),
                Some([Side::Body(body), Side::Collider(collider)]) => {
                    all.colliders.insert([body, collider], pair.value)
                }
                _ => None,
            };
        }
        if !scene.frictions.is_empty() {
            self.extensions.insert(all);
        }
    }
}
