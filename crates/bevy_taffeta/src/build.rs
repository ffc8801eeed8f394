//! Entities become a simulation, and their changes are taken up.

use crate::advice::hint;
use crate::body::{BodyPlace, BodyVelocity, Cloth, Pins, SoftBody, SoftMaterial};
use crate::collider::SoftCollider;
use crate::device::Device;
use crate::drawn::{BodyMesh, all_places, drawn_of, mesh_of, view_into, viewed};
use crate::pose::{Rigid, place_in_world};
use crate::refused::{Refusals, named};
use crate::running::{Carried, Running, RunningBody, RunningCollider};
use crate::scene::FromScene;
use crate::step::{DivergenceMessages, Refused};
use crate::track::Track;
use crate::world::{DefaultWorld, DeviceChoice, DrawMethod, Environment, RunOn, SoftWorld};
use bevy::ecs::query::QueryData;
use bevy::ecs::system::SystemParam;
use bevy::math::DVec3;
use bevy::platform::collections::{HashMap, HashSet};
use bevy::prelude::*;
use std::time::Instant;
use taffeta::scene::{self, Body, Place, Scene};
use taffeta::taffeta_gpu::Gpu;
use taffeta::{Advice, BuildError, Options, Refusal, Simulation, StepError};

/// What makes an entity a body.
#[derive(QueryData)]
pub struct BodyData {
    entity: Entity,
    cloth: Option<Ref<'static, Cloth>>,
    soft: Option<Ref<'static, SoftBody>>,
    material: Ref<'static, SoftMaterial>,
    pins: Ref<'static, Pins>,
    place: Option<Ref<'static, BodyPlace>>,
    velocity: Option<Ref<'static, BodyVelocity>>,
    name: Option<Ref<'static, Name>>,
    from: Option<&'static FromScene>,
    transform: &'static GlobalTransform,
}

/// What makes an entity a collider.
#[derive(QueryData)]
pub struct ColliderData {
    entity: Entity,
    collider: Ref<'static, SoftCollider>,
    name: Option<Ref<'static, Name>>,
    from: Option<&'static FromScene>,
    transform: &'static GlobalTransform,
}

/// A world and what it has so far.
#[derive(QueryData)]
#[query_data(mutable)]
pub struct WorldData {
    entity: Entity,
    world: Ref<'static, SoftWorld>,
    environment: Ref<'static, Environment>,
    on: Ref<'static, RunOn>,
    running: Option<&'static mut Running>,
}

type Bodies<'w, 's> = Query<'w, 's, BodyData, Or<(With<Cloth>, With<SoftBody>)>>;

/// All that may be a part of a simulation.
#[derive(SystemParam)]
pub struct Entities<'w, 's> {
    bodies: Bodies<'w, 's>,
    colliders: Query<'w, 's, ColliderData>,
    transforms: Query<'w, 's, &'static GlobalTransform>,
    parents: Query<'w, 's, &'static ChildOf>,
    default_world: Query<'w, 's, Entity, With<DefaultWorld>>,
    names: Query<'w, 's, NameOrEntity>,
}

/// What it takes to build simulations, and what is remembered of it.
#[derive(SystemParam)]
pub struct Building<'w, 's> {
    device: Device<'w>,
    meshes: Option<ResMut<'w, Assets<Mesh>>>,
    arrivals: Local<'s, [Arrivals; 2]>,
    /// What worlds were built without.
    refused: Local<'s, HashMap<Entity, Refusals>>,
}

/// The bodies and colliders of a world, in order.
#[derive(Default, PartialEq)]
pub struct Members {
    pub bodies: Vec<Entity>,
    pub colliders: Vec<Entity>,
}

