//! The row of vertices that a renderer draws.

use crate::backend::Backend;
use crate::diagnostics::normals::{sums, unit_or_up};
use crate::gpu::drawn::Drawing;
use crate::gpu::kernels::Name;
use crate::gpu::layout::{Four, GROUP, NONE};
use crate::parity::bench::{Bench, Given};
use crate::parity::row::{Row, Tolerance};
use crate::real::dot;
use crate::solvers::explicit::parity::fixtures;
use crate::topology::Csr;
use taffeta_gpu::bytemuck::cast_slice;

const SAME: &str = "sums, products, quotients and roots in the same order; hardware may fuse them";

/// One row for each kernel.
pub const ROWS: &[Row] = &[Row {
    name: "draw_vertices",
    entry: "draw_vertices",
    tolerance: Tolerance::new(0.0, 64.0, SAME),
    check: draw_vertices,
}];

/// Of the ball, half a dozen words a vertex and one between; the last vertex has no node.
fn draw_vertices(bench: &mut Bench<'_>) -> Result<(), String> {
    let kernel = bench.kernel(Name::new("draw_vertices"), &[])?;
    let parameters = Drawing {
        place_x: [0.8, 0.1, -0.2, 1.5],
        place_y: [-0.1, 0.9, 0.3, -2.5],
        place_z: [0.2, -0.3, 0.7, 0.5],
        normal_x: [1.1, 0.2, -0.1, 0.0],
        normal_y: [0.1, 1.2, 0.3, 0.0],
        normal_z: [-0.3, 0.2, 0.9, 0.0],
        alpha: 0.3,
        first: 5,
        stride: 7,
        normal: 4,
    };
    for fixture in fixtures(bench)? {
        let body = &fixture.cpu.assembly().bodies[1];
        let triangles = body.user_surface().triangles;
        let by_node = Csr::corners(body.nodes, &triangles);
        let place = |node: usize| body.solver_index(node) as u32;
        let (old, new) = (&fixture.old.position, swirled(&fixture.old.position));
        let shown: Vec<[f32; 3]> = (0..body.nodes)
            .map(|node| place(node) as usize)
            .map(|at| std::array::from_fn(|i| old[at][i] + parameters.alpha * (new[at][i] - old[at][i])))
            .collect();
        let mut wanted = vec![f32::NAN; 5 + 7 * (body.nodes + 1)];
        for (node, sum) in sums(&shown, &triangles).into_iter().enumerate() {
            let words = &mut wanted[5 + 7 * node..];
            words[..3].copy_from_slice(
                &[parameters.place_x, parameters.place_y, parameters.place_z]
                    .map(|[a, b, c, shift]| dot([a, b, c], shown[node]) + shift),
            );
            let turned = [parameters.normal_x, parameters.normal_y, parameters.normal_z]
                .map(|[a, b, c, _]| dot([a, b, c], sum));
            words[4..7].copy_from_slice(&unit_or_up(turned));
        }
        let mut nodes: Vec<u32> = (0..body.nodes).flat_map(|node| [place(node), node as u32]).collect();
        nodes.extend([NONE; 2]);
        let mut arrays = fixture.arrays();
        arrays.insert("drawing", cast_slice(&[parameters]).to_vec());
        arrays
            .insert("triangle_places", triangles.as_flattened().iter().map(|&n| place(n as usize)).collect());
        arrays.insert("corner_starts", by_node.offsets);
        arrays.insert("node_corners", by_node.items);
        arrays.insert("drawn_nodes", nodes);
        arrays.insert("new_position", cast_slice(&new).to_vec());
        arrays.insert("vertices", vec![f32::NAN.to_bits(); wanted.len()]);
        let groups = (body.nodes + 1).div_ceil(GROUP);
        let given = Given { arrays: &arrays, records: &fixture.records(), groups };
        bench.run(&kernel, &given, |written| {
            let found = written.take("vertices");
            written.outcome().compare("vertices", &wanted, &found);
        })?;
    }
    Ok(())
}

/// Places somewhat further on, each its own way.
fn swirled(places: &[Four]) -> Vec<Four> {
    places.iter().map(|&[x, y, z, w]| [x + 0.1 * y, y - 0.2 * z, z + 0.05 * x, w]).collect()
}
