//! Flat meshes of a rectangle or a disc, in three patterns that may be turned against the outline.

use spade::{ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation};
use std::f64::consts::TAU;
use std::fmt;
use taffeta::topology::random::SplitMix64;

/// A place in the plane [m].
pub type Point = [f64; 2];

/// How triangles are laid within an outline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pattern {
    /// Squares, each with the same diagonal.
    Grid,
    /// Triangles of three equal sides.
    Equilateral,
    /// Triangles between nodes that are shifted at random by up to 0.3 edges.
    Irregular,
}

impl Pattern {
    /// All three.
    pub const ALL: [Self; 3] = [Self::Equilateral, Self::Grid, Self::Irregular];
}

impl fmt::Display for Pattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Grid => "grid",
            Self::Equilateral => "equilateral",
            Self::Irregular => "irregular",
        })
    }
}

/// A pattern of edges of one length, turned.
#[derive(Clone, Copy, Debug)]
pub struct Lattice {
    /// How triangles are laid.
    pub pattern: Pattern,
    /// Length of an edge [m].
    pub edge: f64,
    /// Turn of the pattern against the outline [degrees].
    pub turn: f64,
}

/// A flat mesh.
#[derive(Clone, Debug, Default)]
pub struct Flat {
    /// Nodes [m].
    pub nodes: Vec<Point>,
    /// Counter-clockwise.
    pub triangles: Vec<[u32; 3]>,
}

/// Nearer than this to an outline a lattice has no node [edges].
const CLEAR: f64 = 0.45;

impl Flat {
    /// A rectangle from one corner to the other. Nodes stand in a row at each of `lines`, across it at these x [m].
    pub fn rectangle(low: Point, high: Point, lines: &[f64], lattice: Lattice) -> Self {
        let edge = lattice.edge;
        let corners = [low, [high[0], low[1]], high, [low[0], high[1]]];
        let mut paths: Vec<Path> = vec![Path::closed(&corners, edge, lines)];
        paths.extend(lines.iter().map(|&x| Path::open([x, low[1]], [x, high[1]], edge)));
        let inside = |[x, y]: Point| x > low[0] && x < high[0] && y > low[1] && y < high[1];
        // A lattice that is not turned starts at the first line, so that its columns are where the lines are.
        let origin = [lines.first().copied().unwrap_or(low[0]), low[1]];
        triangulated(&paths, &lattice.nodes(origin, [low, high], inside), lattice)
    }

    /// A disc about the origin. Nodes stand in a circle at each of `circles` [m], too.
    pub fn disc(radius: f64, circles: &[f64], lattice: Lattice) -> Self {
        let all = circles.iter().copied().chain([radius]);
        let paths: Vec<Path> = all.map(|radius| Path::circle(radius, lattice.edge)).collect();
        let inside = |[x, y]: Point| x.hypot(y) < radius;
        triangulated(&paths, &lattice.nodes([0.0; 2], [[-radius; 2], [radius; 2]], inside), lattice)
    }

    /// Nodes that satisfy a condition.
    pub fn select(&self, mut is_wanted: impl FnMut(Point) -> bool) -> Vec<usize> {
        (0..self.nodes.len()).filter(|&node| is_wanted(self.nodes[node])).collect()
    }

    /// The mesh as OBJ in the xz plane, its first coordinate along x, with texture coordinates in metres: the warp runs along x.
    pub fn obj(&self) -> String {
        self.placed(|[x, z]| [x, 0.0, z])
    }

    /// The same, with each node at another place [m]: at rest the mesh is still flat where a fabric's curvature is, but not its edges.
    pub fn placed(&self, place: impl Fn(Point) -> [f64; 3]) -> String {
        let mut text = String::new();
        for &[u, v] in &self.nodes {
            let [x, y, z] = place([u, v]);
            text += &format!("v {x:?} {y:?} {z:?}\nvt {u:?} {v:?}\n");
        }
        for triangle in &self.triangles {
            // Seen from +y, z points down the page: the other way round.
            let [a, b, c] = triangle.map(|node| node + 1);
            text += &format!("f {a}/{a} {c}/{c} {b}/{b}\n");
        }
        text
    }

