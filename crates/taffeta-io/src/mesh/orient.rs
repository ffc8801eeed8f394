//! Closed parts turned outward.

use super::clean::counted;
use super::nesting::{Solid, containers};
use super::parts::{Part, Parts};
use super::triangles::Triangles;

/// Why triangles were turned, in numbers.
#[derive(Default)]
struct Turned {
    /// Triangles turned for their neighbours' sake.
    disagreed: usize,
    /// Triangles turned with their part.
    inside_out: usize,
    /// Closed parts turned because they were inside out.
    parts: usize,
    /// Closed parts turned with what they lie in.
    followers: usize,
}

/// Turns parts so that an outermost closed one has a positive volume, and one inside it keeps its sense relative to it:
/// a cavity stays a cavity. `turned` are the file's triangles that were turned to agree with their neighbours.
pub(super) fn outward(
    triangles: &mut Triangles,
    parts: &Parts,
    nodes: &[[f64; 3]],
    turned: &[bool],
    repairs: &mut Vec<String>,
) {
    let closed: Vec<&Part> = parts.list.iter().filter(|part| part.closed).collect();
    let flips = flips(&closed, parts, &triangles.nodes, nodes).unwrap_or_else(|| {
        let count = closed.len();
        repairs.push(format!(
            "{count} closed parts overlap too much to tell their inside: their winding is as found"
        ));
        vec![None; count]
    });
    let mut sum = Turned { disagreed: turned.iter().filter(|t| **t).count(), ..Turned::default() };
    for (part, flip) in closed.iter().zip(flips) {
        let Some(follows) = flip else { continue };
        sum.parts += usize::from(!follows);
        sum.followers += usize::from(follows);
        for &triangle in parts.members(part) {
            triangles.turn(triangle as usize);
            // A triangle that fills a hole is not the file's, and was not turned.
            match turned.get(triangle as usize) {
                Some(true) => sum.disagreed -= 1,
                Some(false) => sum.inside_out += 1,
                None => {}
            }
        }
    }
    report(&sum, parts.list.len(), repairs);
}

/// For each closed part whether to turn it over, and if so, whether only because it lies in one that is. `None`: they
/// overlap too much to find out.
fn flips(
    closed: &[&Part],
    parts: &Parts,
    triangles: &[[u32; 3]],
    nodes: &[[f64; 3]],
) -> Option<Vec<Option<bool>>> {
    let solid = |part: &&Part| {
        let members = parts.members(part);
        Solid { members, volume: volume(members, triangles, nodes) }
    };
    let solids: Vec<Solid> = closed.iter().map(solid).collect();
    let around =
        if solids.len() > 1 { containers(&solids, triangles, nodes)? } else { vec![None; solids.len()] };
    // The largest first, so that what is around a part has been decided.
    let mut order: Vec<usize> = (0..solids.len()).collect();
    order.sort_by(|&a, &b| solids[b].volume.abs().total_cmp(&solids[a].volume.abs()));
    let mut flips = vec![None; solids.len()];
    for solid in order {
        flips[solid] = match around[solid] {
            Some(outer) => flips[outer].map(|_: bool| true),
            None => (solids[solid].volume < 0.0).then_some(false),
        };
    }
    Some(flips)
}

fn report(turned: &Turned, parts: usize, repairs: &mut Vec<String>) {
    if turned.disagreed > 0 {
        repairs.push(format!("reoriented {}: neighbours disagreed", counted(turned.disagreed, "triangle")));
    }
    let why = match (turned.parts, turned.followers) {
        (0, _) => return,
        (1, 0) if parts == 1 => "the surface was inside out".to_owned(),
        (1, 0) => "1 closed part was inside out".to_owned(),
        (1, inner) => format!("1 closed part was inside out, with {inner} inside it"),
        (outer, 0) => format!("{outer} closed parts were inside out"),
        (outer, inner) => format!("{outer} closed parts were inside out, with {inner} inside them"),
    };
    repairs.push(format!("reoriented {}: {why}", counted(turned.inside_out, "triangle")));
}

/// Six times the volume [m³] inside `members`: Σ a·(b × c), about a node of theirs.
fn volume(members: &[u32], triangles: &[[u32; 3]], nodes: &[[f64; 3]]) -> f64 {
    let Some(&first) = members.first() else { return 0.0 };
    let origin = nodes[triangles[first as usize][0] as usize];
    let sixfold = |&member: &u32| {
        let [a, b, c] =
            triangles[member as usize].map(|n| [0, 1, 2].map(|i| nodes[n as usize][i] - origin[i]));
        let cross = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
        a[0] * cross[0] + a[1] * cross[1] + a[2] * cross[2]
    };
    members.iter().map(sixfold).sum()
}
