//! The row of the kernel that counts what comes next.

use crate::contact::triangles::carry::Phase;
use crate::contact::triangles::gpu_layout as layout;
use crate::contact::triangles::parity::run;
use crate::contact::triangles::parity_scene::fixture;
use crate::contact::triangles::parity_stages::ROOM;
use crate::contact::triangles::twin::Twin;
use crate::parity::bench::Bench;

const RESTART: u32 = Phase::Restart as u32;
const SQUEEZE: u32 = Phase::Squeeze as u32;
const STOP: u32 = Phase::Stop as u32;
const OVER: u32 = Phase::Over as u32;

/// What is counted, and what some words of `surface_work` are before.
const CASES: &[(usize, &[(usize, u32)])] = &[
    (layout::COUNT_PAIRS, &[(layout::PAIRS, ROOM)]),
    (layout::COUNT_PAIRS, &[(layout::PAIRS, ROOM + 1), (layout::MOST_PAIRS, ROOM + 100)]),
    (layout::COUNT_CONTACTS, &[(layout::CONTACTS, 257), (layout::TOUCHED, 256), (layout::FORCES, 9)]),
    (layout::COUNT_CONTACTS, &[(layout::CONTACTS, ROOM + 77), (layout::TOUCHED, 0), (layout::SHORT, 1)]),
    (layout::COUNT_ROUND, &[(layout::ROUND, 0)]),
    (layout::COUNT_ROUND, &[(layout::ROUND, 1), (layout::SINKS, 0.011_f32.to_bits())]),
    (layout::COUNT_ROUND, &[(layout::ROUND, 4), (layout::SINKS, 0.01_f32.to_bits())]),
    (layout::COUNT_ROUND, &[(layout::ROUND, 4), (layout::SINKS, 0.011_f32.to_bits())]),
    (layout::COUNT_ROUND, &[(layout::ROUND, 11), (layout::SINKS, 0.011_f32.to_bits())]),
    (layout::COUNT_WAYS, &[(layout::IS_ACTIVE, 1)]),
    (
        layout::COUNT_WAYS,
        &[(layout::IS_ACTIVE, 1), (layout::CHANGE_OF_WAY, 0.1_f32.to_bits()), (layout::IS_ODD, 1)],
    ),
    (layout::COUNT_WAYS, &[(layout::IS_ACTIVE, 1), (layout::WAY, 0.1_f32.to_bits())]),
    (layout::COUNT_WAYS, &[(layout::IS_ACTIVE, 1), (layout::FILTER_ROUND, 2)]),
    (layout::COUNT_PART, &[]),
    (layout::COUNT_PART, &[(layout::CORNER_PART, 1), (layout::FARTHEST_PLACE, 1_f32.to_bits())]),
    (layout::COUNT_PART, &[(layout::CORNER_PART, 2), (layout::FARTHEST_PLACE, 1_f32.to_bits())]),
    (layout::COUNT_PART, &[(layout::CORNER_PART, 3)]),
    (layout::COUNT_CARRIED, &[(layout::CORNER_PART, 2), (layout::PUSH_ROUND, 3), (layout::PUSHED, 1)]),
    (layout::COUNT_CARRIED, &[(layout::CORNER_PART, 2), (layout::PUSH_PHASE, OVER), (layout::WAITING, 7)]),
    (layout::COUNT_CARRIED, &[(layout::CORNER_PART, 2), (layout::PAIRS, ROOM + 1)]),
    (layout::COUNT_CARRIED, &[(layout::CORNER_PART, 3)]),
    (layout::COUNT_PUSHES, &[(layout::PUSHED, 1), (layout::PUSH_ROUND, 5)]),
    (layout::COUNT_PUSHES, &[(layout::PUSHED, 1), (layout::PUSH_ROUND, 6), (layout::WAITING, 7)]),
    (layout::COUNT_PUSHES, &[(layout::PUSH_ROUND, 6)]),
    (layout::COUNT_PUSHES, &[(layout::PUSH_ROUND, 6), (layout::WAITING, 7)]),
    (layout::COUNT_PUSHES, &[(layout::PUSHED, 1), (layout::PUSH_ROUND, 30), (layout::WAITING, 7)]),
    (layout::COUNT_PUSHES, &[(layout::PUSHED, 1), (layout::PUSH_ROUND, 31), (layout::WAITING, 7)]),
    (layout::COUNT_PUSHES, &[(layout::PUSHED, 1), (layout::PUSH_ROUND, 31)]),
    (layout::COUNT_PUSHES, &[(layout::PUSH_ROUND, 32), (layout::PUSH_PHASE, RESTART)]),
    (layout::COUNT_PUSHES, &[(layout::PUSH_ROUND, 33), (layout::PUSH_PHASE, SQUEEZE)]),
    (layout::COUNT_PUSHES, &[(layout::PUSH_ROUND, 33), (layout::PUSH_PHASE, SQUEEZE), (layout::WAITING, 7)]),
    (
        layout::COUNT_PUSHES,
        &[(layout::PUSHED, 1), (layout::PUSH_ROUND, 46), (layout::PUSH_PHASE, SQUEEZE), (layout::WAITING, 7)],
    ),
    (
        layout::COUNT_PUSHES,
        &[
            (layout::PUSHED, 1),
            (layout::PUSH_ROUND, 47),
            (layout::PUSH_PHASE, SQUEEZE),
            (layout::WAITING, 7),
            (layout::SQUEEZED, 3),
        ],
    ),
    (layout::COUNT_PUSHES, &[(layout::PUSHED, 1), (layout::PUSH_ROUND, 62), (layout::PUSH_PHASE, STOP)]),
    (layout::COUNT_PUSHES, &[(layout::PUSHED, 1), (layout::PUSH_ROUND, 63), (layout::PUSH_PHASE, STOP)]),
    (layout::COUNT_PUSHES, &[(layout::PUSH_ROUND, 50), (layout::PUSH_PHASE, STOP)]),
    (layout::COUNT_SOLVED, &[(layout::IS_ODD, 0)]),
    (layout::COUNT_SOLVED, &[(layout::IS_ODD, 1)]),
    (
        layout::COUNT_WAYS,
        &[(layout::IS_ACTIVE, 0), (layout::FILTER_ROUND, 2), (layout::WAY, 0.1_f32.to_bits())],
    ),
    (layout::COUNT_HELD, &[(layout::IS_ACTIVE, 1), (layout::HELD, 3)]),
    (layout::COUNT_HELD, &[(layout::IS_ACTIVE, 1), (layout::HELD, 3), (layout::JAM, 48)]),
    (layout::COUNT_HELD, &[(layout::IS_ACTIVE, 1), (layout::HELD, 3), (layout::JAM, 49)]),
    (layout::COUNT_HELD, &[(layout::IS_ACTIVE, 1), (layout::IN_ROUNDS, 1)]),
    (layout::COUNT_HELD, &[(layout::IS_ACTIVE, 0), (layout::IN_ROUNDS, 1)]),
    (
        layout::COUNT_FILTER_ROUND,
        &[(layout::IS_ACTIVE, 1), (layout::WAY, 0.1_f32.to_bits()), (layout::PROGRESS, 0.1_f32.to_bits())],
    ),
    (layout::COUNT_FILTER_ROUND, &[(layout::IS_ACTIVE, 1), (layout::WAY, 0.1_f32.to_bits())]),
    (layout::COUNT_FILTER_ROUND, &[(layout::IS_ACTIVE, 1), (layout::PROGRESS, 0.1_f32.to_bits())]),
    (
        layout::COUNT_FILTER_ROUND,
        &[(layout::IS_ACTIVE, 1), (layout::PROGRESS, 0.1_f32.to_bits()), (layout::FILTER_ROUND, 3)],
    ),
    (
        layout::COUNT_FILTER_ROUND,
        &[
            (layout::IS_ACTIVE, 1),
            (layout::WAY, 0.1_f32.to_bits()),
            (layout::PROGRESS, 0.1_f32.to_bits()),
            (layout::FILTER_ROUND, 2),
            (layout::WAY_TAKEN, 0.2_f32.to_bits()),
        ],
    ),
    (
        layout::COUNT_FILTER_ROUND,
        &[
            (layout::IS_ACTIVE, 1),
            (layout::WAY_TAKEN, 0.1_f32.to_bits()),
            (layout::MOST_WAY_TAKEN, 0.05_f32.to_bits()),
        ],
    ),
];

/// All that is counted, with numbers on both sides of what is asked.
pub fn count(bench: &mut Bench<'_>) -> Result<(), String> {
    for (part, numbers) in CASES {
        let mut fixture = fixture(51)?;
        let mut twin = Twin::of(&fixture, 5);
        twin.part = *part as u32;
        (twin.work[layout::PAIRS], twin.work[layout::MOST_CONTACTS]) = (17, 5);
        for &(word, number) in *numbers {
            twin.work[word] = number;
        }
        run(bench, "count_surfaces", &mut fixture, twin, |twin, _| twin.count_surfaces())?;
    }
    Ok(())
}
