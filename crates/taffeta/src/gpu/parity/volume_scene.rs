//! The scene that rows of volumes are run on.

use crate::build::Assembly;
use crate::build::body::{BodyAssembly, BodySprings};
use crate::gpu::parity::mesh_scene;
use crate::scene::{
    Body, Bounds, Collider, Icosphere, Internal, Keyframe, Mass, Mesh, Scene, Select, Volume, VolumeForm,
    VolumeWeights,
};

fn soft(name: &str, subdivisions: u32, at: [f64; 3], volume: Volume) -> Body {
    let ball = Body::soft(name, Mesh::Icosphere(Icosphere { radius: 0.31, subdivisions }))
        .with_mass(Mass::Volume(23.0))
        .structural(61.3, 0.023)
        .at(at);
    Body { volume: Some(volume), ..ball }
}

fn form(form: VolumeForm) -> Volume {
    Volume { form, ..Volume::default() }
}

/// The body with weights of which no node has touched.
pub const UNTOUCHED: &str = "weighted";

fn weighted(name: &str, subdivisions: u32, at: [f64; 3]) -> Body {
    let ball = VolumeWeights { center: [at[0], at[1] + 0.11, at[2] + 0.25], radius: 0.35 };
    soft(name, subdivisions, at, Volume { weights: Some(ball), ..form(VolumeForm::Projected) })
}

/// Of one group and of several, the last of which is not full; in every form, with weights and without, beside bodies
/// without a volume; one cannot move at all.
fn bodies() -> Vec<Body> {
    let mut braced = soft("braced", 2, [0.9, 0.3, 0.1], form(VolumeForm::Projected));
    braced.springs.internal = Some(Internal { count: 111, k: 7.9, d: 0.0091, ..Internal::default() });
    let cloth = |name, mesh| Body::cloth(name, mesh).with_mass(Mass::Node(0.01)).structural(29.0, 0.011);
    let blob = Mesh::Icosphere(Icosphere { radius: 0.2, subdivisions: 1 });
    let pressed = Volume { pressure: Some(37.0), ..Volume::default() };
    let projected = |name: &str, x: f64| soft(name, 1, [x, 0.3, -1.1], form(VolumeForm::Projected));
    // Where weights are large.
    let front = Bounds { min: [-1.0, -1.0, 1.39], max: [9.0, 9.0, 9.0] };
    let large = soft("corrected", 3, [0.1, 0.29, -0.05], form(VolumeForm::Corrected));
    let mut bodies = Vec::from([
        cloth("sheet", Mesh::grid(7, 11, [0.5, 0.3])).at([0.0, 1.4, 0.0]),
        large.pin(Select::nodes([3, 500])),
        braced.pin(Select::nodes([0, 17])),
        cloth("blob", blob).at([0.0, 1.9, 0.0]),
        #[cfg(feature = "paper-forms")]
        soft("printed", 1, [1.7, 0.3, 0.1], form(VolumeForm::Printed)),
        #[cfg(feature = "paper-forms")]
        soft("shader", 2, [2.5, 0.3, 0.1], form(VolumeForm::PaperShader)),
        weighted(UNTOUCHED, 3, [3.3, 0.29, 0.1]),
        soft("pressed", 2, [3.9, 0.3, 1.1], pressed),
        weighted("touched", 2, [4.9, 0.3, 1.1]),
        weighted("held", 1, [5.7, 0.3, 1.1]).pin(Select { inside: Some(front), ..Select::default() }),
        projected("still", 0.0).pin(Select::nodes((0..42).collect::<Vec<_>>())),
    ]);
    // As many as there are volumes to aim at.
    let names = ["one", "two", "three", "four", "five"];
    bodies.extend(names.iter().zip(1..).map(|(name, i)| projected(name, 0.8 * f64::from(i))));
    bodies
}

/// Takes some springs away along edges; the ring stays.
fn thin_out(body: &mut BodyAssembly) {
    let BodySprings::Mesh(lists) = &mut body.springs else { return };
    let Some(list) = lists.first_mut() else { return };
    let keep = |i: &usize| i % 5 != 2;
    list.pairs = (0..list.pairs.len()).filter(keep).map(|i| list.pairs[i]).collect();
    list.rest = (0..list.rest.len()).filter(keep).map(|i| list.rest[i]).collect();
}

/// The bodies above a sloping floor and about a ball that rises; with `meshes`, about some of these too.
pub fn assembly(drag: f64, meshes: bool) -> Result<Assembly, String> {
    let rising = Keyframe::translate(0.5, [0.1, 0.2, -0.1]);
    let mut scene = Scene::new("volumes")
        .collider(Collider::plane([0.0, 0.02, 0.0], [0.03, 1.0, 0.02]).friction(0.4).restitution(0.2))
        .collider(Collider::sphere([0.9, 0.65, 0.1], 0.11).friction(0.3).keyframe(rising))
        .time(0.0173, 0.0041);
    if meshes {
        scene.colliders.extend(mesh_scene::colliders());
    }
    scene.bodies = bodies();
    scene.world.gravity = [0.37, -9.63, 0.21];
    scene.world.wind_force = [0.013, 0.0071, -0.0193];
    scene.world.drag = drag;
    let mut assembly = Assembly::new(&scene).map_err(|error| error.to_string())?;
    assembly.bodies.iter_mut().filter(|body| body.volume.is_some()).skip(3).for_each(thin_out);
    Ok(assembly)
}
