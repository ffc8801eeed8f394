//! A disk as POSIX promises it, and what a power failure may leave on it.
//!
//! What a program writes, creates, renames and removes is at first in memory alone. `fsync` of a file puts its content on the disk and not
//! its name, `fsync` of a folder the names in it and not their content. Of all else anything may be on the disk, in any order:
//!
//! - of a write all, half, the length alone, whose bytes are zeros then, or nothing, whatever became of earlier and later ones;
//! - a name that was given, changed or taken away, if what it builds on is there: a rename needs the creation, and it is atomic.
//!
//! File systems promise more: with ext4, syncing a new file also keeps its name. That is not counted on here.

use std::collections::{BTreeMap, HashMap};
use std::fs;
use std::path::Path;

/// Files by their paths with their content; a folder has none.
pub type State = BTreeMap<String, Option<Vec<u8>>>;

/// What a program asks for; paths are relative to the folder that the disk stands for.
#[derive(Clone, Debug, PartialEq)]
pub enum Operation {
    Open {
        file: i32,
        path: String,
        create: bool,
        truncate: bool,
    },
    Close {
        file: i32,
    },
    /// Where the next write goes.
    Seek {
        file: i32,
        at: usize,
    },
    Read {
        file: i32,
        bytes: usize,
    },
    /// Without a place it goes where the last one ended.
    Write {
        file: i32,
        at: Option<usize>,
        bytes: Vec<u8>,
    },
    Resize {
        file: i32,
        length: usize,
    },
    Sync {
        file: i32,
    },
    MakeFolder {
        path: String,
    },
    Rename {
        from: String,
        to: String,
    },
    Remove {
        path: String,
    },
    /// Something that this model does not know, with files or paths.
    Unknown {
        call: String,
        files: Vec<i32>,
        paths: Vec<String>,
    },
}

/// What is on the disk of something that was not synced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fate {
    Kept,
    Lost,
    /// Of a write: the first half of it.
    Half,
    /// Of a write: the file is as long as with it.
    Length,
}

/// Something that was not synced.
#[derive(Clone, Copy)]
pub struct Unsynced {
    /// Whether it is about a name in a folder, not about the content of a file.
    pub is_name: bool,
    /// Whether it can be kept in part.
    pub is_write: bool,
    /// The folder or the file.
    pub node: usize,
    /// Its place among what was not synced of the same folder or file, and among all of its kind.
    pub index: usize,
    pub number: usize,
}

pub struct Disk {
    nodes: Vec<Node>,
    /// The node of each open file, and where it is written next.
    open: HashMap<i32, (usize, usize)>,
}

/// The folder that the disk stands for.
const ROOT: usize = 0;

struct Node {
    /// What it was called first.
    name: String,
    content: Content,
}

enum Content {
    File { synced: Vec<u8>, unsynced: Vec<Change> },
    Folder { synced: Names, unsynced: Vec<Naming> },
}

type Names = BTreeMap<String, usize>;

enum Change {
    Write { at: usize, bytes: Vec<u8> },
    Resize(usize),
}

enum Naming {
    Give(String, usize),
    Change { from: String, to: String, node: usize },
    Take(String, usize),
}

impl Disk {
    /// A disk with an empty folder.
    pub fn new() -> Self {
        let mut disk = Self { nodes: Vec::new(), open: HashMap::new() };
        disk.add(String::new(), Content::Folder { synced: Names::new(), unsynced: Vec::new() });
        disk
    }

    /// What is in a folder `name` within `root` now, all of it synced.
    pub fn of(root: &Path, name: &str) -> std::io::Result<Self> {
        let mut disk = Self::new();
        if root.join(name).exists() {
            let node = disk.take_in(root, name)?;
            disk.nodes[ROOT].content =
                Content::Folder { synced: Names::from([(name.to_owned(), node)]), unsynced: Vec::new() };
        }
        Ok(disk)
    }

    fn take_in(&mut self, root: &Path, path: &str) -> std::io::Result<usize> {
        let real = root.join(path);
        let content = if real.is_dir() {
            let mut synced = Names::new();
            for entry in fs::read_dir(&real)? {
                let name = entry?.file_name().to_string_lossy().into_owned();
                let node = self.take_in(root, &format!("{path}/{name}"))?;
                synced.insert(name, node);
            }
            Content::Folder { synced, unsynced: Vec::new() }
        } else {
            Content::File { synced: fs::read(&real)?, unsynced: Vec::new() }
        };
        Ok(self.add(path.to_owned(), content))
    }

    fn add(&mut self, name: String, content: Content) -> usize {
        self.nodes.push(Node { name, content });
        self.nodes.len() - 1
    }

