//! The programs that make runs: this one, and `taffeta`, which has the benches.

use std::hash::Hasher;
use std::path::{Path, PathBuf};
use taffeta_io::program::Failure;
use twox_hash::XxHash64;

/// This program and `taffeta`, each with a hash of its bytes: what another build ran is run again.
pub struct Programs {
    own: String,
    taffeta: Option<(PathBuf, String)>,
}

impl Programs {
    /// This program alone, which does where no bench is run.
    ///
    /// # Errors
    /// Where it cannot be read.
    pub fn own() -> Result<Self, Failure> {
        let file = own_file()?;
        Ok(Self { own: hash(&file)?, taffeta: None })
    }

    /// With `taffeta`: the program that is asked for, or the one beside this one.
    ///
    /// # Errors
    /// Where there is none.
    pub fn with_taffeta(self, asked: Option<&Path>) -> Result<Self, Failure> {
        let file = match asked {
            Some(asked) => asked.to_owned(),
            None => own_file()?.with_file_name(format!("taffeta{}", std::env::consts::EXE_SUFFIX)),
        };
        if !file.is_file() {
            return Err(Failure::Input(format!(
                "the benches need the program `taffeta`, and there is none at {}: `cargo build --release -p taffeta-cli` \
                 builds it; --taffeta PATH says where another one is",
                file.display()
            )));
        }
        let hash = hash(&file)?;
        Ok(Self { taffeta: Some((file, hash)), ..self })
    }

    /// The program `taffeta`.
    pub fn taffeta(&self) -> Option<&Path> {
        self.taffeta.as_ref().map(|(file, _)| file.as_path())
    }

    /// The hash of `taffeta`, or of this program; empty for one that is not needed.
    pub fn hash(&self, of_taffeta: bool) -> &str {
        if of_taffeta { self.taffeta.as_ref().map_or("", |(_, hash)| hash) } else { &self.own }
    }
}

fn own_file() -> Result<PathBuf, Failure> {
    std::env::current_exe().map_err(|error| Failure::Work(format!("this program: {error}")))
}

fn hash(file: &Path) -> Result<String, Failure> {
    let bytes = std::fs::read(file).map_err(|error| Failure::Work(format!("{}: {error}", file.display())))?;
    let mut hasher = XxHash64::with_seed(0);
    hasher.write(&bytes);
    Ok(format!("{:016x}", hasher.finish()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_program_that_is_not_there_is_told_how_to_be_built() {
        let none = Programs::own().unwrap().with_taffeta(Some(Path::new("nowhere/taffeta")));
        let said = none.err().map(|failure| (failure.code(), failure.to_string())).unwrap_or_default();
        assert_eq!(said.0, 2);
        assert!(
            said.1.contains("none at nowhere/taffeta: `cargo build --release -p taffeta-cli`"),
            "{}",
            said.1
        );
    }

    #[test]
    fn another_build_has_another_hash() {
        let folder = tempfile::tempdir().unwrap();
        let of = |bytes: &[u8]| {
            let file = folder.path().join("taffeta");
            std::fs::write(&file, bytes).unwrap();
            Programs::own().unwrap().with_taffeta(Some(&file)).unwrap()
        };
        let [a, b] = [of(b"a"), of(b"b")];
        assert!(a.hash(true) != b.hash(true) && a.hash(false) == b.hash(false));
        assert_eq!(Programs::own().unwrap().hash(true), "");
    }
}
