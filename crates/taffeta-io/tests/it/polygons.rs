//! Polygons of many corners, and of odd shapes: the triangles cover them once, and all of their edges stay.

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};
use taffeta::topology::{Polygons, Surface};
use taffeta_io::surface_from;

type Point = [f64; 2];

/// Knuth's generator (The Art of Computer Programming 2, 1997).
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn below(&mut self, count: usize) -> usize {
        (self.unit() * count as f64) as usize
    }
}

fn surface_of(ring: &[Point], lift: impl Fn(Point) -> [f64; 3]) -> Surface {
    let polygons =
        Polygons { offsets: vec![0, ring.len() as u32], corners: (0..ring.len() as u32).collect() };
    surface_from(ring.iter().map(|&p| lift(p)).collect(), polygons, None, vec![]).unwrap()
}

fn turn(a: Point, b: Point, c: Point) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn area(ring: &[Point]) -> f64 {
    (1..ring.len() - 1).map(|i| 0.5 * turn(ring[0], ring[i], ring[i + 1])).sum()
}

/// The triangles are n − 2, all counter-clockwise, add up to the polygon, and have its edges as their border: so they
/// cover it once.
fn assert_covered(name: &str, ring: &[Point]) {
    let surface = surface_of(ring, |[x, y]| [x, y, 0.0]);
    assert_eq!(surface.triangles.len(), ring.len() - 2, "{name}: {:?}", surface.repairs);
    let flat = |node: u32| [surface.nodes[node as usize][0], surface.nodes[node as usize][1]];
    let mut sum = 0.0;
    for triangle in &surface.triangles {
        let [a, b, c] = triangle.map(flat);
        assert!(turn(a, b, c) > 0.0, "{name}: {triangle:?} is flat or turned over");
        sum += 0.5 * turn(a, b, c);
    }
    let whole = area(ring);
    assert!((sum - whole).abs() <= 1e-9 * whole, "{name}: {sum} of {whole}");
    let node = |vertex: usize| surface.node_of_vertex.as_ref().map_or(vertex as u32, |nodes| nodes[vertex]);
    let edges = (0..ring.len()).map(|i| (node(i), node((i + 1) % ring.len())));
    assert_eq!(border(surface.triangles.iter().copied()), net(edges), "{name}");
}

/// How often each edge is walked from its lower to its higher node, less the other way.
fn net(edges: impl Iterator<Item = (u32, u32)>) -> HashMap<(u32, u32), i32> {
    let mut counts = HashMap::new();
    for (a, b) in edges {
        *counts.entry((a.min(b), a.max(b))).or_insert(0) += if a < b { 1 } else { -1 };
    }
    counts.retain(|_, count| *count != 0);
    counts
}

fn border(triangles: impl Iterator<Item = [u32; 3]>) -> HashMap<(u32, u32), i32> {
    net(triangles.flat_map(|[a, b, c]| [(a, b), (b, c), (c, a)]))
}

fn polar(angle: f64, radius: f64) -> Point {
    [radius * angle.cos(), radius * angle.sin()]
}

fn around(count: usize, radius: impl FnMut(usize) -> f64) -> Vec<Point> {
    let angles = (0..count).map(|i| TAU * i as f64 / count as f64);
    angles.zip((0..count).map(radius)).map(|(angle, radius)| polar(angle, radius)).collect()
}

/// Teeth of a width of 2/3 above a bar; `height` of each.
fn comb(teeth: usize, mut height: impl FnMut(usize) -> f64) -> Vec<Point> {
    let mut ring = vec![[0.0, -1.0], [teeth as f64, -1.0]];
    for tooth in (0..teeth).rev() {
        let (left, top) = (tooth as f64, height(tooth));
        ring.extend([[left + 0.9, 0.0], [left + 0.75, top], [left + 0.25, top], [left + 0.1, 0.0]]);
    }
    ring
}

/// A corridor that winds inward.
fn spiral(count: usize, turns: f64) -> Vec<Point> {
    let half = count / 2;
    let place = |i: usize, inset: f64| {
        let part = i as f64 / half as f64;
        polar(TAU * turns * part, 1.0 + turns * (1.0 - part) - inset)
    };
    (0..half).map(|i| place(i, 0.0)).chain((0..half).rev().map(|i| place(i, 0.5))).collect()
}

