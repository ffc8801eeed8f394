//! Surfaces of triangles as colliders.
//!
//! A closed surface is solid. A position inside is moved out to the nearest point. The side follows from the
//! angle-weighted pseudonormal (Bærentzen, Aanæs, "Signed Distance Computation Using the Angle Weighted
//! Pseudonormal", 2005). An open surface is a sheet with two sides: a node is moved away from it on the side on which
//! it was. A node whose segment crosses a triangle is moved back onto the plane in which it entered. The vertices of
//! a deforming mesh move on straight lines from pose to pose.

use crate::contact::collider_mesh::hull::hull;
use crate::contact::collider_mesh::tree::{Candidates, Tree};
use crate::contact::collider_mesh::triangle::{
    Corners, Crossing, Nearest, between, crossing, mix, nearest, normal_of, pseudonormal,
};
use crate::contact::colliders::rigid::Rigid;
use crate::motion::poses::{self, Timing};
use crate::real::{Real, add, dot, norm, scale, sub};
use crate::scene::{Collider, Mesh, SceneError, Shape};
use crate::topology::ground;
use crate::topology::{Edges, Placement, Surface, measure, shapes};

/// A mesh over time, placed.
#[derive(Clone, Debug)]
pub struct MeshShape {
    /// Nodes [m] in each pose; one pose if it is rigid.
    pub poses: Vec<Vec<[f64; 3]>>,
    /// Triangles in the order of the tree.
    pub triangles: Vec<[u32; 3]>,
    /// Boxes of the tree in each interval between poses and the one before; one set if there is one pose.
    pub boxes: Vec<Vec<[[f64; 3]; 2]>>,
    /// Whether it has an inside.
    pub solid: bool,
    timing: Timing,
    /// Largest distance of a node's motion up to each pose [m].
    travel: Vec<f64>,
    /// Largest coordinate of a node [m].
    extent: f64,
}

/// A mesh at the end of a sub-step.
#[derive(Clone, Copy, Debug)]
pub struct MeshNow<T> {
    /// The number of the mesh.
    pub index: u32,
    /// Its placement.
    pub place: Rigid<T>,
    /// The pose that it comes from, and the fraction of the motion to the next pose at both ends of the sub-step.
    /// Below 0: on the motion from the pose before.
    pub pose: u32,
    pub pose_fractions: [T; 2],
    /// Rate of that fraction [1/s].
    pub rate: T,
    /// Distance kept to nodes [m].
    pub offset: T,
    /// Bounds of the motion of any node since the first pose, and in the sub-step [m].
    pub travel: T,
    pub stride: T,
}

/// A mesh in a backend's numbers.
#[derive(Clone, Debug)]
pub struct MeshSurface<T> {
    /// Corners of each triangle [m] in each pose.
    pub poses: Vec<Vec<Corners<T>>>,
    pub triangles: Vec<[u32; 3]>,
    pub trees: Vec<Tree<T>>,
    pub solid: bool,
}

/// The contact of a node, in the mesh's own frame.
#[derive(Clone, Copy, Debug)]
pub struct MeshContact<T> {
    /// Depth [m].
    pub depth: T,
    /// Outward unit normal.
    pub normal: [T; 3],
    /// Velocity of the surface by the change of shape [m/s].
    pub velocity: [T; 3],
    /// Whether the node's segment crosses the mesh.
    pub passed: bool,
}

/// The triangle nearest to a position: of several at the same distance, the first.
#[derive(Clone, Copy, Debug)]
pub struct Found<T> {
    pub triangle: u32,
    pub at: Nearest<T>,
}

/// The crossings of a segment.
struct Passage<T> {
    /// The first triangle, and its crossing.
    triangle: u32,
    hit: Crossing<T>,
    /// Whether any triangle is crossed outward.
    comes_out: bool,
}

/// Least offset from nodes, in units in the last place of their positions. A node on a face must not be behind it by
/// rounding, or its next crossing would be missed.
const LEAST_OFFSET: f64 = 16.0;

