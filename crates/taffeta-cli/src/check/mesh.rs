//! Measures a mesh and judges it.

use super::report::*;
use super::sample::Sample;
use super::{Args, MeshKind, advice, words};
use crate::console::{self, grouped};
use std::sync::Arc;
use taffeta::topology::{Edges, Inspection, Intersections, NoInside, Surface, no_inside, self_intersections};
use taffeta_io::MeshOptions;
use taffeta_io::program::{Failure, complain};

/// How many edges, vertices and pairs are named.
const NAMED: usize = 8;
/// How many components are listed.
const COMPONENTS: usize = 20;
/// Triangles from which on the search for those that meet takes more than a moment, and filling holes is not tried.
const MANY: usize = 1_000_000;

/// Checks a mesh. One that is refused is reported all the same.
pub fn check(args: &Args) -> Result<(), Failure> {
    let options = MeshOptions { fill_holes: args.fill_holes, ..MeshOptions::default() };
    let surface = taffeta_io::load_mesh(&args.path, &options).map_err(|e| Failure::Input(e.to_string()))?;
    if surface.triangles.len() > MANY {
        let count = grouped(surface.triangles.len());
        complain(&format!("looking for self-intersections among {count} triangles, which takes a while"));
    }
    let intersections = self_intersections(&surface.nodes, &surface.triangles);
    let report = report(args, surface, &intersections);
    console::say(&if args.json { console::json(&report)? } else { words::of(&report, args.kind) })?;
    if args.kind == Some(MeshKind::Body) && !report.body.accepted {
        return Err(Failure::Input(format!("{}: refused as a body", report.mesh)));
    }
    Ok(())
}

fn report(args: &Args, surface: Surface, intersections: &Intersections) -> MeshReport {
    let found = Inspection::new(&surface);
    let unsplit = unsplit(&surface).map(|surface| Inspection::new(&surface));
    let touching = unsplit.as_ref().unwrap_or(&found);
    let vertex = surface.vertex_of_node();
    let corners = |t: usize| surface.triangles[t].map(|node| vertex[node as usize]);
    let edge = |pair: [u32; 2]| {
        let [a, b] = pair.map(|node| vertex[node as usize]);
        [a.min(b), a.max(b)]
    };
    let pairs = |which: fn(u32) -> bool| named(found.edges.with_uses(which).map(edge));
    let [lo, hi] = found.bounds;
    let extent = [0, 1, 2].map(|i| hi[i] - lo[i]);
    let lowest = lo[1];
    let mut report = MeshReport {
        mesh: args.path.display().to_string(),
        vertices: surface.vertices.len(),
        faces: surface.polygons.len(),
        nodes: surface.nodes.len(),
        triangles: surface.triangles.len(),
        edges: found.edges.pairs.len(),
        closed: found.edges.is_closed(),
        orientable: found.orientable,
        components: found.parts.len(),
        joined_components: touching.joined_parts,
        largest_components: largest_components(&found, |t| corners(t)[0]),
        euler_characteristic: found.euler,
        genus: found.genus,
        holes: found.holes,
        open_borders: found.open_borders,
        boundary_edges: pairs(|uses| uses == 1),
        non_manifold_edges: pairs(|uses| uses > 2),
        non_manifold_edges_in_file: if found.edges.non_manifold_edges() > 0 { crowded(&surface) } else { 0 },
        flipped_edges: named(found.edges.flipped_pairs(&surface.triangles).map(edge)),
        bow_ties: named(touching.bow_ties.iter().map(|node| vertex[*node as usize])),
        self_intersections: IntersectionReport {
            crossing: intersections.crossing,
            folded: intersections.folded,
            complete: intersections.complete,
            first: intersections.first.iter().map(|pair| pair.map(|t| corners(t as usize))).collect(),
        },
        extent,
        area: found.area,
        volume: found.volume,
        shortest_edge: EdgeReport { length: found.shortest.0, vertices: edge(found.shortest.1) },
        longest_edge: EdgeReport { length: found.longest.0, vertices: edge(found.longest.1) },
        thinnest_triangle: TriangleReport { aspect: found.thinnest.0, vertices: corners(found.thinnest.1) },
        bending_factors: None,
        memory_bytes: 0,
        repairs: surface.repairs.clone(),
        warnings: Vec::new(),
        unit: advice::unit(extent.into_iter().fold(0.0, f64::max)),
        body: body_verdict(no_inside(&surface, &found.edges), found.holes, || {
            !args.fill_holes && (surface.triangles.len() > MANY || filling_would_do(args))
        }),
        shell: Verdict { accepted: true, reason: None, remedy: None },
        scene: None,
    };
    report.warnings = advice::warnings(&report);
    let surface = Arc::new(surface);
    let mut sample = Sample::new(&report, args.kind, lowest);
    report.memory_bytes = sample.memory(&surface);
    report.bending_factors = sample.bending(&surface);
    if args.kind != Some(MeshKind::Body) || report.body.accepted {
        sample.make_room(&surface);
        report.scene = Some(sample.toml(args));
    }
    report
}

