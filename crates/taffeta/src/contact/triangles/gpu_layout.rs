//! Records of contact of surfaces as kernels see them.

use bytemuck::{Pod, Zeroable};

/// `SurfaceContact` of impulse.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct SurfaceContact {
    pub nodes: [u32; 4],
    pub weights: [f32; 4],
    pub normal: [f32; 3],
    pub gap: f32,
    pub impulse: [f32; 3],
    pub mobility: f32,
    pub force: [f32; 3],
    pub thickness: f32,
    pub order: [u32; 3],
    pub friction: f32,
    pub solved: [f32; 3],
    pub push: f32,
    pub leads: u32,
    pub grip: f32,
    pub padding: [f32; 2],
}

/// `SolvedContact` of solved.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct SolvedContact {
    pub nodes: [u32; 4],
    pub weights: [f32; 4],
    pub normal: [f32; 3],
    pub gap: f32,
    pub first: [f32; 3],
    pub lead: f32,
    pub impulse: [f32; 3],
    pub along: f32,
    pub applied: [f32; 3],
    pub across: f32,
    pub friction: f32,
    pub stiffness: f32,
    pub system: u32,
    pub is_held: u32,
}

/// Numbers that kernels know by the same names.
macro_rules! words {
    ($($(#[$doc:meta])* $name:ident = $value:expr;)*) => {
        $($(#[$doc])* pub const $name: usize = $value;)*
        /// All of them.
        #[cfg(test)]
        pub const WORDS: &[(&str, usize)] = &[$((stringify!($name), $name)),*];
    };
}

words! {
    // Of the header of the tables.
    NODE_PLACES = 0;
    ALL_PLACES = 1;
    LEAF_COUNT = 2;
    TOP_LEVEL = 3;
    LEVEL_BOXES = 4;
    LEAVES_AT = 16;
    ROWS_AT = 17;
    ROW_ITEMS_AT = 18;
    RINGS_AT = 19;
    MATERIALS_AT = 20;
    MATERIAL_COUNT = 21;
    LEAVES_OF_AT = 22;
    LEAF_ITEMS_AT = 23;
    START_AT = 24;
    HAS_SURFACE_AT = 25;
    PAIR_ROOM = 26;
    CONTACT_ROOM = 27;
    BUCKETS = 28;
    LONGEST_WAY = 30;
    SQUARED_WAY = 31;
    SQUARED_PROGRESS = 32;
    SQUARED_CHANGE = 33;
    ALLOWANCE = 34;
    THICKEST = 35;
    LONGEST_EDGE = 36;
    ROUND_ROOM = 37;
    JAM_ROOM = 39;
    PUSH_ROOM = 40;
    IS_TANGLED = 41;
    PULL_COUNT = 42;
    IS_SOLVED = 43;
    FANS_AT = 44;
    FAN_ITEMS_AT = 45;
    IMPULSE_ROOM = 46;
    // Of a leaf.
    LEAF_WORDS = 56;
    LEAF_NODES = 16;
    LEAF_MATERIAL = 17;
    LEAF_HELD = 18;
    LEAF_COUNTS = 19;
    LEAF_TRIANGLES = 20;
    LEAF_EDGES = 28;
    LEAF_VERTICES = 52;
    LEAF_GROUP = 16;
    // Arrays of places.
    AT_START = 0;
    BEFORE = 1;
    AFTER = 2;
    BASE_VELOCITY = 3;
    PUSH = 4;
    TARGET = 5;
    TARGET_VELOCITY = 6;
    // Of a place, and of a pull, where surfaces pass through each other.
    KNOT_WORDS = 11;
    KNOT_OF = 0;
    KNOT_NEXT = 2;
    KNOT_ASTRAY = 4;
    KNOT_ABOVE = 6;
    KNOT_LOOSE = 8;
    KNOT_LED = 10;
    PULL_WORDS = 16;
    PULL_WEIGHTS = 4;
    PULL_DIRECTION = 8;
    PULL_THICKNESS = 11;
    PULL_SIZE = 12;
    PULL_LED = 13;
    // What is counted.
    PAIRS = 0;
    CONTACTS = 1;
    TOUCHED = 2;
    PARTS = 3;
    FORCES = 4;
    SINKS = 5;
    NEAREST = 6;
    WAY = 7;
    CHANGE_OF_WAY = 8;
    FARTHEST_PLACE = 9;
    PROGRESS = 10;
    HELD = 11;
    ROUND = 12;
    IS_ACTIVE = 13;
    FILTER_ROUND = 14;
    JAM = 15;
    LISTED = 16;
    IN_ROUNDS = 17;
    IS_ODD = 18;
    CORNER_PART = 19;
    PUSHED = 20;
    PUSH_ROUND = 21;
    SHORT = 22;
    MOST_PAIRS = 23;
    MOST_CONTACTS = 24;
    MOST_IMPULSES = 25;
    MOST_ROUNDS = 26;
    MOST_JAMS = 27;
    MOST_PUSHES = 28;
    WAY_TAKEN = 29;
    MOST_WAY_TAKEN = 30;
    SQUEEZED = 31;
    PUSH_PHASE = 32;
    WAITING = 33;
    LISTS = 34;
    STAMPS = 32;
    // Which pairs of leaves are listed.
    NEAR = 0;
    AROUND = 1;
    ALL = 2;
    CARRIED = 3;
    SOLVED = 4;
    // What is counted by a command.
    COUNT_PAIRS = 0;
    COUNT_CONTACTS = 1;
    COUNT_ROUND = 2;
    COUNT_WAYS = 3;
    COUNT_HELD = 4;
    COUNT_FILTER_ROUND = 5;
    COUNT_PART = 6;
    COUNT_CARRIED = 7;
    COUNT_PUSHES = 8;
    COUNT_SOLVED = 9;
    // Commands that run in as many workgroups as are counted.
    ON_PAIRS = 0;
    ON_CONTACTS = 1;
    ON_TOUCHED = 2;
    ON_ROUND_CONTACTS = 3;
    ON_ROUND_TOUCHED = 4;
    ON_MEASURE = 5;
    ON_PART = 6;
    ON_MARK = 7;
    ON_HOLD = 8;
    ON_LIST = 9;
    ON_CORNERS = 10;
    ON_PUSH = 11;
    ON_TAKE = 12;
    ON_BOXES = 13;
}

/// Words of the header.
pub const HEADER: usize = 47;
/// Arrays of places.
pub const PLACE_ARRAYS: usize = 7;
/// Levels of boxes at most: sixteen times more leaves each.
pub const LEVELS: usize = 6;
/// Records of `surface_forces` for each contact.
pub const FORCE_RECORDS: usize = 3;
/// What bounds are multiplied by, for rounding.
pub const LOOSE_REACH: f64 = 1.0001;
