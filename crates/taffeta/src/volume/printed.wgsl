// The volume as its paper prints it and as its programs keep it, to compare with.
//
// Source: Va, Choi, Hong, "Real-Time Surface-Based Volume Constraints on Mass-Spring Model in Unity3D", 2023. Eq. 10 has
// −3 g for the gradient; the programs have that too, and Φ for Φ/h² in eq. 14. In λ = (…)/D that leaves, with the error Φ
// [m³] and the flux Σ g·v*/h [m³/s²]:

/// λ D of the programs.
fn volume_of_programs(off: f32, flux: f32) -> f32 {
    return flux - off / 3.0;
}

/// λ D as printed.
fn volume_as_printed(off: f32, flux: f32, h: f32) -> f32 {
    return flux - off / (3.0 * h * h);
}
