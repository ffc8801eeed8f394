//! Advice of the engine in the words of components.

use taffeta::Advice;

/// What to set to follow advice, as the end of a sentence; empty where there is nothing.
pub fn hint(advice: &[Advice]) -> String {
    let all: Vec<String> = advice.iter().filter_map(component).collect();
    if all.is_empty() { String::new() } else { format!(" ({})", all.join("; ")) }
}

fn component(advice: &Advice) -> Option<String> {
    let field = match advice {
        Advice::Cpu => "RunOn::device = DeviceChoice::Cpu",
        Advice::LongestStep(step) => {
            return Some(format!("SoftWorld::time.max_step = Some({step:e}) or less"));
        }
        Advice::SolveByNodes => "SoftWorld::solver with Method::Ice and ConstraintForm::Primal",
        Advice::ExplicitSprings => "SoftWorld::solver with Method::Springs",
        Advice::CorrectedVolume => "SoftMaterial::volume with VolumeForm::Corrected",
        Advice::SoftBody => "a SoftBody",
        Advice::Cloth => "a Cloth",
        Advice::EvenWind => "Environment::wind_force in place of air",
        _ => return None,
    };
    Some(field.to_owned())
}
