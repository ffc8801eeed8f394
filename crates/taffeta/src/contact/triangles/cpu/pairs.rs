//! The pairs that a worker looks at: all that may touch before it searches again.
//!
//! What a sub-step does depends on positions alone. Which pairs are listed, and which of these are looked at, only has to be
//! enough for that: a list holds until nodes have moved by its margin, and a pair sleeps until they have moved by its distance
//! from contact.

use crate::contact::triangles::cpu::lanes::{Distances, gather};
use crate::contact::triangles::cpu::tree::{Box3, Tree, are_near, around, join, nowhere};
use crate::contact::triangles::impulse::KEEPS;
use crate::contact::triangles::surfaces::{Kind, LEAF, Surfaces};
use crate::cpu::shared::Shared;
use crate::cpu::simd::SimdLevel;
use crate::real::Real;
use crate::topology::LANES;
use std::iter::Peekable;
use std::ops::Range;

/// Pairs of one kind, ascending.
pub struct List<T> {
    pub kind: Kind,
    /// Both primitives of each pair by their numbers, and its nodes by place.
    pub keys: Vec<[u32; 2]>,
    pub nodes: Vec<[u32; 4]>,
    /// Thickness [m] and friction.
    pub materials: Vec<[T; 2]>,
    /// How far nodes must have moved since the search before a pair can be in contact [m].
    pub wakes: Vec<f64>,
    /// The force on the first side of each at the end of the last sub-step [N].
    pub forces: Vec<[T; 3]>,
    /// Pairs that were looked at in this sub-step, and how far apart they were where it began [m].
    pub awake: Vec<(u32, T)>,
}

impl<T: Real> List<T> {
    /// An empty one.
    pub fn new(kind: Kind) -> Self {
        Self {
            kind,
            keys: Vec::new(),
            nodes: Vec::new(),
            materials: Vec::new(),
            wakes: Vec::new(),
            forces: Vec::new(),
            awake: Vec::new(),
        }
    }

    /// Pairs that carry a force.
    pub fn carried(&self) -> impl Iterator<Item = ([u32; 2], [T; 3])> {
        let all = self.keys.iter().copied().zip(self.forces.iter().copied());
        all.filter(|(_, force)| *force != [T::ZERO; 3])
    }

    /// Wakes the pairs that may be in contact when nodes have moved by `limit` since the search [m].
    pub fn wake(&mut self, limit: f64) {
        self.awake.clear();
        let awake = (0..).zip(&self.wakes).filter(|(_, wake)| **wake <= limit);
        self.awake.extend(awake.map(|(pair, _)| (pair, T::ZERO)));
    }
}

/// Boxes of a scene's leaves, triangles and edges where the last search was.
pub struct Boxes<T> {
    pub leaves: Shared<Box3<T>>,
    pub triangles: Shared<Box3<T>>,
    pub edges: Shared<Box3<T>>,
}

impl<T: Real> Boxes<T> {
    /// For some surfaces.
    pub fn new(surfaces: &Surfaces) -> Self {
        Self {
            leaves: vec![nowhere(); surfaces.leaves()].into(),
            triangles: vec![nowhere(); surfaces.triangles.len()].into(),
            edges: vec![nowhere(); surfaces.edges.len()].into(),
        }
    }

    /// Sets those of some leaves, at positions `x` [m].
    ///
    /// # Safety
    /// No other worker touches them before the next barrier.
    pub unsafe fn set(&self, surfaces: &Surfaces, own: Range<usize>, x: [&[T]; 3]) {
        let at = |node: u32| x.map(|column| column[node as usize]);
        let first = own.start * LEAF;
        let triangles = first.min(surfaces.triangles.len())..(own.end * LEAF).min(surfaces.triangles.len());
        let edges = surfaces.edges_of[own.start] as usize..surfaces.edges_of[own.end] as usize;
        // SAFETY: the caller's promise.
        let (leaves, of_triangles, of_edges) = unsafe {
            (self.leaves.write(own), self.triangles.write(triangles.clone()), self.edges.write(edges.clone()))
        };
        leaves.fill(nowhere());
        for ((number, corners), one) in
            triangles.clone().zip(&surfaces.triangles[triangles]).zip(of_triangles)
        {
            *one = corners.iter().fold(nowhere(), |all, &node| around(all, at(node)));
            let leaf = &mut leaves[(number - first) / LEAF];
            *leaf = join(*leaf, *one);
        }
        for (ends, one) in surfaces.edges[edges].iter().zip(of_edges) {
            *one = ends.iter().fold(nowhere(), |all, &node| around(all, at(node)));
        }
    }

    /// Bytes that they take.
    pub fn bytes(&self) -> usize {
        self.leaves.bytes() + self.triangles.bytes() + self.edges.bytes()
    }
}

/// Memory of a search.
pub struct Search<T> {
    tree: Tree<T>,
    /// For each primitive of a leaf, what is near it.
    near: Vec<Vec<u32>>,
    /// Pairs of a leaf whose boxes are near, and their nodes.
    found: Vec<([u32; 2], [u32; 4])>,
}

