//! How much of what a frame may need is written down: as much as frames have needed lately.

/// Frames after which no more is written down than they needed.
const LOOKED_BACK: u32 = 30;

/// What frames needed at most of several things.
pub struct Needed<const N: usize> {
    most: [u32; N],
    frames: u32,
}

impl<const N: usize> Needed<N> {
    /// Before any frame.
    pub fn new() -> Self {
        Self { most: [0; N], frames: 0 }
    }

    /// Notes what a frame needed. After a number of frames it gives the most that these needed, and starts again.
    pub fn note(&mut self, needed: [u32; N]) -> Option<[u32; N]> {
        self.most.iter_mut().zip(needed).for_each(|(most, needed)| *most = needed.max(*most));
        self.frames += 1;
        (self.frames == LOOKED_BACK).then(|| std::mem::replace(self, Self::new()).most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_most_that_frames_needed_is_given_after_some_and_forgotten() {
        let mut needed = Needed::new();
        for frame in 1..LOOKED_BACK {
            assert_eq!(needed.note([u32::from(frame == 3) * 7, 2]), None);
        }
        assert_eq!(needed.note([1, 5]), Some([7, 5]));
        assert!((1..LOOKED_BACK).all(|_| needed.note([1, 1]).is_none()));
        assert_eq!(needed.note([1, 1]), Some([1, 1]));
    }
}
