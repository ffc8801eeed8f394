//! The surfaces of a scene that touch each other: vertices, edges and triangles in an order of good locality.

use crate::assembly::Assembly;
use crate::assembly::body::BodyAssembly;
use crate::contact::clusters::margin::extent;
use crate::contact::colliders::moving::MovingCollider;
use crate::contact::nodes::build::exclusions;
use crate::contact::nodes::self_contact::Exclusions;
use crate::contact::triangles::closest::{EdgeEdge, Pair, VertexTriangle};
use crate::contact::triangles::cones::fan;
use crate::contact::triangles::leaves::{Cut, Leaf, Rings};
use crate::plan::Substep;
use crate::real::{Real, cross, dot};
use crate::scene::{ContactForm, ContactZone, Layers, Scene, SceneError, SelfCollision, plain};
use crate::topology::boxes::{around, leaf_order};
use crate::topology::{Csr, Piercing, measure, piercings_apart};
use std::collections::{HashMap, HashSet};

/// A body, a vertex or a triangle that is none.
const NONE: u32 = u32::MAX;
/// Thickness of neighbours along the surface, at most, relative to their distance at the start: more would hold cloth flat.
pub const NEIGHBOURS: f64 = 0.5;
/// Places that are joined with all others of their point, at most.
const MOST_JOINED: usize = 64;
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
    /// Parts that keep another distance.
    zones: Vec<ThickZone>,
    /// The largest of all distances [m], and the zone that keeps it.
    thickest: (f64, Option<String>),
}

/// Triangles that keep another distance than the rest of their surface.
#[derive(Clone, Debug)]
struct ThickZone {
    /// Distance kept [m].
    thickness: f64,
    /// By number: among those of the body, or of all surfaces.
    triangles: Vec<usize>,
}

/// All surfaces of a scene.
#[derive(Default)]
pub struct Surfaces {
    /// Thickness [m] and friction of each surface by its number, then of zones that have another thickness.
    pub materials: Vec<[f64; 2]>,
    /// The surface of each of the latter.
    zones: Vec<u32>,
    /// The number of the surface of each place; none has a place without. Behind the places of nodes are those of corners of
    /// colliders.
    pub surface_of: Vec<u32>,
    /// Number of the places of nodes.
    pub places: usize,
    /// How many of the surfaces are of bodies, which come first.
    pub(super) soft: usize,
    /// Corners by place, leaf after leaf.
    pub triangles: Vec<[u32; 3]>,
    /// Edges and vertices by place, leaf after leaf.
    pub edges: Vec<[u32; 2]>,
    pub vertices: Vec<u32>,
    pub leaves: Vec<Leaf>,
    /// Nodes of two leaves that are one, or neighbours.
    pub rings: Rings,
    /// For each place the corners of triangles at it.
    pub corners_at: Csr,
    /// For each place the least of those that are sewn to the same point.
    pub points: Vec<u32>,
    /// Mean length of the bodies' edges at the start [m].
    pub mean_edge: f64,
    /// The longest edge, of colliders too [m].
    pub longest_edge: f64,
    /// Largest thickness of a pair, and the least one of two surfaces [m].
    pub thickest: f64,
    pub thinnest: f64,
    /// Places at the start [m].
    pub start: Vec<[f64; 3]>,
    /// Surfaces of two bodies that do not touch, the lower number first.
    apart: HashSet<[u32; 2]>,
    /// The layers of each surface; empty where nothing is said, and all meet.
    layers: Vec<Layers>,
    /// Friction of pairs of surfaces that the scene names, the lower number first.
    frictions: HashMap<[u32; 2], f64>,
    /// On which side of the triangles of each collider outside is, 1 where their normals point or -1; 0 if it is not closed.
    outsides: Vec<i64>,
    /// Whether some start through each other.
    pub start_tangled: bool,
}

/// Bodies of a scene that have contact of this form and do not touch each other, by their numbers, the lower one first.
#[derive(Clone, Debug, Default)]
pub struct Apart(pub HashSet<[usize; 2]>);

/// What is known of surfaces while they are listed.
#[derive(Default)]
struct Listed {
    /// Nodes that never give way: pinned ones, and corners of colliders.
    held: Vec<bool>,
    /// For each place that is sewn or split, the places that it is one with. Some may be listed twice.
    joined: HashMap<u32, Vec<u32>>,
    /// Neighbours along the surface by body: its first place, its grid.
    neighbours: Vec<(usize, Option<[usize; 2]>, Exclusions)>,
    /// Zones, and the surfaces that they are of.
    zones: Vec<(u32, ThickZone)>,
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
}