/// Builds the simulations of worlds that have changed.
pub fn build(
    mut commands: Commands,
    mut worlds: Query<WorldData>,
    entities: Entities,
    mut building: Building,
    mut refused: MessageWriter<Refused>,
    mut messages: DivergenceMessages,
) {
    let all = worlds.iter().map(|world| world.entity).collect();
    let mut members = entities.members(&all, &mut building.arrivals);
    building.refused.retain(|world, _| all.contains(world));
    for mut world in &mut worlds {
        let members = members.remove(&world.entity).unwrap_or_default();
        if members.bodies.is_empty() {
            building.refused.remove(&world.entity);
            if world.running.is_some() {
                commands.entity(world.entity).remove::<Running>();
            }
        } else if world.is_due(&members, &entities, building.refused.get(&world.entity)) {
            if let Some(running) = &mut world.running {
                // What was submitted and has diverged is not to be gone on from.
                let polled = running.simulation.poll().map(drop);
                running.unreported = 0;
                messages.write(world.entity, running, polled);
            }
            let clock = Instant::now();
            let before = building.refused.remove(&world.entity).unwrap_or_default();
            let mut refusals = Refusals::default();
            let built = loop {
                let left = members.but(&refusals, world.running.as_deref());
                if left.bodies.is_empty() {
                    commands.entity(world.entity).remove::<Running>();
                    break None;
                }
                let plan = Plan { world: &world, entities: &entities, refusals: &refusals };
                let error = match plan.run(&left, &mut building) {
                    Ok(running) => break Some(running),
                    Err(error) => error,
                };
                let entity = named(&error, &left.bodies, &left.colliders);
                let entity = entity.filter(|entity| !refusals.is_out(*entity));
                let runs = |entity| world.running.as_deref().is_some_and(|running| running.has(entity));
                let is_new = refusals.add(entity, &error, entity.is_some_and(runs));
                if is_new && !before.has_said(entity, &error) {
                    let name = entities.names.get(entity.unwrap_or(world.entity));
                    let name = name.map(|name| format!("{name}: ")).unwrap_or_default();
                    error!("taffeta: {name}{error}{}", hint(error.advice()));
                    refused.write(Refused { world: world.entity, entity, error });
                }
                if entity.is_none() {
                    break None;
                }
            };
            refusals.unbuilt = built.is_none().then_some(members);
            if let Some(mut running) = built {
                running.timing.build = clock.elapsed().as_secs_f64();
                for body in &running.bodies {
                    commands.entity(body.entity).insert(Mesh3d(body.mesh.handle.clone()));
                }
                commands.entity(world.entity).insert(running);
            }
            building.refused.insert(world.entity, refusals);
        }
    }
}

impl WorldDataItem<'_, '_> {
    /// Whether it is to be built again. What can change while it runs is changed.
    fn is_due(&mut self, members: &Members, entities: &Entities, refusals: Option<&Refusals>) -> bool {
        let unbuilt = refusals.and_then(|refusals| refusals.unbuilt.as_ref());
        let mut refused = refusals
            .into_iter()
            .flat_map(Refusals::entities)
            .chain(unbuilt.into_iter().flat_map(Members::all));
        let mended = refused.any(|entity| entities.was_mended(entity));
        let changed = mended || self.world.is_changed() || self.on.is_changed() || members.changed(entities);
        let weather = self.environment.is_changed();
        let environment = &self.environment;
        // A world that was built without air takes none up.
        let lacks_air = |running: &mut Mut<Running>| running.simulation.set_world(environment).is_err();
        let lacks = weather && !changed && self.running.as_mut().is_some_and(lacks_air);
        let stale = self.running.as_ref().is_none_or(|running| !members.are_those_of(running, refusals));
        match unbuilt {
            Some(then) => changed || weather || then != members,
            None => changed || lacks || stale,
        }
    }
}

/// When entities were first seen, in numbers.
#[derive(Default)]
pub struct Arrivals {
    number: HashMap<Entity, u64>,
    next: u64,
}

impl Arrivals {
    /// Entities in the order of their scene, then of their arrival; of those that arrive together, of their indices.
    fn order(&mut self, all: impl Iterator<Item = (Option<FromScene>, Entity)>) -> Vec<Entity> {
        let mut all: Vec<_> = all.collect();
        all.sort_unstable_by_key(|(_, entity)| entity.index_u32());
        let before = std::mem::take(&mut self.number);
        for &(_, entity) in &all {
            let number = before.get(&entity).copied().unwrap_or(self.next);
            self.next = self.next.max(number + 1);
            self.number.insert(entity, number);
        }
        all.sort_by_key(|(from, entity)| (from.map_or(usize::MAX, |from| from.0), self.number[entity]));
        all.into_iter().map(|(_, entity)| entity).collect()
    }
}

impl Entities<'_, '_> {
    /// Whether what makes a body or collider has changed.
    fn has_changed(&self, entity: Entity) -> bool {
        let body = |body: BodyDataItem| {
            body.cloth.is_some_and(|cloth| cloth.is_changed())
                || body.soft.is_some_and(|soft| soft.is_changed())
                || body.material.is_changed()
                || body.pins.is_changed()
        };
        self.bodies.get(entity).is_ok_and(body)
            || self.colliders.get(entity).is_ok_and(|one| one.collider.is_changed())
    }

