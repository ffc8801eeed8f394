//! The exclusion lists of self-collision, and warnings of contacts at the start.

use crate::assembly::Assembly;
use crate::assembly::body::{BodyAssembly, BodySprings};
use crate::contact::nodes::cells::Cells;
use crate::contact::nodes::pair::{ContactMaterial, combine_materials};
use crate::contact::nodes::self_contact::{Exclusions, GAP, SelfContact};
use crate::real::{hypot, norm, sub};
use crate::scene::{Scene, SceneError, SelfCollision, plain};
use crate::topology::{Csr, measure};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Most nodes on an exclusion list.
const MAX_EXCLUSIONS: usize = 1024;

impl BodyAssembly {
    /// Enables self-collision of the body, whose springs are known.
    pub(crate) fn enable_self_collision(&mut self, wish: &SelfCollision) -> Result<(), SceneError> {
        let exclusions = exclusions(self, wish.thickness, "self_collision.thickness")?;
        let edges = edges(self);
        let lengths = || edges.iter().map(|pair| measure::length(&self.start, *pair));
        let longest = lengths().fold(0.0, f64::max);
        if wish.thickness < GAP * longest {
            self.warnings.push(format!(
                "self_collision.thickness is {} m, less than 0.71 times its longest edge of {longest:.4} m: nodes of another \
                 layer can pass between its own; {:.4} m, and more where it stretches, or a finer mesh would do",
                plain(wish.thickness),
                GAP * longest
            ));
        }
        let surface = ContactMaterial {
            thickness: wish.thickness,
            friction: wish.friction,
            restitution: wish.restitution,
        };
        self.extensions.insert(SelfContact { surface, exclusions, longest });
        Ok(())
    }
}

/// Nodes of a body that are neighbours along its surface: closer than the length of a fold whose layers are a thickness apart.
pub(crate) fn exclusions(body: &BodyAssembly, thickness: f64, key: &str) -> Result<Exclusions, SceneError> {
    let reach = std::f64::consts::FRAC_PI_2 * thickness;
    let edges = edges(body);
    let found = match body.grid_layout {
        Some(layout) => of_grid(body, layout, reach),
        None => of_mesh(body, &edges, reach),
    };
    found.ok_or_else(|| {
        let length = edges.iter().map(|pair| measure::length(&body.start, *pair)).sum::<f64>();
        too_thick(key, thickness, length / edges.len().max(1) as f64)
    })
}

fn too_thick(key: &str, thickness: f64, edge: f64) -> SceneError {
    SceneError::new(
        key,
        format!(
            "is {} m, and nodes are {edge:.2e} m from their neighbours: a node would have over {MAX_EXCLUSIONS} neighbours \
             within the thickness; {:.2e} m, or a coarser mesh would do",
            plain(thickness),
            8.0 * edge
        ),
    )
}

/// Edges of the surface by the solver's nodes. A grid has one along each side, since all are alike.
fn edges(body: &BodyAssembly) -> Vec<[u32; 2]> {
    match (body.grid_layout, &body.edges) {
        (Some([rows, cols]), _) => {
            let sides = [(rows, [0, cols as u32]), (cols, [0, 1])];
            sides.into_iter().filter(|(count, _)| *count > 1).map(|(_, pair)| pair).collect()
        }
        (None, Some(edges)) => {
            edges.pairs.iter().map(|pair| pair.map(|node| body.solver_local(node as usize) as u32)).collect()
        }
        (None, None) => Vec::new(),
    }
}

/// The exclusion lists of a grid. `None`: they are too long.
fn of_grid(body: &BodyAssembly, [rows, cols]: [usize; 2], reach: f64) -> Option<Exclusions> {
    let between = |a: usize, b: usize| norm(sub(body.start[b], body.start[a]));
    let down = if rows > 1 { between(0, cols) } else { 0.0 };
    let across = if cols > 1 { between(0, 1) } else { 0.0 };
    let BodySprings::Grid(along) = &body.springs else { return None };
    // Offsets of springs, as [`crate::assembly::body::GridDirections`].
    let springs = [[0, 1], [0, 2], [1, 0], [2, 0], [1, 1], [1, -1]];
    let springs: Vec<[i32; 2]> =
        springs.iter().zip(along).filter(|(_, one)| one.is_some()).map(|(way, _)| *way).collect();
    let most = |spacing: f64, count: usize| {
        let nodes = if spacing > 0.0 { (reach / spacing).ceil() } else { 0.0 };
        nodes.max(2.0).min(count as f64 - 1.0)
    };
    let (high, wide) = (most(down, rows), most(across, cols));
    if (2.0 * high + 1.0) * (2.0 * wide + 1.0) > 4.0 * MAX_EXCLUSIONS as f64 {
        return None;
    }
    let (high, wide) = (high as i32, wide as i32);
    let is_excluded = |way: [i32; 2]| {
        let edge = way[0].abs() <= 1 && way[1].abs() <= 1;
        let near = hypot(f64::from(way[0]) * down, f64::from(way[1]) * across) < reach;
        edge || near || springs.contains(&way) || springs.contains(&way.map(|n| -n))
    };
    let ways = (-high..=high).flat_map(|row| (-wide..=wide).map(move |col| [row, col]));
    let ways: Vec<[i32; 2]> = ways.filter(|&way| way != [0, 0] && is_excluded(way)).collect();
    (ways.len() <= MAX_EXCLUSIONS).then_some(Exclusions::Grid(ways))
}

