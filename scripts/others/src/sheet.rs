//! The scene: a square sheet over a ball over a floor, as in `scenes/s1_fig15.toml`.

/// Edge of the sheet [m].
pub const SIZE: f32 = 2.0;
/// Where the flat sheet begins [m]. The ball's centre is the origin.
pub const HEIGHT: f32 = 0.55;
/// Of a node [kg].
pub const NODE_MASS: f32 = 0.15;
/// Of the ball [m].
pub const RADIUS: f32 = 0.5;
/// Where the floor is [m].
pub const FLOOR: f32 = -0.5;
/// How far from ball and floor nodes are kept [m]; the scene has none above its floor.
pub const OFFSET: f32 = 0.01;
/// Of sheet, ball and floor.
pub const FRICTION: f32 = 0.3;
/// Downwards [m/s²].
pub const GRAVITY: f32 = 9.81;
/// Of a frame [s].
pub const FRAME: f32 = 1.0 / 60.0;

/// Two nodes and how far apart they want to be [m].
pub struct Spring {
    pub ends: [u32; 2],
    pub rest: f32,
}

/// A cloth in another engine.
pub trait Engine {
    /// Simulates a frame: how many steps that took.
    fn frame(&mut self) -> Result<u32, String>;
    /// Where nodes are [m].
    fn positions(&self) -> Vec<[f32; 3]>;
    /// What keeps lengths.
    fn springs(&self) -> Vec<Spring>;
    /// How many springs there are, where the engine has springs at all.
    fn spring_count(&self) -> Option<usize>;
}

/// What a cloth is like in a frame.
#[derive(Clone, Copy)]
pub struct Look {
    /// Lowest and highest node [m].
    pub heights: [f32; 2],
    /// Of the node that is nearest to the ball's surface or deepest in it [m].
    pub ball_gap: f32,
    /// How many nodes touch the ball.
    pub touching: usize,
    /// Longest spring by its rest length.
    pub stretch: f32,
}

impl Look {
    /// Whether it is on the ball and on the floor, and not in them: else its times say nothing.
    pub fn lies(&self) -> Result<(), String> {
        let [low, high] = self.heights;
        if self.touching == 0 || high < RADIUS {
            return Err("it fell off the ball".to_owned());
        }
        if self.ball_gap < -OFFSET || low < FLOOR - OFFSET {
            return Err("it is inside the ball or the floor".to_owned());
        }
        Ok(())
    }
}

/// Looks at a cloth, or says that it has blown up.
pub fn look(positions: &[[f32; 3]], springs: &[Spring]) -> Result<Look, String> {
    if positions.iter().flatten().any(|x| !x.is_finite()) {
        return Err("a node is nowhere".to_owned());
    }
    let least = |values: &mut dyn Iterator<Item = f32>| values.fold(f32::INFINITY, f32::min);
    let gap = |at: &[f32; 3]| length(*at) - RADIUS;
    let length_of = |spring: &Spring| {
        let [a, b] = spring.ends.map(|node| positions[node as usize]);
        length([0, 1, 2].map(|axis| b[axis] - a[axis])) / spring.rest
    };
    let heights = || positions.iter().map(|at| at[1]);
    Ok(Look {
        heights: [least(&mut heights()), -least(&mut heights().map(|y| -y))],
        ball_gap: least(&mut positions.iter().map(gap)),
        touching: positions.iter().filter(|at| gap(at) < 2.0 * OFFSET).count(),
        stretch: -least(&mut springs.iter().map(|spring| -length_of(spring))),
    })
}

fn length(v: [f32; 3]) -> f32 {
    v.iter().map(|x| x * x).sum::<f32>().sqrt()
}
