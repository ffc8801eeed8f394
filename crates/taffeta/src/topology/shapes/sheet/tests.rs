use super::*;
use crate::scene::Mesh;
use crate::topology::measure::area_of;
use crate::topology::shapes;

const PATTERNS: [Pattern; 2] = [Pattern::Equilateral, Pattern::Grid];

/// Smallest and largest angle of all triangles [°].
fn angles(surface: &Surface) -> [f64; 2] {
    let mut extremes = [180.0_f64, 0.0];
    for triangle in &surface.triangles {
        let corners = triangle.map(|node| surface.nodes[node as usize]);
        for i in 0..3 {
            let [tip, p, q] = [0, 1, 2].map(|j| corners[(i + j) % 3]);
            let [p, q] = [p, q].map(|end| [end[0] - tip[0], end[2] - tip[2]]);
            let angle = (p[0] * q[1] - p[1] * q[0]).abs().atan2(p[0] * q[0] + p[1] * q[1]).to_degrees();
            extremes = [extremes[0].min(angle), extremes[1].max(angle)];
        }
    }
    extremes
}

fn lengths(surface: &Surface) -> [f64; 2] {
    let edges = Edges::new(surface.nodes.len(), &surface.triangles, &[]);
    let lengths = edges.pairs.iter().map(|pair| crate::topology::measure::length(&surface.nodes, *pair));
    lengths.fold([f64::INFINITY, 0.0], |[low, high], length| [low.min(length), high.max(length)])
}

/// Whether a triangle looks to +y or to −y, by twice its area.
fn upward([a, b, c]: [[f64; 2]; 3]) -> f64 {
    (b[1] - a[1]) * (c[0] - a[0]) - (b[0] - a[0]) * (c[1] - a[1])
}

/// One part without a hole that looks up everywhere and has this area [m²]; its texture coordinates are its places.
#[track_caller]
fn is_whole(surface: &Surface, area: f64) {
    let places = |triangle: &[u32; 3]| triangle.map(|node| surface.nodes[node as usize]);
    let plane = |corners: [[f64; 3]; 3]| upward(corners.map(|[x, _, z]| [x, z]));
    assert!(surface.triangles.iter().all(|triangle| plane(places(triangle)) > 0.0));
    let sum: f64 = surface.triangles.iter().map(|triangle| area_of(places(triangle))).sum();
    assert!((sum / area - 1.0).abs() < 1e-9, "{sum} m², not {area} m²");
    let edges = Edges::new(surface.nodes.len(), &surface.triangles, &[]);
    let euler = surface.nodes.len() as i64 - edges.pairs.len() as i64 + surface.triangles.len() as i64;
    assert_eq!((euler, edges.holes(), edges.non_manifold_edges(), edges.flipped), (1, 1, 0, 0));
    let uvs = surface.uvs.as_ref().unwrap();
    for (&vertex, &uv) in surface.polygons.corners.iter().zip(&uvs.corners) {
        let [x, _, z] = surface.vertices[vertex as usize];
        assert_eq!(uvs.coords[uv as usize], [x as f32, z as f32]);
    }
}

#[test]
fn a_sheet_has_straight_borders_and_equal_sides() {
    for (size, edge) in [([1.0, 0.7], 0.05), ([0.3, 0.31], 0.02), ([0.02, 1.0], 0.02), ([1.0, 0.011], 0.01)] {
        let one = shapes::surface(&Mesh::sheet(size, edge)).unwrap();
        is_whole(&one, size[0] * size[1]);
        let around = Edges::new(one.nodes.len(), &one.triangles, &[]).boundary_nodes();
        let on_border = |node: usize| {
            let [x, _, z] = one.nodes[node];
            2.0 * x.abs() == size[0] || 2.0 * z.abs() == size[1]
        };
        let expected: Vec<_> = (0..one.nodes.len()).filter(|&node| on_border(node)).collect();
        assert_eq!(around.iter().map(|&node| node as usize).collect::<Vec<_>>(), expected);
        let mut grouped: Vec<_> = one.groups.iter().flat_map(|(_, nodes)| nodes.clone()).collect();
        grouped.sort_unstable();
        grouped.dedup();
        assert_eq!(grouped, around);
    }
    // Halves of triangles have half an edge along the border, and a right angle.
    let fine = shapes::surface(&Mesh::sheet([1.0, 1.0], 0.01)).unwrap();
    let ([low, high], [short, long]) = (angles(&fine), lengths(&fine));
    assert!((29.7..30.3).contains(&low) && (89.9..90.1).contains(&high), "{low}, {high}");
    assert!((0.0049..0.0051).contains(&short) && (0.0099..0.0101).contains(&long), "{short}, {long}");
}

#[test]
fn a_sheet_of_squares_is_a_grid_with_texture_coordinates() {
    let squares = Sheet { size: [0.4, 0.3], edge: 0.11, pattern: Pattern::Grid };
    let [one, grid] =
        [Mesh::Sheet(squares), Mesh::grid(4, 5, [0.4, 0.3])].map(|m| shapes::surface(&m).unwrap());
    assert_eq!((&one.nodes, &one.triangles, &one.polygons), (&grid.nodes, &grid.triangles, &grid.polygons));
    is_whole(&one, 0.12);
}

#[test]
fn a_disc_is_round_and_its_triangles_are_well_shaped() {
    for pattern in PATTERNS {
        for tenths in (20..160).step_by(7).chain([301, 1000]) {
            let radius = 0.1 * f64::from(tenths);
            let disc = Disc { radius: 0.01 * radius, edge: 0.01, pattern };
            let one = shapes::surface(&Mesh::Disc(disc)).unwrap();
            assert_eq!(one.nodes.len() as u64, Mesh::Disc(disc).nodes());
            let rim = disc.rim() as f64;
            is_whole(&one, 0.5 * rim * (TAU / rim).sin() * disc.radius * disc.radius);
            let ([low, high], [short, long]) = (angles(&one), lengths(&one));
            let words = format!("{pattern:?}, {radius} edges: {low}° to {high}°, {short} m to {long} m");
            let most = if pattern == Pattern::Grid { 0.0166 } else { 0.0142 };
            assert!(low > 34.0 && high < 110.0 && short > 0.0072 && long < most, "{words}");
        }
    }
}

#[test]
fn the_inside_of_a_disc_is_even() {
    for (pattern, wanted) in PATTERNS.into_iter().zip([[60.0, 60.0], [45.0, 90.0]]) {
        let mut one = shapes::surface(&Mesh::Disc(Disc { radius: 0.2, edge: 0.01, pattern })).unwrap();
        let inside = |node: &u32| one.nodes[*node as usize].iter().map(|x| x * x).sum::<f64>() < 0.16 * 0.16;
        let kept: Vec<_> = one.triangles.iter().filter(|t| t.iter().all(inside)).copied().collect();
        assert!(kept.len() > one.triangles.len() / 2);
        one.triangles = kept;
        assert!(angles(&one).iter().zip(wanted).all(|(angle, wanted)| (angle - wanted).abs() < 1e-9));
    }
}