/// The exclusion lists of a mesh with these edges.
fn of_mesh(body: &BodyAssembly, edges: &[[u32; 2]], reach: f64) -> Option<Exclusions> {
    let mut pairs = edges.to_vec();
    // Several nodes at one point of the surface.
    pairs.extend(body.split.iter().map(|pair| pair.map(|node| body.solver_local(node as usize) as u32)));
    let BodySprings::Mesh(lists) = &body.springs else { return None };
    let by_node = Csr::corners(body.nodes, &pairs);
    let by_spring: Vec<Csr> = lists.iter().map(|list| Csr::corners(body.nodes, &list.pairs)).collect();
    let other = |pairs: &[[u32; 2]], end: u32| pairs[end as usize / 2][1 - end as usize % 2];
    let mut walk = Walk::new(body.nodes);
    let (mut offsets, mut items) = (vec![0], Vec::new());
    for node in 0..body.nodes {
        let from = items.len();
        walk.within(node as u32, reach, &mut items, |node| {
            let (pairs, by_node) = (&pairs, &by_node);
            by_node.row(node as usize).iter().map(move |&end| {
                let next = other(pairs, end);
                (next, measure::length(&body.start, [node, next]))
            })
        });
        items.extend(by_node.row(node).iter().map(|&end| other(&pairs, end)));
        for (list, rows) in lists.iter().zip(&by_spring) {
            items.extend(rows.row(node).iter().map(|&end| other(&list.pairs, end)));
        }
        items[from..].sort_unstable();
        let mut kept = from;
        for i in from..items.len() {
            if items[i] != node as u32 && (kept == from || items[kept - 1] != items[i]) {
                items[kept] = items[i];
                kept += 1;
            }
        }
        items.truncate(kept);
        if kept - from > MAX_EXCLUSIONS {
            return None;
        }
        offsets.push(u32::try_from(items.len()).ok()?);
    }
    Some(Exclusions::Mesh(Csr { offsets, items }))
}

/// Shortest paths along edges from one node after another (Dijkstra 1959).
struct Walk {
    way: Vec<f64>,
    queue: BinaryHeap<Reverse<(u64, u32)>>,
}

impl Walk {
    fn new(nodes: usize) -> Self {
        Self { way: vec![f64::INFINITY; nodes], queue: BinaryHeap::new() }
    }

    /// Adds the nodes closer than `reach` [m], and the node itself. Stops if there are too many.
    fn within<I: Iterator<Item = (u32, f64)>>(
        &mut self,
        node: u32,
        reach: f64,
        found: &mut Vec<u32>,
        edges: impl Fn(u32) -> I,
    ) {
        let from = found.len();
        let mut seen = vec![node];
        self.way[node as usize] = 0.0;
        self.queue.push(Reverse((0, node)));
        while let Some(Reverse((bits, node))) = self.queue.pop() {
            // Bits of positive numbers have the order of the numbers.
            let way = f64::from_bits(bits);
            if way > self.way[node as usize] || found.len() - from > MAX_EXCLUSIONS {
                continue;
            }
            found.push(node);
            for (next, length) in edges(node) {
                let on = way + length;
                if on < reach && on < self.way[next as usize] {
                    self.way[next as usize] = on;
                    seen.push(next);
                    self.queue.push(Reverse((on.to_bits(), next)));
                }
            }
        }
        seen.iter().for_each(|&node| self.way[node as usize] = f64::INFINITY);
    }
}

impl Assembly {
    /// Self-colliding bodies, with their surfaces.
    pub fn self_colliding(&self) -> impl Iterator<Item = (&BodyAssembly, &SelfContact)> {
        self.bodies.iter().filter_map(|body| Some((body, body.self_contact()?)))
    }

