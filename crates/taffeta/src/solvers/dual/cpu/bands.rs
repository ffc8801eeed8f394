//! Constraints by bands, as diagonals of a sparse matrix are stored. All constraints of a material between nodes that are
//! equally far apart in the order of nodes make a band: on a grid, each of its six directions. A band has one row for each
//! node, so sixteen rows act between two runs of sixteen nodes, and no list is read. Where a node has no constraint, its row
//! is zero.

use crate::cpu::column::Column;
use crate::cpu::shared::Shared;
use crate::cpu::simd::SimdLevel;
use crate::real::Real;
use crate::solvers::constraints::Constraints;
use crate::solvers::dual::cpu::band_kernels::{
    ApplyBands, Band, CombineBands, GatherBands, SetUpBand, total,
};
use crate::solvers::dual::cpu::kernels::{Advance, Multiply, Product};
use crate::solvers::dual::distance::Softness;
use crate::topology::LANES;
use std::collections::BTreeSet;
use std::ops::Range;

/// Nodes of a chunk at most.
pub const CHUNK: usize = 64;
/// Rows for each constraint at most. Four rows of a list take as long as sixteen of a band, which need more memory.
const ROWS: usize = 2;

/// The bands of a body.
pub struct Bands<T> {
    /// Solver index of its first node, and number of its nodes.
    pub first: usize,
    pub count: usize,
    /// The same in whole vectors.
    pub nodes: usize,
    /// In ascending order of their steps.
    bands: Vec<Band>,
    /// By band: where the rows are of which the first node is the second end, and the first end, in the order in which forces
    /// are added.
    seconds: Vec<usize>,
    firsts: Vec<usize>,
    /// Its part of what neighbours read by band and node, of what is by row, and of what is by node.
    columns: Range<usize>,
    rows: Range<usize>,
    padded: Range<usize>,
    /// By row: rest length [m], less than 0 where there is no constraint.
    rest: Vec<T>,
    /// By constraint: its row.
    row_of: Vec<u32>,
}

/// State of all bodies with bands.
pub struct BandState<T> {
    /// By band and node: direction, scaled; the vector that nodes gather, which is the residual in the iteration. Before
    /// the nodes of a band there are zeros, for nodes that are no second end.
    direction: [Shared<T>; 3],
    vector: Shared<T>,
    /// By row, in the order of chunks, bands and nodes: what rows and the iteration have. The residual is in `p` before
    /// the iteration.
    compliance: Shared<T>,
    scale: Shared<T>,
    x: Shared<T>,
    p: Shared<T>,
    s: Shared<T>,
    w: Shared<T>,
    /// The force of each row in the last sub-step [N].
    pub multipliers: Shared<T>,
    /// By node: the velocity change by constraint forces, divided by the sub-step; in the end, their sum. After the nodes
    /// there are zeros, for rows without a second end.
    response: [Shared<T>; 3],
    /// By node: normal of its predicted contact, and whether it slides.
    contact: [Shared<T>; 4],
}

/// Rows of a chunk.
struct Rows<'w, T> {
    compliance: &'w mut [T],
    scale: &'w mut [T],
    x: &'w mut [T],
    p: &'w mut [T],
    s: &'w mut [T],
    w: &'w mut [T],
    multiplier: &'w mut [T],
}

/// Nodes of a chunk.
pub struct BandNodes<'w, T> {
    pub response: [&'w mut [T]; 3],
    pub contact: [&'w mut [T]; 4],
}

/// A chunk of the nodes of a body with bands.
pub struct BandChunk<'w, T> {
    pub bands: &'w Bands<T>,
    pub state: &'w BandState<T>,
    pub level: SimdLevel,
    pub nodes: Range<usize>,
}

impl<T: Real> Bands<T> {
    /// Those of each body that has few, by its nodes.
    pub fn of_bodies(list: &Constraints, bodies: &[Range<usize>]) -> Vec<Option<Self>> {
        let mut before = [0; 3];
        let mut all = Vec::new();
        for (nodes, rows) in bodies.iter().zip(&list.bodies) {
            let bands = Self::new(list, nodes, rows, before);
            if let Some(bands) = &bands {
                before = [bands.columns.end, bands.rows.end, bands.padded.end];
            }
            all.push(bands);
        }
        all
    }

