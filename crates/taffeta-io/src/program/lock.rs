//! One run at a time in a folder.

use crate::files::{create_folders, in_file, open_or_create_own, sync_folder};
use std::fs::{File, TryLockError, remove_dir, remove_file};
use std::io;
use std::path::{Path, PathBuf};

/// Keeps other runs and reports out of a folder. What a killed run leaves of it keeps nobody out.
pub struct RunLock {
    path: PathBuf,
    file: File,
    /// The folder was made for this run.
    made: bool,
}

impl RunLock {
    /// Takes the folder, and makes it if need be.
    ///
    /// # Errors
    /// Where another program has it, of the kind `ResourceBusy`; and where it cannot be made or written to.
    pub fn take(dir: &Path) -> io::Result<Self> {
        let made = !dir.exists();
        create_folders(dir)?;
        // Somebody else may have made it a moment ago.
        sync_folder(dir);
        let path = dir.join("lock.part");
        let file = open_or_create_own(&path).map_err(|error| in_file(&path, error))?;
        let lock = Self { file, path, made };
        match lock.file.try_lock() {
            Err(TryLockError::WouldBlock) => {
                // It is another's: its file stays.
                std::mem::forget(lock);
                let what = "another run is writing here; wait for it or choose another folder";
                Err(io::Error::new(io::ErrorKind::ResourceBusy, what))
            }
            // A file system without locks cannot keep others out.
            _ => Ok(lock),
        }
    }
}

impl Drop for RunLock {
    fn drop(&mut self) {
        // What cannot be removed does no harm: the lock ends with the program.
        let _ = remove_file(&self.path);
        if let Some(folder) = self.path.parent().filter(|_| self.made) {
            // A run that was refused leaves no folder behind; one with results is not empty.
            let _ = remove_dir(folder);
        }
        let _ = self.file.unlock();
    }
}
