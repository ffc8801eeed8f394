use crate::scene::*;

fn scene() -> Scene {
    let body =
        Body::cloth("flag", Mesh::grid(3, 4, [1.0, 1.0])).with_mass(Mass::Node(0.1)).structural(100.0, 0.1);
    Scene::new("test").body(body).collider(Collider::sphere([0.0; 3], 0.5))
}

/// Changes a good scene; the error is then at `path` and has these words.
#[track_caller]
fn refused(change: impl FnOnce(&mut Scene), path: &str, words: &str) {
    let mut scene = scene();
    change(&mut scene);
    let error = scene.validate().unwrap_err();
    assert_eq!(error.path, path, "{error}");
    assert!(error.message.contains(words), "{error}");
}

fn pin(motion: Vec<Keyframe>) -> Pin {
    Pin { select: Select::nodes([0]), motion, ..Pin::default() }
}

fn load() -> Force {
    Force { body: "flag".into(), select: Select::nodes([0]), force: Some([1.0; 3]), ..Force::default() }
}

#[test]
fn a_scene_that_can_run_is_accepted() {
    let mut good = scene();
    good.forces.push(load());
    good.bodies[0]
        .pins
        .push(pin(vec![Keyframe::translate(0.0, [0.0; 3]), Keyframe::translate(1.0, [1.0; 3])]));
    let endless = Bounds { min: [f64::NEG_INFINITY; 3], max: [f64::INFINITY; 3] };
    good.bodies[0].pins[0].select.inside = Some(endless);
    assert_eq!(good.validate(), Ok(()));
}

#[test]
fn times_must_lead_forwards() {
    refused(|s| s.time.dt = 0.0, "time.dt", "is 0 s, more than 0");
    refused(|s| s.time.max_step = Some(-0.1), "time.max_step", "is -0.1 s");
    refused(|s| s.time.max_step = Some(1e-9), "time.max_step", "16666667 sub-steps a frame");
    let tiny = |step| move |s: &mut Scene| s.time.max_step = Some(step);
    refused(tiny(1e-14), "time.max_step", "is 1e-14 s, 1.666666666667e12 sub-steps a frame");
    refused(tiny(1e-300), "time.max_step", "is 1e-300 s, 1e-15 to 1e15 s would do");
    refused(|s| s.time.frames = 0, "time.frames", "1 or more");
    let keys = vec![Keyframe::translate(1.0, [0.0; 3]), Keyframe::translate(1.0, [0.0; 3])];
    refused(
        |s| s.bodies[0].pins = vec![pin(vec![]), pin(keys)],
        "body[0].pin[1].motion[1].t",
        "is 1 s after 1 s",
    );
    let early = Keyframe::translate(-1.0, [0.0; 3]);
    refused(|s| s.colliders[0].motion = vec![early], "collider[0].motion[0].t", "is -1 s, 0 or more");
}

#[test]
fn pins_may_deform_but_turn_nothing_inside_out_and_colliders_keep_their_shape() {
    let one = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let pulled = |x: f64| Keyframe::deform(1.0, [[x, 0.0, 0.0], one[1], one[2]], [0.0; 3]);
    let pinned = |x: f64| move |s: &mut Scene| s.bodies[0].pins = vec![pin(vec![pulled(x)])];
    let at = "body[0].pin[0].motion[0].deform";
    refused(pinned(-1.0), at, "whose determinant is -1; one above 0");
    refused(pinned(0.0), at, "whose determinant is 0; one above 0");
    refused(pinned(f64::NAN), at, "finite");
    refused(pinned(2e3), at, "numbers up to 1000");
    let mut good = scene();
    pinned(1.2)(&mut good);
    assert_eq!(good.validate(), Ok(()));
    let moved = |s: &mut Scene| s.colliders[0].motion = vec![pulled(1.2)];
    refused(moved, "collider[0].motion[0].deform", "is for pins, and a collider");
}