    /// Those of a body, if they are few and no constraint is there twice; `before` is what other bodies take.
    fn new(
        list: &Constraints,
        nodes: &Range<usize>,
        rows: &Range<usize>,
        before: [usize; 3],
    ) -> Option<Self> {
        let (count, padded) = (nodes.len(), nodes.len().next_multiple_of(LANES));
        let kind = |row: usize| (list.ends[row][1] - list.ends[row][0], list.material[row]);
        let mut kinds = BTreeSet::new();
        for row in rows.clone() {
            kinds.insert(kind(row));
            if kinds.len() * padded > ROWS * rows.len() {
                return None;
            }
        }
        let lead = kinds.last()?.0 as usize;
        let lead = lead.next_multiple_of(LANES);
        let bands: Vec<Band> =
            kinds.iter().zip(0..).map(|(kind, i)| Band::new(*kind, lead + i * (lead + padded))).collect();
        let number = bands.len() * padded;
        let mut all = Self {
            first: nodes.start,
            count,
            nodes: padded,
            seconds: bands.iter().rev().map(|band| band.second).collect(),
            firsts: bands.iter().map(|band| band.first).collect(),
            columns: part(before[0], bands.len() * (lead + padded)),
            rows: part(before[1], number),
            padded: part(before[2], padded + lead),
            rest: vec![-T::ONE; number],
            row_of: Vec::with_capacity(rows.len()),
            bands,
        };
        let kinds: Vec<_> = kinds.into_iter().collect();
        for row in rows.clone() {
            let band = kinds.binary_search(&kind(row)).ok()?;
            let at = all.row(band, list.ends[row][0] as usize - nodes.start);
            if all.rest[at] >= T::ZERO {
                return None;
            }
            all.rest[at] = T::from_f64(list.rest[row]);
            all.row_of.push(at as u32);
        }
        Some(all)
    }

    /// The row of a node in a band.
    fn row(&self, band: usize, node: usize) -> usize {
        let start = node / CHUNK * CHUNK;
        self.bands.len() * start + band * CHUNK.min(self.nodes - start) + node - start
    }

    /// Where the forces of its constraints are.
    pub fn own_multipliers(&self) -> impl Iterator<Item = usize> {
        (0..self.row_of.len()).map(|constraint| self.multiplier_of(constraint))
    }

    /// Where that of one of them is.
    pub fn multiplier_of(&self, constraint: usize) -> usize {
        self.rows.start + self.row_of[constraint] as usize
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        let columns = 4 * self.columns.len() + 8 * self.rows.len() + 7 * self.padded.len();
        columns * size_of::<T>() + size_of_val(&self.row_of[..])
    }
}

impl Band {
    fn new((step, material): (u32, u32), first: usize) -> Self {
        let (step, material) = (step as usize, material as usize);
        Self { step, first, second: first - step, material }
    }
}

fn part(start: usize, len: usize) -> Range<usize> {
    start..start + len
}

impl<T: Real> BandState<T> {
    /// Zeros for all bodies that have bands.
    pub fn new(bodies: &[Option<Bands<T>>]) -> Self {
        let last = bodies.iter().flatten().last();
        let [columns, rows, padded] =
            last.map_or([0; 3], |last| [last.columns.end, last.rows.end, last.padded.end]);
        let zeros = |n| Shared::from(Column::zeros(n));
        Self {
            direction: [(); 3].map(|()| zeros(columns)),
            vector: zeros(columns),
            compliance: zeros(rows),
            scale: zeros(rows),
            x: zeros(rows),
            p: zeros(rows),
            s: zeros(rows),
            w: zeros(rows),
            multipliers: zeros(rows),
            response: [(); 3].map(|()| zeros(padded)),
            contact: [(); 4].map(|()| zeros(padded)),
        }
    }

    /// What the nodes of a body have, to read.
    pub fn response(&self, bands: &Bands<T>) -> [&[T]; 3] {
        // SAFETY: nodes are written before a barrier, and not again before another.
        self.response.each_ref().map(|column| &unsafe { column.read() }[bands.padded.clone()])
    }
}

impl<'w, T: Real> BandChunk<'w, T> {
    /// Its nodes, but for those that fill up the last vector.
    pub fn real_nodes(&self) -> Range<usize> {
        self.nodes.start..self.nodes.end.min(self.bands.count)
    }

