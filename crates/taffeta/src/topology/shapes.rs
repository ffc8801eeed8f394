//! Shapes by name: the surface of each [`Mesh`], vertices = nodes, triangles counter-clockwise from outside.

mod flat;
mod round;
mod sheet;

pub use flat::grid_surface;

use crate::scene::{Mesh, check_shape};
use crate::topology::{Polygons, Surface};

/// The surface of a mesh, its sizes checked.
///
/// ```
/// use taffeta::scene::{Icosphere, Mesh};
/// use taffeta::topology::shapes;
///
/// let ball = shapes::surface(&Mesh::Icosphere(Icosphere { radius: 0.1, subdivisions: 2 }))?;
/// assert_eq!((ball.nodes.len(), ball.triangles.len()), (162, 320));
/// assert!(shapes::surface(&Mesh::chain(0, 1.0)).unwrap_err().starts_with("mesh.chain.links: is 0"));
/// # Ok::<(), String>(())
/// ```
pub fn surface(mesh: &Mesh) -> Result<Surface, String> {
    check_shape(mesh).map_err(|(field, message)| format!("{field}: {message}"))?;
    Ok(match mesh {
        Mesh::Grid(grid) => grid_surface(grid.rows, grid.cols, grid.size),
        Mesh::Sheet(one) => sheet::sheet(*one),
        Mesh::Disc(disc) => sheet::disc(*disc),
        Mesh::Icosphere(ball) => round::icosphere(*ball),
        Mesh::UvSphere(ball) => round::uv_sphere(*ball),
        Mesh::Torus(torus) => round::torus(*torus),
        Mesh::Cube(cube) => flat::cube(*cube),
        Mesh::Cylinder(cylinder) => round::cylinder(*cylinder),
        Mesh::Chain(chain) => flat::chain(*chain),
        Mesh::Surface(surface) => Surface::clone(surface),
        Mesh::File(name) => {
            return Err(format!(
                "`{name}` is a file, which the engine does not read; taffeta_io::load_scene does"
            ));
        }
    })
}

/// A surface of faces with three corners or four; a quad is cut along its second diagonal: (0 1 3), (3 1 2).
fn from_faces(vertices: Vec<[f64; 3]>, faces: impl Iterator<Item = Vec<u32>>) -> Surface {
    let mut polygons = Polygons::default();
    let mut triangles = Vec::new();
    for face in faces {
        polygons.push(&face);
        match *face {
            [a, b, c] => triangles.push([a, b, c]),
            [a, b, c, d] => triangles.extend([[a, b, d], [d, b, c]]),
            _ => unreachable!("shapes are made of triangles and quads"),
        }
    }
    Surface { nodes: vertices.clone(), vertices, polygons, triangles, ..Surface::default() }
}

