//! Files that users name, opened so that nothing else is read or written than a regular file of that very name.

mod given;

pub use given::Given;

use crate::program::one_line;
use std::ffi::OsString;
use std::fs::{File, OpenOptions, create_dir_all, read_dir};
use std::io::{self, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// The error with the file that it is about.
pub(crate) fn in_file(path: &Path, error: io::Error) -> io::Error {
    io::Error::new(error.kind(), format!("{}: {error}", one_line(&path.display().to_string())))
}

/// Opens a regular file for reading; links are followed. Folders, pipes and devices are refused, without waiting for their other end.
///
/// # Errors
/// Of the kind `InvalidInput` where it is something else; else what the system says.
pub fn open(path: &Path) -> io::Result<File> {
    let mut options = File::options();
    without_waiting(options.read(true));
    let file = options.open(path)?;
    if file.metadata()?.is_file() { Ok(file) } else { Err(refused("is not a regular file")) }
}

/// Reads a regular file, as [`open`] does, up to `most` bytes of it.
///
/// # Errors
/// As [`open`].
pub fn read(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let file = open(path)?;
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(file.metadata()?.len().min(most) as usize)?;
    file.take(most).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Opens a file that is written here. Nobody else's file is: a link, by symbol or a second name for the same file, is refused, as all is
/// that is no regular file.
pub(crate) fn open_own(path: &Path) -> io::Result<File> {
    let mut options = File::options();
    without_links(options.read(true).write(true));
    let file = match options.open(path) {
        Err(_) if path.is_symlink() => return Err(refused(LINK)),
        opened => opened?,
    };
    let metadata = file.metadata()?;
    if !metadata.is_file() {
        return Err(refused("is not a regular file: remove it, or choose another folder"));
    }
    if has_other_names(&metadata) {
        return Err(refused(LINK));
    }
    Ok(file)
}

/// As [`open_own`]; what is not there is made. Another program may make or remove it at the same time.
pub(crate) fn open_or_create_own(path: &Path) -> io::Result<File> {
    loop {
        match File::options().read(true).write(true).create_new(true).open(path) {
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
            made => return made,
        }
        match open_own(path) {
            Err(error) if error.kind() == ErrorKind::NotFound => {}
            opened => return opened,
        }
    }
}

/// Makes an empty file, or empties the one that is there; nobody else's: links, and what is no regular file, are refused.
///
/// # Errors
/// Of the kind `InvalidInput` where it is something else; else what the system says.
pub fn create(path: &Path) -> io::Result<File> {
    let file = open_or_create_own(path)?;
    file.set_len(0)?;
    Ok(file)
}

/// Whether nothing is written into a folder: a link leads elsewhere.
pub(crate) fn check_folder(path: &Path) -> io::Result<()> {
    if path.is_symlink() { Err(in_file(path, refused(LINK))) } else { Ok(()) }
}

const LINK: &str = "is a link to a file elsewhere, which nothing is written to: remove it, put a copy in its place, or choose another \
     folder";

fn refused(what: &str) -> io::Error {
    io::Error::new(ErrorKind::InvalidInput, what)
}

#[cfg(unix)]
fn without_waiting(options: &mut OpenOptions) {
    std::os::unix::fs::OpenOptionsExt::custom_flags(options, libc::O_NONBLOCK);
}

#[cfg(not(unix))]
fn without_waiting(_: &mut OpenOptions) {}

#[cfg(unix)]
fn without_links(options: &mut OpenOptions) {
    std::os::unix::fs::OpenOptionsExt::custom_flags(options, libc::O_NONBLOCK | libc::O_NOFOLLOW);
}

/// Windows opens the link itself then, which is no regular file.
#[cfg(windows)]
fn without_links(options: &mut OpenOptions) {
    const FILE_FLAG_OPEN_REPARSE_POINT: u32 = 0x0020_0000;
    std::os::windows::fs::OpenOptionsExt::custom_flags(options, FILE_FLAG_OPEN_REPARSE_POINT);
}

#[cfg(not(any(unix, windows)))]
fn without_links(_: &mut OpenOptions) {}

#[cfg(unix)]
fn has_other_names(metadata: &std::fs::Metadata) -> bool {
    std::os::unix::fs::MetadataExt::nlink(metadata) > 1
}

#[cfg(not(unix))]
fn has_other_names(_: &std::fs::Metadata) -> bool {
    false
}

/// Gives the file at `path` the content `pieces`, all at once: what was there stays until the new content is whole and on the disk. A link
/// at `path` is replaced and not followed.
///
/// # Errors
/// What the system says, with the name of the file. Nothing of the attempt stays then.
pub fn replace(path: &Path, pieces: &[&[u8]]) -> io::Result<()> {
    let replace = || {
        let folder = folder_of(path);
        let name = path.file_name().ok_or_else(|| refused("is no name of a file"))?;
        remove_left(folder, name);
        let mut prefix = name.to_owned();
        prefix.push(".");
        let mut builder = tempfile::Builder::new();
        builder.prefix(&prefix).suffix(LEFT).rand_bytes(DIGITS);
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let mut file = locked(&builder, folder)?;
        pieces.iter().try_for_each(|piece| file.write_all(piece))?;
        file.as_file().sync_all()?;
        file.persist(path).map_err(|error| error.error)?;
        sync_folder(path);
        Ok(())
    };
    replace().map_err(|error| in_file(path, error))
}

/// A new file that others leave alone.
fn locked(builder: &tempfile::Builder, folder: &Path) -> io::Result<NamedTempFile> {
    loop {
        let file = builder.tempfile_in(folder)?;
        // A file system without locks loses what a killed program leaves.
        let _ = file.as_file().lock();
        // Before it was locked, another program may have taken it for that.
        if file.path().try_exists()? {
            return Ok(file);
        }
    }
}

/// How names of files end that [`replace`] has not finished, and how many digits at random are before that.
const LEFT: &str = ".part";
const DIGITS: usize = 12;

/// Removes what killed programs have left of replacing the file `name`: those that still run hold a lock.
fn remove_left(folder: &Path, name: &std::ffi::OsStr) {
    let (Ok(entries), Some(name)) = (read_dir(folder), name.to_str()) else { return };
    for path in entries.flatten().map(|entry| entry.path()) {
        let own = path.file_name().and_then(|own| own.to_str()).unwrap_or_default();
        let digits = own.strip_prefix(name).and_then(|rest| rest.strip_prefix('.')?.strip_suffix(LEFT));
        if digits.is_some_and(|digits| digits.len() == DIGITS)
            && let Ok(file) = open_own(&path)
            && file.try_lock().is_ok()
        {
            // It stays locked until it is gone. What cannot be removed does no harm.
            let _ = std::fs::remove_file(&path);
        }
    }
}

/// The folder of a file.
fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Makes a folder and those above it, and puts their names on the disk.
pub(crate) fn create_folders(path: &Path) -> io::Result<()> {
    let is_missing = |one: &&Path| !one.as_os_str().is_empty() && !one.exists();
    let missing: Vec<&Path> = path.ancestors().take_while(is_missing).collect();
    create_dir_all(path)?;
    missing.into_iter().for_each(sync_folder);
    Ok(())
}

/// Puts the names beside a file on the disk, its own as well, where folders can be synced. Before that a power failure may take back that
/// files were created, renamed and removed, each apart from the others; syncing a file keeps its content and not its name.
pub fn sync_folder(path: &Path) {
    let _ = File::open(folder_of(path)).and_then(|folder| folder.sync_all());
}

/// A path with something after its name.
pub(crate) fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    let mut name: OsString = path.as_os_str().to_owned();
    name.push(suffix);
    PathBuf::from(name)
}
