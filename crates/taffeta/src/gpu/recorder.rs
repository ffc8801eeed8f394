//! A frame as a list of dispatches: `step::frame` says in which order.

use crate::gpu::kernels::{Contact, Kernels, Name};
use crate::gpu::layout::{GROUP, NODE_SUMS, RESTORED};
use crate::gpu::order::{Stages, Tile};
use crate::gpu::segment::{Counts, Segment};
use crate::step::Stage;
use taffeta_gpu::{DispatchList, GpuError};

/// Writes down what a segment does in a frame.
pub struct Recorder<'a> {
    pub segment: &'a mut Segment,
    pub kernels: &'a mut Kernels,
    pub list: &'a mut DispatchList,
    /// What the program does in this frame.
    pub counts: Counts,
    /// The first stage that the GPU does; those before it have been done.
    pub from: Stage,
    /// Whether the frame ends with these sub-steps, and is measured.
    pub last: bool,
    /// Sub-steps from here on have been done with one before.
    pub ahead: usize,
    /// Number of sub-steps.
    pub all: usize,
    /// What went wrong first.
    pub fault: Result<(), GpuError>,
}

/// The particle stages that one kernel does at once, in their order.
const FUSED: [Stage; 5] = [Stage::Loads, Stage::Springs, Stage::Integrate, Stage::Pins, Stage::Contact];

/// Particle stages as they are asked for, to be run later.
#[derive(Default)]
pub struct Listed {
    stages: Vec<Stage>,
    /// Whether they are those of a body that keeps its volume.
    keeps_volume: bool,
}

impl Listed {
    /// The stages in their order.
    pub fn stages(&self) -> impl Iterator<Item = Stage> + use<'_> {
        self.stages.iter().copied()
    }
}

impl Tile for Listed {
    fn loads(&mut self) {
        self.stages.push(Stage::Loads);
    }

    fn springs(&mut self) {
        self.stages.push(Stage::Springs);
    }

    fn is_constrained(&self) -> bool {
        false
    }

    fn wait_for_constraints(&mut self) {
        self.stages.push(Stage::Constraints);
    }

    fn constrain(&mut self) {
        self.stages.push(Stage::Constraints);
    }

    fn keeps_volume(&self) -> bool {
        self.keeps_volume
    }

    fn gradients(&mut self) {
        self.stages.push(Stage::Volumes);
    }

    fn keep_volume(&mut self) {
        self.stages.push(Stage::Volumes);
    }

    fn attach(&mut self) {
        self.stages.push(Stage::Attach);
    }

    fn part(&mut self) {
        self.stages.push(Stage::Pairs);
    }

    fn restore_volume(&mut self) {
        self.stages.push(Stage::Project);
    }

    fn integrate(&mut self) {
        self.stages.push(Stage::Integrate);
    }

    fn pins(&mut self) {
        self.stages.push(Stage::Pins);
    }

    fn contact(&mut self) {
        self.stages.push(Stage::Contact);
    }
}