impl SurfaceContact {
    /// The largest distance kept [m], and the zone that keeps it.
    pub(super) fn thickest(&self) -> (f64, Option<&str>) {
        (self.thickest.0, self.thickest.1.as_deref())
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
        let (thickest, zone) = wish.thickest();
        let within = zone.map_or(String::new(), |name| format!("zone.{name}."));
        let key = format!("self_collision.{within}thickness");
        let neighbours = exclusions(self, thickest, &key)?;
        let zones = self.thick_zones(wish)?;
        let across = extent(around(self.start.iter().copied()));
        if thickest > across {
            self.warnings.push(format!(
                "{key} is {} m, and all of the body is {across:.3} m across: whatever comes near it touches all of \
                 it; 0.002 to 0.005 m is usual for cloth (mm are divided by 1000)",
                plain(thickest)
            ));
        }
        let SelfCollision { thickness, friction, .. } = *wish;
        let thickest = (thickest, zone.cloned());
        self.extensions.insert(SurfaceContact { thickness, friction, neighbours, zones, thickest });
        Ok(())
    }

    /// The zones that keep another distance.
    fn thick_zones(&self, wish: &SelfCollision) -> Result<Vec<ThickZone>, SceneError> {
        if wish.zones.is_empty() {
            return Ok(Vec::new());
        }
        let named = wish.zones.iter().map(|(name, zone)| (name, &zone.select));
        let of_triangles = self.zones("self_collision.zone", &self.user_surface(), named)?;
        let of_zone = |(number, zone): (usize, &ContactZone)| {
            let all = of_triangles.iter().enumerate();
            let triangles = all.filter(|(_, of)| **of == number).map(|(triangle, _)| triangle).collect();
            ThickZone { thickness: zone.thickness, triangles }
        };
        Ok((1..).zip(wish.zones.values()).map(of_zone).collect())
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

    /// Bodies that do not touch, though they have contact of this form.
    pub fn apart(&self) -> Option<&Apart> {
        self.extensions.get()
    }

    /// Lists the surfaces of all bodies that have contact of this form.
    pub(crate) fn add_surfaces(&mut self, scene: &Scene) {
        let apart = apart(scene);
        let places = self.places;
        let mut all = Surfaces { surface_of: vec![NONE; places], places, ..Surfaces::default() };
        let mut listed = Listed { held: vec![true; places], ..Listed::default() };
        let mut triangles = Vec::new();
        all.start = vec![[0.0; 3]; places];
        let mut numbers = Vec::new();
        for (index, body) in self.bodies.iter().enumerate() {
            numbers.push(all.materials.len() as u32);
            all.add_body(body, &mut listed, &mut triangles);
            all.layers.resize(all.materials.len(), self.meetings().of_body(index));
        }
        all.apart = apart.0.iter().map(|pair| pair.map(|body| numbers[body])).collect();
        if triangles.is_empty() {
            return;
        }
        all.soft = all.materials.len();
        self.attachments().joined().for_each(|pair| listed.join(pair));
        all.points = self.points();
        listed.average_points(&all.points);
        let mut of_colliders = Vec::new();
        for (index, collider) in self.colliders().iter().enumerate() {
            of_colliders.push(all.materials.len() as u32);
            triangles.extend(all.add_collider(collider));
            all.layers.resize(all.materials.len(), self.meetings().of_collider(index));
        }
        if self.meetings().all_meet() {
            all.layers = Vec::new();
        }
        let materials = all.add_zones(&listed, &triangles);
        all.frictions = self.frictions_of(&numbers, &of_colliders);
        listed.held.resize(all.start.len(), true);
        all.points.extend(places as u32..all.start.len() as u32);
        all.thickest = all.materials.iter().map(|[thickness, _]| *thickness).fold(0.0, f64::max);
        all.thinnest = all.least_thickness();
        let mut order = leaf_order(&all.start, &triangles);
        let surface = |triangle: u32| all.surface_of[triangles[triangle as usize][0] as usize];
        order.sort_by_key(|&triangle| (surface(triangle), materials[triangle as usize]));
        all.triangles = order.iter().map(|&triangle| triangles[triangle as usize]).collect();
        let materials: Vec<u32> = order.into_iter().map(|triangle| materials[triangle as usize]).collect();
        all.cut(&materials, &listed);
        all.start_tangled = self.note_piercings(&all);
        let with_surface =
            self.bodies.iter().enumerate().filter(|(_, body)| body.surface_contact().is_some());
        let with_surface: Vec<usize> = with_surface.map(|(body, _)| body).collect();
        self.lead_out(&with_surface);
        self.extensions.insert(all);
        self.extensions.insert(apart);
    }

    /// The friction of pairs of surfaces that the scene names, by the surfaces of bodies and colliders.
    fn frictions_of(&self, bodies: &[u32], colliders: &[u32]) -> HashMap<[u32; 2], f64> {
        let (named, mut all) = (self.frictions(), HashMap::new());
        let has_surface = |body: usize| self.bodies[body].surface_contact().is_some();
        let has_faces = |collider: usize| self.colliders()[collider].faces().is_some();
        for (a, &of_a) in bodies.iter().enumerate().filter(|&(a, _)| has_surface(a)) {
            for (b, &of_b) in bodies.iter().enumerate().skip(a).filter(|&(b, _)| has_surface(b)) {
                all.extend(named.of_bodies(a, b).map(|friction| ([of_a, of_b], friction)));
            }
            let with_faces = colliders.iter().enumerate().filter(|&(collider, _)| has_faces(collider));
            for (collider, &of_collider) in with_faces {
                all.extend(named.of_collider(a, collider).map(|friction| ([of_a, of_collider], friction)));
            }
        }
        all
    }

    /// Warns of surfaces that start through each other. Returns whether there are any.
    fn note_piercings(&mut self, all: &Surfaces) -> bool {
        let surface = |triangle: u32| all.surface_of[all.triangles[triangle as usize][0] as usize];
        let touch = |pair: [u32; 2]| all.material(pair.map(surface)).is_some();
        let found = piercings_apart(&all.start, &all.triangles, |place| all.points[place as usize], touch);
        let Some(Piercing { edge, triangle }) = found.first else { return false };
        let ends =
            if (edge[0] as usize) < all.places { [edge[0], edge[1]] } else { [triangle[0], triangle[1]] };
        let index = self.number_of_body(ends[0]);
        let body = &mut self.bodies[index];
        let [a, b] = ends.map(|node| body.vertex_of_solver(node as usize - body.first));
        body.warnings.push(format!(
            "surfaces start through each other: {} pairs of an edge and a triangle, one of them at its vertices {a} and {b}; they \
             are pulled apart while the scene runs, and until then `intersections` in frames.csv counts them",
            found.pairs
        ));
        true
    }
}

impl Surfaces {
    /// Adds a body and its triangles by place, none if it has no contact of this form.
    fn add_body(&mut self, body: &BodyAssembly, listed: &mut Listed, triangles: &mut Vec<[u32; 3]>) {
        let Some(contact) = body.surface_contact() else { return };
        let (first, number) = (body.first, self.materials.len() as u32);
        self.surface_of[first..first + body.nodes].fill(number);
        self.start[first..first + body.nodes].copy_from_slice(&body.start);
        for (held, free) in listed.held[first..].iter_mut().zip(&body.free) {
            *held = !free;
        }
        self.materials.push([contact.thickness, contact.friction]);
        listed.neighbours.push((first, body.grid_layout, contact.neighbours.clone()));
        let place = |node: u32| body.solver_index(node as usize) as u32;
        body.split.iter().for_each(|pair| listed.join(pair.map(place)));
        let before = triangles.len();
        listed.zones.extend(contact.zones.iter().map(|zone| {
            let of_all = zone.triangles.iter().map(|triangle| before + triangle).collect();
            (number, ThickZone { triangles: of_all, ..*zone })
        }));
        triangles.extend(body.user_surface().triangles.iter().map(|triangle| triangle.map(place)));
    }

