/// Disjoint sets (Tarjan 1975), each by its smallest member; members may be turned against each other.
pub(crate) struct Sets {
    /// A member nearer to the first of its set, which is its own.
    pub parent: Vec<u32>,
    /// Whether a member is turned against its parent.
    turned: Vec<bool>,
}

/// What joining two members did.
pub(crate) struct Join {
    /// Whether they were in different sets.
    pub joined: bool,
    /// Whether they are turned against each other as was asked.
    pub agrees: bool,
}

impl Sets {
    pub fn new(count: usize) -> Self {
        Self { parent: (0..count as u32).collect(), turned: vec![false; count] }
    }

    /// The set of a member, and whether the member is turned against it; halves the path on the way.
    pub fn root(&mut self, mut member: u32) -> (u32, bool) {
        let mut turned = false;
        loop {
            let i = member as usize;
            let above = self.parent[i] as usize;
            if above == i {
                return (member, turned);
            }
            if self.parent[above] as usize != above {
                self.turned[i] ^= self.turned[above];
                self.parent[i] = self.parent[above];
            }
            turned ^= self.turned[i];
            member = self.parent[i];
        }
    }

    /// Puts two members into one set, turned against each other or not.
    pub fn join(&mut self, a: u32, b: u32, turned: bool) -> Join {
        let ((a, of_a), (b, of_b)) = (self.root(a), self.root(b));
        let turn = of_a ^ of_b ^ turned;
        if a != b {
            self.parent[a.max(b) as usize] = a.min(b);
            self.turned[a.max(b) as usize] = turn;
        }
        Join { joined: a != b, agrees: a != b || !turn }
    }

    /// Numbers the sets in the order of their first member: the number of each member's set, and how many there are.
    pub fn numbers(&mut self) -> (Vec<u32>, usize) {
        let (mut numbers, mut count) = (vec![0; self.parent.len()], 0);
        for member in 0..self.parent.len() as u32 {
            let root = self.root(member).0;
            numbers[member as usize] = if root == member {
                count += 1;
                count - 1
            } else {
                numbers[root as usize]
            };
        }
        (numbers, count as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn members_stay_turned_against_each_other_when_paths_are_halved() {
        let mut sets = Sets::new(6);
        for member in [4, 3, 2, 1] {
            assert!(sets.join(member - 1, member, true).joined);
        }
        for _ in 0..3 {
            assert_eq!([4, 3, 2, 1].map(|m| sets.root(m)), [(0, false), (0, true), (0, false), (0, true)]);
        }
        assert!(sets.join(1, 4, true).agrees && !sets.join(1, 4, false).agrees);
        assert_eq!(sets.numbers(), (vec![0, 0, 0, 0, 0, 1], 2));
    }
}
