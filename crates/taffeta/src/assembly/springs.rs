//! Springs of a body, by kind.

use crate::scene::{Internal, SceneError, Spring, Springs};
use crate::topology::measure::{length, norm, sub};
use crate::topology::struts::{given_struts, struts};
use crate::topology::{Edges, RestShape, Surface};

/// What a spring is for.
///
/// ```
/// use taffeta::scene::{Body, Mass, Mesh, Scene};
/// use taffeta::springs::SpringKind;
///
/// let cloth = Body::cloth("cloth", Mesh::grid(3, 3, [0.2, 0.2])).with_mass(Mass::Area(0.2));
/// let scene = Scene::new("").body(cloth.structural(50.0, 0.05).shear(20.0, 0.05));
/// let lists = taffeta::springs_of(&scene, 0)?;
/// let diagonals = lists.iter().filter(|list| list.kind == SpringKind::Shear);
/// assert_eq!(diagonals.map(|list| list.pairs.len()).sum::<usize>(), 8);
/// assert_eq!(SpringKind::Shear.name(), "shear");
/// # Ok::<(), taffeta::scene::SceneError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum SpringKind {
    /// Grid neighbours; edges of a mesh; links.
    Structural,
    /// Grid diagonals.
    Shear,
    /// Two apart on grids and chains; opposite corners of adjacent triangles.
    Bend,
    /// Struts inside a soft body.
    Internal,
}

impl SpringKind {
    /// Its name in scenes and outputs.
    pub fn name(self) -> &'static str {
        match self {
            Self::Structural => "structural",
            Self::Shear => "shear",
            Self::Bend => "bend",
            Self::Internal => "internal",
        }
    }

    /// Its place in a body.
    fn field(self) -> &'static str {
        match self {
            Self::Structural => "springs.structural",
            Self::Shear => "springs.shear",
            Self::Bend => "springs.bend",
            Self::Internal => "springs.internal",
        }
    }
}

/// The springs of one kind of a body.
///
/// ```
/// use taffeta::scene::{Body, Mass, Mesh, Scene};
///
/// let chain = Body::cloth("chain", Mesh::chain(2, 1.0)).with_mass(Mass::Whole(0.1)).structural(50.0, 0.05);
/// let [links] = &taffeta::springs_of(&Scene::new("").body(chain), 0)?[..] else { panic!("one list") };
/// assert_eq!(links.pairs, [[0, 1], [1, 2]]);
/// assert_eq!((&links.rest[..], links.k), (&[0.5, 0.5][..], 50.0));
/// # Ok::<(), taffeta::scene::SceneError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SpringList {
    /// What they are for.
    pub kind: SpringKind,
    /// Nodes at the ends, a < b.
    pub pairs: Vec<[u32; 2]>,
    /// Rest lengths [m].
    pub rest: Vec<f64>,
    /// Stiffness [N/m].
    pub k: f64,
    /// Damping along the spring [kg/s].
    pub d: f64,
}

