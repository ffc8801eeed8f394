//! The surfaces of a scene that touch each other: vertices, edges and triangles in an order of good locality.

use crate::assembly::Assembly;
use crate::assembly::body::BodyAssembly;
use crate::contact::colliders::moving::MovingCollider;
use crate::contact::nodes::build::exclusions;
use crate::contact::nodes::self_contact::Exclusions;
use crate::contact::triangles::closest::{
    Closest, EdgeEdge, Pair, VertexTriangle, edge_edge, vertex_triangle,
};
use crate::plan::Substep;
use crate::real::{Real, norm};
use crate::scene::{ContactForm, SceneError, SelfCollision};
use crate::topology::boxes::leaf_order;
use crate::topology::{Csr, Piercing, measure, piercings};
use std::collections::{HashMap, HashSet};

/// Triangles of a leaf.
pub const LEAF: usize = 8;
/// A body, a vertex or a triangle that is none.
const NONE: u32 = u32::MAX;
/// Thickness of neighbours along the surface, relative to their distance at the start: more would hold cloth flat.
const NEIGHBOURS: f64 = 0.5;
/// Distance that triangles and edges keep from those of colliders, relative to the collider's offset, and at least, relative to
/// the thickness of the body.
const OFFSET: f64 = 0.9;
const LEAST: f64 = 0.25;

/// What a body's description says of its surface.
#[derive(Clone, Debug)]
pub struct SurfaceContact {
    /// Distance kept between surfaces [m].
    pub thickness: f64,
    /// Coulomb coefficient.
    pub friction: f64,
    /// Which nodes are neighbours along the surface.
    neighbours: Exclusions,
}

/// All surfaces of a scene.
#[derive(Default)]
pub struct Surfaces {
    /// Thickness [m] and friction of each body that has one, by the number of its surface.
    pub materials: Vec<[f64; 2]>,
    /// The number of the surface of each place; none has a place without. Behind the places of nodes are those of corners of
    /// colliders.
    pub surface_of: Vec<u32>,
    /// Number of the places of nodes.
    pub places: usize,
    /// How many of the surfaces are of bodies, which come first.
    soft: usize,
    /// Corners by place, leaf after leaf.
    pub triangles: Vec<[u32; 3]>,
    /// Edges and vertices by place, each in the leaf of its first triangle.
    pub edges: Vec<[u32; 2]>,
    pub vertices: Vec<u32>,
    /// Where those of each leaf begin, and where the last end.
    pub edges_of: Vec<u32>,
    pub vertices_of: Vec<u32>,
    /// Mean length of the bodies' edges at the start [m].
    pub mean_edge: f64,
    /// The longest edge, of colliders too [m].
    pub longest_edge: f64,
    /// Largest thickness of a pair [m].
    pub thickest: f64,
    /// Bodies by the number of their surface, with the neighbours of their nodes.
    bodies: Vec<Neighbours>,
    /// Places at the start [m].
    start: Vec<[f64; 3]>,
    /// Nodes that are pinned, by place.
    held: Vec<bool>,
    /// For each place that is sewn or split, the places that it is one with.
    joined: HashMap<u32, Vec<u32>>,
}

/// A body's nodes that are neighbours along its surface.
struct Neighbours {
    first: u32,
    cols: u32,
    lists: Lists,
}

/// As [`Exclusions`], to ask for a pair.
enum Lists {
    /// Whether each offset up to so many rows and columns away is one, row by row.
    Grid([i32; 2], Vec<bool>),
    Mesh(Csr),
}

/// The two kinds of pairs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A vertex and a triangle.
    VertexTriangle,
    /// Two edges.
    EdgeEdge,
}

impl Kind {
    /// Both, in the order in which contacts are summed up.
    pub const ALL: [Self; 2] = [Self::VertexTriangle, Self::EdgeEdge];

