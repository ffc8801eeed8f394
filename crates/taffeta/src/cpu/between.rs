//! What single passes leave to others where they run apart.

/// What passes pass to each other beside the state, by place. Lanes past a mesh's last node are places, too.
#[derive(Clone, Debug, Default)]
pub struct Between<T> {
    /// Force on each place [N]; those of no tile stay.
    pub force: Vec<[T; 3]>,
    /// The collider that each place touched last, from 1; 0: none.
    pub last_collider: Vec<u32>,
}