    /// Does what a program asked for. Says in words what has changed, if anything has.
    pub fn apply(&mut self, operation: &Operation) -> Result<Option<String>, String> {
        match operation {
            Operation::Open { file, path, create, truncate } => self.open(*file, path, *create, *truncate),
            Operation::MakeFolder { path } => {
                let folder = Content::Folder { synced: Names::new(), unsynced: Vec::new() };
                self.create(path, folder)?;
                Ok(Some(format!("make {path}")))
            }
            Operation::Rename { from, to } => {
                let (folder, from_name, node) = self.named(from)?;
                let (other, to_name) = self.place(to)?;
                if other != folder {
                    return Err(format!(
                        "{from} goes to another folder, {to}, and this model has no such rename"
                    ));
                }
                self.name(folder, Naming::Change { from: from_name, to: to_name, node });
                Ok(Some(format!("rename {from} to {to}")))
            }
            Operation::Remove { path } => {
                let (folder, name, node) = self.named(path)?;
                self.name(folder, Naming::Take(name, node));
                Ok(Some(format!("remove {path}")))
            }
            Operation::Unknown { call, files, paths } => {
                let is_ours = files.iter().any(|file| self.open.contains_key(file)) || !paths.is_empty();
                if is_ours { Err(format!("this model does not know {call}")) } else { Ok(None) }
            }
            Operation::Close { file } => {
                self.open.remove(file);
                Ok(None)
            }
            Operation::Seek { file, .. }
            | Operation::Read { file, .. }
            | Operation::Write { file, .. }
            | Operation::Resize { file, .. }
            | Operation::Sync { file } => match self.open.get(file).copied() {
                Some(place) => self.use_open(operation, *file, place),
                None => Ok(None),
            },
        }
    }

    fn open(
        &mut self,
        file: i32,
        path: &str,
        create: bool,
        truncate: bool,
    ) -> Result<Option<String>, String> {
        let there = self.find(path);
        let node = match there {
            Some(node) => node,
            None if create => {
                self.create(path, Content::File { synced: Vec::new(), unsynced: Vec::new() })?
            }
            // Not of this disk, such as the scene.
            None => return Ok(None),
        };
        self.open.insert(file, (node, 0));
        if truncate && there.is_some() {
            self.change(node, Change::Resize(0));
            return Ok(Some(format!("empty {path}")));
        }
        Ok(there.is_none().then(|| format!("create {path}")))
    }

    fn use_open(
        &mut self,
        operation: &Operation,
        file: i32,
        (node, at): (usize, usize),
    ) -> Result<Option<String>, String> {
        let name = self.nodes[node].name.clone();
        Ok(match operation {
            Operation::Seek { at, .. } => {
                self.open.insert(file, (node, *at));
                None
            }
            Operation::Read { bytes, .. } => {
                self.open.insert(file, (node, at + bytes));
                None
            }
            Operation::Write { at: own, bytes, .. } => {
                if own.is_none() {
                    self.open.insert(file, (node, at + bytes.len()));
                }
                let (at, bytes) = (own.unwrap_or(at), bytes.clone());
                let words = format!("write {} bytes at {at} of {name}", bytes.len());
                self.change(node, Change::Write { at, bytes });
                Some(words)
            }
            Operation::Resize { length, .. } => {
                self.change(node, Change::Resize(*length));
                Some(format!("make {name} {length} bytes long"))
            }
            _ => {
                self.sync(node);
                Some(format!("sync {}", if name.is_empty() { "the folder above" } else { &name }))
            }
        })
    }

    fn create(&mut self, path: &str, content: Content) -> Result<usize, String> {
        let (folder, name) = self.place(path)?;
        let node = self.add(path.to_owned(), content);
        self.name(folder, Naming::Give(name, node));
        Ok(node)
    }

    /// The folder of a path, and the name in it.
    fn place(&self, path: &str) -> Result<(usize, String), String> {
        let (folder, name) = path.rsplit_once('/').unwrap_or(("", path));
        let folder = self.find(folder).ok_or_else(|| format!("{path}: no such folder"))?;
        Ok((folder, name.to_owned()))
    }

    fn named(&self, path: &str) -> Result<(usize, String, usize), String> {
        let (folder, name) = self.place(path)?;
        Ok((folder, name, self.find(path).ok_or_else(|| format!("{path}: no such file"))?))
    }

    /// What a path means to a running program.
    fn find(&self, path: &str) -> Option<usize> {
        path.split('/').filter(|name| !name.is_empty()).try_fold(ROOT, |node, name| {
            let Content::Folder { synced, unsynced } = &self.nodes[node].content else { return None };
            names(synced, unsynced, |_| true).get(name).copied()
        })
    }

    fn change(&mut self, node: usize, change: Change) {
        if let Content::File { unsynced, .. } = &mut self.nodes[node].content {
            unsynced.push(change);
        }
    }

    fn name(&mut self, node: usize, naming: Naming) {
        if let Content::Folder { unsynced, .. } = &mut self.nodes[node].content {
            unsynced.push(naming);
        }
    }

