//! What is wrong with what a program asks of a running simulation.

use crate::scene::SceneError;

/// What a program asked of a running simulation cannot be done. Nothing is changed then.
///
/// ```
/// # use taffeta::scene::{Body, Collider, Mass, Mesh, Scene, Select};
/// # use taffeta::{Options, Simulation};
/// # let cloth = Body::cloth("cloth", Mesh::grid(4, 5, [0.4, 0.3])).with_mass(Mass::Area(0.2));
/// # let scene = Scene::new("").time(0.01, 1e-3).body(cloth.structural(50.0, 0.05).pin(Select::nodes([0])))
/// #     .collider(Collider::sphere([0.0, -1.0, 0.0], 0.2).named("ball"));
/// # let mut simulation = Simulation::new(&scene, &Options::default())?;
/// use taffeta::InputError;
///
/// let cloth = simulation.body("cloth")?;
/// let error = simulation.apply_force(cloth, 20, [0.0; 3]).unwrap_err();
/// assert!(matches!(error, InputError::NoVertex { vertex: 20, vertices: 20, .. }));
/// assert_eq!(simulation.body("sheet").unwrap_err().to_string(), "there is no body `sheet`; there are: cloth");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum InputError {
    /// No body has the name.
    #[error("there is no body `{name}`; {}", those(.known))]
    NoBody {
        /// The name.
        name: String,
        /// Names of all bodies.
        known: Vec<String>,
    },
    /// No collider has the name.
    #[error("there is no collider `{name}`; {}", those(.known))]
    NoCollider {
        /// The name.
        name: String,
        /// Names of all colliders.
        known: Vec<String>,
    },
    /// A handle of another simulation.
    #[error("a handle of another simulation; names resolve to new handles in each")]
    ForeignHandle,
    /// The body has fewer pins.
    #[error("body `{body}` has {pins} pins and none with index {pin}")]
    NoPin {
        /// Name of the body.
        body: String,
        /// The index.
        pin: usize,
        /// Number of its pins.
        pins: usize,
    },
    /// The body has fewer vertices.
    #[error("body `{body}` has vertices 0 to {}, not {vertex}", .vertices.saturating_sub(1))]
    NoVertex {
        /// Name of the body.
        body: String,
        /// The vertex.
        vertex: usize,
        /// Number of its vertices.
        vertices: usize,
    },
    /// The vertex is in no face.
    #[error("vertex {vertex} of body `{body}` is in no face and not simulated")]
    NotSimulated {
        /// Name of the body.
        body: String,
        /// The vertex.
        vertex: usize,
    },
    /// The body has fewer nodes.
    #[error("body `{body}` has {nodes} nodes and none with index {node}")]
    NoNode {
        /// Name of the body.
        body: String,
        /// The node.
        node: u32,
        /// Number of its nodes.
        nodes: usize,
    },
    /// A pin that never moves in its scene.
    #[error("pin {pin} of body `{body}` never moves; a keyframe at t = 0 makes a pin movable")]
    Immovable {
        /// Name of the body.
        body: String,
        /// The pin.
        pin: usize,
    },
    /// What is to be moved follows keyframes of the scene.
    #[error("{what} follows keyframes; one that does not could be moved")]
    FollowsKeyframes {
        /// What was to be moved, in words.
        what: String,
    },
    /// No scene could have such a number, or such a world.
    #[error(transparent)]
    Value(#[from] SceneError),
    /// The vertices of the body do not fit where they are to be drawn.
    #[error("body `{body}` cannot be drawn there: {why}")]
    VertexTarget {
        /// Name of the body.
        body: String,
        /// Why not, and what would do.
        why: String,
    },
    /// Frames are counted in 32 bits.
    #[error("{frames} frames more than {before} are not counted in 32 bits: {} would do", u32::MAX - .before)]
    TooManyFrames {
        /// Frames done.
        before: u32,
        /// Frames asked for.
        frames: u32,
    },
    /// The snapshot is of another scene, or has numbers that none of this one could have.
    #[error("{0}")]
    Snapshot(String),
}

/// The names that there are, in words.
fn those(known: &[String]) -> String {
    if known.is_empty() { "there are none".to_owned() } else { format!("there are: {}", known.join(", ")) }
}
