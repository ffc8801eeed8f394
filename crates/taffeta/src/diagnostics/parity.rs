//! Rows of the sums at the end of a frame. The GPU adds up in 32 bits within a workgroup, the CPU in 64; so a sum is
//! compared in units in the last place of the sum of its terms' sizes.

use crate::assembly::body::BodyAssembly;
use crate::backend::Backend;
use crate::cpu::CpuBackend;
use crate::diagnostics::gpu::NODE_SUMS;
use crate::elements::spring::cpu::Springs;
use crate::gpu::kernels::Name;
use crate::gpu::layout::Four;
use crate::parity::bench::{Bench, Given, Written};
use crate::parity::fixture::Fixture;
use crate::parity::row::{Row, Tolerance};
use crate::real::{cross, dot, sub};
use crate::report::{FrameSums, StateSums};
use crate::solvers::explicit::parity::{fixtures, kernel_of};

/// A lane adds up some terms of few operations each, then come eight levels of a tree: each rounds by half a unit.
const TREE: Tolerance = Tolerance::new(
    16.0,
    24.0,
    "the GPU adds up in 32 bits, some terms by lane, then eight levels of a tree; the CPU in 64",
);
/// One row for each kernel.
pub const ROWS: &[Row] = &[
    row("measure_nodes", TREE, nodes),
    row("measure_grid_springs", TREE, grid_springs),
    row("measure_mesh_springs", TREE, mesh_springs),
    row("measure_volumes", TREE, volumes),
];

