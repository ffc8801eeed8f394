//! Blocks of the finest level, from the directions of elements' modes: sixteen nodes at a time.

use crate::assembly::Assembly;
use crate::cpu::places::{Groups, Places};
use crate::elements::cpu::ElementSet;
use crate::elements::directions::{DirectionLayout, NUMBERS};
use crate::elements::lanes::Lanes;
use crate::real::Real;
use crate::solvers::implicit::couplings::{Solved, Tables};
use crate::topology::LANES;

/// Kinds of elements that are solved for.
pub type Sets<T> = [Box<dyn ElementSet<T>>];

/// Lanes that are added up at a time: their nine numbers stay in the registers of AVX2.
const HALF: usize = LANES / 2;

/// Kinds of elements at most.
const KINDS: usize = crate::elements::KINDS.len();

/// Directions of each kind, and where they are.
pub type KindDirections<'a, T> = [Option<(&'a [T], DirectionLayout)>; KINDS];

/// Directions of all kinds, to read.
///
/// # Safety
/// As of [`Shared::read`](crate::cpu::shared::Shared::read).
pub unsafe fn directions<T: Real>(sets: &Sets<T>) -> KindDirections<'_, T> {
    std::array::from_fn(|kind| {
        let directions = sets.get(kind)?.directions()?;
        // SAFETY: promised by the caller.
        Some((unsafe { directions.read() }, directions.layout()))
    })
}

/// What the blocks of the finest level are made of: each block of a group of slots gets something of each of some elements.
#[derive(Default)]
pub struct Assembled {
    /// By group: where its sources start; one more than there are groups.
    offsets: Vec<u32>,
    /// By source: which kind the elements of all lanes are of.
    kinds: Vec<u8>,
    /// By source: where directions of the first mode are, here and at the other node.
    places: Groups,
}

impl Assembled {
    /// Of the finest level of a whole scene.
    pub fn new(assembly: &Assembly, tables: &Tables) -> Self {
        let lists = assembly.elements();
        let layout =
            |solved: &Solved| DirectionLayout::new(lists[solved.list].kind, lists[solved.list].len());
        let layouts: Vec<DirectionLayout> = tables.solved.iter().filter_map(layout).collect();
        let mut all = Self { offsets: vec![0], ..Self::default() };
        for group in 0..tables.finest.len() / LANES {
            for (kind, (solved, layout)) in tables.solved.iter().zip(&layouts).enumerate() {
                let of_lane = |lane: usize| -> Vec<[u32; 2]> {
                    let sources = tables.finest.sources(group * LANES + lane).iter();
                    sources.filter_map(|&source| places(solved, layout, source)).collect()
                };
                let lanes: [Vec<[u32; 2]>; LANES] = std::array::from_fn(of_lane);
                let most = lanes.iter().map(Vec::len).max().unwrap_or(0);
                for one in 0..most {
                    let none = [layout.nowhere; 2];
                    let place = |end: usize, lane: usize| lanes[lane].get(one).unwrap_or(&none)[end];
                    all.kinds.push(kind as u8);
                    for end in 0..2 {
                        all.places.push(std::array::from_fn(|lane| place(end, lane)));
                    }
                }
            }
            all.offsets.push(all.kinds.len() as u32);
        }
        all
    }

    /// The blocks of a group.
    #[inline(always)]
    pub fn block<T: Real>(&self, group: usize, kinds: &KindDirections<'_, T>) -> [Lanes<T>; 9] {
        let sources = self.offsets[group] as usize..self.offsets[group + 1] as usize;
        let mut block = [[T::ZERO; LANES]; 9];
        for half in 0..LANES / HALF {
            let mut sum = [[T::ZERO; HALF]; 9];
            for source in sources.clone() {
                let Some(kind) = &kinds[usize::from(self.kinds[source])] else { continue };
                let ends = [0, 1].map(|end| self.places.places(2 * source + end));
                // Loops of their own, so that compilers keep sums in registers and load whole vectors where they can.
                match (kind.1.is_tense, ends) {
                    (true, [Places::Run(a), Places::Run(b)]) => {
                        subtract::<T, NUMBERS>(kind, |end, column| run([a, b][end], half, column), &mut sum);
                    }
                    (false, [Places::Run(a), Places::Run(b)]) => {
                        subtract::<T, 3>(kind, |end, column| run([a, b][end], half, column), &mut sum);
                    }
                    (true, ends) => {
                        subtract::<T, NUMBERS>(kind, |end, column| some(ends[end], half, column), &mut sum);
                    }
                    (false, ends) => {
                        subtract::<T, 3>(kind, |end, column| some(ends[end], half, column), &mut sum);
                    }
                }
            }
            for (lanes, sum) in block.iter_mut().zip(&sum) {
                lanes[half * HALF..(half + 1) * HALF].copy_from_slice(sum);
            }
        }
        block
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        4 * self.offsets.len() + self.kinds.len() + self.places.bytes()
    }
}

/// Subtracts from half of the lanes of a block the products of the directions at both ends, of all modes of a kind. `N` numbers make
/// a direction; `fetch` has those of an end of a column.
#[inline(always)]
fn subtract<T: Real, const N: usize>(
    (columns, layout): &(&[T], DirectionLayout),
    fetch: impl Fn(usize, &[T]) -> [T; HALF],
    sum: &mut [[T; HALF]; 9],
) {
    for mode in 0..layout.modes {
        let (mut a, mut b) = ([[T::ZERO; HALF]; N], [[T::ZERO; HALF]; N]);
        for axis in 0..N {
            let column = &columns[mode * layout.mode() + axis * layout.stride..];
            a[axis] = fetch(0, column);
            b[axis] = fetch(1, column);
        }
        for row in 0..3 {
            for column in 0..3 {
                for lane in 0..HALF {
                    sum[3 * row + column][lane] -= a[row][lane] * b[column][lane];
                }
            }
            if N == NUMBERS {
                for lane in 0..HALF {
                    sum[4 * row][lane] -= a[N - 1][lane] * b[N - 1][lane];
                }
            }
        }
    }
}

/// Half of the lanes of a run of places.
#[inline(always)]
fn run<T: Real>(first: usize, half: usize, column: &[T]) -> [T; HALF] {
    *column[first + half * HALF..].first_chunk().expect("zeros follow the last direction")
}

/// Half of the lanes of any places.
#[inline(always)]
fn some<T: Real>(places: Places<'_>, half: usize, column: &[T]) -> [T; HALF] {
    match places {
        Places::Run(first) => run(first, half, column),
        Places::List(places) => {
            let mut lanes = [T::ZERO; HALF];
            for (lane, &place) in lanes.iter_mut().zip(&places[half * HALF..]) {
                *lane = column[place as usize];
            }
            lanes
        }
    }
}

/// Where the two directions of a source are, if they are those of a kind's first mode.
fn places(solved: &Solved, layout: &DirectionLayout, source: [u32; 2]) -> Option<[u32; 2]> {
    let [a, b] = source.map(|one| (one as usize).checked_sub(solved.first_direction));
    let (a, b) = (a?, b?);
    let (element, within) = (a / solved.directions, a % solved.directions);
    if element >= solved.elements.len() || within >= layout.nodes {
        return None;
    }
    let place = |at: usize| layout.place(solved.elements.start + element, at % solved.directions) as u32;
    Some([place(a), place(b)])
}