    /// How many of a pair's four nodes are its first side.
    pub const fn first(self) -> usize {
        match self {
            Self::VertexTriangle => VertexTriangle::FIRST,
            Self::EdgeEdge => EdgeEdge::FIRST,
        }
    }

    /// The closest points of a pair.
    pub fn closest<T: Real>(self, x: [[T; 3]; 4]) -> Closest<T> {
        match self {
            Self::VertexTriangle => vertex_triangle(x),
            Self::EdgeEdge => edge_edge(x),
        }
    }
}

impl BodyAssembly {
    /// Contact of its surface; `None` where it has none of this form.
    pub fn surface_contact(&self) -> Option<&SurfaceContact> {
        self.extensions.get()
    }

    /// Enables contact of its triangles.
    pub(crate) fn enable_surface_contact(&mut self, wish: &SelfCollision) -> Result<(), SceneError> {
        debug_assert!(wish.form == ContactForm::Triangles);
        if self.triangles() == 0 {
            let message = "is \"triangles\", and the body has none; \"nodes\" would do";
            return Err(SceneError::new("self_collision.form", message));
        }
        if wish.restitution > 0.0 {
            let message =
                "is more than 0, which contact between triangles cannot do; 0, or form = \"nodes\" would do";
            return Err(SceneError::new("self_collision.restitution", message));
        }
        let neighbours = exclusions(self, wish.thickness)?;
        let SelfCollision { thickness, friction, .. } = *wish;
        self.extensions.insert(SurfaceContact { thickness, friction, neighbours });
        Ok(())
    }
}

impl Assembly {
    /// The surfaces that touch each other; none in a scene without.
    pub fn surfaces(&self) -> Option<&Surfaces> {
        self.extensions.get()
    }

    /// The same, to be taken by a backend.
    pub(crate) fn surfaces_mut(&mut self) -> Option<&mut Surfaces> {
        self.surfaces()?;
        Some(self.extensions.get_mut())
    }

    /// Lists the surfaces of all bodies that have contact of this form.
    pub(crate) fn add_surfaces(&mut self) {
        let places = self.places;
        let mut all = Surfaces { surface_of: vec![NONE; places], places, ..Surfaces::default() };
        let mut triangles = Vec::new();
        (all.start, all.held) = (vec![[0.0; 3]; places], vec![true; places]);
        for body in &self.bodies {
            let Some(contact) = body.surface_contact() else { continue };
            let (first, number) = (body.first, all.materials.len() as u32);
            all.surface_of[first..first + body.nodes].fill(number);
            all.start[first..first + body.nodes].copy_from_slice(&body.start);
            for (held, free) in all.held[first..].iter_mut().zip(&body.free) {
                *held = !free;
            }
            all.materials.push([contact.thickness, contact.friction]);
            let place = |node: u32| body.solver_index(node as usize) as u32;
            triangles.extend(body.user_surface().triangles.iter().map(|t| t.map(place)));
            all.bodies.push(Neighbours {
                first: first as u32,
                cols: body.grid_layout.map_or(0, |[_, cols]| cols as u32),
                lists: match &contact.neighbours {
                    Exclusions::Grid(ways) => Lists::of_grid(ways),
                    Exclusions::Mesh(rows) => Lists::Mesh(rows.clone()),
                },
            });
            for pair in &body.split {
                let [a, b] = pair.map(place);
                all.join(a, b);
            }
        }
        if triangles.is_empty() {
            return;
        }
        all.soft = all.materials.len();
        for [a, b] in self.attachments().joined() {
            all.join(a, b);
        }
        for collider in self.colliders() {
            triangles.extend(all.add_collider(collider));
        }
        all.thickest = all.materials.iter().map(|[thickness, _]| *thickness).fold(0.0, f64::max);
        let order = leaf_order(&all.start, &triangles);
        all.triangles = order.into_iter().map(|triangle| triangles[triangle as usize]).collect();
        all.own();
        self.note_piercings(&all);
        self.extensions.insert(all);
    }