    fn sync(&mut self, node: usize) {
        match &mut self.nodes[node].content {
            Content::File { synced, unsynced } => {
                *synced = bytes(synced, unsynced, |_| Fate::Kept);
                unsynced.clear();
            }
            Content::Folder { synced, unsynced } => {
                *synced = names(synced, unsynced, |_| true);
                unsynced.clear();
            }
        }
    }

    /// How many names were not synced.
    pub fn unsynced_names(&self) -> usize {
        let count = |node: &Node| match &node.content {
            Content::Folder { unsynced, .. } => unsynced.len(),
            Content::File { .. } => 0,
        };
        self.nodes.iter().map(count).sum()
    }

    /// What is there after a power failure, where `fate` says what became of each thing that was not synced; and what was lost, in words.
    pub fn state(&self, fate: &mut dyn FnMut(Unsynced) -> Fate) -> (State, Vec<String>) {
        let (mut lost, mut numbers) = (Vec::new(), [0; 2]);
        let (mut contents, mut folders) = (HashMap::new(), HashMap::new());
        for (node, Node { name, content }) in self.nodes.iter().enumerate() {
            let is_name = matches!(content, Content::Folder { .. });
            let mut decide = |index: usize, is_write: bool, words: String| {
                let number = numbers[usize::from(is_name)];
                numbers[usize::from(is_name)] += 1;
                let fate = fate(Unsynced { is_name, is_write, node, index, number });
                match fate {
                    Fate::Kept => {}
                    Fate::Lost => lost.push(words),
                    Fate::Half => lost.push(format!("half of: {words}")),
                    Fate::Length => lost.push(format!("all but the length of: {words}")),
                }
                fate
            };
            match content {
                Content::File { synced, unsynced } => {
                    let is_write = |index: usize| matches!(unsynced[index], Change::Write { .. });
                    let decide = |index: usize| decide(index, is_write(index), unsynced[index].words(name));
                    contents.insert(node, bytes(synced, unsynced, decide));
                }
                Content::Folder { synced, unsynced } => {
                    let decide =
                        |index: usize| decide(index, false, unsynced[index].words(name)) == Fate::Kept;
                    folders.insert(node, names(synced, unsynced, decide));
                }
            }
        }
        let mut state = State::new();
        gather(ROOT, "", &contents, &folders, &mut state);
        (state, lost)
    }
}

impl Change {
    fn words(&self, file: &str) -> String {
        match self {
            Self::Write { at, bytes } => format!("write {} bytes at {at} of {file}", bytes.len()),
            Self::Resize(length) => format!("make {file} {length} bytes long"),
        }
    }
}

impl Naming {
    fn words(&self, folder: &str) -> String {
        match self {
            Self::Give(name, _) => format!("create {name} in {folder}"),
            Self::Change { from, to, .. } => format!("rename {from} to {to} in {folder}"),
            Self::Take(name, _) => format!("remove {name} from {folder}"),
        }
    }
}

/// The content of a file.
fn bytes(synced: &[u8], unsynced: &[Change], mut fate: impl FnMut(usize) -> Fate) -> Vec<u8> {
    let mut all = synced.to_vec();
    for (index, change) in unsynced.iter().enumerate() {
        match (fate(index), change) {
            (Fate::Lost, _) => {}
            (_, Change::Resize(length)) => all.resize(*length, 0),
            (fate, Change::Write { at, bytes }) => {
                let written = match fate {
                    Fate::Half => &bytes[..bytes.len() / 2],
                    Fate::Length => &[],
                    _ => &bytes[..],
                };
                let end = if fate == Fate::Length { at + bytes.len() } else { at + written.len() };
                all.resize(all.len().max(end), 0);
                all[*at..at + written.len()].copy_from_slice(written);
            }
        }
    }
    all
}

/// The names in a folder.
fn names(synced: &Names, unsynced: &[Naming], mut is_kept: impl FnMut(usize) -> bool) -> Names {
    let mut all = synced.clone();
    for (index, naming) in unsynced.iter().enumerate() {
        if !is_kept(index) {
            continue;
        }
        match naming {
            // Where an earlier file of that name is still there, this needs its removal.
            Naming::Give(name, node) => {
                all.entry(name.clone()).or_insert(*node);
            }
            Naming::Change { from, to, node } => {
                if all.get(from) == Some(node) {
                    all.remove(from);
                    all.insert(to.clone(), *node);
                }
            }
            Naming::Take(name, node) => {
                if all.get(name) == Some(node) {
                    all.remove(name);
                }
            }
        }
    }
    all
}

/// Adds what is in a folder.
fn gather(
    folder: usize,
    path: &str,
    contents: &HashMap<usize, Vec<u8>>,
    folders: &HashMap<usize, Names>,
    state: &mut State,
) {
    for (name, node) in &folders[&folder] {
        let own = if path.is_empty() { name.clone() } else { format!("{path}/{name}") };
        state.insert(own.clone(), contents.get(node).cloned());
        if folders.contains_key(node) {
            gather(*node, &own, contents, folders, state);
        }
    }
}

#[cfg(test)]
mod tests;
