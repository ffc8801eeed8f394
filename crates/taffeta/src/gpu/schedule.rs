//! From the list of passes to kernels: which of them carry out which passes, and in which order.
//!
//! A kernel may carry out several operations that follow each other in the list, on all nodes or on those of some classes of
//! bodies. What each of them does stands in a table that the features give; this module finds an order of its entries in
//! which every class of bodies goes through its own operations in the order of the list, and fails where there is none.

use crate::gpu::feature::{Command, Groups};
use crate::step::{Line, Marks, On, Op, Pass, Stage};

/// One entry of the table: what some commands carry out.
pub struct Fused<'f> {
    /// By what name its time is told.
    pub label: &'static str,
    /// Operations, in the order of the list.
    pub operations: Vec<Op>,
    /// On the nodes of which bodies: those with some marks and without others.
    pub with: Marks,
    /// See `with`.
    pub without: Marks,
    /// Whether it writes the state after alone: before a body has gone on from forces to positions, what is written on its nodes is
    /// written over.
    pub writes_state: bool,
    /// What is done.
    pub commands: Vec<Command<'f>>,
    /// Sub-steps that it carries out at once.
    pub steps: u32,
}

impl<'f> Fused<'f> {
    /// On all nodes.
    pub fn new(operations: &[Op], commands: Vec<Command<'f>>) -> Self {
        Self {
            label: operations[0].stage().name(),
            operations: operations.to_vec(),
            with: Marks::NONE,
            without: Marks::NONE,
            writes_state: false,
            commands,
            steps: 1,
        }
    }

    /// On nodes of bodies with some marks and without others.
    pub fn on(self, with: Marks, without: Marks) -> Self {
        Self { with, without, ..self }
    }

    /// Named as what moves particles.
    pub fn named(self, label: &'static str) -> Self {
        Self { label, ..self }
    }

    /// Whether it has anything to dispatch.
    pub fn does_something(&self) -> bool {
        let is_there = |command: &Command<'_>| match command {
            Command::Dispatch(dispatch) => !matches!(dispatch.groups, Groups::Linear(0)),
            Command::SwapStates | Command::Label(_) => false,
        };
        self.commands.iter().any(is_there)
    }

    fn acts_on(&self, class: Marks) -> bool {
        class.has(self.with) && class.0 & self.without.0 == 0
    }
}

/// Whether two operations may change places: pins move nodes that are held, colliders those that are not.
fn commute(a: Op, b: Op) -> bool {
    matches!((a, b), (Op::Pins, Op::Contact) | (Op::Contact, Op::Pins))
}

/// An operation that a class of bodies has yet to go through, and its place in the list.
type Left = Vec<(usize, Op)>;

/// Where operations are among those that are left, if they come next; others may stand before them only if they commute.
fn next_in(left: &[(usize, Op)], operations: &[Op]) -> Option<Vec<usize>> {
    let (mut found, mut rest) = (Vec::new(), operations);
    for (at, &(_, op)) in left.iter().enumerate() {
        match rest.split_first() {
            None => break,
            Some((&first, others)) if first == op => {
                found.push(at);
                rest = others;
            }
            Some(_) if rest.iter().all(|&one| commute(one, op)) => {}
            Some(_) => return None,
        }
    }
    rest.is_empty().then_some(found)
}

/// Takes away what stands at these indices, in rising order.
fn take(left: &mut Left, done: &[usize]) {
    for &at in done.iter().rev() {
        left.remove(at);
    }
}

/// The order of the table's entries that carries out the passes `lines`, from a stage on, on bodies of these classes. Entries with the same
/// operations on the same nodes come one after the other.
///
/// # Errors
/// Where no entry carries out what comes next.
pub fn schedule(
    lines: &[Line],
    classes: &[Marks],
    table: &[Fused<'_>],
    from: Stage,
) -> Result<Vec<usize>, String> {
    let mut all: Vec<(Marks, Left)> =
        classes.iter().map(|&class| (class, passes_of(lines, class, from))).collect();
    let mut order = Vec::new();
    while let Some(first) = all.iter().filter_map(|(_, left)| left.first()).min() {
        let entry = best(&all, table).ok_or_else(|| format!("no kernel comes next for {:?}", first.1))?;
        let same = |other: &Fused<'_>| {
            let one = &table[entry];
            (&other.operations, other.with, other.without) == (&one.operations, one.with, one.without)
        };
        order.extend((0..table.len()).filter(|&index| same(&table[index])));
        for (class, left) in &mut all {
            if table[entry].acts_on(*class)
                && let Some(done) = next_in(left, &table[entry].operations)
            {
                take(left, &done);
            }
        }
    }
    Ok(order)
}

