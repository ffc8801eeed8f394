// How many workgroups the commands of contact run in, and what comes next.

#import contact/triangles/surfaces.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/substep.wgsl

// What is counted.
const COUNT_PAIRS: u32 = 0u;
const COUNT_CONTACTS: u32 = 1u;
const COUNT_ROUND: u32 = 2u;
const COUNT_WAYS: u32 = 3u;
const COUNT_HELD: u32 = 4u;
const COUNT_FILTER_ROUND: u32 = 5u;
const COUNT_PART: u32 = 6u;
const COUNT_CARRIED: u32 = 7u;
const COUNT_PUSHES: u32 = 8u;
const COUNT_SOLVED: u32 = 9u;

// Commands that run in as many workgroups as are counted: three words each. Boxes have one for each level.
const ON_PAIRS: u32 = 0u;
const ON_CONTACTS: u32 = 1u;
const ON_TOUCHED: u32 = 2u;
const ON_ROUND_CONTACTS: u32 = 3u;
const ON_ROUND_TOUCHED: u32 = 4u;
const ON_MEASURE: u32 = 5u;
const ON_PART: u32 = 6u;
const ON_MARK: u32 = 7u;
const ON_HOLD: u32 = 8u;
const ON_LIST: u32 = 9u;
const ON_CORNERS: u32 = 10u;
const ON_PUSH: u32 = 11u;
const ON_TAKE: u32 = 12u;
const ON_BOXES: u32 = 13u;

/// How far a contact may sink in by a sub-step, relative to its thickness, before another round corrects impulses.
const MOST_SINKING: f32 = 0.01;
/// Rounds of impulses at most.
const IMPULSES: u32 = 12u;
/// Rounds of the filter at most.
const MOST_FILTER_ROUNDS: u32 = 64u;
/// Nodes slide in the first rounds of a sub-step, of which there are more only for those that go far.
const SLIDES: u32 = 4u;
/// How often nodes that are held back may hold back others before planes of all pairs stand still.
const JAMS: u32 = 16u;
/// After how many rounds of pushes less of each distance is kept, and after how many nodes stop.
const FIRST_PUSHES: u32 = 32u;
const FIRST_STOP: u32 = 48u;

/// Workgroups of a command, in rows as dispatches have them.
fn put_groups(command: u32, groups: u32) {
    surface_counts[3u * command] = min(groups, GROUPS_IN_ROW);
    surface_counts[3u * command + 1u] = (groups + GROUPS_IN_ROW - 1u) / GROUPS_IN_ROW;
    surface_counts[3u * command + 2u] = 1u;
}

/// Workgroups with an invocation for each of some.
fn put_each(command: u32, count: u32) {
    put_groups(command, (count + 255u) / 256u);
}

/// A workgroup for each group of leaves, where pairs are listed.
fn put_list(is_on: bool) {
    put_groups(ON_LIST, select(0u, (table(LEAF_COUNT) + LEAF_GROUP - 1u) / LEAF_GROUP, is_on));
}

fn put_boxes(is_on: bool) {
    for (var level = 0u; level <= table(TOP_LEVEL); level++) {
        put_each(ON_BOXES + level, select(0u, table(LEVEL_BOXES + 2u * level + 1u), is_on));
    }
}

/// Notes what a list needs, and that there was too little room.
fn check_room(list: u32, room: u32, most: u32, flag: u32) -> u32 {
    let wanted = counted(list);
    need(most, wanted, room, flag);
    set_counted(list, min(wanted, room));
    return min(wanted, room);
}

/// Notes that so much is needed, of room or of what is written down, and whether there is less.
fn need(most: u32, wanted: u32, room: u32, flag: u32) {
    atomicMax(&surface_work[most], wanted);
    if wanted > room {
        atomicOr(&surface_work[SHORT], flag);
    }
}

fn count_contacts() {
    let contacts = check_room(CONTACTS, table(CONTACT_ROOM), MOST_CONTACTS, 2u);
    put_each(ON_CONTACTS, contacts);
    put_each(ON_ROUND_CONTACTS, contacts);
    put_each(ON_TOUCHED, counted(TOUCHED));
    put_each(ON_ROUND_TOUCHED, counted(TOUCHED));
    set_counted(FORCES, 0u);
    set_counted(IS_ACTIVE, 1u);
}

