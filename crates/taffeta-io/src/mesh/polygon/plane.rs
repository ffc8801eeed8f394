//! Flattens a polygon. Leaving out a coordinate is exact: what lies on a line stays there, and a plane polygon that does
//! not cross itself does not do so afterwards.

pub(super) type Point = [f64; 2];

/// How points become flat.
#[derive(Clone, Copy)]
pub(super) enum Projection {
    /// These two coordinates.
    Keep([usize; 2]),
    /// Their places along two axes, from an origin.
    Onto { origin: [f64; 3], axes: [[f64; 3]; 2] },
}

/// A polygon's normal, of the length of twice its area, and one of its points.
#[derive(Clone, Copy)]
pub(super) struct Normal {
    along: [f64; 3],
    origin: [f64; 3],
}

/// Newell's normal (Sutherland, Sproull and Schumacker, 1974); of a polygon whose parts cancel, that of its largest part.
pub(super) fn normal_of(ring: &[u32], nodes: &[[f64; 3]]) -> Normal {
    let origin = nodes[ring[0] as usize];
    let at = |node: u32| sub(nodes[node as usize], origin);
    let (mut sum, mut largest, mut total) = ([0.0; 3], [0.0; 3], 0.0);
    for pair in ring[1..].windows(2) {
        let part = cross(at(pair[0]), at(pair[1]));
        sum = [0, 1, 2].map(|i| sum[i] + part[i]);
        total += size(part);
        if size(part) > size(largest) {
            largest = part;
        }
    }
    let along = if size(sum) > 1e-12 * total { sum } else { largest };
    Normal { along, origin }
}

impl Projection {
    /// Leaves out the coordinate along which the normal is longest.
    pub fn major(normal: Normal) -> Self {
        Self::without(normal, by_size(normal)[0])
    }

    /// All that are worth a try, the best first. Those almost along the polygon's plane are not.
    pub fn of_normal(normal: Normal) -> impl Iterator<Item = Self> {
        let seen = move |axis: &usize| normal.along[*axis].abs() > 0.01 * size(normal.along);
        let [major, second, third] = by_size(normal);
        let others = [second, third].into_iter().filter(seen).map(move |axis| Self::without(normal, axis));
        [Self::without(normal, major), Self::along(normal)].into_iter().chain(others)
    }

    fn without(normal: Normal, axis: usize) -> Self {
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        Self::Keep(if normal.along[axis] < 0.0 { [v, u] } else { [u, v] })
    }

    /// Duff et al., Building an Orthonormal Basis, Revisited, 2017.
    fn along(Normal { along, origin }: Normal) -> Self {
        let length = size(along);
        let n = if length > 0.0 { along.map(|x| x / length) } else { [0.0, 0.0, 1.0] };
        let sign = 1.0_f64.copysign(n[2]);
        let a = -1.0 / (sign + n[2]);
        let b = n[0] * n[1] * a;
        let u = [1.0 + sign * n[0] * n[0] * a, sign * b, -sign * n[0]];
        let v = [b, sign + n[1] * n[1] * a, -n[1]];
        Self::Onto { origin, axes: [u, v] }
    }

    pub fn point(self, place: [f64; 3]) -> Point {
        match self {
            Self::Keep([u, v]) => [place[u], place[v]],
            Self::Onto { origin, axes } => {
                let p = sub(place, origin);
                axes.map(|axis| p[0] * axis[0] + p[1] * axis[1] + p[2] * axis[2])
            }
        }
    }

    pub fn points<'a>(self, ring: &'a [u32], nodes: &'a [[f64; 3]]) -> impl Iterator<Item = Point> + 'a {
        ring.iter().map(move |&node| self.point(nodes[node as usize]))
    }
}

/// The axes, the one along which the normal is longest first.
fn by_size(normal: Normal) -> [usize; 3] {
    let mut axes = [2, 1, 0];
    axes.sort_by(|&a, &b| normal.along[b].abs().total_cmp(&normal.along[a].abs()));
    axes
}

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn size(a: [f64; 3]) -> f64 {
    (a[0] * a[0] + a[1] * a[1] + a[2] * a[2]).sqrt()
}
