//! What a frame does not change of a body in USD: faces and texture coordinates, or the length of a curve.

use std::fmt::Display;
use std::io::{self, Write};
use taffeta::topology::{Polygons, Surface, Uvs};

/// Opens the prim called `name` and writes its topology; the points follow.
pub(super) fn write_topology(out: &mut impl Write, name: &str, surface: &Surface) -> io::Result<()> {
    if surface.polygons.is_empty() {
        return write_curve(out, name, surface.vertices.len());
    }
    writeln!(out, "    def Mesh \"{name}\"\n    {{")?;
    writeln!(out, "        uniform bool doubleSided = 1")?;
    writeln!(out, "        uniform token orientation = \"rightHanded\"")?;
    writeln!(out, "        uniform token subdivisionScheme = \"none\"")?;
    let Polygons { offsets, corners } = &surface.polygons;
    write_list(out, "int[] faceVertexCounts", offsets.windows(2).map(|pair| pair[1] - pair[0]))?;
    writeln!(out)?;
    write_list(out, "int[] faceVertexIndices", corners)?;
    writeln!(out)?;
    surface.uvs.as_ref().map_or(Ok(()), |uvs| write_uvs(out, uvs))
}

fn write_uvs(out: &mut impl Write, uvs: &Uvs) -> io::Result<()> {
    let coords = uvs.coords.iter().map(|[u, v]| format!("({u}, {v})"));
    write_list(out, "texCoord2f[] primvars:st", coords)?;
    writeln!(out, " (\n            interpolation = \"faceVarying\"\n        )")?;
    write_list(out, "int[] primvars:st:indices", &uvs.corners)?;
    writeln!(out)
}

fn write_curve(out: &mut impl Write, name: &str, points: usize) -> io::Result<()> {
    writeln!(out, "    def BasisCurves \"{name}\"\n    {{")?;
    writeln!(out, "        uniform token type = \"linear\"")?;
    writeln!(out, "        int[] curveVertexCounts = [{points}]")
}

fn write_list<T: Display>(
    out: &mut impl Write,
    what: &str,
    items: impl IntoIterator<Item = T>,
) -> io::Result<()> {
    write!(out, "        {what} = [")?;
    for (i, item) in items.into_iter().enumerate() {
        let comma = if i == 0 { "" } else { ", " };
        write!(out, "{comma}{item}")?;
    }
    write!(out, "]")
}
