//! Pulls in the plane of a fabric, against its tensor.

use crate::bench::{Bench, Extent, Job, Rest, Row, Solver};
use crate::flat::{Flat, Lattice};
use crate::groups::Group;
use crate::specimen::{Case, GRAVITY, Plain, body, cases, clamped, head, mean, pin, strip, tip};

pub const GROUP: Group = Group {
    name: "pulls",
    title: "Pulls in the plane",
    words: "A square of 20 cm of an orthotropic fabric (500 and 300 N/m along warp and weft, ν = 0.3, shear 60 N/m) floats and is \
            pulled at its border by the same traction everywhere: along the warp, along the weft, both, in shear beside a pull (as \
            in a shear frame), and at 45° to the warp (on the bias). The mean deformation is held against the compliance of the \
            tensor, 1/S_warp, −ν/S_warp, 1/S_weft, 1/G, and ¼ (1/S_warp + 1/S_weft − 2 ν/S_warp + 1/G) on the bias. A stretch by s \
            along the warp from a traction of S ½ (s² − 1) s (ν = 0) checks large strains. A strip of 50 cm that hangs by one end is \
            longer by ρ g L²/(2 S). Allowed is 1 %.",
    axes: ["elements a length", "strain of a traction that stretches by 1.2"],
    is_logarithmic: false,
    theory: Some(|| vec![(8.0, 0.2), (40.0, 0.2)]),
    jobs,
};

const SIDE: f64 = 0.2;
const STRETCH: [f64; 2] = [500.0, 300.0];
const POISSON: f64 = 0.3;
const SHEAR: f64 = 60.0;

/// A traction: force by length of the border [N/m], symmetric: 11, 22, 12 by the mesh's axes.
type Traction = [f64; 3];

fn jobs(extent: Extent) -> Vec<Job> {
    let job = |case: Case| {
        Job::of(case, move |bench| {
            let mut rows = vec![hanging(bench, case)?, large(bench, case)?];
            let (warp, weft) = ([1.0, 0.0, 0.0], [0.0, 0.6, 0.0]);
            let [s1, s2] = STRETCH;
            let e = |row: Row, expected: f64| row.within(expected, 1.0);
            let found = pulled(bench, case, "warp", warp, [1.0, 0.0])?;
            rows.push(e(row(case, "warp", "strain along a pull on the warp", found[0]), 1.0 / s1));
            rows.push(e(row(case, "warp", "strain across a pull on the warp", found[1]), -POISSON / s1));
            let found = pulled(bench, case, "weft", weft, [1.0, 0.0])?;
            rows.push(e(row(case, "weft", "strain along a pull on the weft", found[1]), 0.6 / s2));
            let found = pulled(bench, case, "biaxial", [1.0, 0.6, 0.0], [1.0, 0.0])?;
            rows.push(e(
                row(case, "biaxial", "strain of the warp, pulled on both", found[0]),
                (1.0 - 0.6 * POISSON) / s1,
            ));
            let found = pulled(bench, case, "shear", [0.3, 0.3, 0.05], [1.0, 0.0])?;
            rows.push(e(row(case, "shear", "shear angle in a frame [rad]", found[2]), 0.05 / SHEAR));
            let found = pulled(bench, case, "bias", [0.2, 0.0, 0.0], [1.0, 1.0])?;
            let compliance = 0.25 * (1.0 / s1 + 1.0 / s2 - 2.0 * POISSON / s1 + 1.0 / SHEAR);
            rows.push(e(row(case, "bias", "strain along a pull on the bias", found[0]), 0.2 * compliance));
            Ok(rows)
        })
    };
    cases(extent, [10, 20, 40]).into_iter().map(job).collect()
}

fn row(case: Case, name: &str, what: &str, ours: f64) -> Row {
    Row::new(what, ours, &case.variant(&format!("pull-{name}")))
}

/// Pulls at the border of a floating square; strain along its axes and the angle between them.
fn pulled(
    bench: &Bench<'_>,
    case: Case,
    name: &str,
    traction: Traction,
    warp: [f64; 2],
) -> Result<[f64; 3], String> {
    let ([s1, s2], poisson) = (STRETCH, POISSON);
    let material = format!(
        "[body.material]\ndensity = 0.2\nstretch = [{s1:?}, {s2:?}]\nshear = {SHEAR:?}\npoisson = {poisson:?}\nbending = 1e-5\n\
         damping = {{ stretch = {:?}, bending = 0.0 }}\nwarp = [{:?}, {:?}]\n",
        damping(case.solver),
        warp[0],
        warp[1]
    );
    let (mesh, places) = floats(bench, case, &format!("pull-{name}"), &material, traction)?;
    let gradient = affine(&mesh, &places);
    Ok([gradient[0][0] - 1.0, gradient[1][1] - 1.0, gradient[0][1] + gradient[1][0]])
}

/// As much as lets a square come to rest soon; what explicit steps stand.
fn damping(solver: Solver) -> f64 {
    if solver.is_implicit { 1e-2 } else { 1e-4 }
}

