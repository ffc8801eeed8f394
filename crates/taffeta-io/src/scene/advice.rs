//! Advice of the engine in the words of scene files.

use taffeta::Advice;

/// The key of a scene that follows a piece of advice, with its value; none where it is not about the scene.
///
/// ```
/// use taffeta::Advice;
/// use taffeta_io::scene::key_of;
///
/// assert_eq!(key_of(&Advice::LongestStep(2.5e-4)).as_deref(), Some("time.max_step = 2.5e-4 or less"));
/// // A scene does not say what it runs on.
/// assert_eq!(key_of(&Advice::Cpu), None);
/// ```
pub fn key_of(advice: &Advice) -> Option<String> {
    let key = match advice {
        Advice::LongestStep(step) => return Some(format!("time.max_step = {step:e} or less")),
        Advice::SolveByNodes => "solver.method = \"ice\" with solver.ice.form = \"primal\"",
        Advice::ExplicitSprings => "solver.method = \"springs\"",
        Advice::CorrectedVolume => "body.volume.form = \"corrected\"",
        Advice::SoftBody => "kind = \"soft\"",
        Advice::Cloth => "kind = \"cloth\"",
        Advice::FillHoles => "fill_holes = true",
        Advice::EvenWind => "world.wind_force in place of world.air",
        _ => return None,
    };
    Some(key.to_owned())
}

/// What to write to follow advice, as the end of a sentence: ` (time.max_step = 1e-3 or less)`. Empty where there is
/// nothing. `words` are the front end's own, or [`key_of`].
///
/// ```
/// use taffeta::Advice;
/// use taffeta_io::scene::{hint, key_of};
///
/// let end = hint(&[Advice::FillHoles, Advice::Cloth], key_of);
/// assert_eq!(end, " (fill_holes = true; kind = \"cloth\")");
/// ```
pub fn hint(advice: &[Advice], words: impl Fn(&Advice) -> Option<String>) -> String {
    let all: Vec<String> = advice.iter().filter_map(words).collect();
    if all.is_empty() { String::new() } else { format!(" ({})", all.join("; ")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn advice_that_is_about_the_scene_names_its_key() {
        let advice = [Advice::Cpu, Advice::LongestStep(3.9e-3), Advice::Cloth];
        assert_eq!(hint(&advice, key_of), " (time.max_step = 3.9e-3 or less; kind = \"cloth\")");
        assert_eq!(hint(&advice[..1], key_of), "");
    }
}
