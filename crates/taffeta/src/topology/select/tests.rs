use crate::topology::select::*;
use crate::topology::shapes::grid_surface;

fn grid(surface: &Surface) -> Selectable<'_> {
    let nodes = &surface.nodes;
    let groups = &surface.groups;
    let vertices = nodes.len();
    Selectable { nodes, vertices, node_of_vertex: None, split: &[], groups, grid: Some([3, 4]), edges: None }
}

#[track_caller]
fn refused(wish: Select, body: &Selectable, field: &str, words: &str) {
    let (at, message) = select(&wish, body).unwrap_err();
    assert!(at == field && message.contains(words), "{at}: {message}");
}

#[test]
fn keys_intersect() {
    let surface = grid_surface(3, 4, [3.0, 2.0]);
    let body = grid(&surface);
    let rows = Select::rows(0, 1);
    assert_eq!(select(&rows, &body).unwrap(), [0, 1, 2, 3, 4, 5, 6, 7]);
    assert_eq!(select(&Select { cols: Some([3, 3]), ..rows.clone() }, &body).unwrap(), [3, 7]);
    assert_eq!(select(&Select { nodes: Some(vec![9, 7, 0, 7]), ..rows }, &body).unwrap(), [0, 7]);
    let bounds = Bounds { min: [-0.5, 0.0, -1.0], max: [0.5, 0.0, 0.0] };
    let boxed = Select { inside: Some(bounds), ..Select::default() };
    assert_eq!(select(&boxed, &body).unwrap(), [1, 2, 5, 6]);
    assert_eq!(select(&Select { boundary: Some(true), ..boxed }, &body).unwrap(), [1, 2]);
}

#[test]
fn a_grid_and_its_mesh_have_the_same_boundary() {
    let surface = grid_surface(3, 4, [3.0, 2.0]);
    let edges = Edges::new(12, &surface.triangles, &[]);
    let mesh = Selectable { grid: None, edges: Some(&edges), ..grid(&surface) };
    let wish = Select { boundary: Some(true), ..Select::default() };
    assert_eq!(select(&wish, &mesh), select(&wish, &grid(&surface)));
    assert_eq!(select(&wish, &mesh).unwrap().len(), 10);
    refused(Select::rows(0, 0), &mesh, "select.rows", "only grids");
}

#[test]
fn vertices_and_groups_become_nodes() {
    let groups = [("hem".to_string(), vec![4, 1, 0]), ("cuff".to_string(), vec![2])];
    let map = [1, 0, u32::MAX, 0, 1];
    let nodes = [[0.0; 3], [1.0; 3]];
    let body = Selectable {
        nodes: &nodes,
        vertices: 5,
        node_of_vertex: Some(&map),
        split: &[],
        groups: &groups,
        grid: None,
        edges: None,
    };
    assert_eq!(select(&Select::nodes([3, 4, 1]), &body).unwrap(), [0, 1]);
    let group = |name: &str| Select { group: Some(name.into()), ..Select::default() };
    assert_eq!(select(&group("hem"), &body).unwrap(), [0, 1]);
    refused(group("sleeve"), &body, "select.group", "no group `sleeve`; it has `hem`, `cuff`");
    refused(group("cuff"), &body, "select", "selects no node");
    refused(Select::nodes([2]), &body, "select.nodes", "no face uses");
    refused(Select::nodes([5]), &body, "select.nodes", "has 5, 0 to 4");
}

#[test]
fn selections_that_cannot_be_met_are_refused() {
    let surface = grid_surface(3, 4, [3.0, 2.0]);
    let body = grid(&surface);
    refused(Select::default(), &body, "select", "no key");
    refused(Select::rows(1, 3), &body, "select.rows", "is 1 to 3, ascending within 0 to 2");
    refused(Select::cols(2, 1), &body, "select.cols", "within 0 to 3");
    let bounds = Bounds { min: [1.0; 3], max: [0.0; 3] };
    refused(Select { inside: Some(bounds), ..Select::default() }, &body, "select.box", "above");
    let away = Bounds { min: [5.0; 3], max: [9.0; 3] };
    let where_it_is = "the body starts between [-1.5, 0.0, -1.0] and [1.5, 0.0, 1.0]";
    refused(Select { inside: Some(away), ..Select::default() }, &body, "select.box", where_it_is);
    refused(Select { boundary: Some(false), ..Select::default() }, &body, "select.boundary", "true would do");
}

#[test]
fn a_vertex_whose_point_was_split_means_all_of_its_nodes() {
    // Two triangles touch in vertex 2 alone: nodes 2 and 5 at one place. Vertex 3 is on no face.
    let touch = [1.0, 0.5, -0.0];
    let nodes = vec![[0.0; 3], [0.0, 1.0, 0.0], touch, [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], touch, [7.0; 3]];
    let surface = Surface {
        vertices: vec![nodes[0], nodes[1], touch, [7.0; 3], nodes[3], nodes[4]],
        node_of_vertex: Some(vec![0, 1, 2, u32::MAX, 3, 4]),
        triangles: vec![[0, 2, 1], [5, 3, 4]],
        groups: vec![("tip".into(), vec![2])],
        nodes,
        ..Surface::default()
    };
    let split = split_nodes(&surface);
    assert_eq!(split, [[5, 2]], "node 6 is at the place of no vertex with a node");
    assert_eq!((surface.first_vertex_of(5), surface.first_vertex_of(3)), (2, 4));
    let body = Selectable {
        nodes: &surface.nodes,
        vertices: 6,
        node_of_vertex: surface.node_of_vertex.as_deref(),
        split: &split,
        groups: &surface.groups,
        grid: None,
        edges: None,
    };
    assert_eq!(select(&Select::nodes([2, 4]), &body).unwrap(), [2, 3, 5]);
    assert_eq!(select(&Select { group: Some("tip".into()), ..Select::default() }, &body).unwrap(), [2, 5]);
}