    /// Warns of nodes that start closer than the thickness, and refuses one that has too many nodes within it.
    pub(crate) fn note_close_nodes(&mut self, scene: &Scene) -> Result<(), SceneError> {
        let found = StartContacts::find(self).map_err(|TooMany| {
            self.too_crowded(scene, |body| Some((body.self_contact()?.surface.thickness, None)), false)
        })?;
        let Some(found) = found else { return Ok(()) };
        let [(a, i), (b, j)] = found.worst.map(|(body, local)| (&self.bodies[body], local));
        let (first, second) = (a.vertex_of_solver(i), b.vertex_of_solver(j));
        let words = format!(
            "{} pairs of nodes start nearer than self_collision.thickness, worst of all vertex {first} here and vertex \
             {second} of `{}`, {:.3e} m apart instead of {:.3e}; they will be moved apart",
            found.pairs, b.name, found.distance, found.thickness
        );
        self.bodies[found.worst[0].0].warnings.push(words);
        Ok(())
    }
}

/// Nodes that start closer than the thickness.
struct StartContacts {
    pairs: u64,
    /// Body and node of the closest pair, relative to its thickness.
    worst: [(usize, usize); 2],
    distance: f64,
    thickness: f64,
}

/// Most pairs of nodes that are looked at, for each node and besides: at ten thousand nodes about a second's work.
const LOOKS: [u64; 2] = [8 * MAX_EXCLUSIONS as u64, 1 << 28];

/// There are more.
struct TooMany;

impl StartContacts {
    fn find(assembly: &Assembly) -> Result<Option<Self>, TooMany> {
        let widest = assembly
            .self_colliding()
            .map(|(_, self_contact)| self_contact.surface.thickness)
            .fold(0.0, f64::max);
        let nodes: Vec<(usize, usize)> = (assembly.bodies.iter().enumerate())
            .filter(|(_, body)| body.self_contact().is_some())
            .flat_map(|(index, body)| (0..body.nodes).map(move |local| (index, local)))
            .collect();
        let place = |&(body, local): &(usize, usize)| assembly.bodies[body].start[local];
        if nodes.is_empty() {
            return Ok(None);
        }
        let surfaces: Vec<Option<&ContactMaterial<f64>>> =
            assembly.bodies.iter().map(|body| Some(&body.self_contact()?.surface)).collect();
        let meetings = assembly.meetings();
        let cells = Cells::new(nodes.len(), widest);
        let bucket = |node: &(usize, usize)| cells.bucket(cells.cell(place(node))) as u32;
        let rows = Csr::new(cells.buckets(), nodes.iter().map(bucket).zip(0..));
        let around = |node: &(usize, usize)| {
            cells.around(cells.cell(place(node))).flatten().map(|bucket| rows.row(bucket))
        };
        // Counted before any of them is looked at, so that millimetres for metres are refused at once.
        let looks: u64 = nodes.iter().flat_map(around).map(|row| row.len() as u64).sum();
        if looks > LOOKS[1] + LOOKS[0] * nodes.len() as u64 {
            return Err(TooMany);
        }
        let mut found = Self { pairs: 0, worst: [(0, 0); 2], distance: f64::INFINITY, thickness: 1.0 };
        for (i, node) in nodes.iter().enumerate() {
            let (body, x) = (&assembly.bodies[node.0], place(node));
            let Some(own) = body.self_contact() else { continue };
            let touches = |&j: &u32| {
                let other = &nodes[j as usize];
                let Some(surface) = surfaces[other.0] else { return false };
                let thickness = combine_materials(&own.surface, surface).thickness;
                j as usize > i && meetings.bodies(node.0, other.0) && norm(sub(place(other), x)) < thickness
            };
            let mut near: Vec<u32> = around(node).flatten().copied().filter(touches).collect();
            near.sort_unstable();
            near.dedup();
            own.exclusions.each(body.grid_layout, node.1, |other| {
                near.retain(|&j| nodes[j as usize] != (node.0, other));
            });
            let index = |j: u32| assembly.bodies[nodes[j as usize].0].first + nodes[j as usize].1;
            let sewn: Vec<usize> = assembly.attachments().exclusions(body.first + node.1).collect();
            near.retain(|&j| sewn.binary_search(&index(j)).is_err());
            for other in near.iter().map(|&j| nodes[j as usize]) {
                let Some(self_contact) = assembly.bodies[other.0].self_contact() else { continue };
                let thickness = combine_materials(&own.surface, &self_contact.surface).thickness;
                let distance = norm(sub(place(&other), x));
                found.pairs += 1;
                if distance * found.thickness < found.distance * thickness {
                    (found.worst, found.distance, found.thickness) = ([*node, other], distance, thickness);
                }
            }
        }
        Ok((found.pairs > 0).then_some(found))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Body, Icosphere, Mass, Mesh};

