//! Surfaces that pass through each other: which nodes are on the wrong side, and which way they have to go.
//!
//! Where two surfaces pass through each other there is a line, and each of them has one side of it where it belongs. There its
//! heavier part is. The nodes on the other side are astray: they go back through the other surface, row by row, and the line
//! moves along both surfaces until it leaves them. Nodes away from the line are on the side of the nearest triangle of another
//! body, if it is near, and else on that of the nearest node next to the line, so that lines need not end at a border. After Baraff,
//! Witkin, Kass, "Untangling Cloth", 2003, who need lines that cut off a part.
//!
//! Where a surface passes through itself, a line may end at a vertex that its triangles share, and then has no two sides.
//! When little of it is left, nodes beside a line leave each other alone, and edges go where it gets shorter. After Volino,
//! Magnenat-Thalmann, "Resolving Surface Collisions through Intersection Contour Minimization", 2006. With more left, new lines
//! can come faster than old ones go.
//!
//! It all follows from positions alone. Sides next to lines are decided by exact arithmetic.

use crate::contact::triangles::sides::sides;
use crate::contact::triangles::surfaces::{Kind, Surfaces};
use crate::real::{add, cross, dot, norm, scale, sub};
use crate::topology::{list_piercings, side_of_triangle};
use std::collections::{BTreeMap, HashMap, HashSet, VecDeque};

/// How unevenly the parts of a surface beside a line may weigh where the shape of the line chooses between them: their
/// difference relative to their sum.
const CHOICE: f64 = 0.5;
/// How near nodes must be to another surface to be on the side of it where they are, relative to the mean edge.
const SEEN: f64 = 2.0;
/// Surfaces are layers if their normals agree so far where they cross, as a cosine, or are against each other.
const LAYERS: f64 = 0.7;
/// How little is left where a surface passes through itself, in pairs of an edge and a triangle.
const LITTLE: usize = 16;
/// Surfaces that cross each other more steeply than with this cosine have no narrow wedge.
const STEEP: f64 = 0.2;

/// Surfaces that pass through each other.
pub struct Tangle {
    /// Pairs of an edge and a triangle that have a point in common.
    pub pairs: u64,
    /// By place.
    knots: Vec<Knot>,
    /// What moves the lines.
    pub pulls: Vec<Pull>,
}

/// What a node has to do with lines. Each has a bit; more lines than there are bits share them. A line has two sides that
/// pass through each other: a node is of the one or of the other.
#[derive(Clone, Copy, Debug, Default)]
pub struct Knot {
    /// Whose nearest line it is.
    pub of: [u32; 2],
    /// At the end of an edge that pierces the other surface, or at a triangle that is pierced.
    pub next: [u32; 2],
    /// On the wrong side of the other surface.
    pub astray: [u32; 2],
    /// Whether it belongs above the other surface, where the triangles' normals point.
    pub above: [u32; 2],
    /// Next to the last lines of a surface with itself; the same for both sides.
    pub loose: [u32; 2],
}

/// The end of an edge that pierces a triangle, and which way it is to go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pull {
    /// The end, by place.
    pub node: u32,
    /// Corners of the triangle, by place, and their weights where the edge pierces.
    pub triangle: [u32; 3],
    pub weights: [f64; 3],
    /// Where it goes, as seen from the triangle, as a unit vector: back through it along its normal, or where its line gets
    /// shorter.
    pub direction: [f64; 3],
}

impl Pull {
    /// The weights of its node and of the corners of its triangle in the vector that is to point where it goes.
    pub fn weights_of_nodes(&self) -> [f64; 4] {
        [1.0, -self.weights[0], -self.weights[1], -self.weights[2]]
    }
}

impl Surfaces {
    /// The thickness of the surfaces of a pull, and that of its contact: it goes as fast as a contact of this thickness
    /// separates [m].
    pub fn thickness_of_pull(&self, pull: &Pull) -> [f64; 2] {
        let surfaces = [pull.node, pull.triangle[0]].map(|node| self.surface_of[node as usize]);
        let [thickness, _] = self.material(surfaces).unwrap_or_default();
        [thickness, thickness.max(self.mean_edge)]
    }

    /// The gap and the thickness of a contact that leads a node out of a collider [m].
    pub fn gap_of_lift(&self) -> [f64; 2] {
        [-2.0 * self.mean_edge, self.mean_edge]
    }
}