/// The springs of a mesh, at rest as `rest` says; kinds that the body lacks are left out. The error's
/// path is from the body: `springs.shear`.
///
/// ```
/// use taffeta::scene::{Spring, Springs};
/// use taffeta::springs::mesh_springs;
/// use taffeta::topology::{Edges, RestShape, shapes::grid_surface};
///
/// let sheet = grid_surface(2, 2, [0.3, 0.4]);
/// let edges = Edges::new(4, &sheet.triangles, &[]);
/// let springs = Springs { structural: Some(Spring { k: 50.0, d: 0.05 }), ..Springs::default() };
/// let lists = mesh_springs(&springs, &sheet, &edges, &RestShape::of(&sheet, 1.0))?;
/// let longest = lists[0].rest.iter().copied().fold(0.0, f64::max);
/// assert!((longest - 0.5).abs() < 1e-12);
/// # Ok::<(), taffeta::scene::SceneError>(())
/// ```
pub fn mesh_springs(
    springs: &Springs,
    surface: &Surface,
    edges: &Edges,
    rest: &RestShape,
) -> Result<Vec<SpringList>, SceneError> {
    if springs.shear.is_some() {
        return Err(SceneError::new(
            SpringKind::Shear.field(),
            "only grids have diagonals; structural and bend would do on a mesh",
        ));
    }
    let mut wanted = Vec::new();
    if let Some(spring) = springs.structural {
        wanted.push((SpringKind::Structural, (edges.pairs.clone(), rest.edge_lengths(edges)), spring));
    }
    if let Some(spring) = springs.bend {
        wanted.push((SpringKind::Bend, bends(surface, edges, rest), spring));
    }
    if let Some(internal) = &springs.internal {
        let pairs = internal_pairs(internal, surface, edges, rest)?;
        wanted.push((SpringKind::Internal, pairs, Spring { k: internal.k, d: internal.d }));
    }
    let list = |(kind, (pairs, rest), Spring { k, d }): (SpringKind, Lengths, Spring)| {
        check_lengths(surface, &pairs, &rest).map_err(|message| SceneError::new(kind.field(), message))?;
        Ok(SpringList { kind, pairs, rest, k, d })
    };
    wanted.into_iter().map(list).collect()
}

/// Pairs of nodes, and the length of each at rest [m].
type Lengths = (Vec<[u32; 2]>, Vec<f64>);

/// Springs across edges, then those along links.
fn bends(surface: &Surface, edges: &Edges, rest: &RestShape) -> Lengths {
    let pairs = edges.bend_pairs(&surface.triangles, &surface.links);
    if !rest.is_given() {
        let lengths = pairs.iter().map(|pair| rest.distance(*pair)).collect();
        return (pairs, lengths);
    }
    // Triangles back to back have no bend spring; see `Edges::bend_pairs`.
    let hinges = edges.hinges(&surface.triangles).into_iter().zip(rest.hinges(edges));
    let across = hinges.filter(|([_, _, left, right], _)| left != right);
    let mut lengths: Vec<f64> = across.map(|(_, [_, _, left, right])| norm(sub(right, left))).collect();
    lengths.extend(pairs[lengths.len()..].iter().map(|pair| rest.distance(*pair)));
    (pairs, lengths)
}

fn internal_pairs(
    wish: &Internal,
    surface: &Surface,
    edges: &Edges,
    rest: &RestShape,
) -> Result<Lengths, SceneError> {
    let field = SpringKind::Internal.field();
    let refuse = |message: String| SceneError::new(field, message);
    let places = rest.nodes().ok_or_else(|| {
        refuse(
            "struts need one place at rest for each node, and the rest shape has seams: its corners at a node lie \
             apart; a rest shape without seams would do"
                .into(),
        )
    })?;
    let pairs = match (&wish.pairs, &wish.file) {
        (Some(pairs), _) => given_struts(pairs, surface)
            .map_err(|(index, message)| SceneError::new(format!("{field}.pairs[{index}]"), message))?,
        (None, Some(file)) => {
            let message =
                format!("`{file}` is a file, which the engine does not read; taffeta_io::load_scene does");
            return Err(refuse(message));
        }
        (None, None) => struts(&places, &surface.triangles, edges, wish.count, wish.seed).map_err(refuse)?,
    };
    let lengths = pairs.iter().map(|pair| length(&places, *pair)).collect();
    Ok((pairs, lengths))
}

/// Refuses a spring without a length at rest: it has no direction either.
fn check_lengths(surface: &Surface, pairs: &[[u32; 2]], rest: &[f64]) -> Result<(), String> {
    match rest.iter().position(|l| !l.is_normal()) {
        None => Ok(()),
        Some(i) => {
            let [a, b] = pairs[i].map(|node| surface.first_vertex_of(node));
            Err(format!("the spring between vertices {a} and {b} has no length; vertices apart would do"))
        }
    }
}

/// Share of its rest length beyond which a spring's start is worth a warning; the inverse of it, for edges pressed.
const FAR: f64 = 2.0;

