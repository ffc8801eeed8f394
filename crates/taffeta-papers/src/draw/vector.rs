//! Vectors of three numbers.

/// A place [m], a direction or a colour.
pub type Vector = [f64; 3];

/// a + s·b
pub fn along(a: Vector, s: f64, b: Vector) -> Vector {
    std::array::from_fn(|axis| a[axis] + s * b[axis])
}

/// a − b
pub fn difference(a: Vector, b: Vector) -> Vector {
    along(a, -1.0, b)
}

/// a + s·(b − a)
pub fn mix(a: Vector, b: Vector, s: f64) -> Vector {
    along(a, s, difference(b, a))
}

/// a·b
pub fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a × b
pub fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The direction of `a`; up, where it has none.
pub fn unit(a: Vector) -> Vector {
    let length = dot(a, a).sqrt();
    if length > 0.0 { a.map(|c| c / length) } else { [0.0, 1.0, 0.0] }
}

/// Two directions square to `a` and to each other.
pub fn across(a: Vector) -> [Vector; 2] {
    let other = if a[1].abs() < 0.9 { [0.0, 1.0, 0.0] } else { [0.0, 0.0, -1.0] };
    let right = unit(cross(other, a));
    [right, cross(unit(a), right)]
}
