//! Sums over the state, as backends hand them over.

use crate::report::{ElementEnergy, FabricStrain, SolverReport};

/// Sums over the state, or over a part of it.
#[derive(Clone, Copy, Debug, Default)]
pub struct StateSums {
    /// Σ m v² [J], twice the kinetic energy.
    pub m_v2: f64,
    /// Σ m x [kg·m].
    pub m_x: [f64; 3],
    /// Σ m v [kg·m/s].
    pub momentum: [f64; 3],
    /// Σ m x × v [kg·m²/s].
    pub angular_momentum: [f64; 3],
    /// Energy of the springs [J].
    pub springs: f64,
    /// Largest l/L.
    pub max_stretch: f64,
    /// Nodes that touched a collider in the last sub-step.
    pub contacts: u64,
}

/// Extremes of a fabric's strain: largest squared stretch along the warp, its negative, the same along the weft, and largest squared
/// sine of the shear angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StrainSums(pub [f64; 5]);

/// What a backend measures at the end of a frame.
#[derive(Clone, Debug, Default)]
pub struct FrameSums {
    /// Into how many parts each sub-step of the scene was cut; 0 where no frame was run.
    pub parts: u32,
    /// Sums over all nodes and springs.
    pub all: StateSums,
    /// Energy of each kind of elements that the scene has.
    pub elements: Vec<ElementEnergy>,
    /// Strain, where there is fabric.
    pub strain: Option<StrainSums>,
    /// Volume of each body [m³], where it is closed.
    pub volumes: Vec<Option<f64>>,
    /// Nodes in contact with each other.
    pub pairs: PairSums,
    /// Pairs of an edge and a triangle that intersect, if surfaces are being untangled.
    pub intersections: Option<u64>,
    /// How much of a node's way contact has taken at most in a sub-step since the last good frame, relative to an edge, where only a scene
    /// that blows up comes to it; 0 else.
    pub blown_up: f64,
    /// The last node, by solver index, that had no room between colliders.
    pub squeezed: Option<u32>,
    /// What the solver of constraints did.
    pub solver: SolverReport,
    /// Joints that are broken.
    pub broken: u64,
    /// Force on each node that a pin holds, but the pin's own and gravity, in the last sub-step [N]; none if there was none.
    pub held: Vec<[f64; 3]>,
}

/// What was found of nodes in contact with each other.
#[derive(Clone, Copy, Debug)]
pub struct PairSums {
    /// Pairs in the last sub-step.
    pub pairs: u64,
    /// Least distance of a pair by its thickness; infinite without pairs.
    pub nearest: f64,
    /// Times that neighbours were searched for in the frame.
    pub searches: u64,
}

impl Default for PairSums {
    fn default() -> Self {
        Self { pairs: 0, nearest: f64::INFINITY, searches: 0 }
    }
}

impl FrameSums {
    /// Adds to the energy of a kind of elements [J].
    #[cfg(feature = "gpu")]
    pub fn add_energy(&mut self, kind: &'static str, energy: f64) {
        match self.elements.iter_mut().find(|one| one.kind == kind) {
            Some(one) => one.energy += energy,
            None => self.elements.push(ElementEnergy::new(kind, energy)),
        }
    }
}

impl StrainSums {
    /// Adds the extremes to those of other parts.
    pub fn add_to(self, all: &mut Option<Self>) {
        let so_far = all.get_or_insert(self);
        for (most, one) in so_far.0.iter_mut().zip(self.0) {
            *most = if one > *most { one } else { *most };
        }
    }

    /// As users read it.
    pub fn strain(&self) -> FabricStrain {
        let [warp, least_warp, weft, least_weft, shear] = self.0;
        let engineering = |squared: f64| squared.max(0.0).sqrt() - 1.0;
        FabricStrain {
            warp: [engineering(-least_warp), engineering(warp)],
            weft: [engineering(-least_weft), engineering(weft)],
            shear: libm::asin(shear.sqrt().min(1.0)),
        }
    }
}

impl StateSums {
    /// Adds the sums of another part.
    pub fn add(&mut self, other: &Self) {
        self.m_v2 += other.m_v2;
        self.springs += other.springs;
        self.contacts += other.contacts;
        self.max_stretch =
            if other.max_stretch > self.max_stretch { other.max_stretch } else { self.max_stretch };
        for axis in 0..3 {
            self.m_x[axis] += other.m_x[axis];
            self.momentum[axis] += other.momentum[axis];
            self.angular_momentum[axis] += other.angular_momentum[axis];
        }
    }
}
