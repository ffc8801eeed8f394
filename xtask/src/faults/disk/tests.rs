use super::*;

const FILE: i32 = 4;
const FOLDER: i32 = 5;

fn create(path: &str) -> Operation {
    Operation::Open { file: FILE, path: path.to_owned(), create: true, truncate: false }
}

fn open_folder() -> Operation {
    Operation::Open { file: FOLDER, path: String::new(), create: false, truncate: false }
}

fn write(text: &str) -> Operation {
    Operation::Write { file: FILE, at: None, bytes: text.into() }
}

fn write_at(at: usize, text: &str) -> Operation {
    Operation::Write { file: FILE, at: Some(at), bytes: text.into() }
}

fn rename(from: &str, to: &str) -> Operation {
    Operation::Rename { from: from.to_owned(), to: to.to_owned() }
}

fn remove(path: &str) -> Operation {
    Operation::Remove { path: path.to_owned() }
}

const SYNC: Operation = Operation::Sync { file: FILE };
const SYNC_FOLDER: Operation = Operation::Sync { file: FOLDER };

fn disk(operations: &[Operation]) -> Disk {
    let mut disk = Disk::new();
    disk.apply(&open_folder()).unwrap();
    for operation in operations {
        disk.apply(operation).unwrap();
    }
    disk
}

/// A state in words, as `name=content`.
fn shown(state: &State) -> String {
    let show = |(name, content): (&String, &Option<Vec<u8>>)| match content {
        Some(bytes) => format!("{name}={}", String::from_utf8_lossy(bytes).replace('\0', "0")),
        None => format!("{name}/"),
    };
    state.iter().map(show).collect::<Vec<_>>().join(" ")
}

/// What is there where of what was not synced these things of a kind are lost, and all else is kept.
fn without(disk: &Disk, is_name: bool, numbers: &[usize]) -> String {
    let is_lost = |one: Unsynced| one.is_name == is_name && numbers.contains(&one.number);
    shown(&disk.state(&mut |one| if is_lost(one) { Fate::Lost } else { Fate::Kept }).0)
}

fn all_lost(disk: &Disk) -> String {
    shown(&disk.state(&mut |_| Fate::Lost).0)
}

fn all_kept(disk: &Disk) -> String {
    shown(&disk.state(&mut |_| Fate::Kept).0)
}

#[test]
fn what_was_synced_stays_and_the_rest_may_go() {
    let disk = disk(&[create("a"), write("abc"), SYNC, SYNC_FOLDER, write("de")]);
    assert_eq!((all_lost(&disk), all_kept(&disk)), ("a=abc".into(), "a=abcde".into()));
}

#[test]
fn a_lost_write_under_a_later_one_leaves_zeros_or_what_was_there() {
    let new = disk(&[create("a"), SYNC_FOLDER, write("abc"), write("de")]);
    assert_eq!([without(&new, false, &[0]), without(&new, false, &[1])], ["a=000de", "a=abc"]);
    let old = disk(&[create("a"), SYNC_FOLDER, write("abc"), SYNC, write_at(0, "X"), write_at(1, "Y")]);
    assert_eq!([without(&old, false, &[0]), without(&old, false, &[1])], ["a=aYc", "a=Xbc"]);
}

#[test]
fn a_write_is_kept_by_half_or_as_a_length() {
    let disk = disk(&[create("a"), SYNC_FOLDER, write("abcd")]);
    let with = |fate: Fate| shown(&disk.state(&mut |_| fate).0);
    assert_eq!([with(Fate::Half), with(Fate::Length)], ["a=ab", "a=0000"]);
}

#[test]
fn a_lost_cut_leaves_what_was_behind_it() {
    let cut = Operation::Resize { file: FILE, length: 1 };
    let seek = Operation::Seek { file: FILE, at: 1 };
    let disk = disk(&[create("a"), SYNC_FOLDER, write("abc"), SYNC, cut, seek, write("X")]);
    assert_eq!(["a=aX", "a=aXc"], [all_kept(&disk), without(&disk, false, &[0])]);
}

#[test]
fn a_synced_file_has_no_name_before_its_folder_is_synced() {
    let disk = disk(&[create("a"), write("abc"), SYNC]);
    assert_eq!(all_lost(&disk), "");
}

#[test]
fn a_rename_is_there_or_not_and_never_without_the_creation() {
    let before = [create("a"), write("old"), SYNC, SYNC_FOLDER];
    let replace = [create("b"), write("new"), SYNC, rename("b", "a")];
    let disk = disk(&[&before[..], &replace].concat());
    assert_eq!(
        [
            all_kept(&disk),
            without(&disk, true, &[1]),
            without(&disk, true, &[0]),
            without(&disk, true, &[0, 1])
        ],
        ["a=new", "a=old b=new", "a=old", "a=old"]
    );
}

#[test]
fn a_name_is_given_again_only_where_it_was_taken_away() {
    let before = [create("a"), write("old"), SYNC, SYNC_FOLDER];
    let disk = disk(&[&before[..], &[remove("a"), create("a")]].concat());
    assert_eq!(
        [all_kept(&disk), without(&disk, true, &[0]), without(&disk, true, &[1])],
        ["a=", "a=old", ""]
    );
}

#[test]
fn what_is_in_a_lost_folder_is_lost() {
    let folder = Operation::MakeFolder { path: "f".into() };
    let disk = disk(&[folder, create("f/a"), write("abc"), SYNC]);
    assert_eq!(
        [all_kept(&disk), without(&disk, true, &[0]), without(&disk, true, &[1])],
        ["f/ f/a=abc", "", "f/"]
    );
}

#[test]
fn what_the_model_does_not_know_is_refused_for_its_own_files_alone() {
    let mut disk = disk(&[create("a")]);
    let unknown = |file| Operation::Unknown { call: "sendfile".into(), files: vec![file], paths: Vec::new() };
    assert!(disk.apply(&unknown(FILE)).is_err());
    assert_eq!(disk.apply(&unknown(9)), Ok(None));
}

#[test]
fn what_is_lost_is_told() {
    let disk = disk(&[create("a"), write("abc")]);
    let (_, lost) = disk.state(&mut |one| if one.is_name { Fate::Lost } else { Fate::Half });
    assert_eq!(lost, ["create a in ", "half of: write 3 bytes at 0 of a"]);
}