/// What becomes of two primitives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// They keep their distance.
    Apart,
    /// They do not act on each other.
    Ignored,
    /// The vertex goes to the side of the triangle where its normal points (above), or to the other.
    Through { above: bool },
}

impl Tangle {
    /// Of surfaces whose nodes and corners of colliders are at `x` [m]; `None` if none passes through another.
    pub fn of(surfaces: &Surfaces, x: &[[f64; 3]]) -> Option<Self> {
        let surface = |triangle: u32| surfaces.surface_of[surfaces.triangles[triangle as usize][0] as usize];
        let touch = |pair: [u32; 2]| surfaces.material(pair.map(surface)).is_some();
        let cuts = list_piercings(x, &surfaces.triangles, |place| surfaces.points[place as usize], touch);
        if cuts.is_empty() {
            return None;
        }
        let pairs = cuts.len() as u64;
        let look = Look { surfaces, x, beside: beside(surfaces, &cuts) };
        let mut by_pair: BTreeMap<[u32; 2], Vec<Cut>> = BTreeMap::new();
        for (edge, triangle) in cuts {
            let (a, b) = (surfaces.surface_of[edge[0] as usize], surface(triangle));
            let sides = edge.map(|node| look.side_of(triangle, node));
            by_pair.entry([a.min(b), a.max(b)]).or_default().push(Cut { edge, triangle, sides, trace: 0 });
        }
        let mut all = Self { pairs, knots: vec![Knot::default(); x.len()], pulls: Vec::new() };
        let mut first = 0;
        for (pair, cuts) in by_pair {
            let lines = look.lines(cuts);
            let count = lines.len();
            all.add(&look, pair, lines, first);
            first += count;
        }
        Some(all)
    }

    /// Adds the lines of two surfaces, or of one with itself.
    fn add(&mut self, look: &Look<'_>, pair: [u32; 2], mut lines: Vec<Line>, first: usize) {
        let labels = look.label(pair, &lines);
        let mut weights = look.weigh(pair, &labels);
        weights.find_order(pair, &lines, look);
        let pairs: usize = lines.iter().map(|line| line.cuts.len()).sum();
        let is_little = pair[0] == pair[1] && pairs <= LITTLE;
        if !is_little {
            lines.iter_mut().enumerate().for_each(|(number, line)| look.choose(line, number, &weights));
        }
        let bit = |line: usize| 1_u32 << ((first + line) % u32::BITS as usize);
        for (number, line) in lines.iter().enumerate() {
            let bit = bit(number);
            let loose = if is_little { bit } else { 0 };
            for cut in &line.cuts {
                let corners = &look.surfaces.triangles[cut.triangle as usize];
                for (nodes, trace) in [(&cut.edge[..], cut.trace), (&corners[..], 1 - cut.trace)] {
                    for knot in nodes.iter().map(|&node| node as usize) {
                        self.knots[knot].next[trace] |= bit;
                        self.knots[knot].loose = self.knots[knot].loose.map(|all| all | loose);
                    }
                }
                let belongs = line.belongs[cut.trace];
                self.pulls.extend(if is_little { look.shorten(cut) } else { look.pull(cut, belongs) });
            }
        }
        for (node, label) in labels {
            let (knot, belongs) = (&mut self.knots[node as usize], lines[label.line].belongs[label.trace]);
            let (bit, trace) = (bit(label.line), label.trace);
            knot.of[trace] |= bit;
            if i64::from(label.side) * belongs < 0 {
                knot.astray[trace] |= bit;
                knot.above[trace] |= if belongs > 0 { bit } else { 0 };
            }
        }
    }

    /// What becomes of a pair of this kind, given by its nodes.
    pub fn rule(&self, kind: Kind, nodes: [u32; 4]) -> Rule {
        Rule::of(kind, nodes.map(|node| self.knots[node as usize]))
    }

    /// What each place has to do with lines.
    #[cfg(feature = "gpu")]
    pub fn knots(&self) -> &[Knot] {
        &self.knots
    }
}