/// A row of nodes, each linked to the next.
fn from_chain(vertices: Vec<[f64; 3]>) -> Surface {
    let links = (1..vertices.len() as u32).map(|i| [i - 1, i]).collect();
    Surface { nodes: vertices.clone(), vertices, links, ..Surface::default() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Body, Cube, Cylinder, Disc, Icosphere, Mass, Pattern, Scene, Torus, UvSphere};
    use crate::topology::{Edges, measure::volume};
    use std::f64::consts::PI;
    use std::sync::Arc;

    /// Volume and Euler characteristic of a closed shape.
    fn facts(mesh: Mesh) -> (f64, i64) {
        let surface = surface(&mesh).unwrap();
        let [v, f] = [surface.nodes.len(), surface.triangles.len()];
        let edges = Edges::new(v, &surface.triangles, &surface.links);
        assert!(edges.is_closed(), "{mesh:?}");
        assert_eq!(surface.vertices, surface.nodes);
        (volume(&surface.nodes, &surface.triangles), v as i64 - edges.pairs.len() as i64 + f as i64)
    }

    #[test]
    fn icospheres_have_the_volumes_of_the_reference() {
        for (subdivisions, expected) in [(2, 4.047045), (3, 4.152741), (4, 4.179739)] {
            let (volume, euler) = facts(Mesh::Icosphere(Icosphere { radius: 1.0, subdivisions }));
            assert!((volume - expected).abs() < 1e-6, "{subdivisions}: {volume}");
            assert_eq!(euler, 2);
        }
    }

    #[test]
    fn a_torus_has_the_volume_of_the_reference_and_a_hole() {
        let (volume, euler) = facts(Mesh::Torus(Torus { major: 1.0, minor: 0.25, rings: 96, segments: 24 }));
        assert!((volume - 1.218785).abs() < 1e-6, "{volume}");
        assert_eq!(euler, 0);
    }

    #[test]
    fn the_cube_of_eight_divisions_is_the_one_of_the_paper() {
        let mesh = Mesh::Cube(Cube { size: 2.0, divisions: 8 });
        let surface = surface(&mesh).unwrap();
        assert_eq!((surface.nodes.len(), surface.triangles.len(), surface.polygons.len()), (386, 768, 384));
        assert_eq!(Edges::new(386, &surface.triangles, &[]).pairs.len(), 1152);
        let (volume, euler) = facts(mesh);
        assert!((volume - 8.0).abs() < 1e-12, "{volume}");
        assert_eq!(euler, 2);
    }

    #[test]
    fn smallest_shapes_are_closed_and_the_right_way_round() {
        let (cube, euler) = facts(Mesh::Cube(Cube { size: 1.0, divisions: 1 }));
        assert!((cube - 1.0).abs() < 1e-15 && euler == 2);
        let (octahedron, euler) = facts(Mesh::UvSphere(UvSphere { radius: 1.0, rings: 2, segments: 4 }));
        assert!((octahedron - 4.0 / 3.0).abs() < 1e-15 && euler == 2, "{octahedron}");
        let prism = Cylinder { radius: 1.0, height: 2.0, segments: 4, rings: 1, capped: true };
        let (prism, euler) = facts(Mesh::Cylinder(prism));
        assert!((prism - 4.0).abs() < 1e-14 && euler == 2, "{prism}");
        assert!(facts(Mesh::Torus(Torus { major: 1.0, minor: 0.5, rings: 3, segments: 3 })).0 > 0.0);
        assert_eq!(facts(Mesh::Icosphere(Icosphere { radius: 1.0, subdivisions: 0 })).1, 2);
    }

    #[test]
    fn finer_round_shapes_approach_the_true_volume() {
        let (ball, _) = facts(Mesh::UvSphere(UvSphere { radius: 2.0, rings: 200, segments: 400 }));
        assert!((ball / (32.0 / 3.0 * PI) - 1.0).abs() < 2e-4, "{ball}");
        let can = Cylinder { radius: 0.5, height: 3.0, segments: 400, rings: 4, capped: true };
        let (can, _) = facts(Mesh::Cylinder(can));
        assert!((can / (0.75 * PI) - 1.0).abs() < 1e-4, "{can}");
    }

    #[test]
    fn a_file_that_is_still_a_name_says_who_reads_it() {
        assert!(surface(&Mesh::File("a.obj".into())).unwrap_err().contains("`a.obj` is a file"));
        assert!(surface(&Mesh::chain(0, 1.0)).unwrap_err().starts_with("mesh.chain.links: is 0"));
    }

    #[test]
    fn an_open_cylinder_has_two_holes_and_its_bands_are_quads() {
        let tube = Cylinder { radius: 1.0, height: 1.0, segments: 12, rings: 3, capped: false };
        let surface = surface(&Mesh::Cylinder(tube)).unwrap();
        assert_eq!((surface.nodes.len(), surface.polygons.len(), surface.triangles.len()), (48, 36, 72));
        assert!(surface.polygons.iter().all(|face| face.len() == 4));
        let edges = Edges::new(48, &surface.triangles, &[]);
        assert_eq!((edges.holes(), edges.boundary_edges()), (2, 24));
    }

    #[test]
    fn the_number_of_nodes_is_known_before_a_shape_is_made() {
        let can =
            |capped| Mesh::Cylinder(Cylinder { radius: 1.0, height: 1.0, segments: 5, rings: 3, capped });
        for mesh in [
            Mesh::grid(3, 4, [1.0; 2]),
            Mesh::chain(7, 1.0),
            Mesh::Icosphere(Icosphere { radius: 1.0, subdivisions: 2 }),
            Mesh::UvSphere(UvSphere { radius: 1.0, rings: 4, segments: 7 }),
            Mesh::Torus(Torus { major: 1.0, minor: 0.5, rings: 4, segments: 7 }),
            Mesh::Cube(Cube { size: 1.0, divisions: 3 }),
            can(true),
            can(false),
            Mesh::sheet([1.0, 0.5], 0.1),
            Mesh::sheet([0.3, 0.55], 0.1),
            Mesh::Disc(Disc { radius: 0.3, edge: 0.05, pattern: Pattern::Equilateral }),
            Mesh::Disc(Disc { radius: 0.3, edge: 0.05, pattern: Pattern::Grid }),
        ] {
            assert_eq!(mesh.nodes(), surface(&mesh).unwrap().nodes.len() as u64, "{mesh:?}");
        }
    }

    #[test]
    fn a_shape_and_the_same_as_data_need_about_the_same_memory() {
        for shape in [Mesh::Cube(Cube { size: 1.0, divisions: 50 }), Mesh::sheet([1.0, 1.0], 0.01)] {
            let data = Mesh::Surface(Arc::new(surface(&shape).unwrap()));
            let body = |mesh| Body::cloth("body", mesh).with_mass(Mass::Node(1.0)).structural(1.0, 0.0);
            let [shape, data] =
                [shape, data].map(|mesh| Scene::new("").body(body(mesh)).memory_needed().bytes as f64);
            assert!((data / shape - 1.0).abs() < 0.05, "{data} and {shape}");
        }
    }
}