/// Both sides of a Hilbert curve (1891), a quarter of its step apart.
fn hilbert(order: u32) -> Vec<Point> {
    let side = 1_u32 << order;
    let place = |mut index: u32| {
        let (mut x, mut y, mut size) = (0, 0, 1);
        while size < side {
            let (rx, ry) = (1 & (index / 2), 1 & (index ^ (index / 2)));
            if ry == 0 {
                if rx == 1 {
                    (x, y) = (size - 1 - x, size - 1 - y);
                }
                (x, y) = (y, x);
            }
            (x, y) = (x + size * rx, y + size * ry);
            (index, size) = (index / 4, 2 * size);
        }
        [f64::from(x), f64::from(y)]
    };
    let path: Vec<Point> = (0..side * side).map(place).collect();
    let offset = |i: usize, sign: f64| {
        let (p, q, r) = (path[i.max(1) - 1], path[i], path[(i + 1).min(path.len() - 1)]);
        let way = |a: Point, b: Point| [b[0] - a[0], b[1] - a[1]];
        let (along, on) = if i == 0 { (way(q, r), way(q, r)) } else { (way(p, q), way(q, r)) };
        let on = if i == path.len() - 1 { along } else { on };
        let left = [-0.25 * sign * along[1], 0.25 * sign * along[0]];
        let corner = if along == on { [0.0; 2] } else { [-0.25 * sign * on[1], 0.25 * sign * on[0]] };
        [q[0] + left[0] + corner[0], q[1] + left[1] + corner[1]]
    };
    (0..path.len()).map(|i| offset(i, -1.0)).chain((0..path.len()).rev().map(|i| offset(i, 1.0))).collect()
}

/// A square with `side`² square holes, joined to it and to each other by bridges that are walked twice.
fn keyholes(side: usize) -> Vec<Point> {
    let end = side as f64;
    let mut ring = vec![[0.0, 0.0], [end, 0.0], [end, end], [0.0, end]];
    for row in (0..side).rev() {
        // Down the left side, into the row along its holes' lower edges, back along the upper ones.
        let y = row as f64;
        let hole = |column: usize| [column as f64 + 0.25, y + 0.25];
        ring.push([0.0, y + 0.25]);
        for column in 0..side {
            let [x, y] = hole(column);
            ring.extend([[x, y], [x, y + 0.5], [x + 0.5, y + 0.5], [x + 0.5, y]]);
        }
        for column in (0..side).rev() {
            let [x, y] = hole(column);
            if column + 1 < side {
                ring.push([x + 0.5, y]);
            }
            ring.push([x, y]);
        }
        ring.push([0.0, y + 0.25]);
    }
    ring
}

/// Random points, joined in an order in which no two edges cross: crossing ones are swapped until there are none.
fn random_polygon(count: usize, random: &mut Random, point: impl Fn(&mut Random) -> Point) -> Vec<Point> {
    let mut ring: Vec<Point> = Vec::new();
    while ring.len() < count {
        let p = point(random);
        if !ring.contains(&p) {
            ring.push(p);
        }
    }
    let crosses = |a, b, c, d| turn(a, b, c) * turn(a, b, d) < 0.0 && turn(c, d, a) * turn(c, d, b) < 0.0;
    'again: loop {
        for i in 0..count {
            for j in i + 2..count {
                if crosses(ring[i], ring[i + 1], ring[j], ring[(j + 1) % count]) {
                    ring[i + 1..=j].reverse();
                    continue 'again;
                }
            }
        }
        break;
    }
    if area(&ring) < 0.0 {
        ring.reverse();
    }
    ring
}

/// Whether no corner lies on an edge that does not end there.
fn touches_nothing(ring: &[Point]) -> bool {
    let count = ring.len();
    let on = |a: Point, b: Point, p: Point| {
        let between = (p[0] - a[0]) * (p[0] - b[0]) + (p[1] - a[1]) * (p[1] - b[1]) <= 0.0;
        turn(a, b, p) == 0.0 && between
    };
    (0..count).all(|i| {
        (0..count).all(|j| j == i || j == (i + 1) % count || !on(ring[i], ring[(i + 1) % count], ring[j]))
    })
}

#[test]
fn polygons_of_a_hundred_thousand_corners_are_covered() {
    const MANY: usize = 100_000;
    let mut random = Random(1);
    let shapes: Vec<(&str, Vec<Point>)> = vec![
        ("circle", around(MANY, |_| 1.0)),
        ("star", around(MANY, |i| if i % 2 == 0 { 1.0 } else { 0.3 })),
        ("random radii", around(MANY, |_| 0.1 + random.unit())),
        ("comb", comb(MANY / 4, |_| 1e5)),
        ("saw comb", comb(MANY / 4, |i| (1 + i % 97) as f64)),
        ("spiral", spiral(MANY, 50.0)),
        ("tight spiral", spiral(MANY, 2000.0)),
        ("Hilbert", hilbert(8)),
        ("keyholes", keyholes(129)),
        (
            "one side",
            (0..MANY - 1).map(|i| [i as f64, 0.0]).chain([[0.3 * MANY as f64, MANY as f64]]).collect(),
        ),
        (
            "valley",
            (0..MANY)
                .map(|i| {
                    let x = i as f64 / MANY as f64 - 0.5;
                    if i % 2 == 0 { [x, x * x] } else { [x, x * x + 0.1] }
                })
                .chain([[0.5, 9.0], [-0.5, 9.0]])
                .collect(),
        ),
    ];
    for (name, ring) in &shapes {
        assert_covered(name, ring);
    }
}