/// The operations that a class goes through, those before a stage left out.
fn passes_of(lines: &[Line], class: Marks, from: Stage) -> Left {
    let mut passes: Vec<&Pass> = Vec::new();
    for line in lines {
        let rounds = if let Line::Rounds(most, _) = line { *most } else { 1 };
        (0..rounds).for_each(|_| passes.extend(line.passes()));
    }
    // Which nodes are moved is not known here: kernels ask.
    let chosen = |on: On| match on {
        On::Scene(of) => class.has(of),
        On::Tiles { .. } => on.chooses(class.and(Marks::MOVED)),
    };
    let numbered = passes.into_iter().enumerate().filter(|(_, pass)| chosen(pass.on));
    numbered.map(|(at, pass)| (at, pass.op)).skip_while(|(_, op)| op.stage() < from).collect()
}

/// The entry to go on with: the first in the list, of those the longest, of those the first in the table.
fn best(all: &[(Marks, Left)], table: &[Fused<'_>]) -> Option<usize> {
    let candidates = (0..table.len()).filter_map(|index| {
        let entry = &table[index];
        let (mut first, mut is_possible) = (usize::MAX, true);
        for (class, left) in all.iter().filter(|(class, _)| entry.acts_on(*class)) {
            match next_in(left, &entry.operations) {
                Some(found) => first = first.min(left[found[0]].0),
                None => is_possible &= is_harmless(entry, (*class, left), table),
            }
        }
        (is_possible && first < usize::MAX).then_some((first, usize::MAX - entry.operations.len(), index))
    });
    candidates.min().map(|(.., index)| index)
}

/// Whether an entry does nothing that lasts to bodies of a class that has not come to it: they will write over it, and do not
/// need it themselves later.
fn is_harmless(entry: &Fused<'_>, (class, left): (Marks, &Left), table: &[Fused<'_>]) -> bool {
    let moves_later = left.iter().any(|(_, op)| *op == Op::Integrate);
    let needs = |at: usize| {
        left[at].1 == entry.operations[0]
            && !table.iter().any(|other| is_part_of_more(at, other, (class, left)))
    };
    entry.writes_state && moves_later && !(0..left.len()).any(needs)
}