    /// Adds the materials of zones behind those of all surfaces. Returns the material of each triangle.
    fn add_zones(&mut self, listed: &Listed, triangles: &[[u32; 3]]) -> Vec<u32> {
        let of_surface = |triangle: &[u32; 3]| self.surface_of[triangle[0] as usize];
        let mut all: Vec<u32> = triangles.iter().map(of_surface).collect();
        for (surface, zone) in &listed.zones {
            let number = self.materials.len() as u32;
            self.materials.push([zone.thickness, self.materials[*surface as usize][1]]);
            self.zones.push(*surface);
            zone.triangles.iter().for_each(|&triangle| all[triangle] = number);
        }
        all
    }

    /// The surface that has a material, itself or in a zone.
    fn surface_with(&self, material: u32) -> u32 {
        let surfaces = self.materials.len() - self.zones.len();
        let zone = (material as usize).checked_sub(surfaces);
        zone.map_or(material, |zone| self.zones[zone])
    }

    /// Adds a collider; its triangles, none if it is round.
    fn add_collider(&mut self, collider: &MovingCollider) -> Vec<[u32; 3]> {
        let Some(faces) = collider.faces() else { return Vec::new() };
        let (first, corners) = (self.start.len(), collider.corners(0.0));
        let number = self.materials.len() as u32;
        self.materials.push([collider.offset(), collider.friction()]);
        self.surface_of.extend(corners.iter().map(|_| number));
        self.outsides.push(outside(faces, &corners));
        self.start.extend(corners);
        faces.iter().map(|face| face.map(|corner| first as u32 + corner)).collect()
    }