    /// Warns of surfaces that start through each other.
    fn note_piercings(&mut self, all: &Surfaces) {
        let of_a_body = |triangle: u32| (all.triangles[triangle as usize][0] as usize) < all.places;
        let found = piercings(&all.start, &all.triangles, |pair| pair.into_iter().any(of_a_body));
        let Some(Piercing { edge, triangle }) = found.first else { return };
        let ends =
            if (edge[0] as usize) < all.places { [edge[0], edge[1]] } else { [triangle[0], triangle[1]] };
        let index = self.bodies.partition_point(|body| body.first <= ends[0] as usize) - 1;
        let body = &mut self.bodies[index];
        let [a, b] = ends.map(|node| body.vertex_of_solver(node as usize - body.first));
        body.warnings.push(format!(
            "surfaces start through each other: {} pairs of an edge and a triangle, one of them at its vertices {a} and {b}; contact \
             between triangles keeps apart what starts apart, and does not untangle this",
            found.pairs
        ));
    }
}

impl Surfaces {
    /// Adds a collider; its triangles, none if it is round.
    fn add_collider(&mut self, collider: &MovingCollider) -> Vec<[u32; 3]> {
        let Some(faces) = collider.faces() else { return Vec::new() };
        let (first, corners) = (self.start.len(), collider.corners(0.0));
        let number = self.materials.len() as u32;
        self.materials.push([collider.offset(), collider.friction()]);
        self.surface_of.extend(corners.iter().map(|_| number));
        self.held.extend(corners.iter().map(|_| true));
        self.start.extend(corners);
        faces.iter().map(|face| face.map(|corner| first as u32 + corner)).collect()
    }

    /// Number of places, those of corners of colliders among them.
    pub fn all_places(&self) -> usize {
        self.start.len()
    }

    /// Corners of colliders at the start [m].
    pub fn corners(&self) -> &[[f64; 3]] {
        &self.start[self.places..]
    }

    fn join(&mut self, a: u32, b: u32) {
        self.joined.entry(a).or_default().push(b);
        self.joined.entry(b).or_default().push(a);
    }

    /// Gives each edge and each vertex to the leaf of its first triangle.
    fn own(&mut self) {
        let (mut edges, mut vertices) = (HashSet::new(), HashSet::new());
        let (mut length, mut count) = (0.0, 0);
        for leaf in self.triangles.chunks(LEAF) {
            self.edges_of.push(self.edges.len() as u32);
            self.vertices_of.push(self.vertices.len() as u32);
            for &[a, b, c] in leaf {
                for pair in [[a, b], [b, c], [c, a]] {
                    let pair = [pair[0].min(pair[1]), pair[0].max(pair[1])];
                    if edges.insert(pair) {
                        self.edges.push(pair);
                        let one = measure::length(&self.start, pair);
                        if (pair[0] as usize) < self.places {
                            (length, count) = (length + one, count + 1);
                        }
                        self.longest_edge = self.longest_edge.max(one);
                    }
                }
                self.vertices.extend([a, b, c].into_iter().filter(|&node| vertices.insert(node)));
            }
        }
        self.edges_of.push(self.edges.len() as u32);
        self.vertices_of.push(self.vertices.len() as u32);
        self.mean_edge = length / f64::from(count);
    }

    /// Number of leaves.
    pub fn leaves(&self) -> usize {
        self.vertices_of.len() - 1
    }

    /// The nodes of a pair: `[vertex, triangle]`, or `[edge, edge]`, by their numbers.
    pub fn nodes(&self, kind: Kind, [one, other]: [u32; 2]) -> [u32; 4] {
        match kind {
            Kind::VertexTriangle => {
                let [a, b, c] = self.triangles[other as usize];
                [self.vertices[one as usize], a, b, c]
            }
            Kind::EdgeEdge => {
                let ([a, b], [c, d]) = (self.edges[one as usize], self.edges[other as usize]);
                [a, b, c, d]
            }
        }
    }