impl Rule {
    /// What becomes of a pair of this kind, whose nodes have to do with lines.
    pub fn of(kind: Kind, knots: [Knot; 4]) -> Self {
        let (one, other) = knots.split_at(kind.first());
        let [one, other] =
            [one, other].map(|some| some.iter().fold(Knot::default(), |all, knot| all.with(knot)));
        let meet = |of_one: [u32; 2], of_other: [u32; 2]| {
            (0..2).any(|trace| of_one[trace] & of_other[1 - trace] != 0)
        };
        let are_loose = meet(one.loose, other.loose);
        let (goes, is_passed) = (meet(one.astray, other.all()), meet(one.all(), other.astray));
        match kind {
            _ if are_loose => Rule::Ignored,
            Kind::VertexTriangle if goes => {
                let above = |trace: usize| one.astray[trace] & one.above[trace] & other.all()[1 - trace] != 0;
                Rule::Through { above: above(0) || above(1) }
            }
            Kind::EdgeEdge if goes || meet(one.next, other.next) => Rule::Ignored,
            _ if is_passed => Rule::Ignored,
            _ => Rule::Apart,
        }
    }
}

impl Knot {
    /// What one of two nodes has to do with lines.
    fn with(&self, other: &Self) -> Self {
        let or = |a: [u32; 2], b: [u32; 2]| [a[0] | b[0], a[1] | b[1]];
        Self {
            of: or(self.of, other.of),
            next: or(self.next, other.next),
            astray: or(self.astray, other.astray),
            above: or(self.above, other.above),
            loose: or(self.loose, other.loose),
        }
    }

    fn all(&self) -> [u32; 2] {
        [self.of[0] | self.next[0], self.of[1] | self.next[1]]
    }
}

/// An edge that pierces a triangle.
#[derive(Clone, Copy, Debug)]
struct Cut {
    edge: [u32; 2],
    /// The number of the triangle.
    triangle: u32,
    /// On which side of it the ends of the edge are.
    sides: [i8; 2],
    /// Which of the two sides of its line the edge is of.
    trace: usize,
}

/// Where surfaces pass through each other: edges and triangles from one triangle to the next.
struct Line {
    cuts: Vec<Cut>,
    /// Where each of its two sides belongs: above the other, 1, or below, -1; 0 if the other is to give way alone, or if little is
    /// left.
    belongs: [i64; 2],
}

/// What a node is a part of: the nearest line, by its number, of which of its two sides, and whether it is above the other one.
#[derive(Clone, Copy, Debug)]
struct Label {
    line: usize,
    trace: usize,
    side: i8,
}

/// Surfaces, and where their nodes and corners are [m].
struct Look<'a> {
    surfaces: &'a Surfaces,
    x: &'a [[f64; 3]],
    /// Triangles at edges that pierce others.
    beside: HashMap<[u32; 2], Vec<u32>>,
}

/// The triangles at edges that pierce others.
fn beside(surfaces: &Surfaces, cuts: &[([u32; 2], u32)]) -> HashMap<[u32; 2], Vec<u32>> {
    let mut all: HashMap<[u32; 2], Vec<u32>> = cuts.iter().map(|(edge, _)| (*edge, Vec::new())).collect();
    for (number, &[a, b, c]) in (0..).zip(&surfaces.triangles) {
        for [from, to] in [[a, b], [b, c], [c, a]] {
            if let Some(list) = all.get_mut(&[from.min(to), from.max(to)]) {
                list.push(number);
            }
        }
    }
    all
}

