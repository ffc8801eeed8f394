//! What a frame was in numbers: what users read, and the sums that backends make it of.

pub(crate) mod sums;

use serde::{Deserialize, Serialize};
use std::borrow::Cow;
pub(crate) use sums::{FrameSums, PairSums, StateSums, StrainSums};

/// One frame in numbers.
///
/// ```
/// use taffeta::scene::{Body, Mass, Mesh, Scene};
/// use taffeta::{Options, Simulation};
///
/// // 24 g of cloth fall for a tenth of a second.
/// let cloth = Body::cloth("cloth", Mesh::grid(4, 5, [0.4, 0.3])).with_mass(Mass::Area(0.2)).structural(50.0, 0.05);
/// let scene = Scene::new("falls").time(0.01, 1e-3).body(cloth);
/// let mut simulation = Simulation::new(&scene, &Options::default())?;
/// let start = simulation.report().energy();
/// let report = simulation.advance(10)?;
/// assert!((report.time - 0.1).abs() < 1e-12);
/// assert!((report.momentum[1] + 0.024 * 9.81 * 0.1).abs() < 1e-6);
/// assert!((report.energy() - start).abs() < 0.02 * report.kinetic);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FrameReport {
    /// Frame number; 0 is the start.
    pub frame: u32,
    /// Time [s].
    pub time: f64,
    /// Sub-steps that the frame took: those of the scene, or 2, 4, 8 or 16 times as many where contact between triangles asked for it; 0
    /// at the start, and where nothing is run because all bodies sleep.
    pub substeps: u32,
    /// ½ Σ m v² [J].
    pub kinetic: f64,
    /// −Σ m g·x [J].
    pub gravitational: f64,
    /// ½ Σ k (l − L)² over all springs [J].
    pub springs: f64,
    /// Energy of other elements that the scene has, kind by kind.
    pub elements: Vec<ElementEnergy>,
    /// Σ m v [kg·m/s].
    pub momentum: [f64; 3],
    /// Σ m x × v [kg·m²/s], about the origin.
    pub angular_momentum: [f64; 3],
    /// Largest l/L over all springs, and along warp and weft over all fabric; 1 without either.
    pub max_stretch: f64,
    /// Strain of fabric, where there is some.
    pub strain: Option<FabricStrain>,
    /// Nodes that touched a collider in the frame's last sub-step.
    pub contacts: u64,
    /// Volume of each body [m³], where it is closed.
    pub volumes: Vec<Option<f64>>,
    /// Volume that each body is to have at this time [m³], where it keeps one.
    pub volume_targets: Vec<Option<f64>>,
    /// Contacts of surfaces, and pairs of nodes that were nearer than their thickness, in the frame's last sub-step.
    pub pairs: u64,
    /// Least distance of such a pair before it was pushed apart, by its thickness.
    pub nearest_pair: Option<f64>,
    /// Times that neighbours were searched for in the frame. It may depend on the number of threads; nothing else does.
    pub pair_searches: u64,
    /// Pairs of an edge and a triangle that have a point in common, while surfaces that start through each other are being pulled
    /// apart, and in the first frame in which they are free; not counted otherwise.
    /// [`Simulation::intersections`](crate::Simulation::intersections) counts them at any time.
    pub intersections: Option<u64>,
    /// A vertex that had no room between colliders in the frame: surfaces may have passed through each other beside it.
    pub squeezed: Option<Squeezed>,
    /// What the solver of constraints did; all zero where there are none.
    pub solver: SolverReport,
    /// Joints of seams and pins that are broken at the end of the frame.
    pub broken: u64,
    /// The reaction of each pin of the scene, body by body.
    pub reactions: Vec<PinReaction>,
    /// Bodies that are [asleep](crate::scene::Sleep).
    pub asleep: u32,
}

/// A vertex that colliders which move left no room, however near to each other the surfaces between them came. All numbers are
/// those of the scene.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Squeezed {
    /// Its body.
    pub body: usize,
    /// The vertex of the body's mesh.
    pub vertex: usize,
    /// The colliders that are nearest to it at the end of the frame, nearest first: at most two.
    pub colliders: Vec<usize>,
}

/// The force with which a pin holds its nodes.
///
/// ```
/// use taffeta::scene::{Body, Mass, Mesh, Scene, Select};
/// use taffeta::{Options, Simulation};
///
/// // A chain of 0.2 kg hangs from its first node.
/// let chain = Body::cloth("chain", Mesh::chain(4, 1.0)).with_mass(Mass::Whole(0.2)).structural(50.0, 0.5);
/// let mut scene = Scene::new("").time(0.1, 1e-3).body(chain.pin(Select::nodes([0])));
/// scene.world.gravity = [9.81, 0.0, 0.0];
/// let mut simulation = Simulation::new(&scene, &Options::default())?;
/// let [pin] = &simulation.advance(100)?.reactions[..] else { panic!("one pin") };
/// assert!((pin.force.expect("after a frame")[0] + 0.2 * 9.81).abs() < 0.01);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PinReaction {
    /// Where its body stands in the scene.
    pub body: usize,
    /// Where the pin stands among those of the body.
    pub pin: usize,
    /// Sum over its nodes of m (a − g) − f in the frame's last sub-step [N], where f are the forces of springs, other elements,
    /// volumes and loads. Contacts, seams and tethers do not count. None at the start, and for pins that break.
    pub force: Option<[f64; 3]>,
}

