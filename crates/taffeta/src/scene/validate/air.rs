//! What air can be.

use crate::scene::Air;
use crate::scene::validate::path::{Checked, Path};

pub(crate) fn check(path: &Path, air: &Air) -> Checked {
    path.key("velocity").finite(&air.velocity)?;
    path.key("density").not_negative(air.density, "kg/m³")?;
    path.key("drag").not_negative(air.drag, "")?;
    path.key("lift").not_negative(air.lift, "")?;
    let Some(gust) = &air.gust else { return Ok(()) };
    let path = path.key("gust");
    path.key("speed").not_negative(gust.speed, "m/s")?;
    path.key("length").positive(gust.length, "m")?;
    path.key("period").positive(gust.period, "s")
}

#[cfg(test)]
mod tests {
    use crate::scene::{Air, Body, Gust, Mass, Mesh, Scene};

    fn refused(air: Air) -> String {
        let body = Body::cloth("sheet", Mesh::grid(2, 2, [1.0; 2])).with_mass(Mass::Node(1.0));
        let mut scene = Scene::new("").body(body);
        scene.world.air = Some(air);
        scene.validate().map_or_else(|error| error.to_string(), |()| "accepted".to_owned())
    }

    #[test]
    fn what_cannot_be_is_refused_by_its_key() {
        let gust = |gust| Air { gust: Some(gust), ..Air::default() };
        let (plain, nan) = (Gust::default(), f64::NAN);
        assert_eq!(refused(gust(plain)), "accepted");
        assert_eq!(refused(Air { density: 0.0, drag: 0.0, lift: 0.0, ..gust(plain) }), "accepted");
        let cases = [
            (Air { velocity: [0.0, nan, 0.0], ..Air::default() }, "world.air.velocity: is [0.0, NaN, 0.0]"),
            (Air { density: -1.0, ..Air::default() }, "world.air.density: is -1 kg/m³, 0 or more would do"),
            (Air { drag: f64::INFINITY, ..Air::default() }, "world.air.drag: is inf, 0 or more"),
            (Air { lift: -0.5, ..Air::default() }, "world.air.lift: is -0.5, 0 or more would do"),
            (gust(Gust { speed: -2.0, ..plain }), "world.air.gust.speed: is -2 m/s, 0 or more would do"),
            (gust(Gust { length: 0.0, ..plain }), "world.air.gust.length: is 0 m, more than 0 would do"),
            (gust(Gust { period: nan, ..plain }), "world.air.gust.period: is NaN s, more than 0 would do"),
        ];
        for (air, expected) in cases {
            assert!(refused(air).starts_with(expected), "{air:?}: {}", refused(air));
        }
    }
}
