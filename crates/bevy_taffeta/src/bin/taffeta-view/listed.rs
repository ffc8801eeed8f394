//! The springs of the scene that runs, by vertex: what pictures of strain and of springs need.

use bevy::prelude::*;
use bevy_taffeta::taffeta::springs::SpringKind;
use bevy_taffeta::taffeta::springs_of;
use bevy_taffeta::{DrawnBody, Running};

/// The springs of each body, made when they are first asked for.
#[derive(Resource, Default)]
pub struct Listed {
    /// Which of the simulations that were built they are of.
    built: Option<u64>,
    bodies: Vec<Vec<Springs>>,
}

/// Springs of one kind.
pub struct Springs {
    /// What they are for.
    pub kind: SpringKind,
    /// Vertices of the body at their ends.
    pub ends: Vec<[u32; 2]>,
    /// Lengths at rest [m].
    pub rest: Vec<f32>,
}

impl Listed {
    /// Those of the simulation as it is.
    pub fn of(&mut self, running: &Running) -> &[Vec<Springs>] {
        if self.built != Some(running.built()) {
            self.built = Some(running.built());
            self.bodies = running.drawn_bodies().map(|body| springs_by_vertex(running, &body)).collect();
        }
        &self.bodies
    }
}

fn springs_by_vertex(running: &Running, body: &DrawnBody) -> Vec<Springs> {
    let (drawn, body) = (body.mesh, body.handle.index());
    let mut of_node = vec![0; running.simulation().bodies()[body].nodes];
    for (&vertex, &node) in
        drawn.vertices.iter().zip(&drawn.nodes).rev().filter(|(_, node)| **node != u32::MAX)
    {
        of_node[node as usize] = vertex;
    }
    let vertex = |node: u32| of_node[node as usize];
    // The scene runs, so it is one that can be simulated.
    let lists = springs_of(running.scene(), body).unwrap_or_default();
    let by_vertex = lists.into_iter().map(|list| Springs {
        kind: list.kind,
        ends: list.pairs.into_iter().map(|pair| pair.map(vertex)).collect(),
        rest: list.rest.into_iter().map(|rest| rest as f32).collect(),
    });
    by_vertex.collect()
}
