//! The list, held against what must be true of every scene.

use super::*;

const NONE: Marks = Marks::NONE;

/// Every class of tiles that a scene with these parts may have; where nodes are moved, some of them are.
fn classes(parts: &Parts) -> impl Iterator<Item = Marks> + use<> {
    let mut solved = vec![NONE];
    if parts.solved {
        solved.extend([Marks::SOLVED, Marks::SOLVED.and(Marks::IMPLICIT)]);
    }
    if parts.positions {
        solved.push(Marks::IMPLICIT);
    }
    let volumes = &[NONE, Marks::VOLUME][..if parts.volumes { 2 } else { 1 }];
    let with = |one: Marks| volumes.iter().map(move |&volume| one.and(volume).and(Marks::MOVED));
    solved.into_iter().flat_map(with).collect::<Vec<_>>().into_iter()
}

/// The operations on tiles of a class, one round of those that come in rounds.
fn of(parts: &Parts, class: Marks) -> Vec<Op> {
    let lines = substep(parts);
    let passes = lines.iter().flat_map(Line::passes);
    passes.filter(|pass| pass.on.chooses(class)).map(|pass| pass.op).collect()
}

fn each(mut check: impl FnMut(&Parts, Marks, &[Op])) {
    for parts in Parts::all() {
        classes(&parts).for_each(|class| check(&parts, class, &of(&parts, class)));
    }
}

#[test]
fn all_forces_come_before_the_one_integration() {
    each(|parts, class, operations| {
        let at: Vec<usize> = (0..operations.len()).filter(|&at| operations[at] == Op::Integrate).collect();
        assert_eq!(at.len(), 1, "{class:?} of {parts:?}");
        let (before, after) = operations.split_at(at[0]);
        let kept = before.last() == Some(&Op::HeldForces);
        let before = if kept { &before[..before.len() - 1] } else { before };
        assert_eq!(kept, parts.held, "{class:?} of {parts:?}");
        assert!(before.iter().all(|op| op.stage() < Stage::Integrate), "{class:?} of {parts:?}");
        assert!(after.iter().all(|op| op.stage() >= Stage::Integrate), "{class:?} of {parts:?}");
        assert_eq!(after[..3], [Op::Integrate, Op::Pins, Op::Contact], "{class:?} of {parts:?}");
    });
}

#[test]
fn every_force_acts_once_on_those_who_have_it() {
    each(|parts, class, operations| {
        let count = |op| operations.iter().filter(|&&one| one == op).count();
        let [solved, implicit, volume] =
            [Marks::SOLVED, Marks::IMPLICIT, Marks::VOLUME].map(|mark| usize::from(class.has(mark)));
        assert_eq!(count(Op::Loads), 1);
        assert_eq!(count(Op::Gather), usize::from(parts.elements));
        assert_eq!(count(Op::Springs), 1 - implicit);
        assert_eq!([count(Op::Predict), count(Op::ConstraintForces)], [solved; 2]);
        // A gradient once, among the springs' rings or alone; sums after all forces but the volume's.
        assert_eq!(count(Op::VolumeForces), volume, "{class:?} of {parts:?}");
        assert_eq!(count(Op::VolumeSums), volume, "{class:?} of {parts:?}");
        assert!(count(Op::Rings) + count(Op::Gradients) >= volume, "{class:?} of {parts:?}");
    });
}

#[test]
fn forces_that_are_kept_are_taken_up_again() {
    each(|parts, class, operations| {
        for (kept, taken) in [(Op::Predict, Op::ConstraintForces), (Op::VolumeSums, Op::VolumeForces)] {
            let at = |op| operations.iter().position(|&one| one == op);
            assert_eq!(at(kept).is_some(), at(taken).is_some(), "{class:?} of {parts:?}");
            assert!(at(kept) <= at(taken), "{class:?} of {parts:?}");
        }
    });
}

#[test]
fn colliders_act_after_all_that_moves_nodes() {
    let moves = [
        Op::Integrate,
        Op::ApplyPositions,
        Op::ApplyAttachments,
        Op::ApplySelfContact,
        Op::ApplySurfaceImpulses,
        Op::RestoreVolumes,
    ];
    for lines in Parts::all().map(|parts| substep(&parts)) {
        let passes: Vec<&Pass> = lines.iter().flat_map(Line::passes).collect();
        for (at, pass) in passes.iter().enumerate().filter(|(_, pass)| moves.contains(&pass.op)) {
            let next = passes[at + 1..].iter().find(|next| next.op != Op::Pins);
            let contact = next.expect("another pass");
            assert_eq!((contact.op, contact.on), (Op::Contact, pass.on), "after {:?}", pass.op);
        }
    }
}

#[test]
fn what_reads_other_tiles_waits_for_them() {
    for parts in Parts::all() {
        let lines = substep(&parts);
        for pass in lines.iter().flat_map(Line::passes) {
            let wanted = match pass.op {
                // They read forces, or the state after, of nodes anywhere.
                Op::Solve | Op::Multipliers | Op::Attachments | Op::MeasureVolumes => true,
                // Nodes anywhere were moved.
                Op::PositionConstraints | Op::ApplyPositions => true,
                Op::SurfaceContacts | Op::SurfaceImpulses | Op::SurfaceFilter => true,
                // What elements have found on other workers.
                Op::Loads => parts.elements,
                _ => false,
            };
            assert_eq!(pass.sync, wanted, "{:?} of {parts:?}", pass.op);
        }
    }
}

#[test]
fn a_scene_is_asked_for_what_it_has_and_nothing_else() {
    for parts in Parts::all() {
        let lines = substep(&parts);
        let has = |op| lines.iter().flat_map(Line::passes).any(|pass| pass.op == op);
        let Parts {
            elements,
            solved,
            positions,
            volumes,
            restored,
            attachments,
            self_contact,
            surface_contact,
            held,
        } = parts;
        let wanted = [
            (Op::Gather, elements),
            (Op::Solve, solved),
            (Op::Rings, volumes),
            (Op::Multipliers, volumes),
            (Op::Gradients, (solved || positions) && volumes),
            (Op::ApplyPositions, positions),
            (Op::ApplyAttachments, attachments),
            (Op::ApplySelfContact, self_contact),
            (Op::ApplySurfaceImpulses, surface_contact),
            (Op::ApplySurfaceFilter, surface_contact),
            (Op::RestoreVolumes, restored),
            (Op::HeldForces, held),
            (Op::MeasureTiles, false),
        ];
        for (op, is_there) in wanted {
            assert_eq!(has(op), is_there, "{op:?} of {parts:?}");
        }
    }
}
