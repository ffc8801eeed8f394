//! Triangles of polygons: the valid diagonal of a quad, ears of larger ones (Meisters, Polygons have ears, 1975). A
//! polygon is flattened along its Newell normal, so that concave and slightly warped ones come out right.

type Point = [f64; 2];

/// Collects the triangles of polygons.
#[derive(Default)]
pub(super) struct Triangulator {
    /// Triangles of nodes.
    pub triangles: Vec<[u32; 3]>,
    /// Polygons with fewer than three different neighbouring corners.
    pub collapsed: usize,
    ring: Vec<u32>,
}

impl Triangulator {
    /// Adds a polygon of vertices.
    pub fn add(&mut self, polygon: &[u32], node_of_vertex: &[u32], nodes: &[[f64; 3]]) {
        self.ring.clear();
        self.ring.extend(polygon.iter().map(|&vertex| node_of_vertex[vertex as usize]));
        self.ring.dedup();
        while self.ring.len() > 1 && self.ring.first() == self.ring.last() {
            self.ring.pop();
        }
        match *self.ring {
            [] | [_] | [_, _] => self.collapsed += 1,
            [a, b, c] => self.triangles.push([a, b, c]),
            [a, b, c, d] => self.quad([a, b, c, d], nodes),
            _ => {
                let points = flatten(&self.ring, nodes);
                ears(&points, |corners| self.triangles.push(corners.map(|i| self.ring[i as usize])));
            }
        }
    }

    /// The shorter diagonal; the other one where the shorter lies outside.
    fn quad(&mut self, [a, b, c, d]: [u32; 4], nodes: &[[f64; 3]]) {
        let points = flatten(&[a, b, c, d], nodes);
        let [p, q, r, s] = [points[0], points[1], points[2], points[3]];
        let first = area(p, q, r) > 0.0 && area(p, r, s) > 0.0;
        let second = area(p, q, s) > 0.0 && area(q, r, s) > 0.0;
        let square = |u: Point, v: Point| (u[0] - v[0]).powi(2) + (u[1] - v[1]).powi(2);
        let split_ac = if first == second { square(p, r) <= square(q, s) } else { first };
        self.triangles.extend(if split_ac { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] });
    }
}

/// Corners in the plane across the polygon's Newell normal, counter-clockwise.
fn flatten(ring: &[u32], nodes: &[[f64; 3]]) -> Vec<Point> {
    let origin = nodes[ring[0] as usize];
    let at = |node: u32| [0, 1, 2].map(|i| nodes[node as usize][i] - origin[i]);
    let mut normal = [0.0; 3];
    for (i, &node) in ring.iter().enumerate() {
        let (p, q) = (at(node), at(ring[(i + 1) % ring.len()]));
        normal[0] += (p[1] - q[1]) * (p[2] + q[2]);
        normal[1] += (p[2] - q[2]) * (p[0] + q[0]);
        normal[2] += (p[0] - q[0]) * (p[1] + q[1]);
    }
    let length = (normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]).sqrt();
    let n = if length > 0.0 { normal.map(|x| x / length) } else { [0.0, 0.0, 1.0] };
    // Duff et al., Building an Orthonormal Basis, Revisited, 2017: a basis without a branch on the direction.
    let sign = 1.0_f64.copysign(n[2]);
    let a = -1.0 / (sign + n[2]);
    let b = n[0] * n[1] * a;
    let u = [1.0 + sign * n[0] * n[0] * a, sign * b, -sign * n[0]];
    let v = [b, sign + n[1] * n[1] * a, -n[1]];
    let dot = |p: [f64; 3], q: [f64; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
    ring.iter().map(|&node| [dot(at(node), u), dot(at(node), v)]).collect()
}

