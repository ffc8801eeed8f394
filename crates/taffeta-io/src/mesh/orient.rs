//! One winding for each connected part, and outward for what is closed.

use super::clean::counted;
use std::collections::VecDeque;

/// No neighbour: an open edge, or one with more than two triangles.
const NONE: u32 = u32::MAX;

/// Turns triangles so that neighbours agree, the majority of each part decides, and the closed parts together hold a
/// positive volume. Parts inside others keep their sense relative to them.
pub(super) fn orient(triangles: &mut [[u32; 3]], nodes: &[[f64; 3]], repairs: &mut Vec<String>) {
    let edges = Edges::of(triangles);
    if edges.crowded > 0 {
        repairs
            .push(format!("not a manifold: {} with more than two triangles", counted(edges.crowded, "edge")));
    }
    let mut turn = vec![false; triangles.len()];
    let mut seen = vec![false; triangles.len()];
    let (mut closed, mut twisted) = (Vec::new(), 0);
    for seed in 0..triangles.len() {
        if seen[seed] {
            continue;
        }
        let part = flood(seed, triangles, &edges, &mut turn, &mut seen);
        let turned = part.members.iter().filter(|&&t| turn[t as usize]).count();
        if part.twisted {
            // No choice is right; the file's own is as good as any.
            part.members.iter().for_each(|&t| turn[t as usize] = false);
        } else if 2 * turned > part.members.len() {
            part.members.iter().for_each(|&t| turn[t as usize] ^= true);
        }
        twisted += usize::from(part.twisted);
        if part.closed && !part.twisted {
            closed.extend(part.members);
        }
    }
    if twisted > 0 {
        repairs
            .push(format!("not orientable: {} with a twist, like a Möbius strip", counted(twisted, "part")));
    }
    let inside_out = volume(&closed, &turn, triangles, nodes) < 0.0;
    if inside_out {
        closed.iter().for_each(|&t| turn[t as usize] ^= true);
    }
    apply(triangles, &turn, inside_out, repairs);
}

fn apply(triangles: &mut [[u32; 3]], turn: &[bool], inside_out: bool, repairs: &mut Vec<String>) {
    let mut turned = 0;
    for (triangle, _) in triangles.iter_mut().zip(turn).filter(|(_, turn)| **turn) {
        triangle.swap(1, 2);
        turned += 1;
    }
    if turned > 0 {
        let why = if inside_out { "the surface was inside out" } else { "neighbours disagreed" };
        repairs.push(format!("reoriented {}: {why}", counted(turned, "triangle")));
    }
}

/// Neighbours across edges.
struct Edges {
    /// For each triangle and side (corner i to i + 1), the side `3·triangle + i` across the edge, or [`NONE`].
    across: Vec<u32>,
    /// Edges with more than two triangles.
    crowded: usize,
}

impl Edges {
    fn of(triangles: &[[u32; 3]]) -> Self {
        let mut sides: Vec<u128> = Vec::with_capacity(3 * triangles.len());
        for (triangle, first) in triangles.iter().zip((0_u32..).step_by(3)) {
            for (i, side) in (0..3).zip(first..) {
                let (a, b) = (triangle[i], triangle[(i + 1) % 3]);
                sides.push(u128::from(a.min(b)) << 64 | u128::from(a.max(b)) << 32 | u128::from(side));
            }
        }
        sides.sort_unstable();
        let mut edges = Self { across: vec![NONE; sides.len()], crowded: 0 };
        for edge in sides.chunk_by(|a, b| a >> 32 == b >> 32) {
            match *edge {
                [a, b] => {
                    edges.across[a as u32 as usize] = b as u32;
                    edges.across[b as u32 as usize] = a as u32;
                }
                [_] => {}
                _ => edges.crowded += 1,
            }
        }
        edges
    }
}

/// Triangles joined by edges of two.
struct Part {
    members: Vec<u32>,
    closed: bool,
    twisted: bool,
}

fn flood(seed: usize, triangles: &[[u32; 3]], edges: &Edges, turn: &mut [bool], seen: &mut [bool]) -> Part {
    let mut part = Part { members: Vec::new(), closed: true, twisted: false };
    let mut queue = VecDeque::from([seed as u32]);
    seen[seed] = true;
    while let Some(triangle) = queue.pop_front() {
        part.members.push(triangle);
        for side in 3 * triangle..3 * triangle + 3 {
            let across = edges.across[side as usize];
            if across == NONE {
                part.closed = false;
                continue;
            }
            let other = across / 3;
            // Neighbours that agree run along their edge in opposite directions, so they start at different nodes.
            let start = |side: u32| triangles[side as usize / 3][side as usize % 3];
            let must_turn = turn[triangle as usize] ^ (start(side) == start(across));
            if !seen[other as usize] {
                seen[other as usize] = true;
                turn[other as usize] = must_turn;
                queue.push_back(other);
            } else if turn[other as usize] != must_turn {
                part.twisted = true;
            }
        }
    }
    part
}

/// Six times the volume [m³] inside `members`: Σ a·(b × c), about a node of theirs.
fn volume(members: &[u32], turn: &[bool], triangles: &[[u32; 3]], nodes: &[[f64; 3]]) -> f64 {
    let Some(&first) = members.first() else { return 0.0 };
    let origin = nodes[triangles[first as usize][0] as usize];
    let mut sum = 0.0;
    for &member in members {
        let [a, b, c] =
            triangles[member as usize].map(|n| [0, 1, 2].map(|i| nodes[n as usize][i] - origin[i]));
        let cross = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
        let sixfold = a[0] * cross[0] + a[1] * cross[1] + a[2] * cross[2];
        sum += if turn[member as usize] { -sixfold } else { sixfold };
    }
    sum
}