    /// Whether something else has changed of a body or collider, which is taken up only where that was refused.
    fn was_mended(&self, entity: Entity) -> bool {
        let body = |body: BodyDataItem| {
            body.place.is_some_and(|place| place.is_changed())
                || body.velocity.is_some_and(|velocity| velocity.is_changed())
                || body.name.is_some_and(|name| name.is_changed())
        };
        self.bodies.get(entity).is_ok_and(body)
            || self.colliders.get(entity).is_ok_and(|one| one.name.is_some_and(|name| name.is_changed()))
    }

    /// Those of each world, in order.
    fn members(&self, worlds: &HashSet<Entity>, arrivals: &mut [Arrivals; 2]) -> HashMap<Entity, Members> {
        let world_of = |entity: Entity| {
            let mut above = std::iter::once(entity).chain(self.parents.iter_ancestors(entity));
            above.find(|one| worlds.contains(one)).or_else(|| self.default_world.iter().next())
        };
        let mut found: HashMap<Entity, Members> = HashMap::default();
        let [of_bodies, of_colliders] = arrivals;
        for entity in of_bodies.order(self.bodies.iter().map(|body| (body.from.copied(), body.entity))) {
            if let Some(world) = world_of(entity) {
                found.entry(world).or_default().bodies.push(entity);
            }
        }
        for entity in of_colliders.order(self.colliders.iter().map(|one| (one.from.copied(), one.entity))) {
            if let Some(world) = world_of(entity) {
                found.entry(world).or_default().colliders.push(entity);
            }
        }
        found
    }
}

impl Members {
    fn all(&self) -> impl Iterator<Item = Entity> {
        self.bodies.iter().chain(&self.colliders).copied()
    }

    fn changed(&self, entities: &Entities) -> bool {
        self.all().any(|entity| entities.has_changed(entity))
    }

    /// Whether a simulation has all that are not refused. Of those it may have some, as they were.
    fn are_those_of(&self, running: &Running, refusals: Option<&Refusals>) -> bool {
        let Self { bodies, colliders } = self.but(refusals, running);
        running.bodies.iter().map(|body| body.entity).eq(bodies)
            && running.colliders.iter().map(|one| one.entity).eq(colliders)
    }

    /// Those that are not refused, or run.
    fn but<'a>(
        &self,
        refusals: impl Into<Option<&'a Refusals>>,
        running: impl Into<Option<&'a Running>>,
    ) -> Self {
        let (refusals, running) = (refusals.into(), running.into());
        let is_refused = |entity: &Entity| refusals.is_some_and(|all| all.has(*entity));
        let is_out = |entity: &Entity| refusals.is_some_and(|all| all.is_out(*entity));
        let runs = |entity: &Entity| running.is_some_and(|running| running.has(*entity));
        let [bodies, colliders] = [&self.bodies, &self.colliders].map(|all| {
            all.iter()
                .copied()
                .filter(|entity| !is_refused(entity) || runs(entity) && !is_out(entity))
                .collect()
        });
        Self { bodies, colliders }
    }
}

/// A simulation that is to be built.
struct Plan<'a, 'w, 's> {
    world: &'a WorldDataItem<'w, 's>,
    entities: &'a Entities<'w, 's>,
    refusals: &'a Refusals,
}

