//! A fabric laid on a body's triangles: each at rest in its own plane, by warp and weft.

use crate::assembly::body::BodyAssembly;
use crate::real::{add, cross, dot, norm, scale, sub};
use crate::scene::{Body, Fabric, RestCurvature, SceneError, Surface, WarpWeft};
use crate::topology::{Csr, Edges, RestShape};

/// A body's triangles and what they are made of.
pub struct Laid {
    /// In the order of the surface.
    pub triangles: Vec<Triangle>,
    /// That of the body, then those of its zones.
    pub fabrics: Vec<Fabric>,
    /// Edges of the surface, in the user's order.
    pub edges: Edges,
    /// Places [m] of a, b, left, right of each edge that two triangles share.
    pub hinges: Vec<Option<[[f64; 3]; 4]>>,
    /// Whether the fabric is at rest as the mesh is.
    pub is_curved: bool,
}

/// A triangle at rest.
pub struct Triangle {
    /// Nodes by the solver's number within the body.
    pub nodes: [u32; 3],
    /// The user's numbers of the same.
    pub user: [u32; 3],
    /// Places along warp and weft [m].
    pub rest: [[f64; 2]; 3],
    /// Which of the fabrics.
    pub fabric: usize,
    /// Whether all of its corners are held.
    pub is_held: bool,
}

impl Triangle {
    /// Area [m²], not below 0.
    pub fn area(&self) -> f64 {
        let [a, b, c] = self.rest;
        0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs()
    }
}

impl Laid {
    /// Triangles in the order in which elements are listed: by their first node, so that neighbours are near each other; of each
    /// row of a grid first those of one half of a square, then those of the other, so that their nodes follow each other.
    pub fn in_order(&self, body: &BodyAssembly) -> impl Iterator<Item = (usize, &Triangle)> {
        let place = |triangle: &Triangle| {
            let first = triangle.nodes.iter().copied().min().unwrap_or(0) as usize;
            let Some([_, cols]) = body.grid_layout else { return (0, false, first) };
            let beside = triangle.nodes.iter().filter(|&&node| node as usize / cols == first / cols).count();
            (first / cols, beside < 2, first)
        };
        let mut all: Vec<(usize, &Triangle)> = self.triangles.iter().enumerate().collect();
        all.sort_by_key(|(_, triangle)| place(triangle));
        all.into_iter()
    }
}

impl BodyAssembly {
    /// Lays the body's fabric on its triangles, where it has one.
    pub fn lay_fabric(&mut self, body: &Body) -> Result<(), SceneError> {
        let Some(material) = &body.material else { return Ok(()) };
        let surface = self.user_surface();
        if surface.triangles.is_empty() {
            let message = "has a fabric, but no triangles to lay it on; springs would do";
            return Err(SceneError::new("material", message));
        }
        let shape = RestShape::of(&surface, self.placement.factor);
        let named = material.zones.iter().map(|(name, zone)| (name, &zone.select));
        let zones = self.zones("material.zone", &surface, named)?;
        let rest_scales = material.zones.values().map(|zone| zone.rest_scale);
        let factors: Vec<WarpWeft> =
            std::iter::once(None).chain(rest_scales).map(|scale| scale.unwrap_or(1.0.into())).collect();
        let base = material.fabric();
        let frames = Frames::new(self, &surface, &shape, material.warp.unwrap_or([1.0, 0.0]));
        if let (true, false) = (is_anisotropic(&base), frames.is_known()) {
            self.warnings.push(
                "its mesh has no texture coordinates, so the direction of the warp follows the mesh's own axes; warp and weft \
                 differ, and texture coordinates would say where they run"
                    .into(),
            );
        }
        self.warnings.extend(material.unusual());
        let triangle = |(index, user): (usize, &[u32; 3])| {
            let (zone, factor) = (zones[index], factors[zones[index]]);
            let rest = frames.flattened(index).map(|[u, v]| [u * factor.warp, v * factor.weft]);
            let nodes = user.map(|node| self.solver_local(node as usize) as u32);
            let is_held = nodes.iter().all(|&node| !self.free[node as usize]);
            Triangle { nodes, user: *user, rest, fabric: zone, is_held }
        };
        let triangles = surface.triangles.iter().enumerate().map(triangle).collect();
        let edges = Edges::new(surface.nodes.len(), &surface.triangles, &surface.links);
        let hinges = {
            let mut places = shape.hinges(&edges);
            edges.uses.iter().map(|&uses| if uses == 2 { places.next() } else { None }).collect()
        };
        let fabrics = std::iter::once(base).chain(material.zones.values().map(|zone| zone.fabric(&base)));
        let is_curved = material.rest_curvature == RestCurvature::Mesh;
        let laid = Laid { triangles, fabrics: fabrics.collect(), hinges, edges, is_curved };
        self.extensions.insert(Some(laid));
        Ok(())
    }

    /// Its fabric, where it has one and it is still known.
    pub fn laid(&self) -> Option<&Laid> {
        self.extensions.get::<Option<Laid>>()?.as_ref()
    }

    /// Gives its memory back once the elements are made.
    pub fn forget_laid(&mut self) {
        if self.laid().is_some() {
            self.extensions.insert(None::<Laid>);
        }
    }
}

fn is_anisotropic(fabric: &Fabric) -> bool {
    let isotropic = 0.5 * (1.0 - fabric.poisson) / (1.0 - fabric.poisson * fabric.poisson);
    fabric.stretch.warp != fabric.stretch.weft
        || fabric.bending.warp != fabric.bending.weft
        || (fabric.shear - isotropic * fabric.stretch.warp).abs() > 1e-3 * fabric.shear
}