impl Stages for Recorder<'_> {
    /// Its number in the list that the segment was told.
    type Substep = usize;
    type Tile<'t>
        = Listed
    where
        Self: 't;

    fn elements(&mut self, &substep: &usize) {
        if self.from > Stage::Elements {
            return;
        }
        self.list.stage("elements");
        let (loads, hinges) = (self.segment.tables.loads.len(), self.segment.tables.hinges.len());
        self.dispatch("scale_loads", substep, loads);
        self.dispatch("bend_hinges", substep, hinges.div_ceil(GROUP));
        self.dispatch("blow_on_panels", substep, self.segment.tables.panels.len().div_ceil(GROUP));
    }

    fn particles(&mut self, &substep: &usize, stages: impl Fn(&mut Listed)) {
        if self.constrains() {
            return self.forces_before_constraints(substep);
        }
        let mut listed = Listed::default();
        stages(&mut listed);
        let fused = listed.stages().eq(FUSED) && self.from == Stage::Elements;
        let pins_later = self.keeps_volumes();
        if substep < self.ahead {
            return;
        }
        if self.segment.paper.is_some() {
            self.as_printed(substep);
        } else if fused && self.can_run_ahead() {
            self.run_ahead(substep);
        } else if fused {
            self.at_once(substep);
        } else {
            let from = self.from;
            let contact_later = self.meets_meshes() && pins_later;
            let later =
                |stage| (pins_later && stage == Stage::Pins) || (contact_later && stage == Stage::Contact);
            for stage in listed.stages().filter(|stage| *stage >= from && !later(*stage)) {
                self.alone(stage, substep);
            }
        }
        if pins_later {
            self.sum_volumes(substep);
        }
    }

    fn constrains(&self) -> bool {
        self.segment.constrained.is_some() || self.segment.primal.is_some()
    }

    fn constraints(&mut self, &substep: &usize, stages: impl Fn(&mut Listed)) {
        let mut listed = Listed::default();
        stages(&mut listed);
        for stage in listed.stages() {
            match stage {
                Stage::Constraints if self.segment.primal.is_some() => self.find_changes(substep),
                Stage::Constraints => self.find_pulls(substep),
                Stage::Contact if self.meets_meshes() && self.keeps_volumes() => {}
                _ => self.alone(stage, substep),
            }
        }
        if self.keeps_volumes() {
            self.list.stage("volumes");
            self.dispatch("volume_gradients", substep, self.segment.tables.volume_groups.len());
        }
    }

    fn keeps_volumes(&self) -> bool {
        // A paper's kernels keep them among the other particle stages.
        !self.segment.tables.volume_groups.is_empty() && self.segment.paper.is_none()
    }

    /// One kernel adds the force of the constraint and does what comes after it, but for pins.
    fn volumes(&mut self, &substep: &usize, _: impl Fn(&mut Listed)) {
        self.list.stage("volumes");
        let name = Name { contact: self.fused_contact(), ..Name::new("volume_particles") };
        self.dispatch_kernel(name, substep, self.segment.tables.volume_groups.len());
        self.alone(Stage::Pins, substep);
        self.contact_apart(substep);
    }

    fn attaches(&self) -> bool {
        self.segment.attaching.is_some() && self.from <= Stage::Attach
    }

    fn attach(&mut self, &substep: &usize, _: impl Fn(&mut Listed)) {
        self.attach_all(substep);
    }

    fn collides(&self) -> bool {
        !self.segment.tables.surfaces.is_empty() && self.from <= Stage::Pairs
    }

    /// The state after the sub-step is read, and written anew where that before it was.
    fn pairs(&mut self, &substep: &usize, _: impl Fn(&mut Listed)) {
        self.list.stage("pairs");
        self.segment.current = 1 - self.segment.current;
        let (buckets, places) = (self.segment.tables.buckets(), self.segment.tables.place_groups());
        self.dispatch("clear_cells", substep, buckets.div_ceil(GROUP));
        self.dispatch("fill_cells", substep, places);
        self.dispatch("find_pairs", substep, places);
        let name = Name { contact: self.fused_contact(), ..Name::new("part_pairs") };
        self.dispatch_kernel(name, substep, places);
        if self.meets_meshes() {
            self.dispatch_on_meshes("contact_parted", substep, places);
        }
    }

    /// A round. Nothing is read back, so that all rounds are written down; on volumes that are restored they do nothing.
    fn project(&mut self, &substep: &usize, _: impl Fn(&mut Listed)) -> bool {
        let groups = &self.segment.tables.volume_groups;
        let (count, any) = (groups.len(), groups.iter().any(|group| group.flags & RESTORED != 0));
        if any {
            self.list.stage("project");
            // It measures what the others have written.
            self.segment.current = 1 - self.segment.current;
            self.dispatch("measure_kept_volumes", substep, count);
            self.segment.current = 1 - self.segment.current;
            let name = Name { contact: self.whole_contact(), ..Name::new("restore_volumes") };
            self.dispatch_kernel(name, substep, count);
        }
        !any
    }

    fn end(&mut self, &substep: &usize) {
        // Sub-steps that were taken at once are one.
        if substep + 1 == self.ahead || substep >= self.ahead {
            self.segment.current = 1 - self.segment.current;
        }
    }

    fn diagnose(&mut self) {
        if self.last {
            self.measure();
        }
    }
}

