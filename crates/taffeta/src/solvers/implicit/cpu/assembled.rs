//! Blocks of the finest level, from the directions of elements' modes: sixteen nodes at a time.

use crate::assembly::Assembly;
use crate::elements::cpu::ElementSet;
use crate::elements::directions::{DirectionLayout, NUMBERS};
use crate::elements::lanes::{Lanes, ascends};
use crate::real::Real;
use crate::solvers::implicit::couplings::{Solved, Tables};
use crate::topology::LANES;

/// Kinds of elements that are solved for.
pub type Sets<T> = [Box<dyn ElementSet<T>>];

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

/// What each block of a group of slots gets of one element.
struct Source {
    /// Which kind, of all lanes.
    kind: usize,
    /// Where directions of the first mode are, here and at the other node.
    places: [[u32; LANES]; 2],
    /// Whether those of neighbouring lanes follow each other.
    in_row: bool,
}

/// What the blocks of the finest level are made of.
pub struct Assembled {
    /// By group: where its sources start; one more than there are groups.
    offsets: Vec<u32>,
    sources: Vec<Source>,
}

impl Assembled {
    /// Of the finest level of a whole scene.
    pub fn new(assembly: &Assembly, tables: &Tables) -> Self {
        let lists = assembly.elements();
        let layout =
            |solved: &Solved| DirectionLayout::new(lists[solved.list].kind, lists[solved.list].len());
        let layouts: Vec<DirectionLayout> = tables.solved.iter().filter_map(layout).collect();
        let mut all = Self { offsets: vec![0], sources: Vec::new() };
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
                    let places = [0, 1].map(|end| std::array::from_fn(|lane| place(end, lane)));
                    all.sources.push(Source { kind, in_row: places.iter().all(|one| ascends(one)), places });
                }
            }
            all.offsets.push(all.sources.len() as u32);
        }
        all
    }

    /// Adds to the blocks of a group what elements give them.
    #[inline(always)]
    pub fn block<T: Real>(&self, group: usize, kinds: &KindDirections<'_, T>, block: &mut [Lanes<T>; 9]) {
        let range = self.offsets[group] as usize..self.offsets[group + 1] as usize;
        let (mut a, mut b) = ([[T::ZERO; LANES]; NUMBERS], [[T::ZERO; LANES]; NUMBERS]);
        for source in &self.sources[range] {
            let Some((columns, layout)) = &kinds[source.kind] else { continue };
            for mode in 0..layout.modes {
                let from = mode * layout.mode();
                let numbers = if layout.is_tense { NUMBERS } else { 3 };
                for axis in 0..numbers {
                    let column = &columns[from + axis * layout.stride..];
                    source.fetch(column, 0, &mut a[axis]);
                    source.fetch(column, 1, &mut b[axis]);
                }
                for row in 0..3 {
                    for column in 0..3 {
                        for lane in 0..LANES {
                            block[3 * row + column][lane] -= a[row][lane] * b[column][lane];
                        }
                    }
                    if layout.is_tense {
                        for lane in 0..LANES {
                            block[4 * row][lane] -= a[3][lane] * b[3][lane];
                        }
                    }
                }
            }
        }
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        4 * self.offsets.len() + size_of_val(&self.sources[..])
    }
}

impl Source {
    /// A number of each lane's direction, at one end.
    #[inline(always)]
    fn fetch<T: Real>(&self, column: &[T], end: usize, lanes: &mut Lanes<T>) {
        let places = &self.places[end];
        if self.in_row {
            let first = places[0] as usize;
            lanes.copy_from_slice(&column[first..first + LANES]);
        } else {
            for (lane, &place) in lanes.iter_mut().zip(places) {
                *lane = column[place as usize];
            }
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
