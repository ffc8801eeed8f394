//! Colliders: one shape, of a size, that moves in order.

use crate::real::{norm, sub};
use crate::scene::validate::body::{NO_HOLES, check_mesh, check_place};
use crate::scene::validate::path::{Checked, Path, SMALLEST, plain};
use crate::scene::validate::{check_motion, counts};
use crate::scene::{Bar, Collider, Heightfield, Mesh, Poses, Shape};

pub(crate) fn check(path: &Path, collider: &Collider) -> Checked {
    let shapes = collider.shapes();
    let &[shape] = shapes.as_slice() else {
        let have = if shapes.is_empty() { "no shape" } else { "more than one shape" };
        return path.refuse(&format!("has {have}; one of {} would do", Collider::SHAPES.join(", ")));
    };
    check_shape(path, shape)?;
    check_size(path, collider, shape)?;
    if let Some(poses) = &collider.poses {
        path.key("poses").demand(matches!(shape, Shape::Mesh(_)), || {
            "is for a collider that is a mesh; motion moves all others".to_owned()
        })?;
        check_poses(&path.key("poses"), poses)?;
    }
    path.key("offset").not_negative(collider.offset, "m")?;
    path.key("offset").short(collider.offset)?;
    path.key("friction").not_negative(collider.friction, "")?;
    path.key("restitution").share(collider.restitution)?;
    check_motion(path, &collider.motion)?;
    collider.motion.iter().enumerate().try_for_each(|(i, key)| {
        let path = path.nth("motion", i);
        path.key("deform").demand(key.deform.is_none(), || {
            "is for pins, and a collider moves without a change of shape; translate and rotate would do, or poses \
             of a mesh"
                .to_owned()
        })
    })
}

/// Where it is, how large, and that what belongs to a mesh is said of one.
fn check_size(path: &Path, collider: &Collider, shape: Shape<'_>) -> Checked {
    let place = path.key("place");
    check_place(&place, &collider.place)?;
    let is_mesh = matches!(shape, Shape::Mesh(_) | Shape::Convex(_) | Shape::Heightfield(_));
    place.key("fit").demand(is_mesh || collider.place.fit.is_none(), || {
        "is for meshes, and this shape has a size; scale would do".to_owned()
    })?;
    let from_file = matches!(shape, Shape::Mesh(mesh) | Shape::Convex(mesh) if mesh.is_from_file());
    path.key("fill_holes").demand(from_file || !collider.fill_holes, || NO_HOLES.to_owned())
}

fn check_shape(path: &Path, shape: Shape<'_>) -> Checked {
    match shape {
        Shape::Sphere(ball) => {
            let path = path.key("sphere");
            path.key("center").within(&ball.center)?;
            path.key("radius").length(ball.radius)
        }
        Shape::Plane(plane) => {
            let path = path.key("plane");
            path.key("point").within(&plane.point)?;
            path.key("normal").direction(plane.normal)
        }
        Shape::Box(cuboid) => {
            let path = path.key("box");
            path.key("center").within(&cuboid.center)?;
            cuboid.half.iter().enumerate().try_for_each(|(i, &half)| path.nth("half", i).length(half))
        }
        Shape::Capsule(bar) => check_bar(&path.key("capsule"), &bar),
        Shape::Cylinder(bar) => {
            let path = path.key("cylinder");
            check_bar(&path, &bar)?;
            let apart = norm(sub(bar.b, bar.a));
            path.key("b").demand(apart > 0.0, || {
                format!("is {:?}, as is a; two ends that are apart would do", bar.b)
            })?;
            path.key("b").demand(apart >= SMALLEST, || {
                format!("is {} m from a; {} m or more would do", plain(apart), plain(SMALLEST))
            })
        }
        Shape::Mesh(mesh) => check_surface(path, "mesh", mesh),
        Shape::Convex(mesh) => check_surface(path, "convex", mesh),
        Shape::Heightfield(field) => check_heightfield(&path.key("heightfield"), field),
    }
}

fn check_bar(path: &Path, bar: &Bar) -> Checked {
    path.key("a").within(&bar.a)?;
    path.key("b").within(&bar.b)?;
    path.key("radius").length(bar.radius)
}

fn check_surface(path: &Path, key: &str, mesh: &Mesh) -> Checked {
    let flat = matches!(mesh, Mesh::Chain(_));
    path.key(key)
        .demand(!flat, || "is a chain, which has no surface; a mesh of triangles would do".to_owned())?;
    check_mesh(path, key, mesh)?;
    path.key(key).demand(mesh.nodes() <= counts::MOST_NODES, || {
        format!("makes {} nodes; up to {} would do", mesh.nodes(), counts::MOST_NODES)
    })
}

fn check_heightfield(path: &Path, field: &Heightfield) -> Checked {
    field.size.iter().enumerate().try_for_each(|(i, &size)| path.nth("size", i).length(size))?;
    path.key("depth").length(field.depth)?;
    let heights = field.heights.iter().flatten();
    heights.copied().try_for_each(|height| path.key("heights").within(&[height]))
}

pub(crate) fn check_poses(path: &Path, poses: &Poses) -> Checked {
    path.key("interval").positive(poses.interval, "s")?;
    path.key("start").not_negative(poses.start, "s")?;
    let both = poses.file.is_some() && !poses.files.is_empty();
    path.demand(!both, || "has file and files; one of them would do".to_owned())
}
