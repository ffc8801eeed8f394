//! What cannot be simulated, while the rest of its world is.

use crate::common::{drawn, messages, plain, positions, ready, run, running, sheet, with_sheet};
use bevy::prelude::*;
use bevy_taffeta::prelude::*;
use bevy_taffeta::taffeta;

#[test]
fn any_mesh_that_is_drawn_becomes_cloth_or_a_collider_and_what_cannot_is_refused() {
    let mut app = plain();
    app.add_plugins(TaffetaPlugin);
    // Its edge at -x is red, on black.
    let mut mesh = Plane3d::new(Vec3::Y, Vec2::splat(0.4)).mesh().subdivisions(7).build();
    let at =
        mesh.attribute(Mesh::ATTRIBUTE_POSITION).and_then(|at| at.as_float3()).expect("positions").to_vec();
    let is_red = |at: &[f32; 3]| at[0] < -0.39;
    let colours: Vec<[f32; 4]> =
        at.iter().map(|at| [f32::from(u8::from(is_red(at))), 0.0, 0.0, 1.0]).collect();
    mesh.insert_attribute(Mesh::ATTRIBUTE_COLOR, colours);
    let lines = Mesh::new(bevy::mesh::PrimitiveTopology::LineList, bevy::asset::RenderAssetUsages::all())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vec![[0.0_f32; 3]; 2]);
    let mut add = |mesh: Mesh| Mesh3d(app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh));
    let [sheet, ball, lines] = [add(mesh), add(Sphere::new(0.1).mesh().ico(3).expect("it")), add(lines)];
    let late = Handle::<Mesh>::default();
    let held = Pins::hold(Select::group("red"));
    let material = SoftMaterial::new(Mass::Area(0.2)).structural(50.0, 0.02);
    let at_height = Transform::from_xyz(0.0, 1.0, 0.0);
    let cloth = app.world_mut().spawn((sheet, FromMesh3d::Cloth, material, held, at_height)).id();
    let ball = app.world_mut().spawn((ball, FromMesh3d::Collider, Transform::from_xyz(0.3, 0.8, 0.0))).id();
    let bad = app.world_mut().spawn((lines, FromMesh3d::Cloth)).id();
    let waits = app.world_mut().spawn((Mesh3d(late), FromMesh3d::Cloth)).id();
    ready(&mut app);
    let [refused] = messages::<Refused>(&app)[..] else { panic!("no message") };
    assert_eq!(refused.entity, Some(bad));
    assert!(refused.error.to_string().contains("LineList"), "{}", refused.error);
    assert!(
        app.world().get::<FromMesh3d>(waits).is_some() && app.world().get::<SoftCollider>(ball).is_some()
    );
    run(&mut app, 40);
    let now = drawn(&app, cloth);
    assert_eq!(now.len(), at.len());
    let (mut fell, center) = (0.0_f32, Vec3::new(0.3, -0.2, 0.0));
    for (now, before) in now.iter().zip(&at) {
        let start = Vec3::from(*before);
        if is_red(before) {
            assert!(now.distance(start) < 1e-5, "{now} was held at {start}");
        }
        fell = fell.max(start.y - now.y);
        assert!(now.distance(center) > 0.098, "{now} is in the ball");
    }
    assert!(fell > 0.2, "{fell} m");
}

#[test]
fn what_cannot_be_is_refused_by_name_and_the_world_runs_on_as_it_was() {
    let (mut app, entity) = with_sheet();
    run(&mut app, 3);
    let good = app.world().get::<SoftMaterial>(entity).expect("it").clone();
    app.world_mut().entity_mut(entity).insert(SoftMaterial { mass: Mass::Node(-1.0), ..good.clone() });
    run(&mut app, 1);
    let [refused] = messages::<Refused>(&app)[..] else { panic!("no message") };
    assert!(refused.error.to_string().contains("body[0].node_mass"), "{}", refused.error);
    assert_eq!(refused.entity, Some(entity));
    run(&mut app, 3);
    assert_eq!(running(&mut app).simulation().frame(), 7);
    app.world_mut().entity_mut(entity).insert(good);
    run(&mut app, 1);
    assert!(messages::<Refused>(&app).is_empty());
}

