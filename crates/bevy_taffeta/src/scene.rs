//! Scenes in our TOML as assets, and what is spawned for one.

use crate::body::{Cloth, SceneBody, SoftBody};
use crate::collider::{SoftCollider, collider_mesh};
use crate::world::{Environment, SoftWorld};
use bevy::asset::io::Reader;
use bevy::asset::io::file::FileAssetReader;
use bevy::asset::{AssetLoader, AssetPath, LoadContext};
use bevy::prelude::*;
use std::path::PathBuf;
use taffeta::scene::{Kind, Scene};
use taffeta_io::{LoadError, load_files, parse_scene};

/// A scene as it is written in TOML, with the meshes that it names.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_taffeta::prelude::*;
/// use bevy_taffeta::taffeta::scene::{Body, Mesh, Scene};
///
/// let flag = Body::cloth("flag", Mesh::grid(20, 30, [1.5, 1.0])).with_mass(Mass::Area(0.2));
/// let scene = SoftScene { scene: Scene::new("flag").body(flag), notes: Vec::new() };
/// let mut scenes = Assets::default();
/// let root = SoftSceneRoot(scenes.add(scene));
/// assert_eq!(scenes.get(&root.0).map(|scene| scene.scene.bodies.len()), Some(1));
/// ```
#[derive(Asset, TypePath, Clone, Debug)]
pub struct SoftScene {
    /// The scene.
    pub scene: Scene,
    /// What the user should know, in words.
    pub notes: Vec<String>,
}

/// Reads scenes. What they name is looked for as the program `taffeta` does: beside the scene's file, in `models` and in
/// `$TAFFETA_MODELS`, among files and not among other sources of assets.
///
/// ```no_run
/// use bevy::prelude::*;
/// use bevy_taffeta::prelude::*;
///
/// // The plugin has the loader: `assets/flag.toml` is loaded by its name.
/// fn load(mut commands: Commands, assets: Res<AssetServer>) {
///     commands.spawn(SoftSceneRoot(assets.load("flag.toml")));
/// }
/// # App::new().add_plugins((DefaultPlugins, TaffetaPlugin)).add_systems(Startup, load).run();
/// ```
#[derive(TypePath, Clone, Debug)]
pub struct SceneLoader {
    root: PathBuf,
}