impl Look<'_> {
    fn side_of(&self, triangle: u32, node: u32) -> i8 {
        let corners = self.surfaces.triangles[triangle as usize].map(|corner| self.x[corner as usize]);
        side_of_triangle(corners, self.x[node as usize])
    }

    /// Sorts cuts into lines. A line goes on from each cut to the others of the same two triangles.
    fn lines(&self, mut cuts: Vec<Cut>) -> Vec<Line> {
        // The first cut of each pair of triangles, and whether its edge is of the lower one.
        let mut firsts: HashMap<[u32; 2], (usize, bool)> = HashMap::new();
        let mut roots = Roots((0..cuts.len()).map(|cut| (cut, false)).collect());
        for (number, cut) in cuts.iter().enumerate() {
            for &of_edge in &self.beside[&cut.edge] {
                let is_lower = of_edge < cut.triangle;
                let key = [of_edge.min(cut.triangle), of_edge.max(cut.triangle)];
                let &mut (first, was_lower) = firsts.entry(key).or_insert((number, is_lower));
                roots.join(first, number, was_lower != is_lower);
            }
        }
        let mut lines: BTreeMap<usize, Line> = BTreeMap::new();
        for (number, cut) in cuts.iter_mut().enumerate() {
            let (root, is_other) = roots.find(number);
            cut.trace = usize::from(is_other);
            let line = lines.entry(root).or_insert(Line { cuts: Vec::new(), belongs: [0; 2] });
            line.cuts.push(*cut);
        }
        lines.into_values().collect()
    }

    /// Labels the nodes of two surfaces, or of one: those at cut edges, and all others as the nearest of them.
    fn label(&self, pair: [u32; 2], lines: &[Line]) -> BTreeMap<u32, Label> {
        let (mut labels, mut open) = (BTreeMap::new(), VecDeque::new());
        let mut cut_edges = HashSet::new();
        for (line, cut) in
            lines.iter().enumerate().flat_map(|(line, of)| of.cuts.iter().map(move |cut| (line, cut)))
        {
            cut_edges.insert(cut.edge);
            for (&node, &side) in cut.edge.iter().zip(&cut.sides).filter(|(_, side)| **side != 0) {
                labels.entry(node).or_insert_with(|| {
                    open.push_back(node);
                    Label { line, trace: cut.trace, side }
                });
            }
        }
        let at_lines: HashSet<u32> = open.iter().copied().collect();
        let neighbours = self.neighbours(pair, &cut_edges);
        while let Some(node) = open.pop_front() {
            let label = labels[&node];
            for &other in neighbours.get(&node).into_iter().flatten() {
                labels.entry(other).or_insert_with(|| {
                    open.push_back(other);
                    label
                });
            }
        }
        if pair[0] != pair[1] {
            let others: Vec<u32> = labels.keys().copied().filter(|node| !at_lines.contains(node)).collect();
            self.see_sides(pair, &mut labels, &others);
        }
        labels
    }

    /// Nodes that are near the other surface are on the side of it where they are.
    fn see_sides(&self, [a, b]: [u32; 2], labels: &mut BTreeMap<u32, Label>, nodes: &[u32]) {
        let Surfaces { surface_of, triangles, mean_edge, .. } = self.surfaces;
        for (one, other) in [(a, b), (b, a)] {
            let is_of = |surface: u32| move |node: u32| surface_of[node as usize] == surface;
            let own: Vec<u32> = nodes.iter().copied().filter(|&node| is_of(one)(node)).collect();
            let others = triangles.iter().filter(|triangle| is_of(other)(triangle[0])).copied();
            let sides = sides(self.x, SEEN * mean_edge, &own, others);
            for (node, side) in own.iter().zip(sides).filter(|(_, side)| *side != 0) {
                if let Some(label) = labels.get_mut(node) {
                    label.side = side;
                }
            }
        }
    }

    /// The neighbours of each node along edges that are not cut.
    fn neighbours(&self, pair: [u32; 2], cut: &HashSet<[u32; 2]>) -> HashMap<u32, Vec<u32>> {
        let mut all: HashMap<u32, Vec<u32>> = HashMap::new();
        let of_pair = |edge: &&[u32; 2]| pair.contains(&self.surfaces.surface_of[edge[0] as usize]);
        for &[a, b] in self.surfaces.edges.iter().filter(of_pair).filter(|edge| !cut.contains(*edge)) {
            all.entry(a).or_default().push(b);
            all.entry(b).or_default().push(a);
        }
        all
    }

    /// The weights of the nodes beside lines. A node that is held counts as all others together, for it cannot give way.
    fn weigh(&self, pair: [u32; 2], labels: &BTreeMap<u32, Label>) -> Weights {
        let mut weights = Weights::default();
        let held = self.surfaces.held_nodes();
        for (&node, &Label { line, trace, side }) in labels {
            let weight = if held.contains(&node) { labels.len() } else { 1 };
            let of_side = usize::from(side < 0);
            weights.of_lines.entry((line, trace)).or_default()[of_side] += weight;
            if pair[0] != pair[1] {
                weights.of_surfaces.entry(self.surfaces.surface_of[node as usize]).or_default()[of_side] +=
                    weight;
            }
        }
        weights
    }

    /// Chooses where both sides of a line belong: not into a closed collider; where most of the surface is; if that is not clear,
    /// where most is beside the line; and if that is not, either, where the line's shape has it.
    fn choose(&self, line: &mut Line, number: usize, weights: &Weights) {
        let is_border = |cut: &&Cut| self.beside[&cut.edge].len() == 1;
        let borders =
            [0, 1].map(|trace| line.cuts.iter().filter(|cut| cut.trace == trace).filter(is_border).count());
        let mut costs = [f64::INFINITY; 2];
        for trace in 0..2 {
            // A tip that goes through the middle of a surface moves alone.
            if borders[trace] == 0 && borders[1 - trace] > 0 {
                continue;
            }
            let surfaces = [trace, 1 - trace].map(|trace| line.surface(self, trace));
            if let Some(outside) = self.surfaces.outside(surfaces[1]) {
                line.belongs[trace] = outside;
                continue;
            }
            let of_line = weights.of_lines.get(&(number, trace)).copied().unwrap_or_default();
            let of_surface = weights.of_surfaces.get(&surfaces[0]).copied().unwrap_or(of_line);
            let is_alone =
                !weights.are_layers && unevenness(of_surface) < CHOICE && unevenness(of_line) >= CHOICE;
            let [above, below] = if is_alone { of_line } else { of_surface };
            line.belongs[trace] = if above >= below { 1 } else { -1 };
            costs[trace] = unevenness([above, below]);
        }
        let cheapest = usize::from(costs[1] < costs[0]);
        if costs[cheapest] < CHOICE && line.is_wide(self) {
            line.belongs[cheapest] *= -1;
        }
    }

    /// The area vector of a triangle [m²], twice as long.
    fn normal(&self, triangle: u32) -> [f64; 3] {
        let [a, b, c] = self.surfaces.triangles[triangle as usize].map(|node| self.x[node as usize]);
        cross(sub(b, a), sub(c, a))
    }

    /// Leads the end of an edge that is astray back through the triangle. The edge belongs above it, 1, or below, -1.
    fn pull(&self, cut: &Cut, belongs: i64) -> Option<Pull> {
        let end = (0..2).find(|&end| i64::from(cut.sides[end]) * belongs < 0)?;
        let [from, to] = self.heights(cut, end).map(|height| height * belongs as f64);
        // Of a fold that it passes, the triangles the other way round do not lead it.
        if to >= 0.0 || from < 0.0 {
            return None;
        }
        let normal = self.normal(cut.triangle);
        self.pull_along(cut, end, scale(normal, belongs as f64))
    }

    /// Leads an edge where its line gets shorter, against the triangle. Of its ends that goes which is nearer to the triangle.
    fn shorten(&self, cut: &Cut) -> Option<Pull> {
        let [from, to] = self.heights(cut, 1);
        let normal = self.normal(cut.triangle);
        let normal = scale(normal, 1.0 / norm(normal));
        let [start, end] = cut.edge.map(|node| self.x[node as usize]);
        let along = scale(sub(end, start), 1.0 / norm(sub(end, start)));
        let mut way = [0.0; 3];
        for &beside in &self.beside[&cut.edge] {
            let corners = self.surfaces.triangles[beside as usize];
            let Some(other) = corners.into_iter().find(|node| !cut.edge.contains(node)) else { continue };
            let inwards = sub(self.x[other as usize], start);
            let inwards = sub(inwards, scale(along, dot(inwards, along)));
            // The line goes on in this triangle and in the pierced one.
            let line = cross(normal, self.normal(beside));
            let line = scale(line, dot(line, inwards).signum() / norm(line).max(f64::MIN_POSITIVE));
            way = add(way, sub(line, scale(normal, 2.0 * dot(along, line) / dot(along, normal))));
        }
        self.pull_along(cut, usize::from(from.abs() > to.abs()), way)
    }

    /// How far above a triangle an edge begins, and ends at one of its ends, times the normal's length [m³].
    fn heights(&self, cut: &Cut, end: usize) -> [f64; 2] {
        let corner = self.x[self.surfaces.triangles[cut.triangle as usize][0] as usize];
        let normal = self.normal(cut.triangle);
        [1 - end, end].map(|end| dot(normal, sub(self.x[cut.edge[end] as usize], corner)))
    }

    /// Leads an end of an edge some way, against the triangle where the edge pierces it; `None` if they have no such place, or there is
    /// no way.
    fn pull_along(&self, cut: &Cut, end: usize, way: [f64; 3]) -> Option<Pull> {
        let triangle = self.surfaces.triangles[cut.triangle as usize];
        let [a, b, c] = triangle.map(|node| self.x[node as usize]);
        let normal = self.normal(cut.triangle);
        let (squared, length) = (dot(normal, normal), norm(way));
        let [from, to] = self.heights(cut, end);
        if squared <= 0.0 || from == to || !(length > 0.0 && length < f64::INFINITY) {
            return None;
        }
        let [start, end_at] = [cut.edge[1 - end], cut.edge[end]].map(|node| self.x[node as usize]);
        let point = add(start, scale(sub(end_at, start), from / (from - to)));
        let weight =
            |from: [f64; 3], to: [f64; 3]| dot(normal, cross(sub(to, from), sub(point, from))) / squared;
        let weights = [weight(b, c), weight(c, a), weight(a, b)].map(|weight| weight.clamp(0.0, 1.0));
        let sum: f64 = weights.iter().sum();
        Some(Pull {
            node: cut.edge[end],
            triangle,
            weights: weights.map(|weight| weight / sum.max(f64::MIN_POSITIVE)),
            direction: scale(way, 1.0 / length),
        })
    }
}