/// Whether there is another round of impulses: the first correction, and then as long as contacts would sink in.
fn count_round() {
    let next = counted(ROUND) + 1u;
    let goes_on = next == 1u || bitcast<f32>(counted(SINKS)) > MOST_SINKING;
    if goes_on && next < IMPULSES {
        need(MOST_IMPULSES, next + 1u, table(IMPULSE_ROOM), 32u);
    }
    if !goes_on {
        put_groups(ON_ROUND_CONTACTS, 0u);
        put_groups(ON_ROUND_TOUCHED, 0u);
    }
    set_counted(SINKS, 0u);
    set_counted(ROUND, next);
}

/// Ways are measured: whether they are gone in parts, and which pairs are to be listed again.
fn count_ways() {
    let round = counted(FILTER_ROUND);
    let is_active = counted(IS_ACTIVE) != 0u;
    if round == 0u {
        // The forces of this sub-step are those of the next one.
        set_counted(IS_ODD, 1u - counted(IS_ODD));
    }
    let is_far = bitcast<f32>(counted(WAY)) > length_of(SQUARED_WAY);
    let in_rounds = is_active && (is_far || round > 0u);
    let is_changed = bitcast<f32>(counted(CHANGE_OF_WAY)) > length_of(SQUARED_CHANGE);
    let is_carried = round == 0u && substeps[own()].corner_parts > 0u;
    let again = is_active && (in_rounds || is_changed || is_carried);
    let places = table(NODE_PLACES);
    put_each(ON_PART, select(0u, places, in_rounds));
    put_boxes(again);
    put_list(again);
    put_each(ON_MARK, select(0u, places, is_active));
    put_groups(ON_HOLD, 0u);
    set_counted(IN_ROUNDS, select(0u, 1u, in_rounds));
    set_counted(LISTED, NEAR);
    set_counted(JAM, round * STAMPS);
    if again || !is_active {
        set_counted(PAIRS, 0u);
    }
}

/// Nodes are held back: those around them are limited by planes that stand still.
fn count_held() {
    let jam = counted(JAM) % STAMPS;
    let is_written = jam < table(JAM_ROOM);
    if counted(HELD) > 0u {
        need(MOST_JAMS, jam + 1u, table(JAM_ROOM), 8u);
    }
    let any = counted(HELD) > 0u && is_written;
    if jam == 0u && counted(IS_ACTIVE) != 0u && (any || counted(IN_ROUNDS) != 0u) {
        put_each(ON_HOLD, table(NODE_PLACES));
    }
    put_list(any);
    if !any {
        put_groups(ON_MARK, 0u);
    }
    set_counted(LISTED, select(AROUND, ALL, jam == JAMS));
    set_counted(JAM, counted(JAM) + 1u);
    set_counted(HELD, 0u);
    set_counted(PAIRS, 0u);
}

/// A round of the filter is over: there is another one if nodes get on that have far to go, or slide.
fn count_filter_round() {
    let is_far = bitcast<f32>(counted(WAY)) > length_of(SQUARED_WAY);
    let gets_on = !(bitcast<f32>(counted(PROGRESS)) < length_of(SQUARED_PROGRESS));
    let next = counted(FILTER_ROUND) + 1u;
    let wanted = counted(IS_ACTIVE) != 0u && gets_on && (is_far || next < SLIDES);
    let another = wanted && next < table(ROUND_ROOM);
    if wanted && next < MOST_FILTER_ROUNDS {
        need(MOST_ROUNDS, next + 1u, table(ROUND_ROOM), 4u);
    }
    set_counted(FILTER_ROUND, next);
    set_counted(IS_ACTIVE, select(0u, 1u, another));
    put_each(ON_MEASURE, select(0u, table(ALL_PLACES), another));
    set_counted(WAY, 0u);
    set_counted(CHANGE_OF_WAY, 0u);
    set_counted(FARTHEST_PLACE, 0u);
    set_counted(PROGRESS, 0u);
    if !another {
        atomicMax(&surface_work[MOST_WAY_TAKEN], counted(WAY_TAKEN));
    }
    set_counted(WAY_TAKEN, 0u);
}

