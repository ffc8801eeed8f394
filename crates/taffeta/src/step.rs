//! One sub-step as data: the list of passes that both backends execute, from top to bottom.
//!
//! A pass is an operation of one feature, on the whole scene or on tiles (some hundred neighbouring nodes). Tile passes that
//! follow each other run one after the other on each tile, so that what a pass has just written is still at hand for the
//! next; where a pass needs what all others have written, all workers synchronise before it. Neither backend has an order of
//! its own: what one may fuse is a table that is checked against this list.

/// Which part of a sub-step an operation belongs to: what times are summed up by, and from where on a GPU can take over.
///
/// ```
/// # use taffeta::scene::{Body, Collider, Mass, Mesh, Scene, Select};
/// # use taffeta::{Options, Simulation};
/// # let cloth = Body::cloth("cloth", Mesh::grid(4, 5, [0.4, 0.3])).with_mass(Mass::Area(0.2));
/// # let scene = Scene::new("").time(0.01, 1e-3).body(cloth.structural(50.0, 0.05).pin(Select::nodes([0])))
/// #     .collider(Collider::sphere([0.0, -1.0, 0.0], 0.2).named("ball"));
/// # let mut simulation = Simulation::new(&scene, &Options::default())?;
/// use taffeta::Stage;
///
/// let times = simulation.step_timed()?;
/// let seconds = |stage: Stage| times.iter().find(|(name, _)| *name == stage.name()).map_or(0.0, |&(_, time)| time);
/// assert!(seconds(Stage::Springs) > 0.0);
/// assert_eq!(seconds(Stage::Constraints), 0.0);
/// assert!(Stage::Springs < Stage::Integrate);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Stage {
    /// Forces of elements that several nodes share.
    #[default]
    Elements,
    /// Wind, drag, point loads, torques, forces of elements by node.
    Loads,
    /// Forces of springs.
    Springs,
    /// Forces of springs that are constraints.
    Constraints,
    /// Forces that keep volumes.
    Volumes,
    /// New velocity, new position.
    Integrate,
    /// Moving pins.
    Pins,
    /// Colliders.
    Contact,
    /// Springs that are constraints on positions, and colliders again.
    Positions,
    /// Seams, pins that break and tethers, and colliders again.
    Attach,
    /// Nodes that touch each other, and colliders again.
    Pairs,
    /// Nodes moved to restore volumes, and colliders again.
    Project,
    /// Nodes held back so that surfaces do not meet.
    Filter,
    /// Sums over the state.
    Diagnose,
}

impl Stage {
    /// All of them, in order.
    pub const ALL: [Self; 14] = [
        Self::Elements,
        Self::Loads,
        Self::Springs,
        Self::Constraints,
        Self::Volumes,
        Self::Integrate,
        Self::Pins,
        Self::Contact,
        Self::Positions,
        Self::Attach,
        Self::Pairs,
        Self::Project,
        Self::Filter,
        Self::Diagnose,
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Elements => "elements",
            Self::Loads => "loads",
            Self::Springs => "springs",
            Self::Constraints => "constraints",
            Self::Volumes => "volumes",
            Self::Integrate => "integrate",
            Self::Pins => "pins",
            Self::Contact => "contact",
            Self::Positions => "positions",
            Self::Attach => "attach",
            Self::Pairs => "pairs",
            Self::Project => "project",
            Self::Filter => "filter",
            Self::Diagnose => "diagnose",
        }
    }
}

