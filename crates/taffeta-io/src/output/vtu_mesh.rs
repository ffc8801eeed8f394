//! One frame of one body as a VTK unstructured grid: XML, then all arrays in binary (VTK XML format 1.0, appended raw).

use super::Positions;
use super::uvs::uvs_of_vertices;
use std::io::{self, Write};
use taffeta::Precision;
use taffeta::topology::{Polygons, Surface};

/// Everything of a body's files but its times and positions.
pub(super) struct Grid {
    before_time: String,
    after_time: String,
    /// The arrays after the positions, as they are in the file.
    arrays: Vec<u8>,
    precision: Precision,
}

impl Grid {
    /// The faces, links and texture coordinates of `surface`; the latter only where each vertex has one, as VTK has
    /// none for corners. `None`: too large for 32-bit indices.
    pub fn of(surface: &Surface, precision: Precision) -> Option<Self> {
        let points = surface.vertices.len();
        let (number, size) = match precision {
            Precision::F32 => ("Float32", 4),
            Precision::F64 => ("Float64", 8),
        };
        let mut arrays = Arrays { offset: 8 + 3 * size * points, bytes: Vec::new() };
        let cells = arrays.cells(surface)?;
        let (mut opening, mut data) = ("<PointData>", String::new());
        if let Some(uvs) = surface.uvs.as_ref().and_then(|uvs| uvs_of_vertices(surface, uvs)) {
            let uvs = uvs.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
            let attributes = "type=\"Float32\" Name=\"TCoords\" NumberOfComponents=\"2\"";
            (opening, data) = ("<PointData TCoords=\"TCoords\">", arrays.add(attributes, uvs));
        }
        let before_time = "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" \
                           byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<UnstructuredGrid>\n<FieldData>\n\
                           <DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">"
            .to_owned();
        let count = surface.polygons.len() + surface.links.len();
        let after_time = format!(
            "</DataArray>\n</FieldData>\n<Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{count}\">\n\
             {opening}\n{data}</PointData>\n<Points>\n\
             <DataArray type=\"{number}\" Name=\"Points\" NumberOfComponents=\"3\" format=\"appended\" offset=\"0\"/>\n\
             </Points>\n<Cells>\n{cells}</Cells>\n</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_"
        );
        Some(Self { before_time, after_time, arrays: arrays.bytes, precision })
    }

    /// Writes the file for `time` [s].
    pub fn write(&self, out: &mut impl Write, time: f64, positions: &Positions) -> io::Result<()> {
        write!(out, "{}{time}{}", self.before_time, self.after_time)?;
        out.write_all(&((3 * positions.len() * self.precision.bytes()) as u64).to_le_bytes())?;
        positions.write(self.precision, out)?;
        out.write_all(&self.arrays)?;
        out.write_all(b"\n</AppendedData>\n</VTKFile>\n")
    }
}

/// Arrays one after the other, each after its length in bytes.
struct Arrays {
    /// Where the next one starts, from the first of the file on [byte].
    offset: usize,
    bytes: Vec<u8>,
}

impl Arrays {
    /// Adds an array and returns the XML that points to it.
    fn add(&mut self, attributes: &str, bytes: Vec<u8>) -> String {
        let xml = format!("<DataArray {attributes} format=\"appended\" offset=\"{}\"/>\n", self.offset);
        self.offset += 8 + bytes.len();
        self.bytes.extend((bytes.len() as u64).to_le_bytes());
        self.bytes.extend(bytes);
        xml
    }

    /// Adds faces and links as cells.
    fn cells(&mut self, surface: &Surface) -> Option<String> {
        let Surface { polygons: Polygons { offsets, corners }, links, .. } = surface;
        let links_end = corners.len() + 2 * links.len();
        i32::try_from(links_end.max(surface.vertices.len())).ok()?;
        let ends = offsets.iter().skip(1).copied();
        let ends = ends.chain((corners.len() + 2..=links_end).step_by(2).map(|end| end as u32));
        let kinds = surface.polygons.iter().map(|polygon| match polygon.len() {
            3 => TRIANGLE,
            4 => QUAD,
            _ => POLYGON,
        });
        let kinds = kinds.chain(links.iter().map(|_| LINE)).collect();
        let bytes = |numbers: &mut dyn Iterator<Item = u32>| numbers.flat_map(u32::to_le_bytes).collect();
        let corners = bytes(&mut corners.iter().chain(links.as_flattened()).copied());
        let mut xml = self.add("type=\"Int32\" Name=\"connectivity\"", corners);
        xml += &self.add("type=\"Int32\" Name=\"offsets\"", bytes(&mut ends.into_iter()));
        xml += &self.add("type=\"UInt8\" Name=\"types\"", kinds);
        Some(xml)
    }
}

// VTK's numbers for kinds of cells.
const LINE: u8 = 3;
const TRIANGLE: u8 = 5;
const POLYGON: u8 = 7;
const QUAD: u8 = 9;