/// Weights above and below the other surface: beside each line by its two sides, and of each of two surfaces.
#[derive(Default)]
struct Weights {
    of_lines: HashMap<(usize, usize), [usize; 2]>,
    of_surfaces: HashMap<u32, [usize; 2]>,
    /// Whether the surfaces lie on each other: then one is above the other wherever they cross.
    are_layers: bool,
}

impl Weights {
    /// Finds out whether two surfaces are layers. What is above of the one then weighs as what is below of the other, or above it
    /// where their normals are against each other.
    fn find_order(&mut self, [a, b]: [u32; 2], lines: &[Line], look: &Look<'_>) {
        let [agree, all] =
            lines.iter().map(|line| line.agreement(look)).fold([0.0; 2], |[s, t], [u, v]| [s + u, t + v]);
        let (Some(&of_a), Some(&of_b)) = (self.of_surfaces.get(&a), self.of_surfaces.get(&b)) else { return };
        self.are_layers = agree.abs() > LAYERS * all;
        if self.are_layers {
            let order = |[above, below]: [usize; 2], other: [usize; 2]| {
                let [with_above, with_below] = if agree > 0.0 { [other[1], other[0]] } else { other };
                [above + with_above, below + with_below]
            };
            self.of_surfaces.insert(a, order(of_a, of_b));
            self.of_surfaces.insert(b, order(of_b, of_a));
        }
    }
}