/// What a pass does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Op {
    /// Forces of elements that several nodes share, and sums that loads need (torques).
    Elements,
    /// Wind, drag, point loads and torques.
    Loads,
    /// Adds the forces of elements to each node.
    Gather,
    /// Springs along the edges of a closed body, and the gradient of its volume, in one walk around each node.
    Rings,
    /// Springs.
    Springs,
    /// Keeps the force for later, and the velocity that it alone would give.
    Predict,
    /// Finds the forces of springs that are constraints, or are integrated implicitly.
    Solve,
    /// Takes up the force that was kept, and adds those that were solved for.
    ConstraintForces,
    /// The gradient of the volume alone.
    Gradients,
    /// Keeps force and gradient for later, and sums up what the multiplier of the volume needs.
    VolumeSums,
    /// Finds the multiplier of each volume.
    Multipliers,
    /// Takes up the force that was kept, and adds that of the volume.
    VolumeForces,
    /// Keeps the forces on nodes that pins hold, of which reactions are made.
    HeldForces,
    /// New velocity, then new position.
    Integrate,
    /// Puts moving pins where their keyframes, or the user, want them.
    Pins,
    /// Keeps nodes out of colliders.
    Contact,
    /// Moves nodes so that springs, which are constraints on positions, have their lengths.
    PositionConstraints,
    /// Has velocities follow.
    ApplyPositions,
    /// Finds what seams, pins that break and tethers do to nodes.
    Attachments,
    /// Does it.
    ApplyAttachments,
    /// Finds which nodes touch each other, and what that does to them.
    SelfContact,
    /// Does it.
    ApplySelfContact,
    /// Finds which surfaces touch each other.
    SurfaceContacts,
    /// Finds the impulses that keep them apart; the rounds end when there are none, or enough were made.
    SurfaceImpulses,
    /// Has them act.
    ApplySurfaceImpulses,
    /// Measures the volumes that are restored by moving nodes; the rounds end when none is off.
    MeasureVolumes,
    /// Moves nodes that touch nothing so that the volume is restored.
    RestoreVolumes,
    /// Finds how far nodes may go before surfaces meet; the rounds end when all have gone as far as they want or may.
    SurfaceFilter,
    /// Holds back who would go farther.
    ApplySurfaceFilter,
    /// Sums over nodes and springs, tile by tile.
    MeasureTiles,
    /// Sums over bodies.
    MeasureBodies,
}

impl Op {
    /// Number of operations.
    pub const COUNT: usize = Self::MeasureBodies as usize + 1;

    /// The stage that it belongs to.
    pub const fn stage(self) -> Stage {
        match self {
            Self::Elements => Stage::Elements,
            Self::Loads | Self::Gather => Stage::Loads,
            Self::Rings | Self::Springs => Stage::Springs,
            Self::Predict | Self::Solve | Self::ConstraintForces => Stage::Constraints,
            Self::Gradients | Self::VolumeSums | Self::Multipliers | Self::VolumeForces => Stage::Volumes,
            Self::HeldForces | Self::Integrate => Stage::Integrate,
            Self::Pins => Stage::Pins,
            Self::Contact => Stage::Contact,
            Self::PositionConstraints | Self::ApplyPositions => Stage::Positions,
            Self::Attachments | Self::ApplyAttachments => Stage::Attach,
            Self::SelfContact | Self::ApplySelfContact => Stage::Pairs,
            Self::SurfaceContacts | Self::SurfaceImpulses | Self::ApplySurfaceImpulses => Stage::Pairs,
            Self::MeasureVolumes | Self::RestoreVolumes => Stage::Project,
            Self::SurfaceFilter | Self::ApplySurfaceFilter => Stage::Filter,
            Self::MeasureTiles | Self::MeasureBodies => Stage::Diagnose,
        }
    }
}

/// What is known of a tile: a set of these.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Marks(pub u8);

impl Marks {
    /// Nothing.
    pub const NONE: Self = Self(0);
    /// Its springs are solved for, or are constraints on positions, and give no force of their own.
    pub const IMPLICIT: Self = Self(1);
    /// It waits for forces that are solved for, in this sub-step.
    pub const SOLVED: Self = Self(2);
    /// Its body keeps its volume, or is under a pressure.
    pub const VOLUME: Self = Self(4);
    /// The last pass over the scene moves some of its nodes.
    pub const MOVED: Self = Self(8);

    /// Both.
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Without some.
    pub const fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// Whether all of `others` are among them.
    pub const fn has(self, others: Self) -> bool {
        self.0 & others.0 == others.0
    }
}

/// What a pass runs on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum On {
    /// The scene at once, as far as its tiles have some marks; workers share it as the feature says.
    Scene(Marks),
    /// Every tile with some marks and without others.
    Tiles {
        /// What it must have.
        with: Marks,
        /// What it must not have.
        without: Marks,
    },
}

