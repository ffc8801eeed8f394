//! A file that has its name only when it is whole.

use std::fs::{File, TryLockError, rename};
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// A file under way: `NAME.part`.
pub(super) struct Part {
    path: PathBuf,
    part: PathBuf,
    file: BufWriter<File>,
}

impl Part {
    /// Starts the file that will be called `path`.
    pub fn create(path: &Path) -> io::Result<Self> {
        let mut name = path.as_os_str().to_owned();
        name.push(".part");
        let part = PathBuf::from(name);
        let file = File::options().write(true).create(true).truncate(false).open(&part);
        let file = file.map_err(|error| naming(&part, error))?;
        if let Err(TryLockError::WouldBlock) = file.try_lock() {
            let what = "another run is writing here; wait for it or choose another folder";
            return Err(naming(&part, io::Error::new(io::ErrorKind::ResourceBusy, what)));
        }
        let emptied = file.metadata().and_then(|now| if now.len() > 0 { file.set_len(0) } else { Ok(()) });
        emptied.map_err(|error| naming(&part, error))?;
        Ok(Self { path: path.to_owned(), part, file: BufWriter::with_capacity(1 << 18, file) })
    }

    /// Overwrites what is at `offset` [byte].
    pub fn patch(&mut self, offset: u64, bytes: &[u8]) -> io::Result<()> {
        let mut patch = || {
            self.file.seek(SeekFrom::Start(offset))?;
            self.file.write_all(bytes)?;
            self.file.seek(SeekFrom::End(0))
        };
        patch().map(drop).map_err(|error| naming(&self.part, error))
    }

    /// Appends `text` of another part, and removes that.
    pub fn take(&mut self, mut other: Self) -> io::Result<()> {
        other.flush()?;
        let mut read = File::open(&other.part).map_err(|error| naming(&other.part, error))?;
        io::copy(&mut read, self).map_err(|error| naming(&self.part, error))?;
        std::fs::remove_file(&other.part).map_err(|error| naming(&other.part, error))
    }

    /// Syncs the file and gives it its name.
    pub fn finish(mut self) -> io::Result<PathBuf> {
        self.flush()?;
        self.file.get_ref().sync_all().map_err(|error| naming(&self.part, error))?;
        rename(&self.part, &self.path).map_err(|error| naming(&self.path, error))?;
        Ok(self.path)
    }

    /// An error about what was to be written here.
    pub fn refuse(&self, what: String) -> io::Error {
        naming(&self.path, io::Error::new(io::ErrorKind::InvalidInput, what))
    }
}

impl Write for Part {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes).map_err(|error| naming(&self.part, error))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush().map_err(|error| naming(&self.part, error))
    }
}

/// The error with the file that it is about.
fn naming(path: &Path, error: io::Error) -> io::Error {
    io::Error::new(error.kind(), format!("{}: {error}", path.display()))
}
