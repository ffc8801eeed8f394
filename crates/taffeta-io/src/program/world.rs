//! Gravity, drag, wind and air that a program changes while a scene runs.

use crate::parse_scene;
use taffeta::scene::World;
use toml::{Table, Value};

/// A world with some of its keys changed, as a scene would have them.
///
/// ```
/// use taffeta::scene::World;
/// use taffeta_io::program::changed;
///
/// let moon = changed(toml::from_str("gravity = [0.0, -1.62, 0.0]")?, &World::default())?;
/// assert_eq!(moon.gravity, [0.0, -1.62, 0.0]);
/// assert!(changed(toml::from_str("gravty = 1")?, &moon).unwrap_err().contains("did you mean `gravity`?"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// What of the changes no world could have.
pub fn changed(changes: Table, now: &World) -> Result<World, String> {
    let mut world = Table::try_from(now).map_err(|error| error.to_string())?;
    world.extend(changes);
    let whole = Table::from_iter([("world".to_owned(), Value::Table(world))]);
    let text = toml::to_string(&whole).map_err(|error| error.to_string())?;
    let loaded = parse_scene(&text, "world", &[]).map_err(|error| error.message)?;
    Ok(loaded.scene.world)
}