/// Square of the cosine below which a surface is seen at a grazing angle, and another may be nearer.
pub(crate) const GRAZING: f64 = 1.0 / 64.0;

impl MeshShape {
    /// Whether it is deforming.
    pub fn deforms(&self) -> bool {
        self.poses.len() > 1
    }

    /// Its placement at time `t` + `h` [s], having moved since `t`.
    pub fn at<T: Real>(&self, index: u32, place: Rigid<T>, offset: f64, (t, h): (f64, f64)) -> MeshNow<T> {
        let (before, after) = (self.timing.in_poses(t), self.timing.in_poses(t + h));
        let pose = (after.ceil() as usize).saturating_sub(1);
        // No sub-step is longer than the time between two poses, except by rounding.
        let fraction = |time: f64| (time - pose as f64).max(-1.0);
        let (way, travel) = (self.travel(before), self.travel(after));
        let extent = place.shift.iter().fold(self.extent, |most, x| most.max(x.to_f64().abs()));
        let least = LEAST_OFFSET * T::EPSILON.to_f64() * extent;
        MeshNow {
            index,
            place,
            pose: pose as u32,
            pose_fractions: [fraction(before), fraction(after)].map(T::from_f64),
            rate: T::from_f64((after - before) / h),
            offset: T::from_f64(offset.max(least)),
            travel: T::from_f64(travel),
            stride: T::from_f64(travel - way),
        }
    }

    /// Nodes at time `t` [s], before its rigid motion [m].
    pub fn nodes(&self, t: f64) -> Vec<[f64; 3]> {
        poses::at(&self.poses, self.timing.in_poses(t))
    }

    /// Largest distance of a node's motion up to a time, counted in poses [m].
    fn travel(&self, time: f64) -> f64 {
        let pose = (time.floor() as usize).min(self.travel.len() - 1);
        let next = (pose + 1).min(self.travel.len() - 1);
        self.travel[pose] + (self.travel[next] - self.travel[pose]) * (time - pose as f64)
    }

    /// In a backend's numbers.
    pub fn surface<T: Real>(&self) -> MeshSurface<T> {
        let corners = |pose: &[[f64; 3]], triangle: &[u32; 3]| {
            triangle.map(|node| pose[node as usize].map(T::from_f64))
        };
        MeshSurface {
            poses: self
                .poses
                .iter()
                .map(|pose| self.triangles.iter().map(|t| corners(pose, t)).collect())
                .collect(),
            triangles: self.triangles.clone(),
            trees: self.boxes.iter().map(|boxes| Tree::of(boxes, self.triangles.len())).collect(),
            solid: self.solid,
        }
    }
}

/// The triangles of a mesh collider, for sub-steps of at most `step` [s].
pub fn mesh_shape(collider: &Collider, shape: Shape<'_>, step: f64) -> Result<Option<MeshShape>, SceneError> {
    let at = |key: &'static str| move |message: String| SceneError::new(key, message);
    let (mut surface, key) = match shape {
        Shape::Mesh(mesh) => (shapes::surface(mesh).map_err(at("mesh"))?, "mesh"),
        Shape::Convex(mesh) => (hull_of(mesh).map_err(at("convex"))?, "convex"),
        Shape::Heightfield(field) => (ground(field).map_err(at("heightfield"))?, "heightfield"),
        _ => return Ok(None),
    };
    if surface.triangles.is_empty() {
        return Err(SceneError::new(key, "has no triangles; a surface would do"));
    }
    let edges = Edges::new(surface.nodes.len(), &surface.triangles, &[]);
    let solid = edges.is_closed();
    if !solid && collider.offset <= 0.0 {
        let message = "is 0 m, and the mesh is not closed: it has two sides; more would do";
        return Err(SceneError::new("offset", message));
    }
    if solid && measure::volume(&surface.nodes, &surface.triangles) < 0.0 {
        surface.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    }
    let placement = Placement::new(&collider.place, &surface.nodes)
        .map_err(|(field, message)| SceneError::new(field, message))?;
    let mut poses = match &collider.poses {
        None => vec![surface.nodes.clone()],
        Some(_) if key != "mesh" => {
            return Err(at("poses")(format!("are those of a mesh, and this is a {key}")));
        }
        Some(given) => poses::given(given, &surface, solid)?,
    };
    poses.iter_mut().for_each(|pose| placement.apply_all(pose));
    let extent = poses.iter().flatten().flatten().fold(0.0, |most: f64, x| most.max(x.abs()));
    let (poses, timing) = match &collider.poses {
        None => (poses, Timing::STILL),
        Some(given) => Timing::fit(poses, given, step),
    };
    Ok(Some(MeshShape::new((poses, timing), &surface.triangles, solid, extent)))
}

