//! Nothing is read or written but a regular file of that very name.
#![cfg(unix)]

use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use taffeta::Precision;
use taffeta_io::files::{create, replace};
use taffeta_io::output::{Begin, Npy};
use taffeta_io::program::RunLock;
use taffeta_io::{Checkpoint, load_scene};

/// A folder with a file that is somebody else's.
struct Desk(tempfile::TempDir);

impl Desk {
    fn new() -> Self {
        let desk = Self(tempfile::tempdir().unwrap());
        fs::write(desk.path("theirs"), "precious").unwrap();
        desk
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn is_as_it_was(&self) {
        assert_eq!(fs::read_to_string(self.path("theirs")).unwrap(), "precious");
    }

    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.0.path()).unwrap();
        let mut names: Vec<String> =
            entries.map(|one| one.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }
}

/// Makes a pipe, which opening for reading would wait for.
fn pipe(path: &Path) {
    assert!(std::process::Command::new("mkfifo").arg(path).status().unwrap().success());
}

#[test]
fn results_are_not_written_through_links() {
    for begin in [Begin::New, Begin::Again] {
        let open = |desk: &Desk| Npy::open(&desk.path("p.npy"), 1, Precision::F32, begin).map(drop);
        for hard in [false, true] {
            let desk = Desk::new();
            let part = desk.path("p.npy.part");
            if hard {
                fs::hard_link(desk.path("theirs"), &part)
            } else {
                symlink(desk.path("theirs"), &part)
            }
            .unwrap();
            let error = open(&desk).unwrap_err().to_string();
            assert!(error.contains("p.npy.part: is a link to a file elsewhere"), "{error}");
            desk.is_as_it_was();
            // A run that goes on takes the finished file up again.
            fs::rename(&part, desk.path("p.npy")).unwrap();
            if begin == Begin::Again {
                assert!(
                    open(&desk).unwrap_err().to_string().contains("p.npy: is a link to a file elsewhere")
                );
                assert_eq!(desk.names(), ["p.npy", "theirs"]);
            }
            desk.is_as_it_was();
        }
        let desk = Desk::new();
        symlink(desk.path("nowhere"), desk.path("p.npy.part")).unwrap();
        assert!(open(&desk).is_err());
        assert!(!desk.path("nowhere").exists());
        let desk = Desk::new();
        pipe(&desk.path("p.npy.part"));
        assert!(open(&desk).unwrap_err().to_string().contains("is not a regular file"));
    }
}

#[test]
fn what_a_killed_run_has_left_is_made_anew() {
    let desk = Desk::new();
    fs::write(desk.path("p.npy.part"), "half of it").unwrap();
    drop(Npy::open(&desk.path("p.npy"), 1, Precision::F32, Begin::New).unwrap());
    assert!(fs::read(desk.path("p.npy.part")).unwrap().starts_with(b"\x93NUMPY"));
}

#[test]
fn a_lock_follows_no_link() {
    let desk = Desk::new();
    symlink(desk.path("theirs"), desk.path("lock.part")).unwrap();
    let error = RunLock::take(desk.0.path()).err().unwrap().to_string();
    assert!(error.contains("lock.part: is a link"), "{error}");
    desk.is_as_it_was();
}

#[test]
fn a_file_is_replaced_at_once_and_a_link_by_a_file() {
    let desk = Desk::new();
    let path = desk.path("summary.json");
    symlink(desk.path("theirs"), &path).unwrap();
    replace(&path, &[b"whole", b" words"]).unwrap();
    desk.is_as_it_was();
    assert!(!path.is_symlink());
    assert_eq!(fs::read_to_string(&path).unwrap(), "whole words");
    // As any program makes files: all may read what the umask lets them.
    fs::write(desk.path("plain"), "").unwrap();
    let mode = |name: &str| fs::metadata(desk.path(name)).unwrap().permissions().mode();
    assert_eq!(mode("summary.json"), mode("plain"));
    assert_eq!(desk.names(), ["plain", "summary.json", "theirs"]);
}

#[test]
fn what_killed_programs_left_of_replacing_goes_and_what_others_are_at_stays() {
    let desk = Desk::new();
    let held = fs::File::create(desk.path("c.0123456789ab.part")).unwrap();
    held.try_lock().unwrap();
    fs::write(desk.path("c.left56789abc.part"), "half").unwrap();
    symlink(desk.path("theirs"), desk.path("c.link56789abc.part")).unwrap();
    fs::write(desk.path("c.own.part"), "of the user").unwrap();
    replace(&desk.path("c"), &[b"new"]).unwrap();
    assert_eq!(desk.names(), ["c", "c.0123456789ab.part", "c.link56789abc.part", "c.own.part", "theirs"]);
    desk.is_as_it_was();
}

#[test]
fn programs_that_replace_a_file_at_once_do_not_disturb_each_other() {
    let desk = Desk::new();
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| (0..50).for_each(|_| replace(&desk.path("c"), &[b"whole"]).unwrap()));
        }
    });
    assert_eq!(fs::read_to_string(desk.path("c")).unwrap(), "whole");
    assert_eq!(desk.names(), ["c", "theirs"]);
}

#[test]
fn a_file_is_emptied_and_a_link_is_not_followed() {
    let desk = Desk::new();
    fs::write(desk.path("half"), "half").unwrap();
    create(&desk.path("half")).unwrap();
    assert_eq!(fs::read(desk.path("half")).unwrap(), b"");
    symlink(desk.path("theirs"), desk.path("link")).unwrap();
    assert!(create(&desk.path("link")).unwrap_err().to_string().contains("is a link to a file elsewhere"));
    desk.is_as_it_was();
}

#[test]
fn pipes_and_devices_are_no_scenes_and_no_checkpoints() {
    let desk = Desk::new();
    pipe(&desk.path("pipe"));
    for path in [desk.path("pipe"), "/dev/zero".into(), desk.0.path().into()] {
        let said =
            [Checkpoint::<u32>::read(&path).unwrap_err(), load_scene(&path, &[]).unwrap_err().to_string()];
        for error in said {
            assert!(error.contains("is not a regular file"), "{error}");
        }
    }
}