/// A stretch of 1.2 along the warp.
fn large(bench: &Bench<'_>, case: Case) -> Result<Row, String> {
    let s: f64 = 1.2;
    let material = format!(
        "[body.material]\ndensity = 0.2\nstretch = 500.0\nshear = 250.0\npoisson = 0.0\nbending = 1e-5\n\
         damping = {{ stretch = {:?}, bending = 0.0 }}\n",
        damping(case.solver)
    );
    let traction = [500.0 * 0.5 * (s * s - 1.0) * s, 0.0, 0.0];
    let (mesh, places) = floats(bench, case, "pull-large", &material, traction)?;
    let found = affine(&mesh, &places)[0][0];
    let strain = row(case, "large", "strain of a traction that stretches by 1.2", found - 1.0);
    Ok(strain.within(s - 1.0, 1.0).at(case.line(), case.elements as f64))
}

/// Where a floating square comes to rest under a traction.
fn floats(
    bench: &Bench<'_>,
    case: Case,
    name: &str,
    material: &str,
    [t11, t22, t12]: Traction,
) -> Result<(Flat, Vec<[f64; 3]>), String> {
    let variant = case.variant(name);
    let lattice: Lattice = case.lattice(SIDE);
    let mesh = Flat::rectangle([-0.5 * SIDE; 2], [0.5 * SIDE; 2], &[], lattice);
    bench.write(&format!("{}.obj", variant.name), &mesh.obj())?;
    let drag =
        if case.solver.is_implicit { 0.0 } else { 0.2 * SIDE * SIDE / mesh.nodes.len() as f64 * 100.0 };
    let world = format!("gravity = [0.0, 0.0, 0.0]\ndrag = {drag:?}");
    let mut scene =
        head("A square that is pulled at its border", 0.02, case.solver, &world) + &body(&variant, material);
    for (node, [n1, n2]) in
        mesh.border_normals().into_iter().enumerate().filter(|(_, normal)| *normal != [0.0; 2])
    {
        let force = [t11 * n1 + t12 * n2, 0.0, t12 * n1 + t22 * n2];
        scene +=
            &format!("[[force]]\nbody = \"cloth\"\nselect = {{ nodes = [{node}] }}\nforce = {force:?}\n");
    }
    let mut running = bench.start(&variant, &scene)?;
    running.settle(Rest { moves: 2e-7 * SIDE, window: 0.1, longest: 4.0 })?;
    Ok((mesh, running.positions()))
}

/// The affine map that is nearest to a deformation: its gradient by the mesh's axes.
fn affine(mesh: &Flat, places: &[[f64; 3]]) -> [[f64; 2]; 2] {
    let count = mesh.nodes.len() as f64;
    let middle = [0, 1].map(|i| mesh.nodes.iter().map(|node| node[i]).sum::<f64>() / count);
    let mut moments = [[0.0; 2]; 2];
    let mut products = [[0.0; 2]; 2];
    for (node, place) in mesh.nodes.iter().zip(places) {
        let (from, to) = ([node[0] - middle[0], node[1] - middle[1]], [place[0], place[2]]);
        for i in 0..2 {
            for j in 0..2 {
                moments[i][j] += from[i] * from[j];
                products[i][j] += to[i] * from[j];
            }
        }
    }
    let [[a, b], [c, d]] = moments;
    let determinant = a * d - b * c;
    products.map(|[p, q]| [(p * d - q * c) / determinant, (q * a - p * b) / determinant])
}

/// How much longer a strip is that hangs by one end.
fn hanging(bench: &Bench<'_>, case: Case) -> Result<Row, String> {
    let (length, stretch, density) = (0.5, 500.0, 0.2);
    let variant = case.variant("hanging");
    let mesh = strip(length, 0.1, case.lattice(length));
    bench.write(&format!("{}.obj", variant.name), &mesh.obj())?;
    let damping = [damping(case.solver), 0.0];
    let fabric = Plain { density, stretch, poisson: 0.0, bending: 1e-5, bending_poisson: 0.0, damping };
    let node_mass = density * length * 0.1 / mesh.nodes.len() as f64;
    let drag = if case.solver.is_implicit { 0.0 } else { 100.0 * node_mass };
    // Along x, so that it hangs straight from the start.
    let world = format!("gravity = [{GRAVITY:?}, 0.0, 0.0]\ndrag = {drag:?}");
    let scene = head("A strip that hangs by one end", 0.02, case.solver, &world)
        + &body(&variant, &fabric.toml())
        + &pin(&clamped(&mesh));
    let mut running = bench.start(&variant, &scene)?;
    running.settle(Rest { moves: 2e-7 * length, window: 0.1, longest: 4.0 })?;
    let longer = mean(&running.positions(), &tip(&mesh, length), 0) - length;
    let row = Row::new("how much longer a hanging strip is [mm]", 1e3 * longer, &variant);
    Ok(row.within(1e3 * density * GRAVITY * length * length / (2.0 * stretch), 1.0))
}
