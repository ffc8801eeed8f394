//! Sun, shadow and sky.

use super::raster::fill;
use super::shapes::{Face, Material};
use super::vector::{Vector, across, along, dot, mix, unit};

/// Towards the sun, for a camera that looks along −z.
const SUN: Vector = [-0.45, 0.8, 0.5];
const SUNLIGHT: Vector = [0.86, 0.82, 0.76];
/// Light from straight above and from straight below.
const SKYLIGHT: Vector = [0.34, 0.38, 0.45];
const GROUNDLIGHT: Vector = [0.17, 0.16, 0.15];
/// Background at the top and at the bottom of the picture.
const TOP: Vector = [0.33, 0.50, 0.75];
const BOTTOM: Vector = [0.86, 0.89, 0.92];
/// Side of the shadow map [samples].
const MAP: usize = 1024;
/// Samples of the map on each side of a place that soften its shadow.
const SOFT: i64 = 3;
/// Of the map's width: how far behind the nearest thing a place is in the shade.
const BIAS: f64 = 0.008;

/// Sunlight, with the distances at which it first meets something.
pub struct Light {
    towards: Vector,
    across: [Vector; 2],
    low: [f64; 2],
    width: f64,
    reach: Vec<f64>,
}

impl Light {
    /// Light on `faces` from over the shoulder of a camera that is turned by `heading` [°].
    pub fn on(faces: &[Face], heading: f64) -> Self {
        let (sine, cosine) = heading.to_radians().sin_cos();
        let [x, y, z] = unit(SUN);
        let towards = [cosine * x + sine * z, y, cosine * z - sine * x];
        let mut light = Self {
            towards,
            across: across(towards),
            low: [0.0; 2],
            width: 1.0,
            reach: vec![f64::MIN; MAP * MAP],
        };
        let casting = || faces.iter().filter(|face| !matches!(face.material, Material::Floor { .. }));
        let places = || casting().flat_map(|face| face.corners.iter().map(|corner| corner.place));
        let range = light.across.map(|axis| {
            let along_axis = || places().map(|place| dot(place, axis));
            [along_axis().fold(f64::INFINITY, f64::min), along_axis().fold(f64::NEG_INFINITY, f64::max)]
        });
        light.low = range.map(|[low, _]| low);
        light.width = range.iter().map(|[low, high]| high - low).fold(1e-9, f64::max) * 1.001;
        casting().for_each(|face| light.cast(face));
        light
    }

    fn place_in_map(&self, place: Vector) -> [f64; 2] {
        std::array::from_fn(|i| (dot(place, self.across[i]) - self.low[i]) / self.width * MAP as f64)
    }

    fn cast(&mut self, face: &Face) {
        let corners = face.corners.map(|corner| self.place_in_map(corner.place));
        let reach = face.corners.map(|corner| dot(corner.place, self.towards));
        fill([MAP; 2], corners, |index, weights| {
            self.reach[index] = self.reach[index].max(dot(weights, reach));
        });
    }

    /// Share of the sun that a place sees.
    fn sun_at(&self, place: Vector) -> f64 {
        let [x, y] = self.place_in_map(place).map(|c| c.floor() as i64);
        let behind = dot(place, self.towards) + BIAS * self.width;
        let lit = |dx: i64, dy: i64| {
            let inside = (0..MAP as i64).contains(&(x + dx)) && (0..MAP as i64).contains(&(y + dy));
            !inside || self.reach[(y + dy) as usize * MAP + (x + dx) as usize] < behind
        };
        let lit = (-SOFT..=SOFT)
            .flat_map(|dy| (-SOFT..=SOFT).map(move |dx| (dx, dy)))
            .filter(|&(dx, dy)| lit(dx, dy));
        lit.count() as f64 / ((2 * SOFT + 1) * (2 * SOFT + 1)) as f64
    }

    /// Light that a matt surface at `place` sends back, as a share of its own colour.
    pub fn at(&self, place: Vector, normal: Vector) -> Vector {
        let around = mix(GROUNDLIGHT, SKYLIGHT, 0.5 + 0.5 * normal[1]);
        let slant = dot(normal, self.towards).max(0.0);
        if slant == 0.0 { around } else { along(around, slant * self.sun_at(place), SUNLIGHT) }
    }
}

/// The background at a height in the picture, 0 at the top to 1 at the bottom.
pub fn sky(height: f64) -> Vector {
    mix(TOP, BOTTOM, height.sqrt())
}