/// A warning if springs start far from their rest lengths, as where two files differ in their unit. `nodes`: places
/// at the start [m]. Only edges count as pressed: cloth that starts folded has short bend springs.
///
/// ```
/// use taffeta::scene::{Body, Mass, Mesh, Scene};
/// use taffeta::springs::start_warning;
///
/// // Links of half a metre, whose nodes start where a file of centimetres has them.
/// let chain = Body::cloth("chain", Mesh::chain(2, 1.0)).with_mass(Mass::Whole(0.1)).structural(50.0, 0.05);
/// let links = taffeta::springs_of(&Scene::new("").body(chain), 0)?;
/// let places = [-50.0, 0.0, 50.0].map(|x| [x, 0.0, 0.0]);
/// let warning = start_warning(&links, &places).expect("all are stretched");
/// assert!(warning.starts_with("2 springs start (100.0 % of 2) at more than"), "{warning}");
/// assert_eq!(start_warning(&links, &places.map(|place| place.map(|x| 0.01 * x))), None);
/// # Ok::<(), taffeta::scene::SceneError>(())
/// ```
pub fn start_warning(lists: &[SpringList], nodes: &[[f64; 3]]) -> Option<String> {
    let (mut all, mut stretched, mut pressed) = (0_usize, 0_usize, 0_usize);
    let (mut longest, mut shortest) = (1.0_f64, 1.0_f64);
    for list in lists {
        for (pair, rest) in list.pairs.iter().zip(&list.rest) {
            let stretch = length(nodes, *pair) / rest;
            all += 1;
            stretched += usize::from(stretch > FAR);
            longest = longest.max(stretch);
            if list.kind == SpringKind::Structural {
                pressed += usize::from(stretch < 1.0 / FAR);
                shortest = shortest.min(stretch);
            }
        }
    }
    let tell = |count: usize, how: &str, most: f64| {
        let springs = if count == 1 { "spring starts" } else { "springs start" };
        let share = 100.0 * count as f64 / all as f64;
        (count > 0).then(|| {
            format!(
                "{count} {springs} ({share:.1} % of {all}) at {how} the rest length, one at {most:.3} times"
            )
        })
    };
    let tells = [tell(stretched, "more than twice", longest), tell(pressed, "less than half", shortest)];
    let tells: Vec<String> = tells.into_iter().flatten().collect();
    let remedy = "a rest shape of the same unit and size as the mesh would start calmer";
    (!tells.is_empty()).then(|| format!("{}; {remedy}", tells.join("; ")))
}

/// Number of springs of a grid, by kind.
///
/// ```
/// use taffeta::springs::{GridCounts, grid_counts};
///
/// // A single row is a chain.
/// assert_eq!(grid_counts(1, 5), GridCounts { structural: 4, shear: 0, bend: 3 });
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GridCounts {
    /// Neighbours: R(C−1) + C(R−1).
    pub structural: u64,
    /// Diagonals: 2(R−1)(C−1).
    pub shear: u64,
    /// Two apart: R(C−2) + C(R−2).
    pub bend: u64,
}