/// Energy of all elements of one kind.
///
/// ```
/// use taffeta::scene::{Body, Mass, Mesh, Scene, Select};
/// use taffeta::{Options, Simulation};
///
/// // A sheet that is held in its middle bends under its weight.
/// let cloth = Body::cloth("cloth", Mesh::grid(5, 5, [0.4, 0.4])).with_mass(Mass::Area(0.2)).structural(50.0, 0.05);
/// let scene = Scene::new("").time(0.01, 1e-3).body(cloth.hinge(1e-4, 0.0).pin(Select::rows(2, 2)));
/// let mut simulation = Simulation::new(&scene, &Options::default())?;
/// let report = simulation.advance(10)?;
/// let [hinges] = &report.elements[..] else { panic!("one kind") };
/// assert!(hinges.kind == "hinges" && hinges.energy > 0.0);
/// assert_eq!(report.energy_of("hinges"), hinges.energy);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ElementEnergy {
    /// The kind: `hinges`.
    pub kind: Cow<'static, str>,
    /// Energy [J].
    pub energy: f64,
}

impl ElementEnergy {
    /// Of a kind, in joules.
    pub(crate) fn new(kind: &'static str, energy: f64) -> Self {
        Self { kind: kind.into(), energy }
    }
}

/// How far fabric is strained, over all of its triangles.
///
/// ```
/// use taffeta::scene::{Body, Keyframe, Material, Mesh, Scene, Select};
/// use taffeta::{Options, Simulation};
///
/// // A strip of cotton, 20 cm long, is pulled by 1 cm along its warp: a strain of 5 %.
/// let side = |name: &str| Select { group: Some(name.into()), ..Select::default() };
/// let strip = Body::cloth("strip", Mesh::sheet([0.2, 0.05], 0.01)).with_material(Material::preset("cotton"));
/// let pull = vec![Keyframe::translate(0.0, [0.0; 3]), Keyframe::translate(0.1, [0.01, 0.0, 0.0])];
/// let strip = strip.pin(side("left")).pin_moving(side("right"), pull);
/// let mut scene = Scene::new("").time(0.01, 0.01).body(strip).method(taffeta::scene::Method::Ice);
/// scene.solver.ice.form = taffeta::scene::ConstraintForm::Primal;
/// let mut simulation = Simulation::new(&scene, &Options::default())?;
/// let strain = simulation.advance(20)?.strain.expect("it is fabric");
/// assert!(strain.warp[0] > 0.04 && strain.warp[1] < 0.06, "{strain:?}");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FabricStrain {
    /// Least and largest engineering strain √(2 E₁₁ + 1) − 1 along the warp; below 0 where it is compressed.
    pub warp: [f64; 2],
    /// The same along the weft.
    pub weft: [f64; 2],
    /// Largest shear angle [rad]: by how much the angle between warp and weft differs from a right angle.
    pub shear: f64,
}

impl FabricStrain {
    /// The extremes of this and another one.
    ///
    /// ```
    /// use taffeta::diagnostics::FabricStrain;
    ///
    /// let frames = [0.01, 0.04].map(|warp| FabricStrain { warp: [0.0, warp], ..FabricStrain::default() });
    /// assert_eq!(frames[0].with(&frames[1]).warp, [0.0, 0.04]);
    /// ```
    pub fn with(&self, other: &Self) -> Self {
        let both = |[low, high]: [f64; 2], [other_low, other_high]: [f64; 2]| {
            [low.min(other_low), high.max(other_high)]
        };
        Self {
            warp: both(self.warp, other.warp),
            weft: both(self.weft, other.weft),
            shear: self.shear.max(other.shear),
        }
    }
}

/// What the solver of constraints did in a frame.
///
/// ```
/// use taffeta::scene::{Body, Mass, Mesh, Method, Scene, Select};
/// use taffeta::{Options, Simulation};
///
/// // As stiff as it likes: the springs are constraints.
/// let cloth = Body::cloth("cloth", Mesh::grid(4, 5, [0.4, 0.3])).with_mass(Mass::Area(0.2)).structural(5e3, 0.05);
/// let scene = Scene::new("").time(0.01, 1e-3).body(cloth.pin(Select::rows(0, 0))).method(Method::Ice);
/// let mut simulation = Simulation::new(&scene, &Options::default())?;
/// let solver = simulation.advance(5)?.solver;
/// assert!(solver.iterations > 0 && solver.residual <= scene.solver.ice.tolerance);
/// assert_eq!((solver.capped, solver.active_fraction), (0, 1.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SolverReport {
    /// Most iterations of a sub-step.
    pub iterations: u32,
    /// Largest residual of a sub-step: relative to the right side; of the form "primal", the error in the norm of the energy,
    /// relative to what the sub-step gives.
    pub residual: f64,
    /// Largest share of the springs that were constraints in a sub-step.
    pub active_fraction: f64,
    /// Sub-steps that ended with a residual beyond the tolerance.
    pub capped: u32,
}

impl FrameReport {
    /// Total energy [J].
    pub fn energy(&self) -> f64 {
        self.kinetic + self.gravitational + self.springs + self.energy_of_elements()
    }

    /// Energy of one kind of elements [J]; 0 where the scene has none.
    pub fn energy_of(&self, kind: &str) -> f64 {
        self.elements.iter().find(|one| one.kind == kind).map_or(0.0, |one| one.energy)
    }

    /// The reaction of a pin of a body, both by their places in the scene [N]; `None` where nothing is known of it.
    pub fn reaction(&self, body: usize, pin: usize) -> Option<[f64; 3]> {
        self.reactions.iter().find(|one| (one.body, one.pin) == (body, pin))?.force
    }

    /// Energy of all elements but springs [J].
    pub fn energy_of_elements(&self) -> f64 {
        self.elements.iter().map(|one| one.energy).sum()
    }

    /// Whether every number is finite; a node that is not shows in the sums.
    pub fn is_finite(&self) -> bool {
        let momentum: f64 = self.momentum.iter().sum();
        self.energy().is_finite() && momentum.is_finite() && self.max_stretch.is_finite()
    }
}