#[test]
fn petals_that_meet_in_one_corner_are_filled() {
    let petals = 33_333;
    let ring: Vec<Point> = (0..petals)
        .flat_map(|i| {
            let angle = |part: f64| TAU * (i as f64 + part) / petals as f64;
            [[0.0; 2], polar(angle(0.2), 1.0), polar(angle(0.8), 1.0)]
        })
        .collect();
    let surface = surface_of(&ring, |[x, y]| [x, 0.0, y]);
    // They hang together in a point only, which is split.
    assert_eq!((surface.nodes.len(), surface.triangles.len()), (3 * petals, petals));
}

#[test]
fn lobes_that_meet_in_one_corner_are_filled() {
    let ring =
        [[0.0, 0.0], [2.0, -1.0], [4.0, 0.0], [2.0, 0.5], [4.0, 1.0], [2.0, 2.0], [0.0, 1.0], [2.0, 0.5]];
    let surface = surface_of(&ring, |[x, y]| [x, y, 0.0]);
    assert_eq!((surface.nodes.len(), surface.triangles.len()), (8, 4));
    let place = |[x, y, _]: [f64; 3]| ring.iter().position(|&corner| corner == [x, y]).unwrap() as u32;
    let places = surface.triangles.iter().map(|t| t.map(|node| place(surface.nodes[node as usize])));
    let first = |i: usize| place([ring[i % 8][0], ring[i % 8][1], 0.0]);
    assert_eq!(border(places), net((0..8).map(|i| (first(i), first(i + 1)))));
}

#[test]
fn random_polygons_are_covered() {
    let mut random = Random(7);
    for round in 0..400 {
        let count = 4 + random.below(37);
        let ring = random_polygon(count, &mut random, |random| [random.unit(), random.unit()]);
        assert_covered(&format!("{round}: {ring:?}"), &ring);
    }
}

#[test]
fn random_polygons_with_many_straight_corners_are_covered() {
    let mut random = Random(11);
    let mut covered = 0;
    for round in 0..4000 {
        let count = 4 + random.below(13);
        let ring =
            random_polygon(count, &mut random, |random| [random.below(7) as f64, random.below(7) as f64]);
        if touches_nothing(&ring) {
            assert_covered(&format!("{round}: {ring:?}"), &ring);
            covered += 1;
        }
    }
    assert!(covered > 400, "{covered}");
}

#[test]
fn corners_that_are_straight_up_to_rounding_keep_their_edges() {
    // Each side of a slanted square in 20 parts: no corner is exactly straight, and each must stay, for neighbours have it.
    let (sides, parts) = (4, 20);
    for degrees in 1..90 {
        let ring: Vec<Point> = (0..sides * parts)
            .map(|i| {
                let corner = |side: usize| {
                    polar(side as f64 * TAU / sides as f64 + f64::from(degrees) * PI / 180.0, 1.0)
                };
                let (a, b, t) = (corner(i / parts), corner(i / parts + 1), (i % parts) as f64 / parts as f64);
                [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]
            })
            .collect();
        assert_covered(&format!("{degrees}°"), &ring);
        let lifted = surface_of(&ring, |[x, y]| [0.1 + x, 0.2 + 0.7 * x - 0.4 * y, 0.3 + y]);
        assert_eq!((lifted.triangles.len(), lifted.repairs.len()), (sides * parts - 2, 0), "{degrees}°");
    }
}

#[test]
fn a_side_that_is_straight_up_to_rounding_is_never_cut_off() {
    // The first corner sees the whole side opposite, whose corners lie on either side of the line by 1e-17 or so.
    let mut random = Random(3);
    for round in 0..1000 {
        let [a, b, c] = [0.0, 0.3, 0.6].map(|part| polar(TAU * (part + 0.2 * random.unit()), 1.0));
        let on_side = |t: f64| [b[0] + t * (c[0] - b[0]), b[1] + t * (c[1] - b[1])];
        let (early, late) = (on_side(0.5 * random.unit()), on_side(0.5 + 0.5 * random.unit()));
        assert_covered(&format!("{round}, four"), &[a, b, early, c]);
        assert_covered(&format!("{round}, five"), &[a, b, early, late, c]);
    }
}

#[test]
fn a_slit_is_kept_open() {
    // A square, cut from its left side to the middle and beyond; the slit's two lips have the same corners.
    let ring = [
        [0.0, 0.0],
        [3.0, 0.0],
        [3.0, 3.0],
        [0.0, 3.0],
        [0.0, 1.0],
        [1.0, 1.5],
        [2.0, 1.0],
        [1.0, 1.5],
        [0.0, 1.0],
    ];
    assert_covered("slit", &ring);
}

#[test]
fn concave_polygons_keep_their_area() {
    let u = [[0.0, 0.0], [3.0, 0.0], [3.0, 2.0], [2.0, 2.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
    assert_eq!(area(&u), 5.0);
    assert_covered("U", &u);
    assert_covered("a corner on a side", &[[0.0, 0.0], [0.5, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
    assert_covered("keyholes", &keyholes(3));
}
