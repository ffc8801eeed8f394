//! How the systems of springs are solved in a sub-step: kernels, in their order.

use super::{BETWEEN_COUNTS, BETWEEN_NEWTON_STEPS, CONTACTS, COUPLED, Implicit, MOVED};
use crate::contact::colliders::gpu::{Colliders, Contact};
use crate::contact::triangles::gpu::TriangleContact;
use crate::elements::gpu::Elements;
use crate::gpu::feature::{Command, Dispatch, Features, Groups};
use crate::gpu::kernels::Name;
use crate::gpu::layout::GROUP;
use crate::motion::gpu::Pins;
use crate::solvers::implicit::gpu_layout::When;
use crate::solvers::implicit::gpu_sewn::{Followers, Sewn};
use crate::solvers::implicit::implicit::LAST_PAIRS;

impl Implicit {
    /// The part of all tails.
    pub(super) fn tail(&self) -> usize {
        2 * self.levels - 1
    }

    /// What nodes follow once all seams are closed, if they are and that makes a difference.
    pub(super) fn sewn_followers(&self) -> Option<&Followers> {
        self.sewn_followers.as_ref().filter(|_| self.sewn.as_ref().is_some_and(Sewn::is_closed))
    }

    /// Parts of coarser levels that iterations have, and where their workgroups are counted.
    pub(super) fn wide(&self) -> Vec<(usize, usize)> {
        let first = if self.sewn_followers().is_some() { self.tail() + 1 } else { self.levels };
        let parts = (first..first + self.levels - 1).filter(|&part| !self.parts[part].groups.is_empty());
        parts.map(|part| (part, self.iterated(self.parts[part].groups.len() as u32))).collect()
    }

    /// Where workgroups of iterations are counted.
    fn iterated(&self, groups: u32) -> usize {
        let index = self.counted.iter().position(|&one| one == [groups, When::Iterated as u32]);
        index.expect("MultigridTables::counted lists what iterations run")
    }

    /// A kernel for each point that seams make, if there are any.
    fn of_points(&self, entry: &'static str) -> Option<Command<'_>> {
        self.sewn.as_ref()?.command(Name::new(entry))
    }

    /// The same in iterations.
    fn iterated_points(&self, entry: &'static str) -> Option<Command<'_>> {
        let sewn = self.sewn.as_ref()?;
        sewn.command(Name::new(entry)).map(|command| self.when(When::Iterated, command))
    }

    /// Finds what springs change of velocities, where all other forces are known, and adds it.
    pub(super) fn find_changes<'f>(&'f self, features: &'f Features) -> Vec<Command<'f>> {
        let nodes = self.parts[0].groups.len();
        let run = |entry, groups| Command::run(self.name(entry), groups);
        let mut all = vec![run("free_nodes", nodes)];
        all.extend(features.get::<Pins>().map(Pins::command));
        if features.get::<Colliders>().is_some_and(Colliders::has_meshes) {
            let name = Name::new("predict_mesh_contacts_implicit").with(Contact::Meshes.choices());
            all.push(Command::run(name, nodes));
        }
        all.push(run("predict_contacts_implicit", nodes));
        all.extend(self.of_points("begin_points"));
        all.extend(self.join_systems(features));
        if self.is_automatic() {
            all.extend(["sum_motion", "weigh_motion"].map(|entry| run(entry, nodes)));
        }
        for newton in 0..self.newton_steps.max(1) {
            if newton > 0 {
                all.push(run("next_newton_step", nodes));
            }
            self.linearise(features, &mut all);
            self.coarsen(&mut all);
            self.iterate(features, &mut all);
        }
        if let Some(contacts) = self.contacts(features) {
            all.extend([run("multiply_change", nodes), contacts.each_for_solver("apply_contacts")]);
            all.extend(contacts.keep_solved());
        }
        all.extend([run("record_implicit_statistics", 1), run("spring_impulses", nodes)]);
        all.extend(self.of_points("pool_impulses"));
        all.push(run("add_implicit_forces", nodes));
        all
    }

    /// Contacts of surfaces, if they are part of the system.
    fn contacts<'f>(&self, features: &'f Features) -> Option<&'f TriangleContact> {
        features.get::<TriangleContact>().filter(|_| self.in_contact)
    }