    /// Length of the border that belongs to each node, and the sum of its normals times that length [m]: what a traction of 1 N/m
    /// in the plane means for the node.
    pub fn border_normals(&self) -> Vec<Point> {
        let mut normals = vec![[0.0; 2]; self.nodes.len()];
        let mut sides: Vec<[u32; 2]> =
            self.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
        sides.sort_unstable();
        for &[a, b] in sides.iter().filter(|[a, b]| sides.binary_search(&[*b, *a]).is_err()) {
            let [from, to] = [a, b].map(|node| self.nodes[node as usize]);
            for node in [a, b] {
                let normal = &mut normals[node as usize];
                normal[0] += 0.5 * (to[1] - from[1]);
                normal[1] -= 0.5 * (to[0] - from[0]);
            }
        }
        normals
    }
}

/// Nodes in a row, one edge apart.
struct Path {
    nodes: Vec<Point>,
    is_closed: bool,
}

impl Path {
    fn open(from: Point, to: Point, edge: f64) -> Self {
        let count = divisions(from, to, edge);
        let nodes = (0..=count).map(|i| between(from, to, i as f64 / count as f64)).collect();
        Self { nodes, is_closed: false }
    }

    /// Around corners; sides along x have nodes at each of `stops`.
    fn closed(corners: &[Point], edge: f64, stops: &[f64]) -> Self {
        let mut nodes = Vec::new();
        for (&from, &to) in corners.iter().zip(corners.iter().cycle().skip(1)) {
            let ahead = |stop: f64| (stop - from[0]) / (to[0] - from[0]);
            let is_along = from[1] == to[1];
            let mut cuts: Vec<f64> = stops
                .iter()
                .map(|&x| ahead(x))
                .filter(|cut| is_along && *cut > 1e-9 && *cut < 1.0 - 1e-9)
                .collect();
            cuts.push(1.0);
            cuts.sort_by(f64::total_cmp);
            let mut last = from;
            for cut in cuts {
                let next = between(from, to, cut);
                let next = if is_along && cut < 1.0 { nearest_stop(next, stops) } else { next };
                let count = divisions(last, next, edge);
                nodes.extend((0..count).map(|i| between(last, next, i as f64 / count as f64)));
                last = next;
            }
        }
        Self { nodes, is_closed: true }
    }

    fn circle(radius: f64, edge: f64) -> Self {
        let count = (TAU * radius / edge).round().max(6.0) as usize;
        let angle = |i: usize| TAU * i as f64 / count as f64;
        Self {
            nodes: (0..count).map(|i| [radius * angle(i).cos(), radius * angle(i).sin()]).collect(),
            is_closed: true,
        }
    }

    fn sides(&self) -> impl Iterator<Item = [Point; 2]> {
        let last = self.is_closed.then(|| [self.nodes[self.nodes.len() - 1], self.nodes[0]]);
        self.nodes.windows(2).map(|pair| [pair[0], pair[1]]).chain(last)
    }

    fn distance(&self, point: Point) -> f64 {
        self.sides().map(|side| distance(side, point)).fold(f64::INFINITY, f64::min)
    }
}

impl Lattice {
    /// Its nodes within an outline.
    fn nodes(&self, origin: Point, [low, high]: [Point; 2], inside: impl Fn(Point) -> bool) -> Vec<Point> {
        let (edge, (sin, cos)) = (self.edge, self.turn.to_radians().sin_cos());
        let height = if self.pattern == Pattern::Grid { edge } else { edge * 0.75_f64.sqrt() };
        let reach = ((high[0] - low[0]).hypot(high[1] - low[1]) / height).ceil() as i64 + 1;
        let mut random = SplitMix64::new(1);
        let mut nodes = Vec::new();
        for row in -reach..=reach {
            for column in -reach..=reach {
                let shift = if self.pattern != Pattern::Grid && row % 2 != 0 { 0.5 } else { 0.0 };
                let mut place = [(column as f64 + shift) * edge, row as f64 * height];
                if self.pattern == Pattern::Irregular {
                    place.iter_mut().for_each(|one| *one += 0.3 * edge * (2.0 * random.unit() - 1.0));
                }
                let [u, v] = place;
                let point = [origin[0] + cos * u - sin * v, origin[1] + sin * u + cos * v];
                if inside(point) {
                    nodes.push(point);
                }
            }
        }
        nodes
    }
}