/// Where warp and weft run on each triangle.
struct Frames<'a> {
    shape: &'a RestShape<'a>,
    /// In the pattern.
    warp: [f64; 2],
    pattern: Pattern,
}

/// What says where the warp runs.
enum Pattern {
    /// Texture coordinates by corner, where a triangle has some.
    Coordinates(Vec<Option<[[f64; 2]; 3]>>),
    /// Two axes, of a shape that is flat at rest.
    Plane([[f64; 3]; 2], bool),
    /// Nothing: the warp runs up, as far as a triangle does.
    Up,
}

impl<'a> Frames<'a> {
    fn new(body: &BodyAssembly, surface: &Surface, shape: &'a RestShape<'a>, warp: [f64; 2]) -> Self {
        let pattern = match coordinates(surface, &body.split) {
            _ if body.grid.is_some() => Pattern::Plane([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]], true),
            Some(coordinates) => Pattern::Coordinates(coordinates),
            None => shape.plane().map_or(Pattern::Up, |normal| Pattern::Plane(axes_of(normal), false)),
        };
        Self { shape, warp, pattern }
    }

    /// Whether the pattern is the user's own.
    fn is_known(&self) -> bool {
        matches!(self.pattern, Pattern::Coordinates(_) | Pattern::Plane(_, true))
    }

    /// A triangle's corners along warp and weft [m].
    fn flattened(&self, triangle: usize) -> [[f64; 2]; 3] {
        let corners = self.shape.corners(triangle);
        let normal = cross(sub(corners[1], corners[0]), sub(corners[2], corners[0]));
        let size = norm(normal);
        if size <= f64::MIN_POSITIVE {
            return [[0.0; 2]; 3];
        }
        let normal = scale(normal, 1.0 / size);
        let wanted = self.direction(triangle, corners);
        let inside = wanted.and_then(|wanted| in_plane(wanted, normal));
        let warp = inside.unwrap_or_else(|| axes_of(normal)[0]);
        let weft = cross(normal, warp);
        corners.map(|place| [dot(sub(place, corners[0]), warp), dot(sub(place, corners[0]), weft)])
    }

    /// Where the warp would run, in space.
    fn direction(&self, triangle: usize, corners: [[f64; 3]; 3]) -> Option<[f64; 3]> {
        let [along, across] = self.warp;
        match &self.pattern {
            Pattern::Plane([first, second], _) => Some(add(scale(*first, along), scale(*second, across))),
            Pattern::Up => Some([across, along, 0.0]),
            Pattern::Coordinates(all) => {
                let [a, b, c] = all[triangle]?;
                let ([u1, v1], [u2, v2]) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
                let determinant = u1 * v2 - u2 * v1;
                let size = (u1 * u1 + v1 * v1).max(u2 * u2 + v2 * v2);
                if determinant.abs() <= 1e-9 * size {
                    return None;
                }
                let first = (along * v2 - across * u2) / determinant;
                let second = (across * u1 - along * v1) / determinant;
                let (e1, e2) = (sub(corners[1], corners[0]), sub(corners[2], corners[0]));
                Some(add(scale(e1, first), scale(e2, second)))
            }
        }
    }
}

/// The part of a direction within a plane, of length 1; nothing where it is across.
fn in_plane(direction: [f64; 3], normal: [f64; 3]) -> Option<[f64; 3]> {
    let inside = sub(direction, scale(normal, dot(direction, normal)));
    let (size, all) = (norm(inside), norm(direction));
    (size > 1e-3 * all).then(|| scale(inside, 1.0 / size))
}

/// Two axes of a plane: the first two coordinate axes that it is not across.
fn axes_of(normal: [f64; 3]) -> [[f64; 3]; 2] {
    let first = if normal[0].abs() < 0.9 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let first = in_plane(first, normal).unwrap_or([1.0, 0.0, 0.0]);
    let second = cross(normal, first);
    // The other axis along y or z, whichever way the plane faces.
    let largest = if second[1].abs() >= second[2].abs() { second[1] } else { second[2] };
    [first, scale(second, if largest < 0.0 { -1.0 } else { 1.0 })]
}

/// Texture coordinates of each triangle's corners: those of the face that has all three.
fn coordinates(surface: &Surface, split: &[[u32; 2]]) -> Option<Vec<Option<[[f64; 2]; 3]>>> {
    let uvs = surface.uvs.as_ref()?;
    let (offsets, corners) = (&surface.polygons.offsets, &surface.polygons.corners);
    let range = |face: usize| offsets[face] as usize..offsets[face + 1] as usize;
    let node = |at: usize| {
        let vertex = corners[at];
        surface.node_of_vertex.as_ref().map_or(vertex, |nodes| nodes[vertex as usize])
    };
    let faces = 0..surface.polygons.len();
    let entries = faces.flat_map(|face| range(face).map(move |at| (node(at), face as u32)));
    let by_node = Csr::new(surface.nodes.len(), entries.filter(|&(node, _)| node != u32::MAX));
    // A node that no face names is one of several at a vertex's point.
    let named = |node: u32| match split.binary_search_by_key(&node, |[split, _]| *split) {
        Ok(at) => split[at][1],
        Err(_) => node,
    };
    let of_triangle = |triangle: &[u32; 3]| {
        let nodes = triangle.map(named);
        let find = |face: u32, wanted: u32| {
            let at = range(face as usize).find(|&at| node(at) == wanted)?;
            Some(uvs.coords[uvs.corners[at] as usize].map(f64::from))
        };
        by_node.row(nodes[0] as usize).iter().find_map(|&face| {
            let [a, b, c] = nodes.map(|node| find(face, node));
            Some([a?, b?, c?])
        })
    };
    Some(surface.triangles.iter().map(of_triangle).collect())
}
