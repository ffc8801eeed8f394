use super::Triangulator;

/// The triangles of one polygon over all `nodes`, and how many polygons crossed themselves.
fn cut(nodes: &[[f64; 3]]) -> (Vec<[u32; 3]>, usize) {
    let ring: Vec<u32> = (0..nodes.len() as u32).collect();
    let mut triangulator = Triangulator::default();
    triangulator.add(&ring, &ring, nodes);
    (triangulator.triangles, triangulator.crossed)
}

#[test]
fn a_concave_quad_is_split_at_its_reflex_corner_in_any_direction() {
    let dart = [[0.0, 0.0], [2.0, -1.0], [0.5, 0.0], [2.0, 1.0]];
    let turned: [fn([f64; 2]) -> [f64; 3]; 3] =
        [|[x, y]| [x, y, 0.0], |[x, y]| [x, 0.0, y], |[x, y]| [0.0, x + 5.0, -y]];
    for turn in turned {
        for start in 0..4 {
            let nodes: Vec<[f64; 3]> = (0..4).map(|i| turn(dart[(i + start) % 4])).collect();
            let reflex = ((6 - start) % 4) as u32;
            let (triangles, crossed) = cut(&nodes);
            assert!(triangles.iter().all(|t| t.contains(&reflex)), "{triangles:?}");
            assert_eq!((triangles.len(), crossed), (2, 0));
        }
    }
}

#[test]
fn a_straight_corner_of_a_quad_gets_both_triangles() {
    // The third corner lies on the edge from the second to the fourth, up to rounding.
    let nodes = [[0.0; 3], [1.0, 0.1, 0.3], [1.1, 0.7, 0.33], [1.2, 1.3, 0.36]];
    let (triangles, _) = cut(&nodes);
    assert!(triangles.iter().all(|t| t.contains(&2)), "{triangles:?}");
}

#[test]
fn what_crosses_itself_ends_and_is_counted() {
    let circle = |i: u32, steps: f64| {
        let angle = f64::from(i) * std::f64::consts::TAU / steps;
        [angle.cos(), 0.0, angle.sin()]
    };
    let pentagram: Vec<[f64; 3]> = [0, 2, 4, 1, 3].map(|i| circle(i, 5.0)).to_vec();
    let bow = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    let eight: Vec<[f64; 3]> = (0..40)
        .map(|i| {
            let [x, _, z] = circle(i, 40.0);
            [x, 0.0, x * z]
        })
        .collect();
    for nodes in [pentagram, bow, eight] {
        let (triangles, crossed) = cut(&nodes);
        assert_eq!((triangles.len(), crossed), (nodes.len() - 2, 1));
    }
}

#[test]
fn a_polygon_of_many_crossings_ends_within_its_effort() {
    // 100,000 corners at random over 27 nodes: each is passed thousands of times.
    let nodes: Vec<[f64; 3]> = (0..27).map(|i| [i % 3, i / 3 % 3, i / 9].map(f64::from)).collect();
    let all: Vec<u32> = (0..27).collect();
    let mut random = 1_u32;
    let ring: Vec<u32> = (0..100_000)
        .map(|_| {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (random >> 8) % 27
        })
        .collect();
    let mut triangulator = Triangulator::default();
    triangulator.add(&ring, &all, &nodes);
    assert_eq!((triangulator.crossed, triangulator.ears.effort), (1, 0));
    assert!(triangulator.triangles.len() > 90_000);
}

#[test]
fn what_meets_itself_in_one_corner_is_no_crossing() {
    let petals: Vec<[f64; 3]> = (0..7)
        .flat_map(|i| {
            let at = |part: f64| std::f64::consts::TAU * (f64::from(i) + part) / 7.0;
            [[0.0; 3], [at(0.2).cos(), at(0.2).sin(), 0.0], [at(0.8).cos(), at(0.8).sin(), 0.0]]
        })
        .collect();
    let places: Vec<u32> = (0..21).map(|i| if i % 3 == 0 { 0 } else { i }).collect();
    let mut triangulator = Triangulator::default();
    triangulator.add(&(0..21).collect::<Vec<_>>(), &places, &petals);
    assert_eq!((triangulator.crossed, triangulator.triangles.len()), (0, 19));
}

#[test]
fn a_warped_polygon_that_crosses_itself_from_one_side_is_cut_from_another() {
    // A wall 1 m high along an S that hangs over: seen along its largest area it crosses itself.
    let path = [[0.0, 0.0], [4.0, 0.0], [3.0, 1.0], [6.0, 1.0]];
    let top = path.iter().rev().map(|&[x, y]| [x, y, 1.0 + 0.5 * y]);
    let nodes: Vec<[f64; 3]> = path.iter().map(|&[x, y]| [x, y, 0.0]).chain(top).collect();
    let (triangles, crossed) = cut(&nodes);
    assert_eq!((triangles.len(), crossed), (6, 0), "{triangles:?}");
}

#[test]
fn what_has_no_area_is_no_crossing() {
    let line: Vec<[f64; 3]> = [0.0, 3.0, 1.0, 2.0, 5.0, 4.0].map(|x| [x, x, 0.3 * x]).to_vec();
    assert_eq!(cut(&line).1, 0);
    let nodes = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mut triangulator = Triangulator::default();
    triangulator.add(&[0, 1, 0, 2], &[0, 1, 2], &nodes);
    triangulator.add(&[0, 1, 0, 1], &[0, 1, 2], &nodes);
    triangulator.add(&[0, 0, 1, 1], &[0, 1, 2], &nodes);
    assert_eq!((triangulator.crossed, triangulator.collapsed), (0, 3));
}