/// A node to triangulate, and its number.
struct Numbered(Point2<f64>, u32);

impl HasPosition for Numbered {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.0
    }
}

/// Triangles between the nodes of paths, whose sides are edges, and those of a lattice that are not too near to them.
fn triangulated(paths: &[Path], lattice_nodes: &[Point], lattice: Lattice) -> Flat {
    let mut nodes: Vec<Point> = Vec::new();
    let mut sides = Vec::new();
    let near = 1e-9 * lattice.edge;
    for path in paths {
        let numbers: Vec<usize> = path
            .nodes
            .iter()
            .map(|&node| {
                let same =
                    nodes.iter().position(|other| (other[0] - node[0]).hypot(other[1] - node[1]) < near);
                same.unwrap_or_else(|| {
                    nodes.push(node);
                    nodes.len() - 1
                })
            })
            .collect();
        sides.extend(numbers.windows(2).map(|pair| [pair[0], pair[1]]));
        if path.is_closed {
            sides.push([numbers[numbers.len() - 1], numbers[0]]);
        }
    }
    let clear = |node: &Point| paths.iter().all(|path| path.distance(*node) > CLEAR * lattice.edge);
    nodes.extend(lattice_nodes.iter().copied().filter(clear));
    let mut mesh = ConstrainedDelaunayTriangulation::<Numbered>::new();
    let skewed = |point: Point| lattice.skewed(point);
    // All numbers are finite, and sides of paths do not cross.
    let handles: Vec<_> = nodes
        .iter()
        .enumerate()
        .map(|(number, &node)| {
            let [x, y] = skewed(node);
            mesh.insert(Numbered(Point2::new(x, y), number as u32)).expect("places are finite")
        })
        .collect();
    for [a, b] in sides {
        mesh.add_constraint(handles[a], handles[b]);
    }
    let triangles = mesh.inner_faces().map(|face| face.vertices().map(|vertex| vertex.data().1));
    let least = 1e-6 * lattice.edge * lattice.edge;
    let is_whole = |triangle: &[u32; 3]| area(triangle.map(|node| nodes[node as usize])) > least;
    let triangles = triangles.filter(is_whole).collect();
    Flat { nodes, triangles }
}

impl Lattice {
    /// Squares have two diagonals alike; a slight skew says which is taken.
    fn skewed(&self, [x, y]: Point) -> Point {
        if self.pattern != Pattern::Grid {
            return [x, y];
        }
        let (sin, cos) = (self.turn - 45.0).to_radians().sin_cos();
        let along = 1e-4 * (cos * x + sin * y);
        [x + along * cos, y + along * sin]
    }
}

fn divisions(from: Point, to: Point, edge: f64) -> usize {
    ((to[0] - from[0]).hypot(to[1] - from[1]) / edge).round().max(1.0) as usize
}

fn between(from: Point, to: Point, at: f64) -> Point {
    [0, 1].map(|axis| from[axis] + at * (to[axis] - from[axis]))
}

fn nearest_stop([x, y]: Point, stops: &[f64]) -> Point {
    let nearest = stops.iter().copied().min_by(|a, b| (a - x).abs().total_cmp(&(b - x).abs()));
    [nearest.unwrap_or(x), y]
}

fn distance([from, to]: [Point; 2], point: Point) -> f64 {
    let (side, out) = ([to[0] - from[0], to[1] - from[1]], [point[0] - from[0], point[1] - from[1]]);
    let along = (side[0] * out[0] + side[1] * out[1]) / (side[0] * side[0] + side[1] * side[1]);
    let foot = between(from, to, along.clamp(0.0, 1.0));
    (point[0] - foot[0]).hypot(point[1] - foot[1])
}

fn area([a, b, c]: [Point; 3]) -> f64 {
    0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
}
