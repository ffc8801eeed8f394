//! Checkpoints: all that a run needs to go on, in one file that is whole or not there.
//!
//! | bytes | what |
//! |---|---|
//! | 8 | `TAFFETA` and a zero |
//! | 4 | version of this format |
//! | 8 | length of the whole file |
//! | 8 | length of the record |
//! | … | the record: scene, reports, what the program wants to remember (postcard) |
//! | … | positions, then velocities of all nodes |
//! | … | pulls of constraints, then a bit for each constraint that comes and goes, then for each joint |
//! | 8 | XXH64 of all bytes before |
//!
//! Numbers are little endian.

use crate::files::{self, in_file};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::hash::Hasher;
use std::io::{self, Read};
use std::path::Path;
use taffeta::Snapshot;
pub use taffeta::scene::{difference, identity};
use twox_hash::XxHash64;

const MAGIC: &[u8; 8] = b"TAFFETA\0";
/// Version of the format; one higher whenever the record changes.
const VERSION: u32 = 16;
/// Magic, version and both lengths.
const HEAD: usize = 28;
/// The hash at the end.
const TAIL: usize = 8;

/// A run between two frames. [`difference`] says whether `scene` is that of [`identity`] for the scene to go on with;
/// then [`taffeta::Simulation::restore`] takes the snapshot. `R` is whatever else your program remembers.
///
/// ```
/// # use taffeta::scene::{Body, Mass, Mesh, Scene};
/// # use taffeta::{Options, Precision, Simulation};
/// # let cloth = Body::cloth("cloth", Mesh::grid(4, 5, [0.4, 0.3])).with_mass(Mass::Area(0.2));
/// # let scene = Scene::new("").time(0.01, 1e-3).body(cloth.structural(50.0, 0.05));
/// # let mut simulation = Simulation::new(&scene, &Options::default())?;
/// # let folder = tempfile::tempdir()?;
/// use taffeta_io::Checkpoint;
/// use taffeta_io::checkpoint::{difference, identity};
///
/// simulation.advance(2)?;
/// let path = folder.path().join("checkpoint.taffeta");
/// Checkpoint { scene: identity(&scene), snapshot: simulation.snapshot(), run: "mine".to_owned() }.write(&path)?;
/// // In another process, maybe:
/// let checkpoint: Checkpoint<String> = Checkpoint::read(&path)?;
/// assert_eq!(difference(&checkpoint.scene, &identity(&scene)), None);
/// let mut again = Simulation::new(&scene, &Options::default())?;
/// again.restore(&checkpoint.snapshot)?;
/// assert_eq!((again.frame(), checkpoint.run.as_str()), (2, "mine"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoint<R> {
    /// The scene, as [`identity`] writes it.
    pub scene: String,
    /// The simulation.
    pub snapshot: Snapshot,
    /// What the program remembers of the run.
    pub run: R,
}

#[derive(Serialize)]
struct Record<'a, R> {
    program: &'a str,
    scene: &'a str,
    snapshot: &'a Snapshot,
    run: &'a R,
}

#[derive(Deserialize)]
struct OwnedRecord<R> {
    program: String,
    scene: String,
    snapshot: Snapshot,
    run: R,
}

impl<R: Serialize> Checkpoint<R> {
    /// Writes the file at `path`; what was there stays until the new one is whole and on the disk.
    pub fn write(&self, path: &Path) -> io::Result<()> {
        let [head, record, hash] = self.around().map_err(|error| in_file(path, io::Error::other(error)))?;
        let Snapshot { state, constraints, .. } = &self.snapshot;
        files::replace(path, &[&head, &record, state, constraints, &hash])
    }

    /// The bytes of such a file, as [`Self::parse`] reads them.
    ///
    /// # Errors
    /// Where what the program remembers cannot be written.
    pub fn to_bytes(&self) -> Result<Vec<u8>, String> {
        let [head, record, hash] = self.around()?;
        Ok([&head[..], &record, &self.snapshot.state, &self.snapshot.constraints, &hash].concat())
    }

    /// What stands before and after the state: head, record, hash.
    fn around(&self) -> Result<[Vec<u8>; 3], String> {
        let Self { scene, snapshot, run } = self;
        let record = Record { program: env!("CARGO_PKG_VERSION"), scene, snapshot, run };
        let record = postcard::to_stdvec(&record).map_err(|error| error.to_string())?;
        let length = HEAD + record.len() + snapshot.state.len() + snapshot.constraints.len() + TAIL;
        let mut head = Vec::from(MAGIC);
        head.extend(VERSION.to_le_bytes());
        head.extend((length as u64).to_le_bytes());
        head.extend((record.len() as u64).to_le_bytes());
        let pieces = [&head[..], &record, &snapshot.state, &snapshot.constraints];
        let mut hasher = XxHash64::with_seed(0);
        pieces.iter().for_each(|piece| hasher.write(piece));
        let hash = hasher.finish().to_le_bytes().to_vec();
        Ok([head, record, hash])
    }
}