/// Twice the signed area.
fn area(a: Point, b: Point, c: Point) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Cuts ears off until three corners are left.
fn ears(points: &[Point], mut triangle: impl FnMut([u32; 3])) {
    let count = points.len();
    let mut next: Vec<usize> = (1..=count).map(|i| i % count).collect();
    let mut before: Vec<usize> = (0..count).map(|i| (i + count - 1) % count).collect();
    let mut reflex: Vec<usize> =
        (0..count).filter(|&i| area(points[before[i]], points[i], points[next[i]]) <= 0.0).collect();
    let (mut left, mut at, mut tried) = (count, 0, 0);
    while left > 3 {
        let corners = [before[at], at, next[at]];
        // Where no ear is left (a polygon that crosses itself), any corner goes.
        if is_ear(points, corners, &reflex) || tried >= left {
            let [p, i, n] = corners;
            triangle([p as u32, i as u32, n as u32]);
            (next[p], before[n]) = (n, p);
            reflex.retain(|&j| {
                let turns = |k: usize| area(points[before[k]], points[k], points[next[k]]) <= 0.0;
                j != i && ((j != p && j != n) || turns(j))
            });
            (left, tried, at) = (left - 1, 0, n);
        } else {
            (tried, at) = (tried + 1, next[at]);
        }
    }
    triangle([before[at] as u32, at as u32, next[at] as u32]);
}

/// Whether the corner is convex and no other corner lies within its triangle; only reflex ones can.
fn is_ear(points: &[Point], [p, i, n]: [usize; 3], reflex: &[usize]) -> bool {
    let [a, b, c] = [points[p], points[i], points[n]];
    if area(a, b, c) <= 0.0 {
        return false;
    }
    let within = |q: Point| {
        q != a && q != b && q != c && area(a, b, q) >= 0.0 && area(b, c, q) >= 0.0 && area(c, a, q) >= 0.0
    };
    !reflex.iter().any(|&j| j != p && j != i && j != n && within(points[j]))
}

#[cfg(test)]
mod tests {
    use super::{Point, Triangulator, area, ears};

    fn triangulated(points: &[Point]) -> f64 {
        let (mut sum, mut count) = (0.0, 0);
        ears(points, |corners| {
            let [a, b, c] = corners.map(|i| points[i as usize]);
            assert!(area(a, b, c) > 0.0, "{corners:?} is flat or turned over");
            sum += 0.5 * area(a, b, c);
            count += 1;
        });
        assert_eq!(count, points.len() - 2);
        sum
    }

    #[test]
    fn concave_polygons_keep_their_area() {
        // A U of height 2 with a slit 1 wide and 1 deep: 3 × 2 − 1 × 1.
        let u =
            [[0.0, 0.0], [3.0, 0.0], [3.0, 2.0], [2.0, 2.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        assert!((triangulated(&u) - 5.0).abs() < 1e-12);
        // A square with a corner in the middle of one side.
        let square = [[0.0, 0.0], [0.5, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        assert!((triangulated(&square) - 1.0).abs() < 1e-12);
        // A star of 7: ½ n sin(π/n) times the product of the radii times 2.
        let star: Vec<Point> = (0..14)
            .map(|i| {
                let (angle, radius) =
                    (f64::from(i) * std::f64::consts::PI / 7.0, if i % 2 == 0 { 1.0 } else { 0.3 });
                [radius * angle.cos(), radius * angle.sin()]
            })
            .collect();
        assert!((triangulated(&star) - 7.0 * 0.3 * (std::f64::consts::PI / 7.0).sin()).abs() < 1e-12);
    }

    #[test]
    fn a_concave_quad_is_split_at_its_reflex_corner_in_any_direction() {
        let dart = [[0.0, 0.0], [2.0, -1.0], [0.5, 0.0], [2.0, 1.0]];
        let turned: [fn(Point) -> [f64; 3]; 3] =
            [|[x, y]| [x, y, 0.0], |[x, y]| [x, 0.0, y], |[x, y]| [0.0, x + 5.0, -y]];
        for turn in turned {
            let nodes: Vec<[f64; 3]> = dart.iter().map(|&p| turn(p)).collect();
            for start in 0..4_u32 {
                let ring = [0, 1, 2, 3].map(|i| (i + start) % 4);
                let mut triangulator = Triangulator::default();
                triangulator.add(&ring, &[0, 1, 2, 3], &nodes);
                assert!(triangulator.triangles.iter().all(|t| t.contains(&0) && t.contains(&2)));
            }
        }
    }

    #[test]
    fn a_polygon_that_crosses_itself_still_ends() {
        let pentagram = [0, 2, 4, 1, 3].map(|i| {
            let angle = f64::from(i) * 0.4 * std::f64::consts::PI;
            [angle.cos(), angle.sin()]
        });
        let mut count = 0;
        ears(&pentagram, |_| count += 1);
        assert_eq!(count, 3);
    }
}
