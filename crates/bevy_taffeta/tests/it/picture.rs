//! Apps that render into a picture, without a window.
#![allow(dead_code, reason = "each test file uses a part")]

use crate::common::{clocked, ready};
use bevy::app::PluginGroupBuilder;
use bevy::camera::RenderTarget;
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::log::LogPlugin;
use bevy::prelude::*;
use bevy::render::pipelined_rendering::PipelinedRenderingPlugin;
use bevy::render::render_resource::TextureFormat;
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured};
use bevy::window::ExitCondition;
use bevy_taffeta::TaffetaPlugin;

/// Side of pictures [pixel].
pub const SIDE: u32 = 96;

/// What the camera draws to.
#[derive(Resource)]
pub struct Canvas(pub Handle<Image>);

/// The last picture that was taken.
#[derive(Resource, Default)]
struct Taken(Option<Image>);

/// An app with the renderer, a camera that looks at the origin from `eye`, and a light.
pub fn rendering(eye: Vec3) -> App {
    rendering_with(eye, |plugins| plugins.disable::<PipelinedRenderingPlugin>())
}

/// As [`rendering`], with plugins chosen.
pub fn rendering_with(eye: Vec3, choose: impl Fn(PluginGroupBuilder) -> PluginGroupBuilder) -> App {
    let mut app = App::new();
    let window = WindowPlugin { primary_window: None, exit_condition: ExitCondition::DontExit, ..default() };
    let plugins = DefaultPlugins.build().set(window).disable::<LogPlugin>();
    let plugins = choose(plugins);
    #[cfg(feature = "window")]
    let plugins = plugins.disable::<bevy::winit::WinitPlugin>();
    app.add_plugins((plugins, TaffetaPlugin));
    let image = Image::new_target_texture(SIDE, SIDE, TextureFormat::Rgba8UnormSrgb, None);
    let canvas = app.world_mut().resource_mut::<Assets<Image>>().add(image);
    app.world_mut().spawn((
        Camera3d::default(),
        RenderTarget::Image(canvas.clone().into()),
        Tonemapping::AcesFitted,
        Msaa::Off,
        Transform::from_translation(eye).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    let sun = Transform::from_xyz(1.0, 3.0, 2.0).looking_at(Vec3::ZERO, Vec3::Y);
    app.world_mut().spawn((DirectionalLight::default(), sun));
    app.insert_resource(Canvas(canvas)).init_resource::<Taken>();
    clocked(app)
}

/// A material that is seen from both sides.
pub fn cloth_material(app: &mut App) -> MeshMaterial3d<StandardMaterial> {
    let material = StandardMaterial {
        base_color: Color::srgb(0.8, 0.3, 0.2),
        double_sided: true,
        cull_mode: None,
        ..default()
    };
    MeshMaterial3d(app.world_mut().resource_mut::<Assets<StandardMaterial>>().add(material))
}

/// Lets time stand still until the pipelines are made, then takes a picture: rows of RGBA.
pub fn picture(app: &mut App) -> Vec<u8> {
    let canvas = app.world().resource::<Canvas>().0.clone();
    app.world_mut().resource_mut::<Time<Virtual>>().pause();
    app.world_mut().resource_mut::<Taken>().0 = None;
    for update in 0..400 {
        // The first pictures may be empty: pipelines are made meanwhile.
        if update % 4 == 3 {
            app.world_mut().spawn(Screenshot::image(canvas.clone())).observe(
                |captured: On<ScreenshotCaptured>, mut taken: ResMut<Taken>| {
                    taken.0 = Some(captured.image.clone())
                },
            );
        }
        app.update();
        let taken = app.world_mut().resource_mut::<Taken>().0.take().and_then(|image| image.data);
        let drawn = |data: &Vec<u8>| data.chunks(4).any(|pixel| pixel[0] > pixel[2].saturating_add(20));
        if let Some(data) = taken.filter(drawn) {
            app.world_mut().resource_mut::<Time<Virtual>>().unpause();
            return data;
        }
    }
    panic!("no picture with anything red on it");
}

/// Share of pixels that differ by more than a few shades.
pub fn difference(a: &[u8], b: &[u8]) -> f64 {
    let apart = |(a, b): (&[u8], &[u8])| a.iter().zip(b).any(|(a, b)| a.abs_diff(*b) > 12);
    let count = a.chunks(4).zip(b.chunks(4)).filter(|pair| apart(*pair)).count();
    count as f64 / f64::from(SIDE * SIDE)
}

/// Ready to be updated, as [`ready`].
pub fn start(app: &mut App) {
    ready(app);
}