/// Number of springs of a grid of `rows` × `cols` nodes, by kind.
///
/// ```
/// use taffeta::springs::grid_counts;
///
/// let sheet = grid_counts(32, 32);
/// assert_eq!((sheet.structural, sheet.shear, sheet.bend), (1984, 1922, 1920));
/// ```
pub fn grid_counts(rows: u32, cols: u32) -> GridCounts {
    let [r, c] = [rows, cols].map(u64::from);
    let less = u64::saturating_sub;
    GridCounts {
        structural: r * less(c, 1) + c * less(r, 1),
        shear: 2 * less(r, 1) * less(c, 1),
        bend: r * less(c, 2) + c * less(r, 2),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Body, Cube, Mesh};
    use crate::topology::shapes;

    fn of(mesh: Mesh, springs: &Springs, scale: f64) -> Result<Vec<SpringList>, SceneError> {
        let surface = shapes::surface(&mesh).unwrap();
        let edges = Edges::new(surface.nodes.len(), &surface.triangles, &surface.links);
        mesh_springs(springs, &surface, &edges, &RestShape::of(&surface, scale))
    }

    #[test]
    fn grids_have_the_numbers_of_springs_of_the_paper() {
        let all = |n: GridCounts| n.structural + n.shear + n.bend;
        assert_eq!(all(grid_counts(32, 32)), 5826);
        assert_eq!(all(grid_counts(34, 34)), 6598);
        let without_bend = |n: GridCounts| n.structural + n.shear;
        assert_eq!(without_bend(grid_counts(38, 38)), 5550);
        assert_eq!(without_bend(grid_counts(32, 32)), 3906);
        assert_eq!(grid_counts(1, 5), GridCounts { structural: 4, shear: 0, bend: 3 });
        assert_eq!(grid_counts(1, 1), GridCounts { structural: 0, shear: 0, bend: 0 });
    }

    #[test]
    fn the_cube_of_the_paper_has_1777_springs() {
        let mut body =
            Body::soft("cube", Mesh::Cube(Cube { size: 2.0, divisions: 8 })).structural(1000.0, 1.0);
        body.springs.internal = Some(Internal { count: 625, k: 500.0, d: 2.0, ..Internal::default() });
        let lists = of(body.mesh, &body.springs, 0.5).unwrap();
        assert_eq!(lists.iter().map(|list| list.pairs.len()).sum::<usize>(), 1777);
        assert_eq!(lists.iter().map(|list| list.kind.name()).collect::<Vec<_>>(), ["structural", "internal"]);
        assert_eq!((lists[1].k, lists[1].d), (500.0, 2.0));
        let [shortest, longest] =
            [f64::min, f64::max].map(|f| lists[0].rest.iter().copied().reduce(f).unwrap());
        assert!((shortest - 0.125).abs() < 1e-15 && (longest - 0.125 * 2f64.sqrt()).abs() < 1e-15);
    }

    #[test]
    fn a_chain_has_links_and_bends() {
        let springs = Body::cloth("c", Mesh::chain(4, 2.0)).structural(1.0, 0.0).bend(1.0, 0.0).springs;
        let lists = of(Mesh::chain(4, 2.0), &springs, 1.0).unwrap();
        assert_eq!(lists[0].rest, [0.5; 4]);
        assert_eq!((lists[1].pairs.len(), lists[1].rest[0]), (3, 1.0));
    }

    #[test]
    fn springs_that_cannot_be_are_refused_by_name() {
        let cube = || Mesh::Cube(Cube { size: 1.0, divisions: 1 });
        let shear = Springs { shear: Some(Spring::default()), ..Springs::default() };
        assert_eq!(of(cube(), &shear, 1.0).unwrap_err().path, "springs.shear");
        let file = Internal { file: Some("s.txt".into()), ..Internal::default() };
        let file = Springs { internal: Some(file), ..Springs::default() };
        assert!(of(cube(), &file, 1.0).unwrap_err().message.contains("`s.txt` is a file"));
        let folded = Surface {
            nodes: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 1.0]],
            triangles: vec![[0, 1, 2], [1, 0, 3]],
            node_of_vertex: Some(vec![3, 0, 1, 2]),
            ..Surface::default()
        };
        let edges = Edges::new(4, &folded.triangles, &[]);
        let bend = Springs { bend: Some(Spring::default()), ..Springs::default() };
        let error = mesh_springs(&bend, &folded, &edges, &RestShape::of(&folded, 1.0)).unwrap_err();
        assert_eq!(error.path, "springs.bend");
        assert!(error.message.contains("vertices 3 and 0"), "{error}");
        let pairs = Internal { pairs: Some(vec![[0, 7], [3, 8]]), ..Internal::default() };
        let pairs = Springs { internal: Some(pairs), ..Springs::default() };
        assert_eq!(of(cube(), &pairs, 1.0).unwrap_err().path, "springs.internal.pairs[1]");
    }
}