/// Whether an entry carries out an operation that is left together with others.
fn is_part_of_more(at: usize, entry: &Fused<'_>, (class, left): (Marks, &Left)) -> bool {
    let covers = |start: usize| {
        let found = next_in(&left[start..], &entry.operations);
        found.is_some_and(|found| found[0] == 0 && found.contains(&(at - start)))
    };
    entry.acts_on(class) && entry.operations.len() > 1 && (0..=at).any(covers)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::step::{self, Parts};

    const NONE: Marks = Marks::NONE;
    const SOLVED: Marks = Marks::SOLVED;
    const VOLUME: Marks = Marks::VOLUME;

    fn entry(operations: &[Op], with: Marks, without: Marks) -> Fused<'static> {
        let moves = [Op::Integrate, Op::Pins, Op::Contact];
        let writes_state = operations.len() == 1 && moves.contains(&operations[0]);
        Fused { writes_state, ..Fused::new(operations, Vec::new()).on(with, without) }
    }

    /// Kernels as of scenes without elements, with colliders that are solids.
    fn table(whole: bool) -> Vec<Fused<'static>> {
        use Op::{
            ConstraintForces, Contact, Elements, Gradients, Integrate, Loads, Multipliers, Pins, Predict,
            Rings, Solve, Springs, VolumeForces, VolumeSums,
        };
        let mut all = vec![
            entry(&[Elements], NONE, NONE),
            entry(&[Loads], NONE, NONE),
            entry(&[Springs], NONE, VOLUME),
            entry(&[Integrate], NONE, NONE),
            entry(&[Pins], NONE, NONE),
            entry(&[Contact], NONE, NONE),
            entry(&[Predict, Solve, ConstraintForces], SOLVED, NONE),
            entry(&[Gradients, VolumeSums], VOLUME, NONE),
            entry(&[Rings, Springs], VOLUME.and(SOLVED), NONE),
            entry(&[Rings, Springs, VolumeSums], VOLUME, SOLVED),
            entry(&[Multipliers, VolumeForces, Integrate, Contact], VOLUME, NONE),
        ];
        if whole {
            all.push(entry(&[Loads, Springs, Integrate, Contact], NONE, VOLUME.and(SOLVED)));
            all.push(entry(&[Loads, Rings, Springs, VolumeSums], VOLUME, SOLVED));
        }
        all
    }

    fn names(parts: Parts, classes: &[Marks], table: &[Fused<'_>]) -> Vec<Vec<Op>> {
        let order = schedule(&step::substep(&parts), classes, table, Stage::default()).expect("an order");
        order.into_iter().map(|index| table[index].operations.clone()).collect()
    }

    #[test]
    fn cloth_alone_takes_the_longest_kernel_and_pins_after_it() {
        let found = names(Parts::default(), &[NONE], &table(true));
        let particles = vec![Op::Loads, Op::Springs, Op::Integrate, Op::Contact];
        assert_eq!(found, [vec![Op::Elements], particles, vec![Op::Pins]]);
    }

    #[test]
    fn what_acts_on_all_nodes_waits_for_bodies_that_need_it_later() {
        let parts = Parts { volumes: true, ..Parts::default() };
        let found = names(parts, &[NONE, VOLUME], &table(true));
        let pins = found.iter().filter(|operations| operations[..] == [Op::Pins]).count();
        assert_eq!((pins, found.last()), (1, Some(&vec![Op::Pins])));
    }

    #[test]
    fn what_is_written_over_does_not_wait() {
        let parts = Parts { volumes: true, solved: true, ..Parts::default() };
        let found = names(parts, &[SOLVED, SOLVED.and(VOLUME)], &table(true));
        let at = |op: Op| found.iter().position(|operations| operations[..] == [op]).expect("it is there");
        let of_volumes = found.iter().position(|operations| operations[0] == Op::Multipliers);
        assert!(
            of_volumes
                .is_some_and(|of_volumes| at(Op::Integrate) < of_volumes && at(Op::Contact) < of_volumes)
        );
    }

    #[test]
    fn every_class_goes_through_the_list_in_order() {
        let scenes = [
            (Parts::default(), vec![NONE]),
            (Parts { volumes: true, ..Parts::default() }, vec![NONE, VOLUME]),
            (Parts { volumes: true, ..Parts::default() }, vec![VOLUME]),
            (Parts { solved: true, ..Parts::default() }, vec![SOLVED]),
            (Parts { solved: true, volumes: true, ..Parts::default() }, vec![SOLVED, SOLVED.and(VOLUME)]),
        ];
        for ((parts, classes), whole) in
            scenes.into_iter().flat_map(|scene| [(scene.clone(), true), (scene, false)])
        {
            let (lines, table) = (step::substep(&parts), table(whole));
            let order = schedule(&lines, &classes, &table, Stage::default()).expect("an order");
            for class in classes {
                let mut left = passes_of(&lines, class, Stage::default());
                for &index in order.iter().filter(|&&index| table[index].acts_on(class)) {
                    if let Some(done) = next_in(&left, &table[index].operations) {
                        take(&mut left, &done);
                    } else {
                        assert!(is_harmless(&table[index], (class, &left), &table), "{class:?}");
                    }
                }
                assert!(left.is_empty(), "{class:?}: {left:?} are left");
            }
        }
    }

    #[test]
    fn an_operation_that_no_kernel_does_is_an_error() {
        let mut table = table(false);
        table.retain(|entry| entry.operations[0] != Op::Integrate);
        let error =
            schedule(&step::substep(&Parts::default()), &[NONE], &table, Stage::default()).unwrap_err();
        assert!(error.contains("Integrate"), "{error}");
    }
}