impl On {
    /// Whether a tile is among them.
    pub const fn chooses(self, marks: Marks) -> bool {
        match self {
            Self::Scene(_) => false,
            Self::Tiles { with, without } => marks.has(with) && marks.0 & without.0 == 0,
        }
    }
}

/// One line of the list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pass {
    /// What is done.
    pub op: Op,
    /// On what.
    pub on: On,
    /// Whether it reads what others have written on other tiles: all workers synchronise before it.
    pub sync: bool,
}

/// Passes, once or in rounds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Line {
    /// Once.
    Once(Pass),
    /// Until the first of them says that nothing is left to do, but so many times at most.
    Rounds(usize, Vec<Pass>),
}

impl Line {
    /// Its passes.
    pub fn passes(&self) -> &[Pass] {
        match self {
            Self::Once(pass) => std::slice::from_ref(pass),
            Self::Rounds(_, passes) => passes,
        }
    }
}

/// What a scene has; passes of what it has not are left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Parts {
    /// Elements whose forces are found one by one.
    pub elements: bool,
    /// Springs that are solved for, always or where they are too long.
    pub solved: bool,
    /// Springs that are constraints on positions.
    pub positions: bool,
    /// Bodies that keep their volume.
    pub volumes: bool,
    /// Volumes that are restored by moving nodes.
    pub restored: bool,
    /// Seams, pins that break or tethers.
    pub attachments: bool,
    /// Nodes that touch each other.
    pub self_contact: bool,
    /// Surfaces that touch each other.
    pub surface_contact: bool,
    /// Nodes that pins hold, whose forces are kept.
    pub held: bool,
}

impl Parts {
    /// Whether a node's motion depends on its neighbours and colliders alone.
    #[cfg(feature = "gpu")]
    pub const fn are_local(&self) -> bool {
        !(self.solved
            || self.positions
            || self.volumes
            || self.attachments
            || self.self_contact
            || self.surface_contact)
    }

    /// Every combination of them.
    #[cfg(test)]
    pub fn all() -> impl Iterator<Item = Self> {
        (0..512).map(|bits: u32| {
            let has = |bit: u32| bits >> bit & 1 == 1;
            Self {
                elements: has(0),
                solved: has(1),
                volumes: has(2),
                restored: has(3),
                attachments: has(4),
                self_contact: has(5),
                held: has(6),
                surface_contact: has(7),
                positions: has(8),
            }
        })
    }
}

/// Most times that a sub-step moves nodes to restore volumes.
pub const PROJECTIONS: usize = 5;

/// Most rounds of impulses between surfaces in a sub-step: a first guess, corrections, and the look that ends them.
pub const IMPULSES: usize = 12;

/// Most rounds in which a sub-step has nodes go where they would end.
pub const FILTERS: usize = 64;

/// On tiles with some marks and without others.
const fn tiles(op: Op, with: Marks, without: Marks) -> Pass {
    Pass { op, on: On::Tiles { with, without }, sync: false }
}

/// On the scene, as far as its tiles have some marks.
const fn scene(op: Op, of: Marks, sync: bool) -> Pass {
    Pass { op, on: On::Scene(of), sync }
}

