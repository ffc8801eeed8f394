use crate::topology::rest::*;

/// Two right triangles at the edge 1–2 of a unit square, at rest as `rest` says.
fn square(rest: Option<[[[f64; 3]; 3]; 2]>) -> (Surface, Edges) {
    let surface = Surface {
        nodes: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2], [3, 2, 1]],
        rest: rest.map(Vec::from),
        ..Surface::default()
    };
    let edges = Edges::new(4, &surface.triangles, &[]);
    (surface, edges)
}

fn across(surface: &Surface, edges: &Edges) -> f64 {
    let [_, _, left, right] = RestShape::of(surface, 2.0).hinges(edges).next().unwrap();
    norm(sub(right, left))
}

#[test]
fn without_another_shape_nodes_are_at_rest_where_they_are() {
    let (surface, edges) = square(None);
    let rest = RestShape::of(&surface, 2.0);
    assert_eq!(rest.edge_lengths(&edges), [2.0, 2.0, 2.0 * 2_f64.sqrt(), 2.0, 2.0]);
    assert!((across(&surface, &edges) - 2.0 * 2_f64.sqrt()).abs() < 1e-15);
    assert_eq!(rest.areas(), [2.0, 2.0]);
    assert_eq!(rest.nodes().unwrap()[3], [2.0, 2.0, 0.0]);
}

#[test]
fn panels_apart_are_unfolded_about_their_seam_whose_length_is_the_mean() {
    // Left: legs 3 and 4, hypotenuse 5 on the seam, height 2.4. Right: an edge of 7 on the seam, height 1.
    let left = [[0.0; 3], [3.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
    let right = [[50.0, 1.0, 9.0], [46.5, 0.0, 9.0], [53.5, 0.0, 9.0]];
    let (surface, edges) = square(Some([left, right]));
    let lengths = RestShape::of(&surface, 2.0).edge_lengths(&edges);
    assert!((lengths[2] - 12.0).abs() < 1e-14, "{lengths:?}");
    // The foot of the left height is 1.8 of 5 from node 1, 0.7 from the middle; that of the right is in the middle.
    let expected = 2.0 * (0.7_f64.powi(2) + 3.4_f64.powi(2)).sqrt();
    assert!((across(&surface, &edges) - expected).abs() < 1e-14);
    assert!(RestShape::of(&surface, 2.0).nodes().is_none());
}

#[test]
fn triangles_that_meet_keep_their_fold_unless_all_lies_flat() {
    let left = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let up = [[0.5, 0.5, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]];
    let (surface, edges) = square(Some([left, up]));
    assert!((across(&surface, &edges) - 2.0 * 1.5_f64.sqrt()).abs() < 1e-15);
    assert_eq!(RestShape::of(&surface, 2.0).nodes().unwrap()[3], [1.0, 1.0, 2.0]);
    // A pattern folded on itself is cloth that lies flat when it is opened.
    let doubled = [[0.1, 0.1, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]];
    let (surface, edges) = square(Some([left, doubled]));
    let expected = 2.0 * (0.5_f64.sqrt() + 0.8 * 0.5_f64.sqrt());
    assert!((across(&surface, &edges) - expected).abs() < 1e-14);
}

#[test]
fn a_given_shape_has_a_volume_where_it_is_whole_and_not_flat() {
    let out = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    let places = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let rest: Vec<_> = out.map(|t: [u32; 3]| t.map(|i| places[i as usize])).into();
    let of = |rest| Surface {
        nodes: vec![[1.0; 3]; 4],
        triangles: out.into(),
        rest: Some(rest),
        ..Surface::default()
    };
    let volume = |rest| RestShape::of(&of(rest), 2.0).volume();
    assert!((volume(rest.clone()).unwrap() - 8.0 / 6.0).abs() < 1e-15);
    let mut apart = rest.clone();
    apart[0][0] = [-1.0, 0.0, 0.0];
    assert_eq!(volume(apart), None);
    let pressed = rest.iter().map(|t| t.map(|[x, y, z]| [x + 0.2 * z, y + 0.3 * z, 0.0])).collect();
    assert_eq!(volume(pressed), None);
}