#[test]
fn numbers_must_be_finite_and_not_below_their_floor() {
    refused(|s| s.world.gravity[1] = f64::NAN, "world.gravity", "NaN");
    refused(|s| s.world.gravity[1] = 1e300, "world.gravity", "numbers up to 1e15");
    refused(|s| s.world.drag = 1e300, "world.drag", "is 1e300 kg/s, up to 1e15 kg/s");
    refused(|s| s.world.drag = -1.0, "world.drag", "is -1 kg/s, 0 or more");
    refused(|s| s.bodies[0].place.position[2] = f64::INFINITY, "body[0].place.position", "finite");
    refused(|s| s.bodies[0].velocity[1] = f64::NAN, "body[0].velocity", "finite");
    refused(
        |s| s.bodies[0].velocity[1] = 3e8,
        "body[0].velocity",
        "300000000.0, 0.0] m/s, within ±1000000 m/s",
    );
    let spin = |s: &mut Scene| s.bodies[0].angular_velocity[2] = -2e6;
    refused(spin, "body[0].angular_velocity", "-2000000.0] rad/s, within ±1000000 rad/s");
    let springs = |s: &mut Scene| s.bodies[0].springs.structural = Some(Spring { k: -5.0, d: 0.0 });
    refused(springs, "body[0].springs.structural.k", "is -5 N/m, 0 or more");
    let hinge = |s: &mut Scene| s.bodies[0].springs.hinge = Some(Hinge { k: 1.0, d: f64::NAN });
    refused(hinge, "body[0].springs.hinge.d", "is NaN N·m·s/rad");
    let nowhere = Bounds { min: [f64::NAN; 3], max: [0.0; 3] };
    let select = Select { inside: Some(nowhere), ..Select::default() };
    let pinned = |s: &mut Scene| s.bodies[0].pins = vec![Pin { select, ..Pin::default() }];
    refused(pinned, "body[0].pin[0].select.box.min", "NaN");
}

#[test]
fn a_body_has_one_mass_that_suits_it() {
    refused(|s| s.bodies[0].mass = Some(1.0), "body[0]", "has node_mass and mass; one of");
    refused(|s| s.bodies[0].node_mass = None, "body[0]", "has no mass");
    refused(|s| s.bodies[0].node_mass = Some(0.0), "body[0].node_mass", "is 0 kg, more than 0");
    let dense = |s: &mut Scene| s.bodies[0] = s.bodies[0].clone().with_mass(Mass::Volume(1.0));
    refused(dense, "body[0].density", "soft bodies");
}

#[test]
fn shapes_and_places_must_make_sense() {
    refused(|s| s.bodies.clear(), "body", "has none");
    refused(|s| s.bodies[0].mesh = Mesh::grid(0, 2, [1.0; 2]), "body[0].mesh.grid.rows", "is 0, 1 or more");
    refused(|s| s.bodies[0].stand_in = Some(Mesh::chain(0, 1.0)), "body[0].stand_in.chain.links", "is 0");
    refused(|s| s.bodies[0].rest_shape = Some("flat.obj".into()), "body[0].rest_shape", "mesh.file (in Rust");
    refused(|s| s.bodies[0].fill_holes = true, "body[0].fill_holes", "mesh.file would do");
    let both = Place { scale: Some(1.0), fit: Some(1.0), ..Place::default() };
    refused(|s| s.bodies[0].place = both, "body[0].place", "scale and fit");
    refused(|s| s.bodies[0].place.fit = Some(0.0), "body[0].place.fit", "is 0 m");
    refused(|s| s.bodies[0].place.scale = Some(-2.0), "body[0].place.scale", "is -2, more");
    let turn = Rotation { axis: [0.0; 3], degrees: 1.0 };
    refused(|s| s.bodies[0].place.rotation = Some(turn), "body[0].place.rotation.axis", "a direction");
    let struts =
        |s: &mut Scene| s.bodies[0].springs.internal = Some(Internal { count: 5, ..Internal::default() });
    refused(struts, "body[0].springs.internal", "no inside");
    let twice = Internal { count: 3, pairs: Some(vec![]), ..Internal::default() };
    let soft = |s: &mut Scene| {
        s.bodies[0].kind = Kind::Soft;
        s.bodies[0].springs.internal = Some(twice);
    };
    refused(soft, "body[0].springs.internal", "a count of 3 and a file");
}

#[test]
fn a_scene_has_no_more_of_anything_than_32_bits_can_number() {
    let half = |s: &mut Scene| s.bodies[0].mesh = Mesh::grid(32768, 32768, [1.0; 2]);
    let twice = |s: &mut Scene| {
        half(s);
        s.bodies.push(Body { name: "twin".into(), ..s.bodies[0].clone() });
    };
    refused(twice, "body[1].mesh", "to 2147483648 nodes, 2147483647 are the limit");
    let hinged = |s: &mut Scene| {
        half(s);
        s.bodies[0].springs.hinge = Some(Hinge::default());
    };
    refused(
        hinged,
        "body[0].springs.hinge",
        "about 3221225472 elements of this kind, 1073741824 are the limit",
    );
    let struts = |s: &mut Scene| {
        s.bodies[0].kind = Kind::Soft;
        s.bodies[0].springs.internal = Some(Internal { count: u32::MAX, ..Internal::default() });
    };
    refused(struts, "body[0].springs.internal", "a count of 4294967295, 268435456 struts");
    let many = |s: &mut Scene| {
        let first = s.bodies[0].clone();
        s.bodies.extend((1..30).map(|i| Body { name: format!("b{i}"), ..first.clone() }));
        s.forces.push(Force { body: "none".into(), ..load() });
    };
    refused(many, "force[0].body", "`b19`, 10 more would do");
}