#[test]
fn a_body_or_collider_that_cannot_be_is_left_out_alone_until_it_changes() {
    let (mut app, good) = with_sheet();
    let material = app.world().get::<SoftMaterial>(good).expect("it").clone();
    let wrong = SoftMaterial { mass: Mass::Node(-1.0), ..material.clone() };
    let bad = app.world_mut().spawn(sheet()).insert((wrong.clone(), Name::new("cape"))).id();
    let stone = SoftCollider(taffeta::scene::Collider::sphere([0.0; 3], -0.1));
    let stone = app.world_mut().spawn((stone, Transform::from_xyz(0.0, -3.0, 0.0))).id();
    let one = positions(&mut app).len();
    run(&mut app, 1);
    let all: Vec<_> = messages::<Refused>(&app).into_iter().map(|one| one.entity).collect();
    assert_eq!(all, [Some(bad), Some(stone)]);
    run(&mut app, 4);
    assert!(messages::<Refused>(&app).is_empty());
    assert_eq!((positions(&mut app).len(), running(&mut app).simulation().frame()), (one, 5));
    // Others come and change, and it is no reason to say it again.
    let third = app.world_mut().spawn(sheet()).id();
    run(&mut app, 1);
    assert!(messages::<Refused>(&app).is_empty());
    assert_eq!(positions(&mut app).len(), 2 * one);
    app.world_mut().entity_mut(bad).insert(material.clone());
    app.world_mut().entity_mut(stone).insert(SoftCollider::sphere(0.1));
    run(&mut app, 1);
    assert_eq!(positions(&mut app).len(), 3 * one);
    assert_eq!(running(&mut app).simulation().colliders().len(), 1);

    // One that runs goes on as it was, and what else has changed is taken up.
    app.world_mut().entity_mut(bad).insert(wrong);
    app.world_mut().entity_mut(third).despawn();
    let before = running(&mut app).simulation().frame();
    run(&mut app, 1);
    let [refused] = messages::<Refused>(&app)[..] else { panic!("no message") };
    assert_eq!(refused.entity, Some(bad));
    run(&mut app, 3);
    assert_eq!((positions(&mut app).len(), running(&mut app).simulation().frame()), (2 * one, before + 4));
    let [mass, good] = [bad, good].map(|one| {
        let body = running(&mut app).body_of(one).expect("it");
        running(&mut app).scene().bodies[body.index()].mass
    });
    assert_eq!(mass, good);
}

#[test]
fn bodies_of_one_name_go_on_from_their_own_states() {
    let (mut app, first) = with_sheet();
    let second =
        app.world_mut().spawn(sheet()).insert((Name::new("cape"), Transform::from_xyz(5.0, 0.0, 0.0))).id();
    app.world_mut().entity_mut(first).insert(Name::new("cape"));
    let balls = [0.1, 0.2].map(|radius| {
        app.world_mut().spawn((
            SoftCollider::sphere(radius),
            Name::new("ball"),
            Transform::from_xyz(0.0, -9.0, 0.0),
        ));
    });
    assert_eq!(balls.len(), 2);
    run(&mut app, 10);
    assert!(messages::<Refused>(&app).is_empty() && running(&mut app).simulation().colliders().len() == 2);
    let before = drawn(&app, second);
    app.world_mut().entity_mut(first).despawn();
    run(&mut app, 1);
    let fell =
        drawn(&app, second).iter().zip(&before).map(|(now, before)| before.y - now.y).fold(0.0, f32::max);
    assert!(
        fell > 0.0 && drawn(&app, second)[38].y < -0.05,
        "it goes on: {fell} m, {}",
        drawn(&app, second)[38]
    );
}

#[test]
fn what_is_pinned_to_a_collider_that_goes_is_left_out_and_the_others_run() {
    let (mut app, sheet_of_all) = with_sheet();
    let ball = app
        .world_mut()
        .spawn((SoftCollider::sphere(0.1), Name::new("ball"), Transform::from_xyz(3.0, 0.0, 0.0)))
        .id();
    let pin =
        taffeta::scene::Pin { select: Select::nodes([0]), collider: Some("ball".to_owned()), ..default() };
    let pins = Pins(vec![bevy_taffeta::Pinned { pin, by: None }]);
    let hung = app.world_mut().spawn(sheet()).insert((pins, Transform::from_xyz(3.0, 0.0, 0.0))).id();
    run(&mut app, 5);
    assert!(messages::<Refused>(&app).is_empty() && running(&mut app).body_of(hung).is_some());
    app.world_mut().entity_mut(ball).despawn();
    run(&mut app, 1);
    let all: Vec<_> = messages::<Refused>(&app).into_iter().map(|one| one.entity).collect();
    assert_eq!(all, [Some(hung)]);
    let before = running(&mut app).simulation().frame();
    run(&mut app, 3);
    assert!(messages::<Refused>(&app).is_empty() && running(&mut app).body_of(hung).is_none());
    assert!(running(&mut app).body_of(sheet_of_all).is_some());
    assert_eq!(running(&mut app).simulation().frame(), before + 3);
}

#[test]
fn a_world_that_lacks_a_body_runs_on_as_it_was_until_that_is_there() {
    let (mut app, _) = with_sheet();
    let pulled = app.world_mut().spawn(sheet()).insert(Name::new("pulled")).id();
    let force = taffeta::scene::Force {
        body: "pulled".to_owned(),
        select: Select::nodes([3]),
        force: Some([0.0, 0.01, 0.0]),
        torque: None,
        motion: Vec::new(),
    };
    let mut world = app.world_mut().query::<&mut SoftWorld>().single_mut(app.world_mut()).expect("one");
    world.forces.push(force);
    run(&mut app, 5);
    assert!(messages::<Refused>(&app).is_empty());
    let count = positions(&mut app).len();
    app.world_mut().entity_mut(pulled).despawn();
    run(&mut app, 1);
    let [refused] = messages::<Refused>(&app)[..] else { panic!("no message") };
    assert!(refused.entity.is_none() && refused.error.to_string().contains("pulled"), "{}", refused.error);
    run(&mut app, 3);
    assert!(messages::<Refused>(&app).is_empty());
    assert_eq!((positions(&mut app).len(), running(&mut app).simulation().frame()), (count, 9));
    let again = app.world_mut().spawn(sheet()).insert(Name::new("pulled")).id();
    run(&mut app, 1);
    assert!(messages::<Refused>(&app).is_empty() && running(&mut app).body_of(again).is_some());
}