    /// On which side of the triangles of a surface outside is, 1 where their normals point or -1, if it is that of a closed
    /// collider.
    pub fn outside(&self, surface: u32) -> Option<i64> {
        let collider = (surface as usize).checked_sub(self.soft)?;
        self.outsides.get(collider).copied().filter(|&side| side != 0)
    }

    /// Nodes of bodies that never give way, by place.
    pub fn held_nodes(&self) -> HashSet<u32> {
        let held = self.leaves.iter().flat_map(|leaf| {
            let lanes = leaf.own().iter().enumerate();
            lanes.filter(|(lane, _)| leaf.held >> lane & 1 == 1).map(|(_, &node)| node)
        });
        held.filter(|&node| (node as usize) < self.places).collect()
    }

    /// The triangles around a place: for each, its other two corners.
    pub fn fan(&self, place: u32) -> impl Iterator<Item = [u32; 2]> + use<'_> {
        fan(&self.corners_at, &self.triangles, place)
    }

    /// Number of places, those of corners of colliders among them.
    pub fn all_places(&self) -> usize {
        self.start.len()
    }

    /// The longest way that nodes go in one round of the filter [m].
    pub fn longest_way(&self) -> f64 {
        self.thickest.max(self.mean_edge)
    }

    /// Corners of colliders at the start [m].
    pub fn corners(&self) -> &[[f64; 3]] {
        &self.start[self.places..]
    }

    /// Cuts the triangles, which have these materials, into leaves, and measures their edges.
    fn cut(&mut self, materials: &[u32], listed: &Listed) {
        let Cut { leaves, edges, vertices } = Cut::new(&self.triangles, materials, &listed.held);
        (self.leaves, self.edges, self.vertices) = (leaves, edges, vertices);
        let lengths = self.edges.iter().map(|&edge| measure::length(&self.start, edge));
        self.corners_at = Csr::corners(self.all_places(), &self.triangles);
        self.longest_edge = lengths.clone().fold(0.0, f64::max);
        let soft = self.edges.iter().zip(lengths).filter(|(edge, _)| (edge[0] as usize) < self.places);
        let (sum, count) = soft.fold((0.0, 0_u32), |(sum, count), (_, length)| (sum + length, count + 1));
        self.mean_edge = sum / f64::from(count);
        let rings = Rings::new(&self.leaves, &self.leaves_by_place(), |node, note| {
            listed.joined.get(&node).into_iter().flatten().for_each(|&other| note(other, true));
            let surface = self.surface_of[node as usize] as usize;
            if let Some((first, layout, exclusions)) = listed.neighbours.get(surface) {
                let each = |other: usize| note((first + other) as u32, false);
                exclusions.each(*layout, node as usize - first, each);
            }
        });
        self.rings = rings;
    }

    /// The least thickness of two surfaces [m].
    fn least_thickness(&self) -> f64 {
        let least = |some: &[[f64; 2]]| some.iter().map(|[own, _]| *own).fold(f64::INFINITY, f64::min);
        let (surfaces, zones) = self.materials.split_at(self.materials.len() - self.zones.len());
        let (bodies, colliders) = surfaces.split_at(self.soft);
        let bodies = &[bodies, zones].concat();
        least(bodies).min((OFFSET * least(colliders)).max(LEAST * least(bodies)))
    }

    /// Thickness [m] and friction of pairs of two surfaces, or of materials of surfaces; `None` if both are of colliders, or do
    /// not touch.
    pub fn material(&self, materials: [u32; 2]) -> Option<[f64; 2]> {
        let surfaces = materials.map(|material| self.surface_with(material));
        let pair = [surfaces[0].min(surfaces[1]), surfaces[0].max(surfaces[1])];
        if self.apart.contains(&pair) || !self.do_meet(pair) {
            return None;
        }
        let [thickness, friction] = self.material_of_both(materials, surfaces)?;
        Some([thickness, self.frictions.get(&pair).copied().unwrap_or(friction)])
    }

    /// Whether two surfaces meet by their layers. Each meets itself.
    fn do_meet(&self, [a, b]: [u32; 2]) -> bool {
        self.layers.is_empty() || a == b || self.layers[a as usize].meets(&self.layers[b as usize])
    }

