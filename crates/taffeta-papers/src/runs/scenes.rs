//! The scenes of the experiments, which the program carries with it.

use std::path::Path;
use taffeta_io::{Loaded, load_files, parse_scene};

/// Name and text of each.
const SCENES: [(&str, &str); 18] = [
    ("balloon", include_str!("../../../../scenes/balloon.toml")),
    ("fall_armadillo", include_str!("../../../../scenes/fall_armadillo.toml")),
    ("fall_bunny", include_str!("../../../../scenes/fall_bunny.toml")),
    ("fall_dragon", include_str!("../../../../scenes/fall_dragon.toml")),
    ("fall_sphere", include_str!("../../../../scenes/fall_sphere.toml")),
    ("fall_torus", include_str!("../../../../scenes/fall_torus.toml")),
    ("hanging_ice", include_str!("../../../../scenes/hanging_ice.toml")),
    ("pile", include_str!("../../../../scenes/pile.toml")),
    ("poke", include_str!("../../../../scenes/poke.toml")),
    ("press_armadillo", include_str!("../../../../scenes/press_armadillo.toml")),
    ("press_bunny", include_str!("../../../../scenes/press_bunny.toml")),
    ("s1_fig11", include_str!("../../../../scenes/s1_fig11.toml")),
    ("s1_fig12", include_str!("../../../../scenes/s1_fig12.toml")),
    ("s1_fig13", include_str!("../../../../scenes/s1_fig13.toml")),
    ("s1_fig14", include_str!("../../../../scenes/s1_fig14.toml")),
    ("s1_fig15", include_str!("../../../../scenes/s1_fig15.toml")),
    ("twist_pins", include_str!("../../../../scenes/twist_pins.toml")),
    ("twist_torque", include_str!("../../../../scenes/twist_torque.toml")),
];

/// A scene with values set as by `--set`. Its meshes are looked for in `models/` of the current folder and of those above it,
/// and in `$TAFFETA_MODELS`.
///
/// # Errors
/// Where a mesh is not there, for then the scene would stand for something else; and in words what else is wrong.
pub fn load(name: &str, sets: &[String]) -> Result<Loaded, String> {
    let text = SCENES.iter().find(|(known, _)| *known == name).map(|(_, text)| *text);
    let text = text.ok_or_else(|| format!("there is no scene `{name}`"))?;
    let file = format!("scenes/{name}.toml");
    let mut loaded = parse_scene(text, &file, sets).map_err(|error| error.to_string())?;
    let folder = std::env::current_dir().map_err(|error| format!("the current folder: {error}"))?;
    load_files(&mut loaded, &folder.join(Path::new(&file))).map_err(|error| error.to_string())?;
    match loaded.notes.first() {
        Some(note) => Err(format!("{note}; `cargo xtask models` fetches it")),
        None => Ok(loaded),
    }
}

/// The command that runs or checks it.
pub fn command(verb: &str, name: &str, sets: &[String]) -> String {
    let sets: String = sets.iter().map(|set| format!(" --set '{set}'")).collect();
    format!("taffeta {verb} scenes/{name}.toml{sets}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_are_read_with_values_set_and_what_is_not_there_is_named() {
        let loaded = load("s1_fig15", &["solver.method=springs".to_owned(), "time.frames=7".to_owned()]);
        assert_eq!(loaded.map(|loaded| loaded.scene.time.frames), Ok(7));
        assert_eq!(load("s4", &[]).err().as_deref(), Some("there is no scene `s4`"));
        let wrong = load("s1_fig15", &["time.frams=7".to_owned()]).err().unwrap_or_default();
        assert!(wrong.contains("frams"), "{wrong}");
    }
}
