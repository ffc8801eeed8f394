//! The order of contacts: they are listed and summed up in it, whoever has found them.

use crate::contact::clusters::packed::GROUP;
use crate::contact::triangles::surfaces::Kind;

/// What a pair of primitives of two leaves is: in the order in which pairs are listed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Way {
    /// A vertex of the first leaf and a triangle of the second.
    VertexTriangle,
    /// A triangle of the first leaf and a vertex of the second.
    TriangleVertex,
    EdgeEdge,
}

impl Way {
    pub fn kind(self) -> Kind {
        match self {
            Self::VertexTriangle | Self::TriangleVertex => Kind::VertexTriangle,
            Self::EdgeEdge => Kind::EdgeEdge,
        }
    }
}

/// A pair of primitives, by their numbers in the first and the second leaf.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Candidate {
    pub way: Way,
    pub one: u8,
    pub other: u8,
}

impl Candidate {
    /// Both primitives by their numbers among those of all surfaces, in the order of their kind of pair. `a` and `b` are the first
    /// triangle, edge and vertex of their leaves.
    pub fn key(&self, [a, b]: [[u32; 3]; 2]) -> [u32; 2] {
        let [one, other] = [u32::from(self.one), u32::from(self.other)];
        match self.way {
            Way::VertexTriangle => [a[2] + one, b[0] + other],
            Way::TriangleVertex => [b[2] + other, a[0] + one],
            Way::EdgeEdge => [a[1] + one, b[1] + other],
        }
    }
}

/// Where a contact stands among all.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Order {
    groups: [u32; 2],
    pub leaves: [u32; 2],
    pub pair: Candidate,
}

impl Order {
    /// That of a pair of primitives of two leaves.
    pub fn new(leaves: [u32; 2], pair: Candidate) -> Self {
        Self { groups: leaves.map(|leaf| leaf / GROUP as u32), leaves, pair }
    }

    /// That of a pair of a kind, by the numbers of its primitives. `firsts` are the first triangle, edge and vertex of each leaf.
    pub fn of_key(firsts: &[[u32; 3]], kind: Kind, key: [u32; 2]) -> Self {
        let find = |what: usize, number: u32| {
            let leaf = firsts.partition_point(|first| first[what] <= number).saturating_sub(1);
            let first = firsts.get(leaf).map_or(0, |first| first[what]);
            (leaf as u32, number.wrapping_sub(first) as u8)
        };
        let [first, second] = match kind {
            Kind::VertexTriangle => [2, 0],
            Kind::EdgeEdge => [1, 1],
        };
        let ((a, one), (b, other)) = (find(first, key[0]), find(second, key[1]));
        match kind {
            Kind::EdgeEdge => Self::new([a, b], Candidate { way: Way::EdgeEdge, one, other }),
            Kind::VertexTriangle if a <= b => {
                Self::new([a, b], Candidate { way: Way::VertexTriangle, one, other })
            }
            Kind::VertexTriangle => {
                Self::new([b, a], Candidate { way: Way::TriangleVertex, one: other, other: one })
            }
        }
    }

    /// The leaf whose worker lists it.
    pub fn leaf(&self) -> usize {
        self.leaves[0] as usize
    }
}