    /// The same by both sides alone.
    fn material_of_both(&self, materials: [u32; 2], surfaces: [u32; 2]) -> Option<[f64; 2]> {
        let [of_a, of_b] = materials.map(|number| self.materials[number as usize]);
        match surfaces.map(|number| number as usize >= self.soft) {
            [true, true] => None,
            [false, false] => Some([0.5 * (of_a[0] + of_b[0]), (of_a[1] * of_b[1]).sqrt()]),
            [is_first, _] => {
                let (of_collider, of_body) = if is_first { (of_a, of_b) } else { (of_b, of_a) };
                // Nodes keep the whole offset from it by themselves.
                Some([(OFFSET * of_collider[0]).max(LEAST * of_body[0]), of_collider[1]])
            }
        }
    }
}

/// On which side of triangles outside is, 1 where their normals point or -1; 0 if they do not close a surface.
fn outside(triangles: &[[u32; 3]], x: &[[f64; 3]]) -> i64 {
    let mut open = HashSet::new();
    for &[a, b, c] in triangles {
        for [from, to] in [[a, b], [b, c], [c, a]] {
            if !open.remove(&[to, from]) && !open.insert([from, to]) {
                return 0;
            }
        }
    }
    let corners = |triangle: &[u32; 3]| triangle.map(|corner| x[corner as usize]);
    let volume: f64 = triangles.iter().map(corners).map(|[a, b, c]| dot(a, cross(b, c))).sum();
    match open.is_empty() {
        true => i64::from(volume > 0.0) - i64::from(volume < 0.0),
        false => 0,
    }
}

/// The bodies that do not touch each other because one is not to touch the other.
fn apart(scene: &Scene) -> Apart {
    let wish = |body: usize| {
        scene.bodies[body].self_collision.as_ref().filter(|wish| wish.form == ContactForm::Triangles)
    };
    let count = scene.bodies.len();
    let named =
        |body: usize| wish(body).is_some_and(|wish| !wish.with.is_empty() || !wish.without.is_empty());
    let with_lists = (0..count).filter(|&body| named(body));
    let pairs = with_lists.flat_map(|one| (0..count).map(move |other| [one, other]));
    let may_touch = |one: usize, other: usize| {
        wish(one).is_none_or(|wish| one == other || wish.may_touch(&scene.body_name(other)))
    };
    let apart = pairs.filter(|&[one, other]| wish(other).is_some() && !may_touch(one, other));
    Apart(apart.map(|[one, other]| [one.min(other), one.max(other)]).collect())
}

impl Listed {
    fn join(&mut self, [a, b]: [u32; 2]) {
        self.joined.entry(a).or_default().push(b);
        self.joined.entry(b).or_default().push(a);
    }

    /// Joins the places that are sewn to the same point, also by way of others. Of very many only those are joined that have a seam
    /// of their own: all their pairs would be too many.
    fn average_points(&mut self, points: &[u32]) {
        let mut all: HashMap<u32, Vec<u32>> = HashMap::new();
        for (place, &point) in (0..).zip(points) {
            if place != point {
                all.entry(point).or_insert_with(|| vec![point]).push(place);
            }
        }
        for places in all.into_values().filter(|places| (3..=MOST_JOINED).contains(&places.len())) {
            for &place in &places {
                let others = places.iter().copied().filter(|&other| other != place);
                self.joined.entry(place).or_default().extend(others);
            }
        }
    }
}

/// Where corners of colliders are at both ends of a sub-step [m], in the order of their places.
pub struct Corners<T> {
    pub before: Vec<[T; 3]>,
    pub after: Vec<[T; 3]>,
}

/// Where corners of all colliders are at a time [m], in the order of their places.
pub fn corners_at(assembly: &Assembly, time: f64) -> impl Iterator<Item = [f64; 3]> {
    let with_faces = assembly.colliders().iter().filter(|collider| collider.faces().is_some());
    with_faces.flat_map(move |collider| collider.corners(time))
}

/// Where corners of colliders are, in a scene in which some move.
pub fn parameters<T: Real>(assembly: &Assembly, [t, h]: [f64; 2], substep: &mut Substep<T>) {
    let moves = |collider: &MovingCollider| collider.faces().is_some() && collider.moves();
    if assembly.bodies.iter().all(|body| body.surface_contact().is_none())
        || !assembly.colliders().iter().any(moves)
    {
        return;
    }
    let at = |t: f64| corners_at(assembly, t).map(|x| x.map(T::from_f64)).collect();
    substep.extensions.insert(Corners::<T> { before: at(t), after: at(t + h) });
}