/// Vertices without a face count, too.
fn hull_of(mesh: &Mesh) -> Result<Surface, String> {
    let Surface { mut nodes, vertices, node_of_vertex, .. } = shapes::surface(mesh)?;
    let nodes_of = node_of_vertex.unwrap_or_default();
    let loose = nodes_of.iter().zip(&vertices).filter(|(node, _)| **node == u32::MAX);
    nodes.extend(loose.map(|(_, place)| place));
    hull(&nodes)
}

impl MeshShape {
    fn new(
        (poses, timing): (Vec<Vec<[f64; 3]>>, Timing),
        triangles: &[[u32; 3]],
        solid: bool,
        extent: f64,
    ) -> Self {
        let (triangles, boxes) = Tree::<f64>::boxes(&poses, triangles);
        let way = |pair: &[Vec<[f64; 3]>]| {
            pair[0].iter().zip(&pair[1]).map(|(a, b)| norm(sub(*b, *a))).fold(0.0, f64::max)
        };
        let mut travel = vec![0.0];
        for pair in poses.windows(2) {
            travel.push(travel[travel.len() - 1] + way(pair));
        }
        Self { poses, triangles, boxes, solid, timing, travel, extent }
    }
}

impl<T: Real> MeshNow<T> {
    /// The same for nodes that start at its final position.
    pub fn arrived(&self) -> Self {
        Self { pose_fractions: [self.pose_fractions[1]; 2], stride: T::ZERO, ..*self }
    }

    /// A position in the mesh's frame [m].
    #[inline(always)]
    pub fn local(&self, x: [T; 3]) -> [T; 3] {
        self.place.back(x)
    }
}

impl<T: Real> MeshSurface<T> {
    /// Corners of a triangle [m], at a fraction of the motion to the next pose.
    #[inline(always)]
    pub fn corners(&self, now: &MeshNow<T>, triangle: u32, fraction: T) -> Corners<T> {
        let triangle = triangle as usize;
        if let [only] = self.poses.as_slice() {
            return only[triangle];
        }
        let earlier = fraction < T::ZERO;
        let pose = if earlier { now.pose as usize - 1 } else { now.pose as usize };
        let fraction = if earlier { fraction + T::ONE } else { fraction };
        let (from, to) = (&self.poses[pose][triangle], &self.poses[pose + 1][triangle]);
        [0, 1, 2].map(|i| between(from[i], to[i], fraction))
    }

    /// Velocity of a point of a triangle [m/s] by the change of shape.
    fn velocity(&self, now: &MeshNow<T>, triangle: u32, barycentric: [T; 3]) -> [T; 3] {
        if self.poses.len() < 2 {
            return [T::ZERO; 3];
        }
        let (pose, triangle) = (now.pose as usize, triangle as usize);
        let (from, to) = (&self.poses[pose][triangle], &self.poses[pose + 1][triangle]);
        mix(&[0, 1, 2].map(|i| scale(sub(to[i], from[i]), now.rate)), barycentric)
    }

    /// The tree of its interval between poses.
    pub fn tree(&self, now: &MeshNow<T>) -> &Tree<T> {
        &self.trees[(now.pose as usize).min(self.trees.len() - 1)]
    }

