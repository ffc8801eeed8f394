//! What the user keeps: pictures of the scene, and the scene with its values as they are.

use crate::busy::Busy;
use crate::play::Notices;
use crate::stage::StageRoot;
use bevy::prelude::*;
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured, save_to_disk};
use bevy_taffeta::prelude::*;
use bevy_taffeta::taffeta::scene::Scene;
use bevy_taffeta::taffeta_io::{files, load_scene, parse_scene};
use bevy_taffeta::{FromScene, Running};
use std::path::{Path, PathBuf};

/// Saves something.
#[derive(Message, Clone, Copy, Debug)]
pub enum Save {
    /// The picture, without panels.
    Picture,
    /// The scene.
    Scene,
}

/// The file that the scene is from.
#[derive(Resource)]
pub struct Source {
    /// Where it is.
    pub path: PathBuf,
    /// The scene with the values of the command line; files that it names are not loaded.
    pub scene: Scene,
}

impl Source {
    /// Reads the file again, for what it names.
    pub fn read(path: &Path, sets: &[String]) -> Result<Self, String> {
        let shown = path.display().to_string();
        let text =
            std::fs::read_to_string(path).map_err(|error| format!("{shown} cannot be read: {error}"))?;
        let scene = parse_scene(&text, &shown, sets).map_err(|error| error.to_string())?.scene;
        Ok(Self { path: path.to_owned(), scene })
    }

    /// The first name of a file that is not there yet, `NAME-MARK.ENDING`, then with numbers.
    fn unused(&self, folder: &Path, mark: &str, ending: &str) -> PathBuf {
        let stem = self.path.file_stem().map_or("scene".into(), |stem| stem.to_string_lossy());
        let name = |number: u32| match number {
            1 => folder.join(format!("{stem}-{mark}.{ending}")),
            number => folder.join(format!("{stem}-{mark}-{number}.{ending}")),
        };
        (1..).map(name).find(|path| path.symlink_metadata().is_err()).unwrap_or_else(|| name(1))
    }
}

/// A picture that is being taken.
#[derive(Resource, Default)]
pub struct Picture {
    /// Where it goes, and for how many updates there are no panels yet.
    wanted: Option<(PathBuf, u32)>,
}

/// Updates without panels before a picture is taken: what is seen lags behind.
const WITHOUT: u32 = 3;

impl Picture {
    /// Whether panels are to be left out.
    pub fn hides_panels(&self) -> bool {
        self.wanted.is_some()
    }
}

/// Saving, by keys and messages.
pub fn save(app: &mut App) {
    app.init_resource::<Picture>()
        .add_message::<Save>()
        .add_systems(Update, (keys, save_scene, begin, take).chain());
}

fn keys(keys: Res<ButtonInput<KeyCode>>, busy: Res<Busy>, mut save: MessageWriter<Save>) {
    if busy.keys {
        return;
    }
    if keys.just_pressed(KeyCode::KeyP) {
        save.write(Save::Picture);
    }
    let control = keys.any_pressed([KeyCode::ControlLeft, KeyCode::ControlRight]);
    if control && keys.just_pressed(KeyCode::KeyS) {
        save.write(Save::Scene);
    }
}

/// Plans a picture, in the folder in which the program was started.
fn begin(
    mut asked: MessageReader<Save>,
    source: Res<Source>,
    worlds: Query<&Running, With<StageRoot>>,
    mut picture: ResMut<Picture>,
) {
    let wanted = asked.read().any(|save| matches!(save, Save::Picture));
    if wanted && picture.wanted.is_none() {
        let frame = worlds.single().map_or(0, |running| running.simulation().frame());
        picture.wanted = Some((source.unused(Path::new("."), &frame.to_string(), "png"), 0));
    }
}