impl Recorder<'_> {
    pub(crate) fn dispatch(&mut self, entry: &'static str, substep: usize, groups: usize) {
        self.dispatch_kernel(Name::new(entry), substep, groups);
    }

    pub(crate) fn dispatch_kernel(&mut self, name: Name, substep: usize, groups: usize) {
        if groups > 0 && self.fault.is_ok() {
            self.fault = self.segment.dispatch(self.kernels, self.list, name, substep, groups as u32);
        }
    }

    /// A kernel that meets triangles of colliders.
    pub(crate) fn dispatch_on_meshes(&mut self, entry: &'static str, substep: usize, groups: usize) {
        self.dispatch_kernel(Name { contact: Contact::Meshes, ..Name::new(entry) }, substep, groups);
    }

    /// Whether colliders are meshes: contact is a kernel of its own then.
    pub(crate) fn meets_meshes(&self) -> bool {
        self.segment.meshes.any()
    }

    /// What kernels do about colliders that have no room for triangles.
    fn fused_contact(&self) -> Contact {
        if self.meets_meshes() { Contact::Later } else { Contact::Solids }
    }

    /// What those do that have.
    pub(crate) fn whole_contact(&self) -> Contact {
        if self.meets_meshes() { Contact::Meshes } else { Contact::Solids }
    }

    /// Contact of all nodes, where it is a kernel of its own.
    fn contact_apart(&mut self, substep: usize) {
        if self.meets_meshes() {
            self.alone(Stage::Contact, substep);
        }
    }

    /// Whether the sub-steps of this frame may be taken several at once: nothing but springs, wind and colliders acts.
    fn can_run_ahead(&self) -> bool {
        self.segment.patches.is_some() && !self.loads_given() && self.counts.pins == 0
    }

    pub(crate) fn loads_given(&self) -> bool {
        self.segment.tables.has_elements() || self.counts.input_forces > 0
    }

    /// Several sub-steps in one kernel, from `substep` on.
    fn run_ahead(&mut self, substep: usize) {
        let Some(patches) = &self.segment.patches else { return };
        let (grids, meshes) = (patches.grids.len(), patches.meshes.len());
        self.ahead = self.all.min(substep + patches.steps as usize);
        self.list.stage("particles");
        self.dispatch("grid_patches", substep, grids);
        self.dispatch("mesh_patches", substep, meshes);
    }

    /// All particle stages in one kernel; loads that are summed up over elements before it. Pins come after contact here:
    /// the one moves held nodes only, the other free ones.
    fn at_once(&mut self, substep: usize) {
        let loads_given = self.loads_given();
        if loads_given {
            self.alone(Stage::Loads, substep);
        }
        self.list.stage("particles");
        let (tiles, meshes) = (self.segment.tables.tiles.len(), self.mesh_groups());
        let contact = self.fused_contact();
        let name = |entry| Name { loads_given, contact, ..Name::new(entry) };
        self.dispatch_kernel(name("grid_particles"), substep, tiles);
        self.dispatch_kernel(name("mesh_particles"), substep, meshes);
        if !self.keeps_volumes() {
            self.alone(Stage::Pins, substep);
            self.contact_apart(substep);
        }
    }

    /// Forces and gradients of bodies that keep their volume, and what the multiplier needs.
    fn sum_volumes(&mut self, substep: usize) {
        self.list.stage("volumes");
        let given = self.from > Stage::Elements || self.loads_given();
        let entry = match self.from {
            Stage::Constraints | Stage::Volumes => "volume_gradients",
            _ if given => "volume_forces_given",
            _ => "volume_forces",
        };
        self.dispatch(entry, substep, self.segment.tables.volume_groups.len());
    }

    /// Workgroups over places where a mesh keeps no volume.
    fn mesh_groups(&self) -> usize {
        if self.segment.tables.meshes.is_empty() { 0 } else { self.segment.tables.place_groups() }
    }

    /// One particle stage in kernels of its own.
    pub(crate) fn alone(&mut self, stage: Stage, substep: usize) {
        self.list.stage(stage.name());
        let places = self.segment.tables.place_groups();
        match stage {
            Stage::Loads => self.dispatch("loads_all", substep, places),
            Stage::Springs => {
                self.dispatch("grid_springs_all", substep, self.segment.tables.tiles.len());
                self.dispatch("mesh_springs_all", substep, self.mesh_groups());
            }
            Stage::Integrate => self.dispatch("integrate_all", substep, places),
            Stage::Pins => self.dispatch("pins_all", substep, self.counts.pins.div_ceil(GROUP)),
            Stage::Contact => {
                let name = Name { contact: self.whole_contact(), ..Name::new("contact_all") };
                self.dispatch_kernel(name, substep, places);
            }
            Stage::Elements
            | Stage::Constraints
            | Stage::Volumes
            | Stage::Attach
            | Stage::Pairs
            | Stage::Project
            | Stage::Diagnose => {}
        }
    }

    fn measure(&mut self) {
        self.list.stage("diagnose");
        let sums = &self.segment.sums;
        // A row for each workgroup.
        let nodes = sums.nodes.len() / NODE_SUMS;
        let (tiles, meshes) = (sums.grid_springs.len(), sums.mesh_springs.len());
        let (hinges, chunks, pairs) = (sums.hinges.len(), sums.volumes.len(), sums.pairs.len());
        self.dispatch("measure_nodes", 0, nodes);
        self.dispatch("measure_grid_springs", 0, tiles);
        self.dispatch("measure_mesh_springs", 0, meshes);
        self.dispatch("measure_hinges", 0, hinges);
        self.dispatch("measure_volumes", 0, chunks);
        self.dispatch("measure_pairs", 0, pairs);
        self.segment.sums.copy(self.list);
        if let Some(constrained) = &self.segment.constrained {
            constrained.copy(self.list);
        }
        if let Some(primal) = &self.segment.primal {
            primal.copy(self.list);
        }
        if let Some(attaching) = &self.segment.attaching {
            attaching.copy(self.list);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::order as step;
    use crate::step::PROJECTIONS;

    /// What a sub-step asks of bodies that keep their volume.
    #[derive(Default)]
    struct Asked(Vec<Vec<Stage>>);

    impl Asked {
        fn note(&mut self, stages: impl Fn(&mut Listed)) {
            let mut listed = Listed { keeps_volume: true, ..Listed::default() };
            stages(&mut listed);
            self.0.push(listed.stages);
        }
    }

    impl Stages for Asked {
        type Substep = ();
        type Tile<'t> = Listed;

        fn elements(&mut self, (): &()) {}

        fn particles(&mut self, (): &(), stages: impl Fn(&mut Listed)) {
            self.note(stages);
        }

        fn constrains(&self) -> bool {
            false
        }

        fn constraints(&mut self, (): &(), _: impl Fn(&mut Listed)) {}

        fn keeps_volumes(&self) -> bool {
            true
        }

        fn volumes(&mut self, (): &(), stages: impl Fn(&mut Listed)) {
            self.note(stages);
        }

        fn attaches(&self) -> bool {
            false
        }

        fn attach(&mut self, (): &(), _: impl Fn(&mut Listed)) {}

        fn collides(&self) -> bool {
            false
        }

        fn pairs(&mut self, (): &(), _: impl Fn(&mut Listed)) {}

        fn project(&mut self, (): &(), stages: impl Fn(&mut Listed)) -> bool {
            self.note(stages);
            false
        }

        fn end(&mut self, (): &()) {}

        fn diagnose(&mut self) {}
    }

    #[test]
    fn the_kernels_of_volumes_do_what_a_sub_step_asks_for() {
        use Stage::{Contact, Integrate, Loads, Pins, Project, Springs, Volumes};
        let mut asked = Asked::default();
        step::frame(&mut asked, &[()]);
        let forces = vec![Loads, Springs, Volumes];
        let particles = vec![Volumes, Integrate, Pins, Contact];
        let rounds = vec![vec![Project, Contact]; PROJECTIONS];
        assert_eq!(asked.0, [vec![forces, particles], rounds].concat());
    }
}
