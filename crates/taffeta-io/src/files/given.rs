//! Files that a program gives as bytes, where there is no disk.

use std::collections::BTreeMap;
use std::io::{self, ErrorKind};
use std::path::{Component, Path};

/// Files by the names that a scene has for them: they stand in for all folders.
///
/// ```
/// use taffeta_io::Given;
///
/// let given: Given = [("kite.obj".to_owned(), b"v 0 0 0".to_vec())].into_iter().collect();
/// assert_eq!(given.get("./kite.obj".as_ref()), Some(&b"v 0 0 0"[..]));
/// ```
#[derive(Clone, Debug, Default)]
pub struct Given(BTreeMap<String, Vec<u8>>);

impl FromIterator<(String, Vec<u8>)> for Given {
    fn from_iter<I: IntoIterator<Item = (String, Vec<u8>)>>(files: I) -> Self {
        Self(files.into_iter().map(|(name, bytes)| (plain(name.as_ref()), bytes)).collect())
    }
}

impl Given {
    /// The bytes of a file.
    pub fn get(&self, name: &Path) -> Option<&[u8]> {
        self.0.get(&plain(name)).map(Vec::as_slice)
    }

    /// The names of all.
    pub fn names(&self) -> Vec<String> {
        self.0.keys().cloned().collect()
    }

    /// The first bytes of a file, at most so many.
    pub(crate) fn read(&self, name: &Path, most: u64) -> io::Result<Vec<u8>> {
        let bytes =
            self.get(name).ok_or_else(|| io::Error::new(ErrorKind::NotFound, "no such file was given"))?;
        Ok(bytes[..usize::try_from(most).map_or(bytes.len(), |most| most.min(bytes.len()))].to_vec())
    }
}

/// A name with `/` alone, and without `.` and `..` where something goes before.
fn plain(name: &Path) -> String {
    let mut parts: Vec<&str> = Vec::new();
    for component in name.components() {
        match component {
            Component::Normal(part) => parts.push(part.to_str().unwrap_or_default()),
            Component::ParentDir if parts.last().is_some_and(|last| *last != "..") => drop(parts.pop()),
            Component::ParentDir => parts.push(".."),
            _ => {}
        }
    }
    parts.join("/")
}