impl<T> Default for Search<T> {
    fn default() -> Self {
        Self { tree: Tree::default(), near: Vec::new(), found: Vec::new() }
    }
}

/// Where a search looks.
pub struct Place<'a, T> {
    pub surfaces: &'a Surfaces,
    pub boxes: &'a Boxes<T>,
    /// Positions [m].
    pub x: [&'a [T]; 3],
    /// The leaves whose pairs are wanted.
    pub own: Range<usize>,
    /// Distance beyond contact at which pairs are listed [m].
    pub margin: T,
    pub level: SimdLevel,
}

impl<T: Real> Search<T> {
    /// Lists the pairs of some leaves: of their vertices with all triangles, and of their edges with all later ones. A pair
    /// keeps its force.
    pub fn run(&mut self, place: &Place<'_, T>, lists: &mut [List<T>; 2]) {
        // SAFETY: written before a barrier, and again after another.
        let leaves = unsafe { place.boxes.leaves.read() };
        self.tree.build(leaves);
        for list in lists {
            let old = std::mem::replace(list, List::new(list.kind));
            let mut carried = old.carried().peekable();
            for leaf in place.own.clone() {
                self.look(place, leaf, list.kind, &leaves[leaf]);
                let own = primitives(place.surfaces, list.kind, leaf);
                self.found.clear();
                for (owner, others) in own.zip(&self.near) {
                    let keys = others.iter().map(|&other| [owner as u32, other]);
                    self.found.extend(keys.map(|key| (key, place.surfaces.nodes(list.kind, key))));
                }
                list.add(place, &self.found, &mut carried);
            }
        }
    }

    /// Finds what is near the primitives of a leaf.
    fn look(&mut self, place: &Place<'_, T>, leaf: usize, kind: Kind, of_leaf: &Box3<T>) {
        let Place { surfaces, boxes, x, margin, .. } = place;
        let reach = *margin + T::from_f64(KEEPS * surfaces.thickest);
        let own = primitives(surfaces, kind, leaf);
        if self.near.len() < own.len() {
            self.near.resize(own.len(), Vec::new());
        }
        self.near[..own.len()].iter_mut().for_each(Vec::clear);
        let near = &mut self.near;
        // SAFETY: written before a barrier, and again after another.
        let (triangles, edges) = unsafe { (boxes.triangles.read(), boxes.edges.read()) };
        let at = |node: u32| x.map(|column| column[node as usize]);
        self.tree.near(of_leaf, reach, |other| match kind {
            Kind::VertexTriangle => {
                let range = other * LEAF..((other + 1) * LEAF).min(triangles.len());
                for (list, &vertex) in near.iter_mut().zip(&surfaces.vertices[own.clone()]) {
                    let point = [at(vertex); 2];
                    for triangle in range.clone() {
                        if are_near(&triangles[triangle], &point, reach) {
                            list.push(triangle as u32);
                        }
                    }
                }
            }
            Kind::EdgeEdge => {
                let range = primitives(surfaces, kind, other);
                for (list, edge) in near.iter_mut().zip(own.clone()) {
                    for later in range.clone().filter(|&later| later > edge) {
                        if are_near(&edges[later], &edges[edge], reach) {
                            list.push(later as u32);
                        }
                    }
                }
            }
        });
    }
}

/// Edges, or vertices, of a leaf.
fn primitives(surfaces: &Surfaces, kind: Kind, leaf: usize) -> Range<usize> {
    let starts = match kind {
        Kind::VertexTriangle => &surfaces.vertices_of,
        Kind::EdgeEdge => &surfaces.edges_of,
    };
    starts[leaf] as usize..starts[leaf + 1] as usize
}

impl<T: Real> List<T> {
    /// Adds those of some pairs that may come into contact, or carry a force. `carried` are the forces from these on.
    fn add(
        &mut self,
        place: &Place<'_, T>,
        found: &[([u32; 2], [u32; 4])],
        carried: &mut Peekable<impl Iterator<Item = ([u32; 2], [T; 3])>>,
    ) {
        let keeps = T::from_f64(KEEPS);
        let most = place.margin + keeps * T::from_f64(place.surfaces.thickest);
        for sixteen in found.chunks(LANES) {
            let nodes = gather(sixteen.iter().map(|(_, nodes)| nodes));
            let (kind, x) = (self.kind, place.x);
            let distances = place.level.run(Distances { kind, nodes: &nodes, x });
            for (&(key, nodes), distance) in sixteen.iter().zip(distances) {
                while carried.peek().is_some_and(|(one, _)| *one < key) {
                    carried.next();
                }
                let force = carried.next_if(|(one, _)| *one == key).map(|(_, force)| force);
                if distance >= most && force.is_none() {
                    continue;
                }
                let Some(material) = place.surfaces.material(kind, nodes) else { continue };
                let material = material.map(T::from_f64);
                if distance >= place.margin + keeps * material[0] && force.is_none() {
                    continue;
                }
                self.keys.push(key);
                self.nodes.push(nodes);
                self.materials.push(material);
                self.wakes.push(0.0);
                self.forces.push(force.unwrap_or([T::ZERO; 3]));
            }
        }
    }
}