/// The passes of a sub-step.
pub fn substep(parts: &Parts) -> Vec<Line> {
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
    } = *parts;
    let (none, implicit, waits, volume) = (Marks::NONE, Marks::IMPLICIT, Marks::SOLVED, Marks::VOLUME);
    let mut list = List::default();

    list.add(scene(Op::Elements, none, false));
    list.add(Pass { sync: elements, ..tiles(Op::Loads, none, none) });
    list.add_if(elements, tiles(Op::Gather, none, none));
    list.add_if(volumes, tiles(Op::Rings, volume, implicit));
    list.add(tiles(Op::Springs, none, implicit));

    // Springs that are solved for need all other forces: their tiles wait.
    list.add_if(solved, tiles(Op::Predict, waits, none));
    // Where springs give no force and nothing is solved for, the gradient is found alone.
    list.add_if(positions && volumes, tiles(Op::Gradients, volume.and(implicit), waits));
    // A multiplier needs the forces on all nodes of its body: these tiles wait, too.
    list.add_if(volumes, tiles(Op::VolumeSums, volume, waits));
    list.move_nodes(held, none, waits.and(volume));
    if solved {
        list.add(scene(Op::Solve, waits, true));
        list.add(tiles(Op::ConstraintForces, waits, none));
        list.add_if(volumes, tiles(Op::Gradients, waits.and(volume), none));
        list.add_if(volumes, tiles(Op::VolumeSums, waits.and(volume), none));
        list.move_nodes(held, waits, volume);
    }
    if volumes {
        list.add(scene(Op::Multipliers, volume, true));
        list.add(tiles(Op::VolumeForces, volume, none));
        list.move_nodes(held, volume, none);
    }

    // What moves nodes once more has colliders act on them again.
    if positions {
        list.add(scene(Op::PositionConstraints, implicit, true));
        list.add(Pass { sync: true, ..tiles(Op::ApplyPositions, Marks::MOVED, none) });
        list.add(tiles(Op::Contact, Marks::MOVED, none));
    }
    if attachments {
        list.add(scene(Op::Attachments, none, true));
        list.add(tiles(Op::ApplyAttachments, Marks::MOVED, none));
        list.add(tiles(Op::Contact, Marks::MOVED, none));
    }
    if self_contact {
        list.add(scene(Op::SelfContact, none, false));
        list.add(tiles(Op::ApplySelfContact, Marks::MOVED, none));
        list.add(tiles(Op::Contact, Marks::MOVED, none));
    }
    if surface_contact {
        list.add(scene(Op::SurfaceContacts, none, true));
        let round = [
            scene(Op::SurfaceImpulses, none, true),
            tiles(Op::ApplySurfaceImpulses, Marks::MOVED, none),
            tiles(Op::Contact, Marks::MOVED, none),
        ];
        list.0.push(Line::Rounds(IMPULSES, round.to_vec()));
    }
    if restored {
        // Contact has changed volumes; what touches nothing gives them back, and may touch something then.
        let round = [
            scene(Op::MeasureVolumes, volume, true),
            tiles(Op::RestoreVolumes, volume.and(Marks::MOVED), none),
            tiles(Op::Contact, volume.and(Marks::MOVED), none),
        ];
        list.0.push(Line::Rounds(PROJECTIONS, round.to_vec()));
    }
    if surface_contact {
        // Nothing moves nodes after it: what it holds apart stays apart.
        let round = [scene(Op::SurfaceFilter, none, true), tiles(Op::ApplySurfaceFilter, Marks::MOVED, none)];
        list.0.push(Line::Rounds(FILTERS, round.to_vec()));
    }
    list.0
}

/// Some of the passes of a sub-step, in its order: for each operation the next pass that does it.
#[cfg(feature = "gpu")]
pub fn part_of(parts: &Parts, operations: &[Op]) -> Vec<Line> {
    let all = substep(parts);
    let mut passes = all.iter().flat_map(Line::passes);
    operations.iter().filter_map(|&op| passes.find(|pass| pass.op == op)).copied().map(Line::Once).collect()
}

/// The passes after the last sub-step of a frame.
pub fn frame_end() -> Vec<Line> {
    vec![
        Line::Once(tiles(Op::MeasureTiles, Marks::NONE, Marks::NONE)),
        Line::Once(scene(Op::MeasureBodies, Marks::NONE, false)),
    ]
}

#[derive(Default)]
struct List(Vec<Line>);

impl List {
    fn add(&mut self, pass: Pass) {
        self.0.push(Line::Once(pass));
    }

    fn add_if(&mut self, is_there: bool, pass: Pass) {
        if is_there {
            self.add(pass);
        }
    }

    /// From forces to positions, on some tiles; the forces on nodes that are `held` are kept before.
    fn move_nodes(&mut self, held: bool, with: Marks, without: Marks) {
        self.add_if(held, tiles(Op::HeldForces, with, without));
        self.add(tiles(Op::Integrate, with, without));
        self.add(tiles(Op::Pins, with, without));
        self.add(tiles(Op::Contact, with, without));
    }
}

#[cfg(test)]
mod tests;