const fn row(
    name: &'static str,
    tolerance: Tolerance,
    check: fn(&mut Bench<'_>) -> Result<(), String>,
) -> Row {
    Row { name, entry: name, tolerance, check }
}

/// What the CPU measures.
pub fn measured(fixture: &mut Fixture) -> Result<FrameSums, String> {
    fixture.cpu.measure().and_then(|()| fixture.cpu.sums()).map_err(|lost| lost.0)
}

/// Runs a kernel in few workgroups, each of which then goes through several portions, and in as many as are used;
/// `compare` is handed what they have written. A place more than there are workgroups must stay as it is.
pub fn sums(
    bench: &mut Bench<'_>,
    fixture: &Fixture,
    (entry, output, width): (&'static str, &'static str, usize),
    groups: &[usize],
    mut compare: impl FnMut(&mut Written<'_>, &[f32]),
) -> Result<(), String> {
    let kernel = kernel_of(bench, Name::new(entry), fixture)?;
    let records = fixture.records();
    for &groups in groups {
        let mut arrays = fixture.arrays();
        arrays.insert(output, vec![f32::NAN.to_bits(); width * (groups + 1)]);
        bench.run(&kernel, &Given { arrays: &arrays, records: &records, groups }, |written| {
            let found: Vec<f32> = written.take(output);
            let (sums, rest) = found.split_at(width * groups);
            written.outcome().copied(&format!("{output}, past its end"), &vec![f32::NAN; width], rest);
            compare(written, sums);
        })?;
    }
    Ok(())
}

/// The sum of every `width`-th number from `first` on.
pub fn total(numbers: &[f32], width: usize, first: usize) -> f32 {
    numbers.iter().skip(first).step_by(width).map(|&number| f64::from(number)).sum::<f64>() as f32
}

/// Compares a sum whose terms' sizes add up to `size`.
pub fn compare(written: &mut Written<'_>, name: &str, wanted: f64, found: f32, size: f64) {
    written.outcome().compare_to(name, &[wanted as f32], &[found], size);
}

fn nodes(bench: &mut Bench<'_>) -> Result<(), String> {
    for mut fixture in fixtures(bench)? {
        let all = measured(&mut fixture)?.all;
        let size = sizes(&fixture);
        let touched = fixture.old.velocity.iter().filter(|four| four[3] < 0.0).count() as f32;
        let groups = [1, 3, fixture.place_groups()];
        let places = ("measure_nodes", "node_sums", NODE_SUMS);
        sums(bench, &fixture, places, &groups, |written, found| {
            let found: [f32; NODE_SUMS] = std::array::from_fn(|i| total(found, NODE_SUMS, i));
            for (i, (name, sum)) in named(&all).into_iter().enumerate() {
                compare(written, name, sum, found[i], size[i]);
            }
            written.outcome().copied("nodes that touch, nodes that are odd", &[touched, 0.0], &found[10..]);
        })?;
        odd_nodes(bench, fixture)?;
    }
    Ok(())
}

/// Nodes that are not finite are counted.
fn odd_nodes(bench: &mut Bench<'_>, mut fixture: Fixture) -> Result<(), String> {
    let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -f32::NAN, f32::MAX, f32::MIN];
    let count = 2 * odd.iter().filter(|number| !number.is_finite()).count() as u32;
    for (i, number) in odd.into_iter().enumerate() {
        fixture.old.position[150 * i + 7][i % 3] = number;
        fixture.old.velocity[150 * i + 90][(i + 1) % 3] = number;
    }
    let places = ("measure_nodes", "node_sums", NODE_SUMS);
    sums(bench, &fixture, places, &[2], |written, found| {
        let found = total(found, NODE_SUMS, NODE_SUMS - 1);
        written.outcome().copied("nodes that are odd", &[count as f32], &[found]);
    })
}

fn named(all: &StateSums) -> [(&'static str, f64); 10] {
    let ([a, b, c], [d, e, f], [g, h, i]) = (all.m_x, all.momentum, all.angular_momentum);
    [
        ("m v²", all.m_v2),
        ("m x, x", a),
        ("m x, y", b),
        ("m x, z", c),
        ("m v, x", d),
        ("m v, y", e),
        ("m v, z", f),
        ("m x × v, x", g),
        ("m x × v, y", h),
        ("m x × v, z", i),
    ]
}

/// The sizes of the terms of each sum over nodes, added up.
fn sizes(fixture: &Fixture) -> [f64; 10] {
    let mut sizes = [0.0; 10];
    for (x, v) in fixture.old.position.iter().zip(&fixture.old.velocity) {
        let m = f64::from(v[3].abs());
        let three = |four: &Four| [0, 1, 2].map(|i| f64::from(four[i].abs()));
        let (x, v) = (three(x), three(v));
        sizes[0] += m * dot(v, v);
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            sizes[1 + i] += m * x[i];
            sizes[4 + i] += m * v[i];
            sizes[7 + i] += m * (x[j] * v[k] + x[k] * v[j]);
        }
    }
    sizes
}

fn grid_springs(bench: &mut Bench<'_>) -> Result<(), String> {
    let is_grid = |body: &BodyAssembly| body.grid_layout.is_some();
    springs(bench, ("measure_grid_springs", "grid_spring_sums", 2), |f| f.tables.springs.tiles.len(), is_grid)
}

fn mesh_springs(bench: &mut Bench<'_>) -> Result<(), String> {
    let is_mesh = |body: &BodyAssembly| body.grid_layout.is_none();
    springs(bench, ("measure_mesh_springs", "mesh_spring_sums", 2), |f| f.place_groups(), is_mesh)
}

fn springs(
    bench: &mut Bench<'_>,
    output: (&'static str, &'static str, usize),
    groups: fn(&Fixture) -> usize,
    chosen: fn(&BodyAssembly) -> bool,
) -> Result<(), String> {
    for mut fixture in fixtures(bench)? {
        measured(&mut fixture)?;
        let wanted = springs_of(&mut fixture.cpu, chosen);
        sums(bench, &fixture, output, &[1, 3, groups(&fixture)], |written, found| {
            compare(written, "energy", wanted[0], total(found, 2, 0), wanted[0]);
            let stretches = found.iter().skip(1).step_by(2);
            // A NaN is larger than all.
            let most = stretches.fold(0.0_f32, |most, &one| if one <= most { most } else { one });
            written.outcome().compare("stretch", &[wanted[1] as f32], &[most]);
        })?;
    }
    Ok(())
}

/// Energy [J] and largest stretch of the springs of some bodies, as last measured.
fn springs_of(cpu: &mut CpuBackend<f32>, chosen: impl Fn(&BodyAssembly) -> bool) -> [f64; 2] {
    let bodies: Vec<bool> = cpu.assembly().bodies.iter().map(chosen).collect();
    let tiles: Vec<bool> = cpu.nodes.tiles.iter().map(|tile| bodies[tile.body]).collect();
    let springs = cpu.feature::<Springs<f32>>().expect("every scene has some");
    springs.sums_of(|tile| tiles[tile])
}

fn volumes(bench: &mut Bench<'_>) -> Result<(), String> {
    for mut fixture in fixtures(bench)? {
        let wanted = measured(&mut fixture)?.volumes;
        let groups = [fixture.tables.volumes.chunks.len()];
        sums(bench, &fixture, ("measure_volumes", "volumes", 1), &groups, |written, found| {
            for (chunk, (&body, &found)) in fixture.tables.volumes.chunk_bodies.iter().zip(found).enumerate()
            {
                let size = sextet_sizes(&fixture, chunk) / 6.0;
                compare(written, &format!("volumes[{chunk}]"), wanted[body].unwrap_or(f64::NAN), found, size);
            }
        })?;
    }
    Ok(())
}

/// The sizes of six times the volumes under a chunk's triangles, added up.
fn sextet_sizes(fixture: &Fixture, chunk: usize) -> f64 {
    let chunk = &fixture.tables.volumes.chunks[chunk];
    let place = |node: u32| -> [f64; 3] {
        let four = fixture.old.position[node as usize];
        [0, 1, 2].map(|i| f64::from(four[i]))
    };
    let corners =
        fixture.tables.volumes.corners[3 * chunk.first as usize..][..3 * chunk.count as usize].chunks(3);
    let origin = place(chunk.origin);
    let size = |corners: &[u32]| {
        let [a, b, c] = [0, 1, 2].map(|i| sub(place(corners[i]), origin));
        let across = cross(b, c).map(f64::abs);
        dot(a.map(f64::abs), across)
    };
    corners.map(size).sum()
}