    /// The depth of a position, offset included [m]; `None` if no triangle is closer than the root of `most` [m²].
    pub fn depth(&self, now: &MeshNow<T>, x: [T; 3], most: T) -> Option<T> {
        let found = self.nearest_of(now, x, most)?;
        Some(self.resting(now, x, &found, &self.tree(now).around(x, found.at.squared)).depth)
    }

    /// The nearest point, if it is closer than the root of `most` [m²].
    fn nearest_of(&self, now: &MeshNow<T>, x: [T; 3], most: T) -> Option<Found<T>> {
        let mut best: Option<Found<T>> = None;
        let bound = |best: Option<Found<T>>| best.map_or(most, |best| best.at.squared);
        self.tree(now).visit_around(x, most, |triangles| {
            for triangle in triangles {
                let at = nearest(x, &self.corners(now, triangle, now.pose_fractions[1]));
                let is_first =
                    best.is_some_and(|best| at.squared == best.at.squared && triangle < best.triangle);
                if at.squared < bound(best) || is_first {
                    best = Some(Found { triangle, at });
                }
            }
            bound(best)
        });
        best
    }

    /// The crossings of a segment while the mesh moves.
    fn passage(&self, now: &MeshNow<T>, way: [[T; 3]; 2], among: &impl Candidates<T>) -> Option<Passage<T>> {
        let mut first: Option<(u32, Crossing<T>)> = None;
        let mut comes_out = false;
        among.visit(|triangle| {
            let [before, after] = now.pose_fractions.map(|fraction| self.corners(now, triangle, fraction));
            if let Some(found) = crossing(way, &before, &after) {
                comes_out |= !found.inward;
                let sooner = first.as_ref().is_none_or(|(which, first)| {
                    found.fraction < first.fraction || (found.fraction == first.fraction && triangle < *which)
                });
                if sooner {
                    first = Some((triangle, found));
                }
            }
        });
        first.map(|(triangle, hit)| Passage { triangle, hit, comes_out })
    }

    /// The outward direction of a solid at the nearest point, of any length.
    fn outward(&self, now: &MeshNow<T>, x: [T; 3], found: &Found<T>, among: &impl Candidates<T>) -> [T; 3] {
        let Found { triangle, at } = found;
        let own = at.barycentric.map(|fraction| fraction != T::ZERO);
        let way = if own == [true; 3] {
            normal_of(&self.corners(now, *triangle, now.pose_fractions[1]))
        } else {
            self.pseudonormal(now, (*triangle, own), among)
        };
        let is_grazing = facing(at, way) < T::from_f64(GRAZING);
        if is_grazing && at.squared > rounding(x) { self.most_facing(now, x, found, way, among) } else { way }
    }

    /// The outward direction at the nearest point, or the normal of a triangle at the same distance up to rounding,
    /// whichever faces the position most. A triangle at a grazing angle may be the nearest by rounding, and its
    /// normal is meaningless then.
    fn most_facing(
        &self,
        now: &MeshNow<T>,
        x: [T; 3],
        found: &Found<T>,
        way: [T; 3],
        among: &impl Candidates<T>,
    ) -> [T; 3] {
        let bound = found.at.squared * (T::ONE + T::EPSILON * T::from_f64(16.0));
        let mut best = (facing(&found.at, way), way);
        among.visit(|other| {
            let corners = self.corners(now, other, now.pose_fractions[1]);
            let (at, normal) = (nearest(x, &corners), normal_of(&corners));
            let faces = facing(&at, normal);
            if at.squared <= bound && faces > best.0 {
                best = (faces, normal);
            }
        });
        best.1
    }

    /// Sum over the triangles that share the corner or edge `own` of a triangle.
    fn pseudonormal(
        &self,
        now: &MeshNow<T>,
        (triangle, own): (u32, [bool; 3]),
        among: &impl Candidates<T>,
    ) -> [T; 3] {
        let nodes = self.triangles[triangle as usize];
        let feature = |node: u32| (0..3).any(|i| own[i] && nodes[i] == node);
        let wanted = own.iter().filter(|&&own| own).count();
        let mut sum = [T::ZERO; 3];
        among.visit(|other| {
            let at = self.triangles[other as usize].map(feature);
            if at.iter().filter(|&&at| at).count() == wanted {
                sum = add(sum, pseudonormal(&self.corners(now, other, now.pose_fractions[1]), at));
            }
        });
        sum
    }