impl Plan<'_, '_, '_> {
    fn run(&self, members: &Members, building: &mut Building) -> Result<Running, BuildError> {
        let old = self.world.running.as_deref();
        let (mut scene, mut bodies) = (self.settings(), Vec::new());
        for body in self.entities.bodies.iter_many(&members.bodies) {
            let is_refused = self.refusals.has(body.entity);
            let as_it_was = old.filter(|_| is_refused).and_then(|old| old.body_as_it_is(body.entity));
            let (described, running) = as_it_was.unwrap_or_else(|| self.describe(&body, old));
            scene.bodies.push(described);
            bodies.push(running);
        }
        let names = scene.bodies.iter_mut().map(|body| &mut body.name);
        rename(names.zip(members.bodies.iter().copied()));
        let colliders = self.colliders(&members.colliders, &mut scene, old);
        let names = scene.colliders.iter_mut().map(|collider| &mut collider.name);
        let named = names.zip(members.colliders.iter().copied());
        rename(named.filter(|(name, _)| !name.is_empty()));
        let mut simulation = self.simulation(&scene, &mut building.device)?;
        // From a state that diverged nothing goes on.
        match old.filter(|old| !old.halted) {
            Some(old) => {
                let pair = |(index, body): (usize, &RunningBody)| {
                    Some([simulation.bodies()[index].handle, old.body_of(body.entity)?])
                };
                let pairs: Vec<_> = bodies.iter().enumerate().filter_map(pair).collect();
                simulation.adopt_bodies(&old.simulation, &pairs).expect("handles of these two");
            }
            None => simulation
                .warnings()
                .iter()
                .for_each(|warning| warn!("taffeta: {warning}{}", hint(&warning.advice))),
        }
        let is_gpu = simulation.backend() == "gpu";
        let mut running = Running {
            shared: is_gpu && self.world.on.draw == DrawMethod::Shared && building.meshes.is_some(),
            copied: [all_places(&simulation), all_places(&simulation)],
            simulation,
            built: old.map_or(0, |old| old.built) + 1,
            timing: old.map(|old| old.timing.clone()).unwrap_or_default(),
            bodies,
            colliders,
            ahead: old.map_or(0.0, |old| old.ahead),
            share: 1.0,
            unreported: 0,
            frozen: Vec::new(),
            halted: false,
            scene,
        };
        running.make_meshes(old, building.meshes.as_deref_mut())?;
        Ok(running)
    }

    /// The scene without bodies and colliders.
    fn settings(&self) -> Scene {
        let SoftWorld { time, solver, sleep, forces, seams, frictions } = SoftWorld::clone(&self.world.world);
        let world = self.world.environment.0.clone();
        Scene { time, world, solver, sleep, forces, seams, frictions, ..Scene::default() }
    }

    /// Adds colliders to the scene. One that follows keyframes has left the place that these count from, and another one goes on from
    /// where its last step ended.
    fn colliders(
        &self,
        members: &[Entity],
        scene: &mut Scene,
        old: Option<&Running>,
    ) -> Vec<RunningCollider> {
        let before = old.map_or(&[][..], |old| &old.colliders);
        let add = |one: ColliderDataItem| {
            let is_refused = self.refusals.has(one.entity);
            let as_it_was = old.filter(|_| is_refused).and_then(|old| old.collider_as_it_is(one.entity));
            if let Some((collider, running)) = as_it_was {
                scene.colliders.push(collider);
                return running;
            }
            let mut collider = one.collider.0.clone();
            let keyed = !collider.motion.is_empty();
            let was = before.iter().find(|was| was.keyed == keyed && was.entity == one.entity);
            let now = Rigid::of(one.transform);
            let track = was.map_or(Track::new(now, now), |was| {
                if keyed { Track::new(was.track.start, was.track.start) } else { was.track.restarted() }
            });
            let (scale, ..) = one.transform.to_scale_rotation_translation();
            let from = was.map_or(*one.transform, |_| track.start.transform(scale).into());
            collider.place = place_in_world(&from, &collider.place);
            if let Some(name) = &one.name {
                collider.name = name.to_string();
            }
            scene.colliders.push(collider);
            RunningCollider { entity: one.entity, track, keyed, shown: None }
        };
        self.entities.colliders.iter_many(members).map(add).collect()
    }

    /// A body as the engine takes it, and what is known of it besides.
    fn describe(&self, body: &BodyDataItem, old: Option<&Running>) -> (Body, RunningBody) {
        let before = old.and_then(|old| old.bodies.iter().find(|one| one.entity == body.entity));
        let start = before.map_or(*body.transform, |before| before.start);
        let described = match (&body.cloth, &body.soft) {
            (Some(cloth), _) => Body::cloth("", cloth.0.clone()),
            (None, Some(soft)) => Body::soft("", soft.0.clone()),
            (None, None) => Body::cloth("", scene::Mesh::chain(2, 1.0)),
        };
        let mut described = body.material.put(described);
        described.name =
            body.name.as_ref().map_or_else(|| format!("body {}", body.entity), |name| name.to_string());
        described.place =
            place_in_world(&start, &body.place.as_ref().map_or_else(Place::default, |place| place.0.clone()));
        let BodyVelocity { linear, angular } = body.velocity.as_deref().copied().unwrap_or_default();
        let turned = |vector| (Rigid::of(&start).turn * DVec3::from_array(vector)).to_array();
        (described.velocity, described.angular_velocity) = (turned(linear), turned(angular));
        let mut carried = Vec::new();
        for (index, pinned) in body.pins.0.iter().enumerate() {
            let mut pin = pinned.pin.clone();
            let by = pinned.by.and_then(|by| Some((by, Rigid::of(self.entities.transforms.get(by).ok()?))));
            if let Some((by, now)) = by {
                let same = |one: &&Carried| one.pin == index && one.by == by;
                let track = before.and_then(|before| before.carried.iter().find(same)).map(|one| one.track);
                let track = track.unwrap_or(Track::new(now, now));
                let carries = Carried { pin: index, by, track };
                pin.motion = vec![carries.keyframe()];
                carried.push(carries);
            }
            described.pins.push(pin);
        }
        let view = view_into(body.transform, 1.0);
        let mesh = BodyMesh::default();
        (
            described,
            RunningBody { entity: body.entity, start, mesh, first_vertex: 0, view, copied: None, carried },
        )
    }

    /// On the device that is asked for.
    fn simulation(&self, scene: &Scene, device: &mut Device) -> Result<Simulation, BuildError> {
        let RunOn { device: choice, threads, on_divergence, .. } = *self.world.on;
        let cpu = Options { threads, on_divergence, ..Options::default() };
        let on = |gpu: Gpu| {
            Simulation::new(scene, &Options { gpu: Some(gpu.into()), on_divergence, ..Options::default() })
        };
        match (choice, device.gpu()) {
            (DeviceChoice::Gpu, None) => {
                Err(Refusal::new("it is to run on a GPU, and Bevy has opened none", [Advice::Cpu]).into())
            }
            (DeviceChoice::Gpu, Some(gpu)) => on(gpu),
            (DeviceChoice::Auto, Some(gpu)) if !gpu.info().is_software() => on(gpu).or_else(|error| {
                let simulation = Simulation::new(scene, &cpu)?;
                warn!("taffeta: the CPU simulates, for {error}");
                Ok(simulation)
            }),
            _ => Simulation::new(scene, &cpu),
        }
    }
}