fn take(mut commands: Commands, mut picture: ResMut<Picture>) {
    let Some((path, updates)) = &mut picture.wanted else { return };
    *updates += 1;
    if *updates == WITHOUT {
        let path = path.clone();
        commands.spawn(Screenshot::primary_window()).observe(
            move |captured: On<ScreenshotCaptured>,
                  mut picture: ResMut<Picture>,
                  mut notices: ResMut<Notices>| {
                save_to_disk(&path)(captured);
                picture.wanted = None;
                notices.done = Some(saved(&path));
            },
        );
    }
}

/// What became of a file that was to be written.
pub fn saved(path: &Path) -> Result<String, String> {
    match std::fs::metadata(path) {
        Ok(file) => Ok(format!("saved {} ({} kB)", shown(path), file.len().div_ceil(1000))),
        Err(error) => Err(format!("{} was not saved: {error}", shown(path))),
    }
}

/// A path as people want it: from the root, if that can be known.
fn shown(path: &Path) -> String {
    path.canonicalize().unwrap_or_else(|_| path.to_owned()).display().to_string()
}

type Worlds<'w, 's> = Query<'w, 's, (&'static SoftWorld, &'static Environment), With<StageRoot>>;

/// Writes the scene beside its file, where the files that it names are found.
fn save_scene(
    mut asked: MessageReader<Save>,
    source: Res<Source>,
    worlds: Worlds,
    materials: Query<(&FromScene, &SoftMaterial)>,
    colliders: Query<(&FromScene, &SoftCollider)>,
    mut notices: ResMut<Notices>,
) {
    let wanted = asked.read().any(|save| matches!(save, Save::Scene));
    let (true, Ok(world)) = (wanted, worlds.single()) else { return };
    let scene = edited(&source.scene, world, materials.iter(), colliders.iter());
    let folder = source.path.parent().unwrap_or(Path::new(""));
    notices.done = Some(write(&scene, &source.unused(folder, "edited", "toml")));
}

/// The scene of the file with the values as they are.
pub fn edited<'a>(
    read: &Scene,
    (world, environment): (&SoftWorld, &Environment),
    materials: impl Iterator<Item = (&'a FromScene, &'a SoftMaterial)>,
    colliders: impl Iterator<Item = (&'a FromScene, &'a SoftCollider)>,
) -> Scene {
    let mut scene = read.clone();
    (scene.time, scene.solver) = (world.time.clone(), world.solver.clone());
    scene.world = environment.0.clone();
    for (from, material) in materials {
        if let Some(body) = scene.bodies.get_mut(from.0) {
            *body = material.put(body.clone());
        }
    }
    for (from, SoftCollider(now)) in colliders {
        if let Some(collider) = scene.colliders.get_mut(from.0) {
            (collider.friction, collider.restitution) = (now.friction, now.restitution);
            collider.offset = now.offset;
        }
    }
    scene
}

/// Writes a scene, and reads it again to be sure.
pub fn write(scene: &Scene, path: &Path) -> Result<String, String> {
    let unsaved = |why: String| format!("{} was not saved: {why}", path.display());
    let text = toml::to_string_pretty(scene).map_err(|error| unsaved(error.to_string()))?;
    files::replace(path, &[text.as_bytes()]).map_err(|error| unsaved(error.to_string()))?;
    load_scene(path, &[]).map_err(|error| format!("{} cannot be read again: {error}", shown(path)))?;
    saved(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All scenes that come with the program.
    fn scenes() -> Vec<PathBuf> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
        let all = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        all.filter(|path| path.extension().is_some_and(|ending| ending == "toml")).collect()
    }

    #[test]
    fn every_scene_is_written_so_that_it_is_read_as_it_was() {
        assert!(scenes().len() > 10);
        for path in scenes() {
            let source = Source::read(&path, &[]).unwrap();
            let text = toml::to_string_pretty(&source.scene).unwrap();
            let again =
                parse_scene(&text, "again", &[]).unwrap_or_else(|error| panic!("{error}\n{text}")).scene;
            assert_eq!(format!("{:?}", source.scene), format!("{again:?}"), "{}", path.display());
        }
    }
}