    /// Sets up its rows, and has nodes gather the forces of the last sub-step. Returns the sum of squared rounding errors.
    pub fn set_up(&self, softness: &[Softness<T>], position: [&[T]; 3], inverse_mass: &[T]) -> f64 {
        let (rows, count, mut sum) = (self.rows(), self.nodes.len(), 0.0);
        let rest = &self.bands.rest[self.own_rows()];
        for (i, band) in self.bands.bands.iter().enumerate() {
            let own = part(i * count, count);
            let (direction, vector) = self.columns_of(band);
            sum += total(&self.level.run(SetUpBand {
                first: self.bands.first + self.nodes.start,
                step: band.step,
                softness: &softness[band.material],
                position,
                inverse_mass,
                rest: &rest[own.clone()],
                multiplier: &rows.multiplier[own.clone()],
                direction,
                compliance: &mut rows.compliance[own.clone()],
                scale: &mut rows.scale[own.clone()],
                right: &mut rows.p[own.clone()],
                x: &mut rows.x[own],
                vector,
            }));
        }
        sum
    }

    /// Gathers the forces of the vector at its nodes, times the inverse mass if that is not empty, in the directions in
    /// which contacts leave nodes free if they act.
    pub fn gather(&self, inverse_mass: &[T], in_contact: bool) {
        let (BandNodes { response, contact }, (direction, vector)) = (self.own_nodes(), self.columns());
        let own = part(self.bands.first + self.nodes.start, self.nodes.len());
        self.level.run(GatherBands {
            seconds: &self.bands.seconds,
            firsts: &self.bands.firsts,
            direction,
            vector,
            nodes: self.nodes.clone(),
            inverse_mass: if inverse_mass.is_empty() { &[] } else { &inverse_mass[own] },
            contact: in_contact.then(|| contact.map(|column| &*column)),
            out: response,
        });
    }

    /// Multiplies the vector by the matrix. Returns vector times itself, and vector times product.
    pub fn apply(&self) -> [f64; 2] {
        let Rows { compliance, w, .. } = self.rows();
        self.apply_with(compliance, w)
    }

    fn apply_with(&self, compliance: &[T], out: &mut [T]) -> [f64; 2] {
        let (direction, vector) = self.columns();
        let sums = self.level.run(ApplyBands {
            bands: &self.bands.bands,
            direction,
            vector,
            response: self.state.response(self.bands),
            nodes: self.nodes.clone(),
            compliance,
            out,
        });
        sums.each_ref().map(total)
    }

    /// The residual without constraint forces; returns its square. Nodes gather the start if that is `warm`, else the
    /// residual.
    pub fn start(&self, warm: bool) -> f64 {
        let Rows { x, p, s, w, .. } = self.rows();
        s.fill(T::ZERO);
        // Without compliance and forces, the part of the velocities remains.
        self.apply_with(s, w);
        let square = total(&self.level.run(CombineBands { to: &mut *p, factor: T::ONE, other: w }));
        if !warm {
            x.fill(T::ZERO);
            self.spread(p);
            p.fill(T::ZERO);
        }
        square
    }

    /// Start times residual, and times its product with the matrix.
    pub fn warmth(&self) -> [f64; 2] {
        let [_, curvature] = self.apply();
        let Rows { x, p, .. } = self.rows();
        [self.level.run(Product { a: x, b: p }), curvature]
    }

    /// Scales the start.
    pub fn scale_start(&self, factor: T) {
        let Rows { x, p, w, .. } = self.rows();
        self.level.run(Multiply { vector: x, factor });
        self.level.run(CombineBands { to: &mut *p, factor: -factor, other: w });
        self.spread(p);
        p.fill(T::ZERO);
    }

    /// A step of conjugate gradients.
    pub fn advance(&self, alpha: T, beta: T) {
        let (Rows { x, p, s, w, .. }, count) = (self.rows(), self.nodes.len());
        let (xs, ps, ss) = (x.chunks_exact_mut(count), p.chunks_exact_mut(count), s.chunks_exact_mut(count));
        let bands = self.bands.bands.iter().zip(w.chunks_exact(count));
        for (((band, w), x), (p, s)) in bands.zip(xs).zip(ps.zip(ss)) {
            let (_, r) = self.columns_of(band);
            self.level.run(Advance { alpha, beta, x, r, p, s, w });
        }
    }

    /// Stores the constraint forces, which nodes gather next.
    pub fn store(&self) {
        let Rows { scale, x, multiplier, .. } = self.rows();
        for ((multiplier, &scale), &x) in multiplier.iter_mut().zip(&*scale).zip(&*x) {
            *multiplier = scale * x;
        }
        self.spread(x);
    }