/// Why a scene was not loaded.
///
/// ```
/// use bevy::asset::AssetLoadFailedEvent;
/// use bevy::prelude::*;
/// use bevy_taffeta::prelude::*;
///
/// fn tell(mut failures: MessageReader<AssetLoadFailedEvent<SoftScene>>) {
///     for failure in failures.read() {
///         warn!("{}", failure.error);
///     }
/// }
/// # use bevy_taffeta::{SceneLoadError, taffeta_io::parse_scene};
///
/// let error = parse_scene("[[body]]\nmesh.file = 7", "flag.toml", &[]).unwrap_err();
/// let error = SceneLoadError::from(Box::new(error));
/// assert!(error.to_string().starts_with("flag.toml:2:"));
/// ```
#[derive(Debug, thiserror::Error)]
pub enum SceneLoadError {
    /// Its bytes did not come.
    #[error("cannot be read: {0}")]
    Read(#[from] std::io::Error),
    /// It is not UTF-8.
    #[error("is not UTF-8: {0}")]
    Text(#[from] std::string::FromUtf8Error),
    /// It is no scene, or a file that it names is not there.
    #[error(transparent)]
    Scene(#[from] Box<LoadError>),
}

impl SceneLoader {
    /// For assets where the app's plugin has them.
    pub(crate) fn of(app: &App) -> Self {
        let folder = app.get_added_plugins::<AssetPlugin>().first().map(|assets| assets.file_path.clone());
        Self { root: FileAssetReader::get_base_path().join(folder.unwrap_or_default()) }
    }
}

impl AssetLoader for SceneLoader {
    type Asset = SoftScene;
    type Settings = ();
    type Error = SceneLoadError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        _settings: &(),
        context: &mut LoadContext<'_>,
    ) -> Result<SoftScene, SceneLoadError> {
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes).await?;
        let path: &AssetPath = context.path();
        let file = self.root.join(path.path());
        let mut loaded =
            parse_scene(&String::from_utf8(bytes)?, &file.display().to_string(), &[]).map_err(Box::new)?;
        load_files(&mut loaded, &file).map_err(Box::new)?;
        Ok(SoftScene { scene: loaded.scene, notes: loaded.notes })
    }

    fn extensions(&self) -> &[&str] {
        &["toml"]
    }
}

/// Spawns a scene's bodies and colliders below this entity once it is loaded, and again when it changes.
///
/// ```no_run
/// use bevy::prelude::*;
/// use bevy_taffeta::prelude::*;
///
/// fn load(mut commands: Commands, assets: Res<AssetServer>) {
///     commands.spawn((SoftSceneRoot(assets.load("flag.toml")), Transform::from_xyz(0.0, 1.0, 0.0)));
/// }
/// # App::new().add_plugins((DefaultPlugins, TaffetaPlugin)).add_systems(Startup, load).run();
/// ```
#[derive(Component, Clone, Debug)]
#[require(SceneMaterials, Transform, Visibility)]
pub struct SoftSceneRoot(pub Handle<SoftScene>);

/// What the bodies and colliders of a scene are drawn with; ways of drawing that are not given are made.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_taffeta::SceneMaterials;
///
/// let mut materials = Assets::<StandardMaterial>::default();
/// let red = materials.add(Color::srgb(0.7, 0.1, 0.1));
/// let given = SceneMaterials { bodies: vec![red.clone()], ..default() };
/// let drawn = given.filled(&mut materials);
/// assert_eq!(drawn.bodies, [red]);
/// assert!(drawn.collider.is_some());
/// ```
#[derive(Component, Clone, Debug, Default)]
pub struct SceneMaterials {
    /// Of bodies, by turns.
    pub bodies: Vec<Handle<StandardMaterial>>,
    /// Of colliders.
    pub collider: Option<Handle<StandardMaterial>>,
}

/// Which body, or which collider, of its scene an entity is.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_taffeta::{FromScene, prelude::*};
///
/// /// Makes the first body of a scene heavier than its file says.
/// fn heavier(mut bodies: Query<(&FromScene, &mut SoftMaterial), Added<FromScene>>) {
///     for (_, mut material) in bodies.iter_mut().filter(|(from, _)| from.0 == 0) {
///         material.mass = Mass::Area(0.4);
///     }
/// }
/// ```
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub struct FromScene(pub usize);

/// Colours of bodies.
const COLOURS: [Color; 4] = [
    Color::srgb(0.75, 0.25, 0.2),
    Color::srgb(0.2, 0.45, 0.7),
    Color::srgb(0.85, 0.65, 0.25),
    Color::srgb(0.35, 0.6, 0.35),
];

impl SceneMaterials {
    /// Makes what was not given: cloth is seen from both sides.
    pub fn filled(&self, materials: &mut Assets<StandardMaterial>) -> Self {
        let mut coloured = |base_color| {
            let material = StandardMaterial {
                base_color,
                perceptual_roughness: 0.8,
                double_sided: true,
                cull_mode: None,
                ..default()
            };
            materials.add(material)
        };
        Self {
            bodies: if self.bodies.is_empty() {
                COLOURS.map(&mut coloured).to_vec()
            } else {
                self.bodies.clone()
            },
            collider: Some(self.collider.clone().unwrap_or_else(|| coloured(Color::srgb(0.55, 0.55, 0.58)))),
        }
    }
}

/// Makes `root` the world of a scene, and spawns its bodies and colliders below it: each an entity with its component, its
/// name, a mesh (of a body once the simulation is built) and a material.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_taffeta::taffeta::scene::{Body, Collider, Mesh, Scene};
/// use bevy_taffeta::{SceneMaterials, prelude::*, spawn_scene};
///
/// let flag = Body::cloth("flag", Mesh::grid(20, 30, [1.5, 1.0])).with_mass(Mass::Area(0.2));
/// let scene = Scene::new("flag").body(flag).collider(Collider::sphere([0.0, -0.5, 0.0], 0.3));
/// let (mut world, mut meshes) = (World::new(), Assets::default());
/// let root = world.spawn_empty().id();
/// spawn_scene(&mut world.commands(), root, &scene, &SceneMaterials::default(), &mut meshes);
/// world.flush();
/// assert_eq!(world.get::<Children>(root).map(|children| children.len()), Some(2));
/// ```
pub fn spawn_scene(
    commands: &mut Commands,
    root: Entity,
    scene: &Scene,
    drawn: &SceneMaterials,
    meshes: &mut Assets<Mesh>,
) {
    let Scene { time, world, solver, sleep, bodies, colliders, forces, seams, frictions, .. } = scene;
    let (time, solver, sleep) = (time.clone(), solver.clone(), *sleep);
    let (forces, seams, frictions) = (forces.clone(), seams.clone(), frictions.clone());
    let settings = SoftWorld { time, solver, sleep, forces, seams, frictions };
    commands.entity(root).insert((settings, Environment(world.clone())));
    for (index, body) in bodies.iter().enumerate() {
        let Some(made) = SceneBody::of(body) else {
            error!("taffeta: body[{index}] has no mass, or several; exactly one would do");
            continue;
        };
        let name = if body.name.is_empty() { format!("body{index}") } else { body.name.clone() };
        let mut entity = commands.spawn((ChildOf(root), FromScene(index), Name::new(name), made));
        match body.kind {
            Kind::Cloth => entity.insert(Cloth(body.mesh.clone())),
            Kind::Soft => entity.insert(SoftBody(body.mesh.clone())),
        };
        if !drawn.bodies.is_empty() {
            entity.insert(MeshMaterial3d(drawn.bodies[index % drawn.bodies.len()].clone()));
        }
    }
    for (index, collider) in colliders.iter().enumerate() {
        let name = if collider.name.is_empty() { format!("collider{index}") } else { collider.name.clone() };
        let mut entity = commands.spawn((
            ChildOf(root),
            FromScene(index),
            Name::new(name),
            SoftCollider(collider.clone()),
        ));
        if let (Some(mesh), Some(material)) = (collider_mesh(collider), &drawn.collider) {
            entity.insert((Mesh3d(meshes.add(mesh)), MeshMaterial3d(material.clone())));
        }
    }
}

/// Spawns scenes that were loaded since the last frame.
pub fn spawn_loaded(
    mut commands: Commands,
    mut events: MessageReader<AssetEvent<SoftScene>>,
    roots: Query<(Entity, Ref<SoftSceneRoot>, &SceneMaterials, Option<&Children>)>,
    spawned: Query<(), With<FromScene>>,
    scenes: Res<Assets<SoftScene>>,
    meshes: Option<ResMut<Assets<Mesh>>>,
    mut materials: Option<ResMut<Assets<StandardMaterial>>>,
) {
    let Some(mut meshes) = meshes else { return };
    let changed: Vec<_> = events.read().filter_map(loaded).collect();
    for (root, scene, given, children) in &roots {
        let id = scene.0.id();
        let (true, Some(found)) = (scene.is_changed() || changed.contains(&id), scenes.get(id)) else {
            continue;
        };
        for child in children.into_iter().flatten().filter(|child| spawned.contains(**child)) {
            commands.entity(*child).despawn();
        }
        for note in &found.notes {
            info!("taffeta: {note}");
        }
        let drawn = materials.as_mut().map_or_else(|| given.clone(), |all| given.filled(all));
        spawn_scene(&mut commands, root, &found.scene, &drawn, &mut meshes);
    }
}

/// The scene that has come, or come again.
fn loaded(event: &AssetEvent<SoftScene>) -> Option<AssetId<SoftScene>> {
    match event {
        AssetEvent::Added { id } | AssetEvent::Modified { id } => Some(*id),
        _ => None,
    }
}
