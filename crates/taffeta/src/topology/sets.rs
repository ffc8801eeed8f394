//! Sets of numbers that are joined two by two.

/// Numbers from 0 on, each in a set of its own at first.
pub struct Sets {
    /// For each a number of its set that is not larger.
    lower: Vec<u32>,
}

impl Sets {
    /// Of so many numbers.
    pub fn new(count: usize) -> Self {
        Self { lower: (0..count as u32).collect() }
    }

    /// The least number of the set of another one.
    pub fn least(&self, mut number: u32) -> u32 {
        while self.lower[number as usize] != number {
            number = self.lower[number as usize];
        }
        number
    }

    /// Makes the sets of two numbers one.
    pub fn join(&mut self, a: u32, b: u32) {
        let [a, b] = [self.least(a), self.least(b)];
        self.lower[a.max(b) as usize] = a.min(b);
    }

    /// The least number of each number's set.
    pub fn all(mut self) -> Vec<u32> {
        for number in 0..self.lower.len() {
            // Those before are done.
            self.lower[number] = self.lower[self.lower[number] as usize];
        }
        self.lower
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_joined_has_one_least_number() {
        let mut sets = Sets::new(7);
        for [a, b] in [[5, 3], [6, 5], [1, 2], [2, 1], [3, 0]] {
            sets.join(a, b);
        }
        assert_eq!([0, 4].map(|number| sets.least(number)), [0, 4]);
        assert_eq!(sets.all(), [0, 1, 1, 0, 4, 0, 0]);
    }
}