    /// Has nodes gather this, which is by row.
    fn spread(&self, rows: &[T]) {
        for (band, rows) in self.bands.bands.iter().zip(rows.chunks_exact(self.nodes.len())) {
            self.columns_of(band).1.copy_from_slice(rows);
        }
    }

    /// Its part of what its body has by row.
    fn own_rows(&self) -> Range<usize> {
        let bands = self.bands.bands.len();
        bands * self.nodes.start..bands * self.nodes.end
    }

    /// Its rows; callers take each only once at a time.
    fn rows(&self) -> Rows<'w, T> {
        let (own, state) = (self.own_rows(), self.state);
        let own = part(self.bands.rows.start + own.start, own.len());
        // SAFETY: chunks do not overlap, each is in one worker's share, and others do not read its rows.
        unsafe {
            Rows {
                compliance: state.compliance.write(own.clone()),
                scale: state.scale.write(own.clone()),
                x: state.x.write(own.clone()),
                p: state.p.write(own.clone()),
                s: state.s.write(own.clone()),
                w: state.w.write(own.clone()),
                multiplier: state.multipliers.write(own),
            }
        }
    }

    /// Its nodes; callers take each only once at a time.
    pub fn own_nodes(&self) -> BandNodes<'w, T> {
        let (state, own) = (self.state, part(self.bands.padded.start + self.nodes.start, self.nodes.len()));
        // SAFETY: as in `rows`; others read `response` after a barrier.
        unsafe {
            BandNodes {
                response: state.response.each_ref().map(|column| column.write(own.clone())),
                contact: state.contact.each_ref().map(|column| column.write(own.clone())),
            }
        }
    }

    /// Directions and vector of its body, to read.
    fn columns(&self) -> ([&'w [T]; 3], &'w [T]) {
        let (all, state) = (&self.bands.columns, self.state);
        // SAFETY: directions are written before a barrier, and not again before another. So is the vector, where nodes gather it;
        // where a chunk is multiplied, only its own rows of it are read, which this worker alone writes.
        unsafe {
            let direction = state.direction.each_ref().map(|column| &column.read()[all.clone()]);
            (direction, &state.vector.read()[all.clone()])
        }
    }

    /// Directions and vector of a band at its nodes, to write; callers take each only once at a time.
    fn columns_of(&self, band: &Band) -> ([&'w mut [T]; 3], &'w mut [T]) {
        let own = part(self.bands.columns.start + band.first + self.nodes.start, self.nodes.len());
        // SAFETY: as in `rows`; others read them after a barrier.
        unsafe {
            let direction = self.state.direction.each_ref().map(|column| column.write(own.clone()));
            (direction, self.state.vector.write(own))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assembly::Assembly;
    use crate::real::{add, dot, scale, sub};
    use crate::scene::{Body, ConstraintForm, Icosphere, Mass, Mesh, Method, Scene};

    fn assembly(meshes: impl IntoIterator<Item = Mesh>) -> Assembly {
        let body = |(i, mesh): (usize, Mesh)| {
            let is_grid = matches!(mesh, Mesh::Grid(_));
            let body = Body::cloth(format!("body {i}"), mesh).with_mass(Mass::Node(0.1));
            let body = body.structural(9.0, 0.1).bend(7.0, 0.1);
            if is_grid { body.shear(8.0, 0.1) } else { body }
        };
        let scene = Scene::new("").method(Method::Ice);
        Assembly::new(&meshes.into_iter().enumerate().map(body).fold(scene, Scene::body)).unwrap()
    }

    fn bands(assembly: &Assembly) -> Vec<Option<Bands<f64>>> {
        let nodes: Vec<_> = assembly.bodies.iter().map(|body| body.solver_range()).collect();
        Bands::of_bodies(assembly.constraints(), &nodes)
    }

    #[test]
    fn grids_have_bands_and_irregular_meshes_have_lists() {
        let ball = Mesh::Icosphere(Icosphere { radius: 1.0, subdivisions: 2 });
        let grid = |rows, cols| Mesh::grid(rows, cols, [1.0, 1.5]);
        let assembly = assembly([grid(5, 33), ball, grid(3, 16), grid(20, 3), grid(2, 2)]);
        let (all, list) = (bands(&assembly), assembly.constraints());
        // The last has six constraints, in four bands of sixteen rows.
        assert_eq!(all.iter().map(Option::is_some).collect::<Vec<_>>(), [true, false, true, true, false]);
        assert_eq!(all[0].as_ref().unwrap().bands.len(), 6);
        let mut taken = BTreeSet::new();
        for (bands, rows) in all.iter().zip(&list.bodies) {
            let Some(bands) = bands else { continue };
            assert_eq!(bands.own_multipliers().count(), rows.len());
            for (row, at) in rows.clone().zip(bands.own_multipliers()) {
                assert!(taken.insert(at) && bands.rest[at - bands.rows.start] == list.rest[row]);
            }
            let rests = bands.rest.iter().filter(|&&rest| rest >= 0.0);
            assert_eq!(rests.count(), rows.len());
        }
    }

    /// Two grids, so that neither begins where arrays begin.
    #[test]
    fn products_are_those_of_the_constraints_one_by_one() {
        let assembly = assembly([Mesh::grid(2, 20, [1.0; 2]), Mesh::grid(11, 13, [1.0, 1.5])]);
        let (all, list) = (bands(&assembly), assembly.constraints());
        let (bands, state) = (all[1].as_ref().unwrap(), BandState::new(&all));
        let nodes = bands.first..bands.first + bands.count;
        let chunks: Vec<_> =
            (0..bands.nodes).step_by(CHUNK).map(|start| start..bands.nodes.min(start + CHUNK)).collect();
        let chunk = |nodes: &Range<usize>| BandChunk {
            bands,
            state: &state,
            level: SimdLevel::detect(),
            nodes: nodes.clone(),
        };
        let some = |i: usize, by: usize| ((i * by) % 23) as f64 / 23.0 - 0.4;
        let columns =
            [7, 5, 3].map(|by| (0..assembly.places).map(|place| some(place, by)).collect::<Vec<_>>());
        let inverse_mass: Vec<_> =
            (0..assembly.places).map(|place| f64::from(u8::from(place % 5 > 0))).collect();
        let softness: Vec<_> = (0..list.materials.len())
            .map(|i| Softness::spring(1.0 + some(i, 4), 0.1, 0.01, ConstraintForm::Compliant, 0.5))
            .collect();
        let forces: Vec<f64> = (0..list.len()).map(|row| some(row, 11)).collect();
        for (at, &force) in bands.own_multipliers().zip(&forces[list.bodies[1].clone()]) {
            // SAFETY: this thread alone has it.
            unsafe { *state.multipliers.item(at) = force };
        }
        let position = columns.each_ref().map(|column| &column[..]);
        let at = |place: usize| position.map(|column| column[place]);
        chunks.iter().for_each(|nodes| _ = chunk(nodes).set_up(&softness, position, &inverse_mass));
        chunks.iter().for_each(|nodes| chunk(nodes).gather(&inverse_mass, false));
        let found: Vec<_> = chunks.iter().map(|nodes| chunk(nodes).apply()).collect();
        // The same one by one.
        let mut response = vec![[0.0; 3]; assembly.places];
        let row = |row: usize| {
            let [a, b] = list.ends[row].map(|end| end as usize);
            let softness = &softness[list.material[row] as usize];
            let own = softness.row(sub(at(b), at(a)), inverse_mass[a] + inverse_mass[b], list.rest[row]);
            let x = if own.scale > 0.0 { forces[row] / own.scale } else { 0.0 };
            (a, b, own, x)
        };
        for (a, b, own, x) in list.bodies[1].clone().map(row) {
            let force = scale(own.direction, x);
            response[a] = sub(response[a], scale(force, inverse_mass[a]));
            response[b] = add(response[b], scale(force, inverse_mass[b]));
        }
        let products = list.bodies[1].clone().map(row).map(|(a, b, own, x)| {
            [x * x, x * (dot(own.direction, sub(response[b], response[a])) + own.compliance * x)]
        });
        let wanted = products.fold([0.0; 2], |[a, b], [c, d]| [a + c, b + d]);
        let found = found.into_iter().fold([0.0; 2], |[a, b], [c, d]| [a + c, b + d]);
        assert!((0..2).all(|i| (found[i] - wanted[i]).abs() < 1e-12 * wanted[0]), "{found:?} {wanted:?}");
        for (place, local) in nodes.zip(0..) {
            let own = state.response(bands).map(|column| column[local]);
            assert!((0..3).all(|axis| (own[axis] - response[place][axis]).abs() < 1e-13), "{place}");
        }
    }
}
