//! A file that has its name only when it is whole.

use super::Begin;
use crate::files::{in_file, open_or_create_own, open_own, sync_folder, with_suffix};
use std::fs::{File, TryLockError, remove_file, rename};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Bytes that are gathered before they are written.
const BUFFER: usize = 1 << 18;

/// A file under way: `NAME.part`.
pub(crate) struct Part {
    path: PathBuf,
    part: PathBuf,
    file: File,
    /// Bytes that are not yet in the file.
    buffer: Vec<u8>,
    /// Bytes in the file.
    written: u64,
    /// A power failure leaves the file one of its names.
    is_named: bool,
}

impl Part {
    /// Starts the file that will be called `path`, or takes it up.
    pub fn open(path: &Path, begin: Begin) -> io::Result<Self> {
        let part = with_suffix(path, ".part");
        if begin == Begin::Again && !is_there(&part) {
            // The earlier run had come to an end.
            open_own(path).and_then(|_| rename(path, &part)).map_err(|error| in_file(path, error))?;
        }
        let open = || match begin {
            Begin::New => {
                // A killed run may have left one.
                let file = open_or_create_own(&part)?;
                lock(&file)?;
                file.set_len(0)?;
                Ok((file, 0))
            }
            Begin::Again => {
                let file = open_own(&part)?;
                lock(&file)?;
                let length = file.metadata()?.len();
                Ok((file, length))
            }
        };
        let (file, written) = open().map_err(|error| in_file(&part, error))?;
        let is_named = begin == Begin::Again;
        Ok(Self { path: path.to_owned(), part, file, buffer: Vec::new(), written, is_named })
    }

    /// Length so far [byte].
    pub fn len(&self) -> u64 {
        self.written + self.buffer.len() as u64
    }

    /// Forgets what comes after the first `length` bytes.
    pub fn cut(&mut self, length: u64) -> io::Result<()> {
        self.buffer.clear();
        let now = self.file.metadata().map_err(|error| in_file(&self.part, error))?.len();
        if now < length {
            return Err(self.refuse(format!(
                "holds {now} bytes and {length} are needed: it is not what the earlier run left"
            )));
        }
        self.file
            .set_len(length)
            .and_then(|()| self.file.seek(SeekFrom::Start(length)))
            .map_err(|error| in_file(&self.part, error))?;
        self.written = length;
        Ok(())
    }

    /// Overwrites what is at `offset` [byte], which has been written.
    pub fn patch(&mut self, offset: u64, bytes: &[u8]) -> io::Result<()> {
        self.flush()?;
        let mut patch = || {
            self.file.seek(SeekFrom::Start(offset))?;
            self.file.write_all(bytes)?;
            self.file.seek(SeekFrom::Start(self.written))
        };
        patch().map(drop).map_err(|error| in_file(&self.part, error))
    }

    /// Appends what is in another part.
    pub fn copy(&mut self, other: &mut Self) -> io::Result<()> {
        other.flush()?;
        other.file.rewind().map_err(|error| in_file(&other.part, error))?;
        io::copy(&mut other.file, self).map(drop)
    }

    /// Removes the file.
    pub fn remove(self) -> io::Result<()> {
        remove_file(&self.part).map_err(|error| in_file(&self.part, error))
    }

    /// Puts everything so far on the disk, and the file's name, which a checkpoint counts on.
    pub fn sync(&mut self) -> io::Result<()> {
        self.sync_content()?;
        if !self.is_named {
            sync_folder(&self.part);
            self.is_named = true;
        }
        Ok(())
    }

    fn sync_content(&mut self) -> io::Result<()> {
        self.flush()?;
        self.file.sync_all().map_err(|error| in_file(&self.part, error))
    }

    /// Syncs the file and gives it its name.
    pub fn finish(mut self) -> io::Result<PathBuf> {
        self.sync_content()?;
        let path = self.finish_later()?;
        sync_folder(&path);
        Ok(path)
    }

    /// Gives the file its name and leaves it to the system when it is on the disk.
    pub fn finish_later(mut self) -> io::Result<PathBuf> {
        self.flush()?;
        rename(&self.part, &self.path).map_err(|error| in_file(&self.path, error))?;
        Ok(self.path)
    }

    /// An error about what was to be written here.
    pub fn refuse(&self, what: String) -> io::Error {
        in_file(&self.path, io::Error::new(io::ErrorKind::InvalidInput, what))
    }
}

impl Write for Part {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.buffer.len() + bytes.len() > BUFFER {
            self.flush()?;
        }
        if bytes.len() < BUFFER {
            self.buffer.extend_from_slice(bytes);
            return Ok(bytes.len());
        }
        let length = self.file.write(bytes).map_err(|error| in_file(&self.part, error))?;
        self.written += length as u64;
        Ok(length)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.write_all(&self.buffer).map_err(|error| in_file(&self.part, error))?;
        self.written += self.buffer.len() as u64;
        self.buffer.clear();
        Ok(())
    }
}

/// Refuses a file called `path`, finished or under way, that has less than `length` bytes: a run cannot go on with it.
///
/// ```
/// use taffeta_io::output::check_file;
///
/// # let folder = tempfile::tempdir()?;
/// # let path = &folder.path().join("frames.csv");
/// std::fs::write(path, "frame,time\n0,0\n")?;
/// assert!(check_file(path, 15).is_ok());
/// assert!(check_file(path, 16).is_err());
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn check_file(path: &Path, length: u64) -> io::Result<()> {
    let part = with_suffix(path, ".part");
    let there = if is_there(&part) { &part } else { path };
    let opened = open_own(there).and_then(|file| file.metadata());
    let now = opened.map_err(|error| in_file(there, error))?.len();
    if now >= length {
        return Ok(());
    }
    let what = format!("holds {now} bytes and {length} are needed: it is not what the earlier run left");
    Err(in_file(there, io::Error::new(io::ErrorKind::InvalidInput, what)))
}

/// Whether anything has this name.
fn is_there(path: &Path) -> bool {
    path.symlink_metadata().is_ok()
}

/// Keeps other runs out, where the file system has locks.
fn lock(file: &File) -> io::Result<()> {
    if let Err(TryLockError::WouldBlock) = file.try_lock() {
        let what = "another run is writing here; wait for it or choose another folder";
        return Err(io::Error::new(io::ErrorKind::ResourceBusy, what));
    }
    Ok(())
}