/// Another part of the motion of colliders begins; after the last one they are at rest.
fn count_part() {
    let part = counted(CORNER_PART);
    let parts = substeps[own()].corner_parts;
    let goes_on = part < parts;
    put_each(ON_CORNERS, select(0u, table(ALL_PLACES), goes_on || part == parts && parts > 0u));
    put_boxes(goes_on);
    put_list(goes_on);
    set_counted(LISTED, CARRIED);
    if goes_on {
        set_counted(PAIRS, 0u);
    } else {
        // It is measured again where nodes are now.
        set_counted(FARTHEST_PLACE, 0u);
    }
    set_counted(CORNER_PART, part + 1u);
}

/// The pairs around colliders are listed: those in the way are pushed.
fn count_carried() {
    let goes_on = counted(CORNER_PART) <= substeps[own()].corner_parts;
    var pairs = 0u;
    if goes_on {
        pairs = check_room(PAIRS, table(PAIR_ROOM), MOST_PAIRS, 1u);
    }
    put_groups(ON_PUSH, pairs);
    put_each(ON_TAKE, select(0u, table(NODE_PLACES), goes_on));
    set_counted(PUSH_ROUND, 0u);
    set_counted(PUSHED, 0u);
    set_counted(WAITING, 0u);
    set_counted(PUSH_PHASE, PHASE_PUSH);
}

/// What is done after a round of pushes, by its number and what it came to.
fn phase_after(phase: u32, round: u32, moved: bool, waits: bool) -> u32 {
    if phase == PHASE_RESTART {
        return PHASE_SQUEEZE;
    }
    let rounds = select(select(PUSHES, FIRST_STOP, phase == PHASE_SQUEEZE), FIRST_PUSHES, phase == PHASE_PUSH);
    if moved && round + 1u < rounds {
        return phase;
    }
    return select(PHASE_OVER, phase + 1u, waits && phase != PHASE_STOP);
}

/// Nodes are pushed: they may push others.
fn count_pushes() {
    let round = counted(PUSH_ROUND);
    let waiting = counted(WAITING);
    let phase = phase_after(counted(PUSH_PHASE), round, counted(PUSHED) != 0u, waiting != 0u);
    if phase == PHASE_STOP {
        atomicMax(&surface_work[SQUEEZED], waiting);
    }
    if phase == PHASE_OVER {
        put_groups(ON_PUSH, 0u);
        put_groups(ON_TAKE, 0u);
    } else {
        need(MOST_PUSHES, round + 2u, table(PUSH_ROOM), 16u);
    }
    set_counted(PUSH_ROUND, round + 1u);
    set_counted(PUSHED, 0u);
    set_counted(WAITING, 0u);
    set_counted(PUSH_PHASE, phase);
}

@compute @workgroup_size(256)
fn count_surfaces(@builtin(local_invocation_index) lane: u32) {
    if lane > 0u {
        return;
    }
    switch surface_part[0] {
        case COUNT_PAIRS: {
            put_groups(ON_PAIRS, check_room(PAIRS, table(PAIR_ROOM), MOST_PAIRS, 1u));
        }
        case COUNT_CONTACTS: {
            count_contacts();
        }
        case COUNT_ROUND: {
            count_round();
        }
        case COUNT_WAYS: {
            count_ways();
        }
        case COUNT_HELD: {
            count_held();
        }
        case COUNT_PART: {
            count_part();
        }
        case COUNT_CARRIED: {
            count_carried();
        }
        case COUNT_PUSHES: {
            count_pushes();
        }
        case COUNT_SOLVED: {
            // Contacts are looked for again, and start from what the solver has found.
            set_counted(IS_ODD, 1u - counted(IS_ODD));
        }
        default: {
            count_filter_round();
        }
    }
}
