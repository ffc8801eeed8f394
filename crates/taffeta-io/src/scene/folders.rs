//! Where the files of a scene may lie: its folder, `models/` folders and `$TAFFETA_MODELS`. Nothing else is read.

use super::words::nearest;
use crate::files::Given;
use crate::mesh::MeshOptions;
use std::cell::RefCell;
use std::path::{Component, Path, PathBuf};

/// Entries of a folder that are looked through for a name that was meant.
const MOST_ENTRIES: usize = 10_000;

/// The folders that are searched, in order.
pub(super) struct Folders<'a> {
    folders: Vec<PathBuf>,
    /// Files in place of all folders.
    given: Option<&'a Given>,
    used: RefCell<Vec<PathBuf>>,
}

/// Why a file cannot be used.
#[derive(Debug)]
pub(super) enum Unusable {
    /// It is in none of the folders; the words say where it was looked for.
    Missing(String),
    /// It may not be read.
    Refused(String),
}

impl<'a> Folders<'a> {
    /// Folders for the scene at `scene`; `models` is the value of `$TAFFETA_MODELS`.
    pub fn of(scene: &Path, models: Option<PathBuf>) -> Self {
        let full = scene.canonicalize().unwrap_or_else(|_| scene.to_owned());
        let own = full.parent().map(Path::to_owned);
        let current = std::env::current_dir().ok().map(|folder| folder.join("models"));
        let above = full.ancestors().skip(1).map(|folder| folder.join("models"));
        let mut folders: Vec<PathBuf> = Vec::new();
        for folder in own.into_iter().chain(current).chain(above).chain(models) {
            if let Ok(folder) = folder.canonicalize()
                && !folders.contains(&folder)
            {
                folders.push(folder);
            }
        }
        Self { folders, given: None, used: RefCell::default() }
    }

    /// Files that are given in place of all folders.
    pub fn given(files: &'a Given) -> Self {
        Self { folders: Vec::new(), given: Some(files), used: RefCell::default() }
    }

    /// How the meshes in them are read.
    pub fn options(&self) -> MeshOptions<'_> {
        MeshOptions { within: &self.folders, given: self.given, ..MeshOptions::default() }
    }

    /// The first bytes of a file that was found, at most so many.
    pub fn read(&self, path: &Path, most: u64) -> std::io::Result<Vec<u8>> {
        self.given.map_or_else(|| crate::files::read(path, most), |given| given.read(path, most))
    }

    /// The files that were found so far.
    pub fn used(self) -> Vec<PathBuf> {
        self.used.into_inner()
    }

    /// The full path of the file that a scene calls `name`.
    pub fn find(&self, name: &str) -> Result<PathBuf, Unusable> {
        if leaves(Path::new(name)) {
            return Err(Unusable::Refused(format!(
                "`{name}` is not a path inside the scene's folder, `models/` or `$TAFFETA_MODELS`; put the file \
                 into one of them and write its path from there"
            )));
        }
        if let Some(given) = self.given {
            let path = PathBuf::from(name);
            let missing = || match &given.names()[..] {
                [] => Unusable::Missing(format!("`{name}` was not given, nor any other file")),
                some => {
                    Unusable::Missing(format!("`{name}` is not among the files given: {}", some.join(", ")))
                }
            };
            return given.get(&path).map(|_| path).ok_or_else(missing);
        }
        let mut odd = None;
        for folder in &self.folders {
            let Ok(path) = folder.join(name).canonicalize() else { continue };
            if !self.folders.iter().any(|folder| path.starts_with(folder)) {
                return Err(Unusable::Refused(format!(
                    "`{name}` is a link to {}, outside of the scene's folder, `models/` and `$TAFFETA_MODELS`",
                    path.display()
                )));
            }
            if path.is_file() {
                self.used.borrow_mut().push(path.clone());
                return Ok(path);
            }
            odd = Some(path);
        }
        if let Some(path) = odd {
            let what = if path.is_dir() { "a folder" } else { "no regular file" };
            return Err(Unusable::Refused(format!("`{name}` is {what}; a file would do")));
        }
        let places: Vec<String> = self.folders.iter().map(|folder| folder.display().to_string()).collect();
        let like =
            self.like(name).map_or_else(|| "; l".to_owned(), |like| format!("; did you mean `{like}`? L"));
        Err(Unusable::Missing(format!(
            "`{name}` was not found{like}ooked in {}. `cargo xtask models` fetches the real models",
            places.join(", ")
        )))
    }

    /// A file whose name is like this one.
    fn like(&self, name: &str) -> Option<String> {
        let (parent, last) = match name.rsplit_once('/') {
            Some((parent, last)) => (format!("{parent}/"), last),
            None => (String::new(), name),
        };
        let mut names: Vec<String> = Vec::new();
        for folder in &self.folders {
            let entries = std::fs::read_dir(folder.join(&parent)).into_iter().flatten().flatten();
            let files = entries.take(MOST_ENTRIES).filter(|entry| entry.path().is_file());
            let names_of = files.filter_map(|entry| entry.file_name().into_string().ok());
            names.extend(names_of.filter(|found| is_kin(Path::new(found), Path::new(last))));
        }
        names.sort();
        nearest(last, &names).map(|like| format!("{parent}{like}"))
    }
}

/// Whether a file may be meant by another name: they have an ending or all before it in common, and it is no scene.
fn is_kin(found: &Path, name: &Path) -> bool {
    let is_scene = found.extension().is_some_and(|ending| ending == "toml");
    !is_scene && (found.extension() == name.extension() || found.file_stem() == name.file_stem())
}

/// Whether the path is absolute or climbs out of the folder it starts in.
fn leaves(path: &Path) -> bool {
    let mut depth = 0_usize;
    for component in path.components() {
        match component {
            Component::Normal(_) => depth += 1,
            Component::CurDir => {}
            Component::ParentDir if depth > 0 => depth -= 1,
            _ => return true,
        }
    }
    depth == 0
}
