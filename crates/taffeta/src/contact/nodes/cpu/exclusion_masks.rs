//! Exclusion lists as masks of pairs of clusters.

use crate::assembly::Assembly;
use crate::contact::nodes::cpu::clusters::Cluster;
use crate::contact::nodes::self_contact::Exclusions;
use crate::topology::LANES;

/// Excluded nodes of two clusters: by lane of the second, one bit for each lane of the first.
pub type Mask = [u16; LANES];

/// Masks of all pairs of clusters with excluded nodes.
pub struct ExclusionMasks {
    /// Where the row of each cluster begins, and where the last ends.
    starts: Vec<u32>,
    /// Second clusters, ascending, with where their mask is.
    rows: Vec<(u32, u32)>,
    /// All of them; the first is empty.
    masks: Vec<Mask>,
}

impl ExclusionMasks {
    /// The masks of the clusters of all workers.
    pub fn new(assembly: &Assembly, clusters: &[Cluster]) -> Self {
        let mut slot_of = vec![0; assembly.places];
        for (index, cluster) in clusters.iter().enumerate() {
            cluster.nodes().enumerate().for_each(|(lane, node)| slot_of[node] = index * LANES + lane);
        }
        let (mut all, mut slots) =
            (Self { starts: vec![0], rows: Vec::new(), masks: vec![[0; LANES]] }, Vec::new());
        for (index, cluster) in clusters.iter().enumerate() {
            let body = &assembly.bodies[cluster.body as usize];
            slots.clear();
            // Within one cluster each pair is checked once.
            slots.extend((0..LANES).flat_map(|a| (0..=a).map(move |b| (index * LANES + b, a))));
            for (lane, node) in cluster.nodes().enumerate() {
                let Some(self_contact) = body.self_contact() else { continue };
                let exclusions: &Exclusions = &self_contact.exclusions;
                let mut note = |other: usize| {
                    let slot = slot_of[other];
                    if slot / LANES >= index {
                        slots.push((slot, lane));
                    }
                };
                exclusions.each(body.grid_layout, node - body.first, |other| note(body.first + other));
                assembly.attachments().exclusions(node).for_each(note);
            }
            all.push_row(&mut slots);
        }
        all
    }

    /// Adds a cluster's row: places of second nodes, with the lane of the first.
    fn push_row(&mut self, slots: &mut [(usize, usize)]) {
        slots.sort_unstable();
        let mut last = None;
        for &mut (slot, lane) in slots {
            if last != Some(slot / LANES) {
                self.rows.push(((slot / LANES) as u32, self.masks.len() as u32));
                self.masks.push([0; LANES]);
            }
            last = Some(slot / LANES);
            let at = self.masks.len() - 1;
            self.masks[at][slot % LANES] |= 1 << lane;
        }
        self.starts.push(self.rows.len() as u32);
    }

    /// The number of the mask of two clusters, `a` not after `b`.
    pub fn find(&self, a: u32, b: u32) -> u32 {
        let a = a as usize;
        let row = &self.rows[self.starts[a] as usize..self.starts[a + 1] as usize];
        row.binary_search_by_key(&b, |(second, _)| *second).map_or(0, |at| row[at].1)
    }

    /// A mask by its number.
    pub fn mask(&self, number: u32) -> &Mask {
        &self.masks[number as usize]
    }

    /// Bytes that they take.
    pub fn bytes(&self) -> usize {
        4 * self.starts.len() + 8 * self.rows.len() + size_of_val(&self.masks[..])
    }
}