/// The surface as it hangs together where nodes at one place are one; `None` where no two are at one place.
fn unsplit(surface: &Surface) -> Option<Surface> {
    // Adding zero makes −0 the same bits as 0.
    let key = |node: &u32| surface.nodes[*node as usize].map(|x| (x + 0.0).to_bits());
    let mut order: Vec<u32> = (0..surface.nodes.len() as u32).collect();
    order.sort_unstable_by_key(|node| (key(node), *node));
    let mut first: Vec<u32> = (0..surface.nodes.len() as u32).collect();
    let mut any = false;
    for same in order.chunk_by(|a, b| key(a) == key(b)).filter(|same| same.len() > 1) {
        same.iter().for_each(|node| first[*node as usize] = same[0]);
        any = true;
    }
    let triangles = || surface.triangles.iter().map(|t| t.map(|node| first[node as usize])).collect();
    any.then(|| Surface { nodes: surface.nodes.clone(), triangles: triangles(), ..Surface::default() })
}

/// Counts all, names the first.
fn named<T>(mut all: impl Iterator<Item = T>) -> Named<T> {
    let first: Vec<T> = all.by_ref().take(NAMED).collect();
    Named { count: first.len() + all.count(), first }
}

/// Edges of the file's faces that more than two faces have.
fn crowded(surface: &Surface) -> usize {
    let node = |vertex: u32| surface.node_of_vertex.as_ref().map_or(vertex, |nodes| nodes[vertex as usize]);
    let sides = surface.polygons.iter().flat_map(|face| {
        let next = face.iter().cycle().skip(1);
        face.iter().zip(next).map(|(a, b)| [node(*a), node(*b)]).map(|[a, b]| [a.min(b), a.max(b)])
    });
    let mut sides: Vec<[u32; 2]> = sides.filter(|[a, b]| a != b).collect();
    sides.sort_unstable();
    sides.chunk_by(|a, b| a == b).filter(|same| same.len() > 2).count()
}

fn largest_components(found: &Inspection, vertex: impl Fn(usize) -> u32) -> Vec<ComponentReport> {
    let mut parts: Vec<_> = found.parts.iter().collect();
    parts.sort_by_key(|part| std::cmp::Reverse(part.triangles));
    let report = |part: &&taffeta::topology::Part| ComponentReport {
        triangles: part.triangles,
        vertex: vertex(part.first),
        closed: part.closed,
        volume: part.volume,
        genus: part.genus,
    };
    parts.iter().take(COMPONENTS).map(report).collect()
}

/// `filling` says whether it would make a body of a mesh that has holes and no other fault.
fn body_verdict(why: Option<NoInside>, holes: usize, filling: impl FnOnce() -> bool) -> Verdict {
    let remedy = why.as_ref().map(|why| {
        if why.fillable && filling() {
            let them = if holes == 1 { "it" } else { "them" };
            format!("--fill-holes here and fill_holes = true in the scene close {them}")
        } else {
            "mend it in a mesh editor, or use it as a shell: kind = \"cloth\"".to_owned()
        }
    });
    Verdict { accepted: why.is_none(), reason: why.map(|why| why.to_string()), remedy }
}

/// Whether the mesh can be a body once its holes are filled. That of a flat sheet leaves no room inside, and a hole
/// between nodes on one line cannot be filled.
fn filling_would_do(args: &Args) -> bool {
    let options = MeshOptions { fill_holes: true, ..MeshOptions::default() };
    taffeta_io::load_mesh(&args.path, &options).is_ok_and(|filled| {
        let edges = Edges::new(filled.nodes.len(), &filled.triangles, &filled.links);
        no_inside(&filled, &edges).is_none()
    })
}