/// The difference of two weights relative to their sum.
fn unevenness(weights: [usize; 2]) -> f64 {
    let [one, other] = weights.map(|weight| weight as f64);
    (one - other).abs() / (one + other).max(1.0)
}

impl Line {
    /// The surface of one of its two sides.
    fn surface(&self, look: &Look<'_>, trace: usize) -> u32 {
        let node = self.cuts.first().map_or(0, |cut| match cut.trace == trace {
            true => cut.edge[0],
            false => look.surfaces.triangles[cut.triangle as usize][0],
        });
        look.surfaces.surface_of[node as usize]
    }

    /// How far the normals of both surfaces agree: the sum of their products, and what it would be at most [m⁴].
    fn agreement(&self, look: &Look<'_>) -> [f64; 2] {
        let mut sums = [0.0; 2];
        for cut in &self.cuts {
            let of_triangle = look.normal(cut.triangle);
            for &beside in &look.beside[&cut.edge] {
                let of_edge = look.normal(beside);
                sums[0] += dot(of_edge, of_triangle);
                sums[1] += norm(of_edge) * norm(of_triangle);
            }
        }
        sums
    }

    /// Two surfaces cross each other with four wedges between them. What is astray should be on both sides of a narrow one: to
    /// close a wide one is a long way. It is a narrow one if each belongs above the other and their normals are against each other,
    /// or one above and one below and their normals agree.
    fn is_wide(&self, look: &Look<'_>) -> bool {
        let [agree, all] = self.agreement(look);
        agree * (self.belongs[0] * self.belongs[1]) as f64 > STEEP * all
    }
}

/// Cuts that are of one line: for each another one, and whether its edge is of the other side. The lowest is the root.
struct Roots(Vec<(usize, bool)>);

impl Roots {
    fn find(&mut self, cut: usize) -> (usize, bool) {
        let (mut at, mut is_other) = (cut, false);
        while self.0[at].0 != at {
            is_other ^= self.0[at].1;
            at = self.0[at].0;
        }
        self.0[cut] = (at, is_other);
        (at, is_other)
    }

    fn join(&mut self, one: usize, other: usize, is_other: bool) {
        let ((a, of_a), (b, of_b)) = (self.find(one), self.find(other));
        if a != b {
            self.0[a.max(b)] = (a.min(b), is_other ^ of_a ^ of_b);
        }
    }
}