    /// The contact of a node that moves straight from `start` to `end`, both in the mesh's frame. `at_end` is the
    /// contact by the nearest point, if that is close; `across` are the triangles that the segment may cross.
    pub fn contact_on_segment(
        &self,
        now: &MeshNow<T>,
        way: [[T; 3]; 2],
        at_end: Option<MeshContact<T>>,
        across: &impl Candidates<T>,
    ) -> Option<MeshContact<T>> {
        if let Some(passage) = self.passage(now, way, across)
            && self.has_passed(at_end.as_ref(), &passage, way)
        {
            let Passage { triangle, hit, .. } = passage;
            let [_, after] = now.pose_fractions.map(|fraction| self.corners(now, triangle, fraction));
            let plane = mix(&after, hit.barycentric);
            return Some(MeshContact {
                depth: now.offset - dot(sub(way[1], plane), hit.normal),
                normal: hit.normal,
                velocity: self.velocity(now, triangle, hit.barycentric),
                passed: true,
            });
        }
        at_end.filter(|at_end| at_end.depth > T::ZERO)
    }

    /// Whether a node that crossed a triangle is on the wrong side, so that the direction to the nearest point does
    /// not lead back. It leads on, or the node has come out again, for example to enter another part of the mesh. The
    /// side of a sheet is unknown if the node started on it up to rounding.
    fn has_passed(
        &self,
        at_end: Option<&MeshContact<T>>,
        passage: &Passage<T>,
        [start, end]: [[T; 3]; 2],
    ) -> bool {
        let leads_on = |at_end: &MeshContact<T>| {
            at_end.depth <= T::ZERO || dot(at_end.normal, sub(end, start)) > T::ZERO
        };
        let Passage { hit, comes_out, .. } = passage;
        if self.solid {
            hit.inward && (*comes_out || at_end.is_none_or(leads_on))
        } else {
            hit.from > rounding(start)
        }
    }

    /// Depth and normal at `x` by the nearest point.
    pub fn resting(
        &self,
        now: &MeshNow<T>,
        x: [T; 3],
        found: &Found<T>,
        around: &impl Candidates<T>,
    ) -> MeshContact<T> {
        let Found { triangle, at } = found;
        let distance = at.squared.sqrt();
        let corners = self.corners(now, *triangle, now.pose_fractions[1]);
        let outward = if self.solid { self.outward(now, x, found, around) } else { normal_of(&corners) };
        // The side of a sheet from which a segment crosses its plane.
        let from = if self.solid { at.apart } else { sub(x, corners[0]) };
        let within = dot(from, outward) < T::ZERO;
        let side = if self.solid && within { -T::ONE } else { T::ONE };
        // At rounding distance, the direction from the nearest point is undefined.
        let far = at.squared > rounding(x);
        let normal = if far {
            scale(at.apart, side / distance)
        } else {
            let length = norm(outward);
            let inverse = T::ONE / if length > T::ZERO { length } else { T::ONE };
            scale(outward, if within && !self.solid { -inverse } else { inverse })
        };
        MeshContact {
            depth: now.offset - distance * side,
            normal,
            velocity: self.velocity(now, *triangle, at.barycentric),
            passed: false,
        }
    }
}

/// Square of the cosine between the direction from the nearest point and another.
fn facing<T: Real>(at: &Nearest<T>, way: [T; 3]) -> T {
    let along = dot(at.apart, way);
    along * along / (at.squared * dot(way, way) + T::TINY)
}

/// Squared rounding error of a position [m²].
fn rounding<T: Real>(x: [T; 3]) -> T {
    let lost = T::EPSILON * T::from_f64(8.0);
    lost * lost * dot(x, x) + T::TINY
}