/// Gives bodies or colliders of one name names of their own.
fn rename<'a>(names: impl Iterator<Item = (&'a mut String, Entity)>) {
    let mut seen = HashSet::new();
    for (name, entity) in names {
        if !seen.insert(name.clone()) {
            *name = format!("{name} {entity}");
            seen.insert(name.clone());
        }
    }
}

impl Running {
    /// Gives each body a mesh, the one that it had where that still fits.
    fn make_meshes(
        &mut self,
        old: Option<&Running>,
        mut meshes: Option<&mut Assets<Mesh>>,
    ) -> Result<(), BuildError> {
        let lost = |error: StepError| BuildError::Lost(error.to_string());
        let mut first = 0;
        for (index, body) in self.bodies.iter_mut().enumerate() {
            let handle = self.simulation.bodies()[index].handle;
            let surface = self.simulation.surface(handle).map_err(|error| lost(error.into()))?;
            let drawn = drawn_of(&surface, &self.scene.bodies[index].mesh);
            body.first_vertex = first;
            first += self.simulation.bodies()[index].vertices;
            if self.shared {
                self.simulation.make_drawn(handle, &drawn.nodes).map_err(lost)?;
            }
            let before = old.and_then(|old| old.bodies.iter().find(|one| one.entity == body.entity));
            let same_way = old.is_some_and(|old| old.shared == self.shared);
            let handle = before.map(|before| before.mesh.handle.clone());
            if let Some(before) = before.filter(|before| same_way && before.mesh.drawn == drawn) {
                body.mesh = before.mesh.clone();
                continue;
            }
            let place = |vertex: usize| self.copied[1][body.first_vertex + vertex];
            let (places, normals) = viewed(&drawn, &body.view, place);
            let mesh = mesh_of(&drawn, places, normals, self.shared);
            let handle = match (&mut meshes, handle) {
                (Some(all), Some(handle)) => {
                    // A handle keeps its place in the assets, so there is one.
                    let _ = all.insert(handle.id(), mesh);
                    handle
                }
                (Some(all), None) => all.add(mesh),
                (None, _) => Handle::default(),
            };
            body.mesh = BodyMesh { handle, drawn };
        }
        if self.shared {
            self.copied = [Vec::new(), Vec::new()];
        }
        Ok(())
    }
}