    /// Finds the contacts that may come about in the sub-step, and which systems those and seams join.
    fn join_systems<'f>(&'f self, features: &'f Features) -> Vec<Command<'f>> {
        let (contacts, links) = (self.contacts(features), self.sewn.as_ref().map_or(0, Sewn::links));
        if contacts.is_none() && links == 0 {
            return Vec::new();
        }
        let systems = self.node_solves.len().div_ceil(GROUP);
        let mut all = contacts.map_or(Vec::new(), TriangleContact::find_for_solver);
        all.push(Command::run(Name::new("part_systems"), systems));
        all.extend(contacts.map(|contacts| contacts.each_for_solver("take_contacts")));
        all.push(Command::run(Name::new("join_sewn_systems"), links.div_ceil(GROUP)));
        all.push(Command::run(Name::new("name_systems"), systems));
        all
    }

    /// Whether the solver finds how many Newton steps it takes.
    pub(super) fn is_automatic(&self) -> bool {
        self.newton_steps == 0
    }

    /// Begins a further Newton step, where one may be needed and none is under way.
    fn go_on<'f>(&'f self, features: &'f Features, all: &mut Vec<Command<'f>>) {
        let nodes = self.parts[0].groups.len();
        let mut begun = Vec::new();
        if self.in_contact {
            begun.push(Command::run(Name::new("multiply_change"), nodes));
        }
        begun.extend(
            ["spring_impulses", "next_newton_step"].map(|entry| Command::run(self.name(entry), nodes)),
        );
        self.linearise(features, &mut begun);
        self.coarsen(&mut begun);
        all.push(Command::run(Name::new("count_next_step"), 1));
        all.extend(begun.into_iter().map(|command| self.when(When::Begun, command)));
    }

    /// A command in as many workgroups as are counted for it; of no workgroups it stays as it is. So do those of contacts, which are
    /// counted by themselves: they find out by the state of a system whether its next step begins.
    fn when<'f>(&'f self, when: When, command: Command<'f>) -> Command<'f> {
        match command {
            Command::Dispatch(Dispatch { name, part, groups: Groups::Linear(groups) }) if groups > 0 => {
                let counted = self.counted.iter().position(|&one| one == [groups as u32, when as u32]);
                let index = counted.expect("MultigridTables::counted lists what a further step runs");
                Command::Dispatch(Dispatch { name, part, groups: Groups::Counted(&self.counts, index) })
            }
            other => other,
        }
    }

    /// A kernel that may import what a system is made of.
    fn name(&self, entry: &'static str) -> Name {
        let mut name = Name::new(entry);
        if self.followers.has_elements() {
            name = name.with(&[COUPLED]);
        }
        if self.joined.is_some() { name.with(&[CONTACTS]) } else { name }
    }

    /// Forces, blocks and diagonals of the finest level.
    fn linearise<'f>(&'f self, features: &'f Features, all: &mut Vec<Command<'f>>) {
        let nodes = self.parts[0].groups.len();
        if self.followers.has_elements() {
            all.extend(features.get::<Elements>().into_iter().flat_map(|all| all.linearise(&[MOVED])));
            all.push(Command::run(Name::new("set_up_couplings"), nodes));
        }
        all.push(Command::run(self.name("set_up_nodes"), nodes));
        if let Some(contacts) = self.contacts(features) {
            all.push(contacts.each_for_solver("linearise_contacts"));
            all.push(Command::run(Name::new("add_contacts"), nodes));
        }
    }

    /// Blocks and diagonals of coarser levels, and what iterations start from.
    fn coarsen<'f>(&'f self, all: &mut Vec<Command<'f>>) {
        for (level, part) in self.parts[..self.levels].iter().enumerate().skip(1) {
            let (groups, edges) = (part.groups.len(), part.edges.len().div_ceil(GROUP));
            if self.followers.has_elements() {
                all.push(Command::run_part(Name::new("coarsen_couplings"), level, groups));
                continue;
            }
            let entry = if level == 1 { "coarsen_springs" } else { "coarsen_edges" };
            all.push(Command::run_part(Name::new(entry), level, edges));
            all.push(Command::run_part(Name::new("coarsen_nodes"), level, groups));
        }
        if self.followers.has_elements() {
            let levels = || self.parts[..self.levels].iter().enumerate();
            let of_all = |entry| {
                levels()
                    .map(move |(level, part)| Command::run_part(Name::new(entry), level, part.groups.len()))
            };
            all.extend(of_all("bound_couplings").chain(of_all("scale_inverses")));
        }
        let nodes = self.parts[0].groups.len();
        all.extend(["weigh_points", "average_points"].iter().filter_map(|entry| self.of_points(entry)));
        if self.in_contact {
            all.push(Command::run(Name::new("multiply_cycled"), nodes));
        }
        all.push(Command::run(self.name("start_nodes"), nodes));
    }

    /// Conjugate gradients, in the steps that are written down.
    fn iterate<'f>(&'f self, features: &'f Features, all: &mut Vec<Command<'f>>) {
        let levels = self.wide();
        for step in 0..self.room {
            if self.is_automatic() && step > 0 && step % BETWEEN_NEWTON_STEPS == 0 {
                self.go_on(features, all);
            }
            if step % BETWEEN_COUNTS == 0 {
                all.push(Command::run(Name::new("count_open_systems"), 1));
            }
            all.push(self.counted("step_nodes", (0, 0)));
            if step + 1 == self.room {
                // Nothing asks for what it leaves.
                break;
            }
            all.extend(self.iterated_points("distribute_residuals"));
            all.extend(self.multiplied("multiply_cycle", "residual_of_nodes"));
            self.correct(&levels, all);
            all.push(self.counted("prolong_level", (0, 0)));
            all.extend(self.multiplied("multiply_cycle", "smooth_nodes"));
            all.extend(self.iterated_points("average_points"));
            all.extend(self.multiplied("multiply_cycled", "apply_nodes"));
        }
        all.push(Command::run(Name::new("count_left"), 1));
    }

    /// The cycle on coarser levels.
    fn correct<'f>(&'f self, levels: &[(usize, usize)], all: &mut Vec<Command<'f>>) {
        let run = |entry, level| self.counted(entry, level);
        // Where seams join systems the last level is no tail.
        let (last, down) = match levels.split_last() {
            Some((&last, down)) if self.sewn_followers().is_some() => (Some(last), down),
            _ => (None, levels),
        };
        for &level in down {
            all.extend([run("restrict_level", level), run("residual_of_level", level)]);
        }
        if let Some(last) = last {
            all.extend([run("restrict_level", last), run("smooth_level", last)]);
            for _ in 1..LAST_PAIRS {
                all.extend([run("smooth_level_back", last), run("smooth_level", last)]);
            }
        } else if !self.parts[self.tail()].groups.is_empty() {
            all.push(run("cycle_tail", (self.tail(), self.levels)));
        }
        for &level in down.iter().rev() {
            all.extend([run("prolong_level", level), run("smooth_level", level)]);
        }
    }

    /// A kernel that needs a product with contacts, if there are some, and then that product before it.
    fn multiplied(&self, product: &'static str, entry: &'static str) -> impl Iterator<Item = Command<'_>> {
        let product = self.in_contact.then_some(product);
        product.into_iter().chain([entry]).map(|entry| self.counted(entry, (0, 0)))
    }

    /// A kernel on a part of a level, in as many workgroups as were counted for it.
    fn counted(&self, entry: &'static str, (part, which): (usize, usize)) -> Command<'_> {
        let groups = Groups::Counted(&self.counts, which);
        Command::Dispatch(Dispatch { name: self.name(entry), part, groups })
    }
}
