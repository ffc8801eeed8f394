//! What theory says: elastica by shooting, and tables.

/// A state of an elastica: its angle [rad], curvature times length, and place in lengths.
pub type State = [f64; 4];

/// Integrates θ″ = moment(s, θ) from s = 0 over a length, by Runge and Kutta's fourth order; x′ = cos θ, y′ = sin θ.
pub fn integrated(start: State, length: f64, moment: impl Fn(f64, f64) -> f64) -> Vec<State> {
    const STEPS: usize = 2000;
    let h = length / STEPS as f64;
    let slope = |s: f64, [theta, bend, ..]: State| [bend, moment(s, theta), theta.cos(), theta.sin()];
    let moved = |state: State, slope: State, by: f64| [0, 1, 2, 3].map(|i| state[i] + by * slope[i]);
    let mut states = vec![start];
    let mut state = start;
    for step in 0..STEPS {
        let s = step as f64 * h;
        let first = slope(s, state);
        let second = slope(s + 0.5 * h, moved(state, first, 0.5 * h));
        let third = slope(s + 0.5 * h, moved(state, second, 0.5 * h));
        let fourth = slope(s + h, moved(state, third, h));
        state =
            [0, 1, 2, 3].map(|i| state[i] + h / 6.0 * (first[i] + 2.0 * (second[i] + third[i]) + fourth[i]));
        states.push(state);
    }
    states
}

/// A strip of load Γ = ρ g L³/B, clamped level at one end: θ″ = −Γ (1 − s) cos θ, θ(0) = 0, θ′(1) = 0, θ downwards.
pub fn cantilever(load: f64) -> Vec<State> {
    let shape =
        |bend: f64| integrated([0.0, bend, 0.0, 0.0], 1.0, |s, theta| -load * (1.0 - s) * theta.cos());
    // The bend at the clamp is between none and that of the whole weight at the end of a level strip. The free end's bend grows
    // with it from below 0 as long as the strip does not turn beyond the vertical.
    let (mut low, mut high) = (0.0, 0.5 * load);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        let states = shape(middle);
        let overturned = states.iter().any(|state| state[0] > std::f64::consts::FRAC_PI_2);
        if overturned || states[states.len() - 1][1] > 0.0 { high = middle } else { low = middle }
    }
    shape(0.5 * (low + high))
}

/// Drop by reach of the free end of [`cantilever`].
pub fn drop_by_reach(load: f64) -> f64 {
    cantilever(load).last().map_or(f64::NAN, |[_, _, x, y]| y / x)
}

/// The load at which the chord of a cantilever is 41.5° below the level (Peirce 1930; ASTM D1388 has his approximation).
pub const PEIRCE: f64 = 8.0042;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cantilevers_have_the_drop_that_was_computed_independently() {
        for (load, expected) in [
            (1.0, 0.12456),
            (2.0, 0.24667),
            (5.0, 0.58572),
            (10.0, 1.06680),
            (20.0, 1.86393),
            (50.0, 3.70556),
        ] {
            assert!((drop_by_reach(load) - expected).abs() < 1e-5, "{load}: {}", drop_by_reach(load));
        }
        assert!((drop_by_reach(PEIRCE).atan().to_degrees() - 41.5).abs() < 1e-3);
    }
}
