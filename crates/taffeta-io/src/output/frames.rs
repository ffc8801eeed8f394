//! `frames.csv`: a row a frame, complete at any time.

use super::Begin;
use super::part::Part;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use taffeta::diagnostics::{FabricStrain, FrameReport, SolverReport, energy_kinds};

/// Writes the table of frames.
///
/// ```
/// # use taffeta::scene::{Body, Mass, Mesh, Scene};
/// # use taffeta::{Options, Precision, Simulation};
/// # let cloth = Body::cloth("cloth", Mesh::grid(4, 5, [0.4, 0.3])).with_mass(Mass::Area(0.2));
/// # let scene = Scene::new("").time(0.01, 1e-3).body(cloth.structural(50.0, 0.05));
/// # let mut simulation = Simulation::new(&scene, &Options::default())?;
/// # let folder = tempfile::tempdir()?;
/// use taffeta_io::output::{Begin, FrameTable};
///
/// let path = folder.path().join("frames.csv");
/// let mut table = FrameTable::open(&path, &[("cloth".to_owned(), false, 0)], Begin::New)?;
/// table.row(simulation.step()?, None, 0.1)?;
/// table.finish()?;
/// assert_eq!(std::fs::read_to_string(path)?.lines().count(), 2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct FrameTable {
    part: Part,
    /// For each body, whether it has a column for its volume, and for how many pins it has columns.
    bodies: Vec<(bool, usize)>,
}

impl FrameTable {
    /// Starts the file at `path`, or takes it up. `bodies` are names, whether the body is closed and has a volume, and how
    /// many pins it has.
    pub fn open(path: &Path, bodies: &[(String, bool, usize)], begin: Begin) -> io::Result<Self> {
        let mut part = Part::open(path, begin)?;
        let table =
            |part| Self { part, bodies: bodies.iter().map(|&(_, closed, pins)| (closed, pins)).collect() };
        if begin == Begin::Again {
            return Ok(table(part));
        }
        write!(part, "frame,time,kinetic,gravitational,springs")?;
        energy_kinds().try_for_each(|kind| write!(part, ",{kind}"))?;
        write!(part, ",energy,px,py,pz,lx,ly,lz,max_stretch")?;
        write!(part, ",warp_min,warp_max,weft_min,weft_max,shear,contacts")?;
        write!(
            part,
            ",pairs,nearest_pair,pair_searches,intersections,iterations,residual,active_fraction,broken,substeps,asleep"
        )?;
        for (name, ..) in bodies.iter().filter(|(_, closed, _)| *closed) {
            write!(part, ",{}", quoted(&format!("volume_{name}")))?;
        }
        for (name, pin) in bodies.iter().flat_map(|(name, _, pins)| (0..*pins).map(move |pin| (name, pin))) {
            for axis in ["x", "y", "z"] {
                write!(part, ",{}", quoted(&format!("reaction_{name}_{pin}_{axis}")))?;
            }
        }
        writeln!(part, ",ms")?;
        part.flush()?;
        Ok(table(part))
    }

    /// Adds a frame that took `ms` [ms], and the number of its intersections where they were counted.
    pub fn row(&mut self, report: &FrameReport, intersections: Option<u64>, ms: f64) -> io::Result<()> {
        let r = report;
        let ([px, py, pz], [lx, ly, lz]) = (r.momentum, r.angular_momentum);
        write!(self.part, "{},{},{},{},{}", r.frame, r.time, r.kinetic, r.gravitational, r.springs)?;
        energy_kinds().try_for_each(|kind| write!(self.part, ",{}", r.energy_of(kind)))?;
        write!(self.part, ",{},{px},{py},{pz},{lx},{ly},{lz},{}", r.energy(), r.max_stretch)?;
        match r.strain {
            Some(FabricStrain { warp: [a, b], weft: [c, d], shear, .. }) => {
                write!(self.part, ",{a},{b},{c},{d},{shear}")?;
            }
            None => write!(self.part, ",,,,,")?,
        }
        write!(self.part, ",{}", r.contacts)?;
        let nearest = r.nearest_pair.map(|share| share.to_string()).unwrap_or_default();
        write!(self.part, ",{},{nearest},{}", r.pairs, r.pair_searches)?;
        let intersections = intersections.map(|pairs| pairs.to_string()).unwrap_or_default();
        write!(self.part, ",{intersections}")?;
        let SolverReport { iterations, residual, active_fraction, .. } = r.solver;
        write!(self.part, ",{iterations},{residual},{active_fraction},{},{}", r.broken, r.substeps)?;
        write!(self.part, ",{}", r.asleep)?;
        for (body, _) in self.bodies.iter().enumerate().filter(|(_, (closed, _))| *closed) {
            match r.volumes.get(body).copied().flatten() {
                Some(volume) => write!(self.part, ",{volume}")?,
                None => write!(self.part, ",")?,
            }
        }
        let pins = |(body, &(_, pins)): (usize, &(bool, usize))| (0..pins).map(move |pin| (body, pin));
        for (body, pin) in self.bodies.iter().enumerate().flat_map(pins) {
            match r.reaction(body, pin) {
                Some([x, y, z]) => write!(self.part, ",{x},{y},{z}")?,
                None => write!(self.part, ",,,")?,
            }
        }
        writeln!(self.part, ",{ms}")?;
        self.part.flush()
    }

    /// Length so far [byte].
    pub fn mark(&self) -> u64 {
        self.part.len()
    }

    /// Goes back to where the length was `mark`.
    pub fn rewind(&mut self, mark: u64) -> io::Result<()> {
        self.part.cut(mark)
    }

    /// Puts all rows so far on the disk.
    pub fn sync(&mut self) -> io::Result<()> {
        self.part.sync()
    }

    /// Completes the file and gives it its name, which is returned.
    pub fn finish(self) -> io::Result<PathBuf> {
        self.part.finish()
    }
}

/// A field of a CSV file.
fn quoted(field: &str) -> String {
    if field.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", field.replace('"', "\"\""))
    } else {
        field.to_owned()
    }
}
