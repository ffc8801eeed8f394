// Gusts: value noise in space and time, with the same mean square everywhere and always (see gust.rs).

/// Gusts at one time.
struct Gusts {
    /// How far the lattice has drifted beyond whole cells, 0 to 1 by axis.
    offset: vec3f,
    /// Lattice points a metre [1/m]; 0: no gusts.
    cells_a_metre: f32,
    /// Keys of the lattices before and after, and their weights [m/s].
    keys: vec2u,
    weights: vec2f,
}

/// What is added to a key on the way to the next lattice point along each axis.
const STRIDE_X: u32 = 0x9e3779b1u;
const STRIDE_Y: u32 = 0x85ebca77u;
const STRIDE_Z: u32 = 0xc2b2ae3du;

/// Values that a number at a lattice point can take, and the middle of them.
const VALUES: u32 = 1024u;
const MIDDLE: f32 = 511.5;

/// Cells from the origin beyond which the field no longer changes.
const FARTHEST_CELL: f32 = 1e9;

/// The start of a cell, and how far from it a number is [0 to 1).
struct InCell {
    start: u32,
    t: f32,
}

/// The cell that a number is in.
fn gust_cell(number: f32) -> InCell {
    let low = select(FARTHEST_CELL, number, number < FARTHEST_CELL);
    let p = select(-FARTHEST_CELL, low, low > -FARTHEST_CELL);
    let near = i32(p);
    let start = f32(near);
    if start > p {
        return InCell(u32(near - 1), p - (start - 1.0));
    }
    return InCell(u32(near), p - start);
}

/// Weights of the two ends of a cell at `t` between them.
fn fade(t: f32) -> vec2f {
    let s = t * t * (3.0 - (t + t));
    return vec2f(1.0 - s, s);
}

/// Bits that look like chance (Wellons, "Prospecting for hash functions", 2018: `lowbias32`).
fn mixed_bits(key: u32) -> u32 {
    let a = (key ^ (key >> 16u)) * 0x7feb352du;
    let b = (a ^ (a >> 15u)) * 0x846ca68bu;
    return b ^ (b >> 16u);
}

/// The vector at a lattice point: three numbers of ten bits, around 0.
fn lattice(key: u32) -> vec3f {
    let bits = mixed_bits(key);
    let whole = vec3f(f32(bits >> 22u), f32((bits >> 12u) % VALUES), f32((bits >> 2u) % VALUES));
    return whole - MIDDLE;
}

/// Velocity of the gusts at `x` [m] beside that of the air [m/s].
fn gust_velocity(gusts: Gusts, x: vec3f) -> vec3f {
    let px = gust_cell(x.x * gusts.cells_a_metre - gusts.offset.x);
    let py = gust_cell(x.y * gusts.cells_a_metre - gusts.offset.y);
    let pz = gust_cell(x.z * gusts.cells_a_metre - gusts.offset.z);
    let first = px.start * STRIDE_X + py.start * STRIDE_Y + pz.start * STRIDE_Z;
    let a = fade(px.t);
    let b = fade(py.t);
    let c = fade(pz.t);
    var sum = vec3f(0.0);
    for (var corner = 0u; corner < 8u; corner++) {
        let i = corner & 1u;
        let j = (corner >> 1u) & 1u;
        let k = corner >> 2u;
        let key = first + i * STRIDE_X + j * STRIDE_Y + k * STRIDE_Z;
        let value = lattice(gusts.keys.x + key) * gusts.weights.x + lattice(gusts.keys.y + key) * gusts.weights.y;
        let weight = select(a.x, a.y, i == 1u) * select(b.x, b.y, j == 1u) * select(c.x, c.y, k == 1u);
        sum += value * weight;
    }
    let squares = (a.x * a.x + a.y * a.y) * (b.x * b.x + b.y * b.y) * (c.x * c.x + c.y * c.y);
    return sum * (1.0 / sqrt(squares));
}