impl<R: DeserializeOwned> Checkpoint<R> {
    /// Reads the file at `path`. The error says why it cannot be used.
    pub fn read(path: &Path) -> Result<Self, String> {
        let read = || {
            let unread = |error: io::Error| format!("cannot be read: {error}");
            let mut file = files::open(path).map_err(unread)?;
            let length = file.metadata().map_err(unread)?.len();
            let mut bytes = Vec::new();
            (&mut file).take(HEAD as u64).read_to_end(&mut bytes).map_err(unread)?;
            // What is no checkpoint may be of any size.
            check_head(&bytes, length)?;
            file.read_to_end(&mut bytes).map_err(unread)?;
            Self::parse(&bytes)
        };
        read().map_err(|what| format!("{}: {what}", path.display()))
    }

    /// Reads a checkpoint from bytes.
    ///
    /// # Errors
    /// Says whether it is no checkpoint, of another version, or damaged.
    pub fn parse(bytes: &[u8]) -> Result<Self, String> {
        let (record, data) = open(bytes)?;
        let record: OwnedRecord<R> = postcard::from_bytes(record).map_err(|error| {
            format!("its record is not of this program's kind ({error}); start the run again")
        })?;
        let OwnedRecord { program, scene, mut snapshot, run } = record;
        let Some((state, constraints)) = split(&snapshot, data) else {
            return Err(format!(
                "written by taffeta {program}, it has {} bytes of state for {} nodes and {} constraints",
                data.len(),
                snapshot.nodes,
                snapshot.pulls.max(snapshot.adaptive).max(snapshot.joints)
            ));
        };
        (snapshot.state, snapshot.constraints) = (state.to_vec(), constraints.to_vec());
        Ok(Self { scene, snapshot, run })
    }
}

/// The bytes of nodes and of constraints, if there are as many as the snapshot says.
fn split<'a>(snapshot: &Snapshot, data: &'a [u8]) -> Option<(&'a [u8], &'a [u8])> {
    let parts = data.split_at_checked(usize::try_from(snapshot.state_bytes()?).ok()?)?;
    (snapshot.constraint_bytes()? == parts.1.len() as u64).then_some(parts)
}

/// The record and what follows it, after magic, version, length and hash were found right.
fn open(bytes: &[u8]) -> Result<(&[u8], &[u8]), String> {
    let record = check_head(bytes, bytes.len() as u64)?;
    let (content, hash) = bytes.split_at(bytes.len().saturating_sub(TAIL));
    let mut hasher = XxHash64::with_seed(0);
    hasher.write(content);
    if hash != hasher.finish().to_le_bytes() {
        return Err("damaged: its checksum does not fit its content".to_owned());
    }
    let body = content.get(HEAD..).and_then(|body| body.split_at_checked(usize::try_from(record).ok()?));
    body.ok_or_else(|| format!("damaged: a record of {record} bytes does not fit into it"))
}

/// The length of the record [byte] in a file of `size` bytes that begins with `bytes`.
fn check_head(bytes: &[u8], size: u64) -> Result<u64, String> {
    if !bytes.starts_with(MAGIC) {
        return Err("not a checkpoint of taffeta: it does not begin like one".to_owned());
    }
    let (Some(version), Some(length), Some(record)) = (word(bytes, 8), word(bytes, 12), word(bytes, 20))
    else {
        return Err(format!("damaged: {size} bytes are too few for a checkpoint"));
    };
    // The version has four bytes only.
    let version = version as u32;
    if version != VERSION {
        let age = if version < VERSION { "an older" } else { "a newer" };
        return Err(format!(
            "written by {age} program, in version {version} of the format; this one reads version {VERSION}: \
             resume with that version, or start the run again"
        ));
    }
    if length != size {
        return Err(format!("damaged: it has {size} bytes and should have {length}"));
    }
    Ok(record)
}

/// Eight bytes from `at` on.
fn word(bytes: &[u8], at: usize) -> Option<u64> {
    Some(u64::from_le_bytes(*bytes.get(at..)?.first_chunk()?))
}