    fn assembly(mesh: Mesh, thickness: f64) -> Result<Assembly, SceneError> {
        let body =
            Body::cloth("cloth", mesh).with_mass(Mass::Node(0.1)).structural(10.0, 0.0).shear(10.0, 0.0);
        Assembly::new(&Scene::new("").body(body.collide_nodes(thickness)).time(0.01, 0.001))
    }

    fn excluded(assembly: &Assembly, local: usize) -> Vec<usize> {
        let (body, self_contact) = assembly.self_colliding().next().unwrap();
        let mut nodes = Vec::new();
        self_contact.exclusions.each(body.grid_layout, local, |node| nodes.push(node));
        nodes.sort_unstable();
        nodes
    }

    #[test]
    fn nodes_of_a_grid_do_not_touch_neighbours_and_what_is_around_a_fold() {
        let grid = || Mesh::grid(9, 7, [0.6, 0.8]);
        let thin = assembly(grid(), 0.01).unwrap();
        assert_eq!(excluded(&thin, 0), [1, 7, 8]);
        assert_eq!(excluded(&thin, 10), [2, 3, 4, 9, 11, 16, 17, 18]);
        // 0.15 m around: those one and a half spacings of 0.1 m away.
        let thick = assembly(grid(), 0.15 / 1.57).unwrap();
        assert_eq!(excluded(&thick, 31), [23, 24, 25, 30, 32, 37, 38, 39]);
        let thicker = assembly(grid(), 0.23 / 1.57).unwrap();
        assert_eq!(excluded(&thicker, 31).len(), 8 + 4 + 8);
        assert!(
            assembly(Mesh::grid(99, 99, [1.0, 1.0]), 0.3).err().unwrap().message.contains("; 8.16e-2 m, or")
        );
    }

    #[test]
    fn nodes_of_a_mesh_do_not_touch_neighbours_and_what_is_around_a_fold() {
        let ball = |thickness| {
            let mesh = Mesh::Icosphere(Icosphere { radius: 1.0, subdivisions: 3 });
            let body = Body::soft("ball", mesh).with_mass(Mass::Node(0.1)).structural(10.0, 0.0);
            Assembly::new(&Scene::new("").body(body.collide_nodes(thickness)).time(0.01, 0.001)).unwrap()
        };
        let of = |assembly: &Assembly| (0..642).map(|i| excluded(assembly, i).len()).collect::<Vec<_>>();
        // Edges are 0.138 m to 0.165 m long.
        assert!(of(&ball(0.05)).iter().all(|&n| n == 5 || n == 6));
        let wide = of(&ball(0.36 / 1.57));
        assert!(wide.iter().all(|&n| (15..=18).contains(&n)), "{wide:?}");
        let far = ball(0.36 / 1.57);
        let mirrored = (0..642).all(|i| excluded(&far, i).iter().all(|&j| excluded(&far, j).contains(&i)));
        assert!(mirrored);
    }

    #[test]
    fn sheets_that_start_in_contact_are_told() {
        let sheet = |name: &str, y: f64| {
            let body = Body::cloth(name, Mesh::grid(11, 11, [1.0, 1.0])).with_mass(Mass::Node(0.1));
            body.structural(10.0, 0.0).collide_nodes(0.09).at([0.0, y, 0.0])
        };
        let warnings = |y: f64| {
            let scene = Scene::new("").body(sheet("low", 0.0)).body(sheet("high", y)).time(0.01, 0.001);
            Assembly::new(&scene).unwrap().bodies[0].warnings.join("\n")
        };
        let told = warnings(0.05);
        assert!(told.contains("121 pairs") && told.contains("of `high`, 5.000e-2 m apart"), "{told}");
        assert_eq!(warnings(0.091), "");
    }

    #[test]
    fn a_thickness_through_which_nodes_slip_is_told() {
        let warnings = |thickness| {
            assembly(Mesh::grid(11, 11, [1.0, 1.0]), thickness).unwrap().bodies[0].warnings.join("")
        };
        assert!(warnings(0.07).contains("0.0710 m"), "{}", warnings(0.07));
        assert_eq!(warnings(0.0711), "");
    }
}