    /// Thickness [m] and friction of a pair with these nodes; `None` where the two sides hang together.
    pub fn material(&self, kind: Kind, nodes: [u32; 4]) -> Option<[f64; 2]> {
        let (one, other) = nodes.split_at(kind.first());
        if one.iter().any(|&a| other.iter().any(|&b| self.is_one(a, b))) {
            return None;
        }
        let [a, b] = [one[0], other[0]].map(|node| self.surface_of[node as usize]);
        if nodes.iter().all(|&node| self.held[node as usize]) {
            return None;
        }
        let [of_a, of_b] = [a, b].map(|number| self.materials[number as usize]);
        for (number, of_collider, of_body) in [(a, of_a, of_b), (b, of_b, of_a)] {
            if number as usize >= self.soft {
                // Nodes keep the whole offset from it by themselves.
                return Some([(OFFSET * of_collider[0]).max(LEAST * of_body[0]), of_collider[1]]);
            }
        }
        let mut thickness = 0.5 * (of_a[0] + of_b[0]);
        if a == b {
            let body = &self.bodies[a as usize];
            if one.iter().any(|&a| other.iter().any(|&b| body.are_neighbours(a, b))) {
                let x = nodes.map(|node| self.start[node as usize]);
                thickness = thickness.min(NEIGHBOURS * norm(kind.closest(x).apart));
            }
        }
        Some([thickness, (of_a[1] * of_b[1]).sqrt()])
    }

    /// Whether two places are one node of the surface: the same, sewn together, or split from one.
    fn is_one(&self, a: u32, b: u32) -> bool {
        a == b || (!self.joined.is_empty() && self.joined.get(&a).is_some_and(|others| others.contains(&b)))
    }
}

impl Neighbours {
    fn are_neighbours(&self, a: u32, b: u32) -> bool {
        let [a, b] = [a - self.first, b - self.first];
        match &self.lists {
            Lists::Mesh(rows) => rows.row(a as usize).binary_search(&b).is_ok(),
            Lists::Grid([high, wide], are) => {
                let at = |node: u32| [node / self.cols, node % self.cols].map(u32::cast_signed);
                let ([ra, ca], [rb, cb]) = (at(a), at(b));
                let (row, col) = (rb - ra + high, cb - ca + wide);
                let inside = (0..=2 * high).contains(&row) && (0..=2 * wide).contains(&col);
                inside && are[(row * (2 * wide + 1) + col) as usize]
            }
        }
    }
}

impl Lists {
    fn of_grid(ways: &[[i32; 2]]) -> Self {
        let [high, wide] = [0, 1].map(|axis| ways.iter().map(|way| way[axis].abs()).max().unwrap_or(0));
        let mut are = vec![false; ((2 * high + 1) * (2 * wide + 1)) as usize];
        for [row, col] in ways {
            are[((row + high) * (2 * wide + 1) + col + wide) as usize] = true;
        }
        Self::Grid([high, wide], are)
    }
}

/// Where corners of colliders are at both ends of a sub-step [m], in the order of their places.
pub struct Corners<T> {
    pub before: Vec<[T; 3]>,
    pub after: Vec<[T; 3]>,
}

/// Where corners of colliders are, in a scene in which some move.
pub fn parameters<T: Real>(assembly: &Assembly, [t, h]: [f64; 2], substep: &mut Substep<T>) {
    let with_faces = || assembly.colliders().iter().filter(|collider| collider.faces().is_some());
    if assembly.bodies.iter().all(|body| body.surface_contact().is_none())
        || !with_faces().any(MovingCollider::moves)
    {
        return;
    }
    let at = |t: f64| with_faces().flat_map(|one| one.corners(t)).map(|x| x.map(T::from_f64)).collect();
    substep.extensions.insert(Corners::<T> { before: at(t), after: at(t + h) });
}