#[test]
fn names_are_unique_and_fit_for_files() {
    refused(|s| s.bodies[0].name = "a/b".into(), "body[0].name", "names files too");
    refused(|s| s.bodies[0].name = "..".into(), "body[0].name", "names files too");
    let twins = |s: &mut Scene| {
        s.bodies.push(s.bodies[0].clone());
        s.bodies[0].name = "body1".into();
        s.bodies[1].name = String::new();
    };
    refused(twins, "body[1].name", "is `body1`, as is that of body[0]");
}

#[test]
fn friction_is_of_two_that_touch_each_other_and_said_once() {
    let between = |one: &str, other: &str, value: f64| {
        let [one, other] = [one, other].map(str::to_owned);
        move |s: &mut Scene| {
            s.colliders.truncate(1);
            s.colliders.push(Collider::plane([0.0; 3], [0.0, 1.0, 0.0]).named("floor"));
            s.frictions.push(Friction { between: [one, other], value });
        }
    };
    refused(
        between("flag", "flor", 0.1),
        "friction[0].between",
        "names `flor`, and there is no body or collider",
    );
    refused(between("flag", "flor", 0.1), "friction[0].between", "`flag`, `collider0`, `floor` would do");
    refused(between("floor", "flag", -0.1), "friction[0].value", "is -0.1, 0 or more");
    refused(between("floor", "collider0", 0.1), "friction[0].between", "names two colliders");
    refused(
        between("flag", "flag", 0.1),
        "friction[0].between",
        "names `flag`, which has no contact between triangles",
    );
    let twice = |s: &mut Scene| {
        between("flag", "floor", 0.1)(s);
        s.frictions.push(Friction { between: ["floor".into(), "flag".into()], value: 0.2 });
    };
    refused(twice, "friction[1].between", "which friction[0] has already");
}

#[test]
fn colliders_have_one_shape_and_coefficients_in_range() {
    refused(|s| s.colliders[0].plane = Some(Plane::default()), "collider[0]", "more than one shape");
    refused(|s| s.colliders[0].sphere = None, "collider[0]", "no shape");
    refused(|s| s.colliders[0] = Collider::sphere([0.0; 3], -1.0), "collider[0].sphere.radius", "is -1 m");
    refused(
        |s| s.colliders[0] = Collider::plane([0.0; 3], [0.0; 3]),
        "collider[0].plane.normal",
        "direction",
    );
    let flat = Collider::cuboid([0.0; 3], [1.0, 0.0, 1.0]);
    refused(move |s| s.colliders[0] = flat, "collider[0].box.half[1]", "is 0 m, more than 0");
    refused(|s| s.colliders[0].name = "two\nlines".into(), "collider[0].name", "letters in a line");
    refused(|s| s.colliders[0].fill_holes = true, "collider[0].fill_holes", "is for a mesh from a file");
    refused(|s| s.colliders[0].friction = -0.1, "collider[0].friction", "is -0.1, 0 or more");
    refused(|s| s.colliders[0].restitution = 1.5, "collider[0].restitution", "is 1.5, 0 to 1");
    refused(|s| s.colliders[0].offset = -1.0, "collider[0].offset", "is -1 m");
}

#[test]
fn forces_act_on_a_body_that_exists_in_one_way() {
    let with = |change: fn(&mut Force)| {
        move |s: &mut Scene| {
            let mut force = load();
            change(&mut force);
            s.forces.push(force);
        }
    };
    refused(with(|f| f.body = "flug".into()), "force[0].body", "no body `flug`; `flag` would do");
    refused(with(|f| f.torque = Some(Torque::default())), "force[0]", "force and torque");
    refused(with(|f| f.force = None), "force[0]", "neither");
    let still = |f: &mut Force| (f.force, f.torque) = (None, Some(Torque::default()));
    refused(with(still), "force[0].torque.axis", "direction");
    let keyed = |f: &mut Force| f.motion = vec![ScaleKey { t: 0.0, scale: f64::NAN }];
    refused(with(keyed), "force[0].motion[0].scale", "finite");
}
