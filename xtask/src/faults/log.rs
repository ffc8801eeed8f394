//! What `strace -f -xx` tells of a program's files.

use super::disk::Operation;
use std::collections::HashMap;
use std::path::Path;

/// How strace is asked for it. What there is not on a machine has a question mark.
pub const FLAGS: [&str; 6] = ["-f", "-xx", "-s", "100000000", "-e", CALLS];
const CALLS: &str = "trace=?open,openat,?openat2,?creat,close,read,readv,write,pwrite64,writev,pwritev,?pwritev2,lseek,ftruncate,\
     ?truncate,fallocate,fsync,fdatasync,?sync_file_range,?rename,?renameat,renameat2,?unlink,unlinkat,?mkdir,mkdirat,?rmdir,?link,\
     linkat,?symlink,symlinkat,copy_file_range,sendfile,dup,?dup2,dup3,fcntl";

/// The operations that a log tells of, with what is in `folder` by its relative path; calls that failed have changed nothing.
pub fn operations(log: &str, folder: &Path) -> Result<Vec<Operation>, String> {
    let lines = whole_lines(log);
    let calls = lines.iter().filter_map(|line| Call::of(line)).map(|call| {
        let operation = call.operation(folder);
        operation.map_err(|what| format!("{}({}): {what}", call.name, call.arguments.join(", ")))
    });
    calls.filter_map(Result::transpose).collect()
}

/// Lines without the number of the thread; where another thread's line is in between, both parts are put together.
fn whole_lines(log: &str) -> Vec<String> {
    let (mut lines, mut begun) = (Vec::new(), HashMap::new());
    for line in log.lines() {
        let Some((thread, line)) = line.split_once(' ') else { continue };
        let line = line.trim_start();
        if let Some(start) = line.strip_suffix(" <unfinished ...>") {
            begun.insert(thread, start);
        } else if let Some((_, end)) =
            line.strip_prefix("<... ").and_then(|line| line.split_once(" resumed>"))
        {
            lines.push(begun.remove(thread).unwrap_or_default().to_owned() + end);
        } else {
            lines.push(line.to_owned());
        }
    }
    lines
}

/// A call that did not fail.
struct Call<'a> {
    name: &'a str,
    arguments: Vec<&'a str>,
    result: usize,
}

impl<'a> Call<'a> {
    fn of(line: &'a str) -> Option<Self> {
        let (call, result) = line.rsplit_once(" = ")?;
        let (name, arguments) = call.trim_end().strip_suffix(')')?.split_once('(')?;
        let result = result.split_whitespace().next()?.parse().ok()?;
        Some(Self { name, arguments: arguments.split(", ").collect(), result })
    }

    /// What it does; nothing where it is about files elsewhere.
    fn operation(&self, folder: &Path) -> Result<Option<Operation>, String> {
        let path = |index: usize| self.path(index, folder);
        let created = |path: Option<String>, flags: &str| {
            let has = |flag: &str| flags.split('|').any(|one| one == flag);
            if path.is_some() && has("O_APPEND") {
                return Err("this model does not know O_APPEND".to_owned());
            }
            let (file, create, truncate) = (self.result as i32, has("O_CREAT"), has("O_TRUNC"));
            Ok(path.map(|path| Operation::Open { file, path, create, truncate }))
        };
        let rename = |from: Option<String>, to: Option<String>| match (from, to) {
            (Some(from), Some(to)) => Ok(Some(Operation::Rename { from, to })),
            (None, None) => Ok(None),
            _ => Err("this model has no rename from elsewhere".to_owned()),
        };
        let remove = |path: Option<String>| path.map(|path| Operation::Remove { path });
        let make = |path: Option<String>| path.map(|path| Operation::MakeFolder { path });
        Ok(match self.name {
            "open" => created(path(0)?, self.argument(1)?)?,
            "openat" => created(path(1)?, self.argument(2)?)?,
            "close" => Some(Operation::Close { file: self.file(0)? }),
            "read" | "readv" => Some(Operation::Read { file: self.file(0)?, bytes: self.result }),
            "write" | "pwrite64" => {
                let mut bytes = text(self.argument(1)?)?;
                bytes.truncate(self.result);
                let at = if self.name == "write" { None } else { Some(self.number(3)?) };
                Some(Operation::Write { file: self.file(0)?, at, bytes })
            }
            "lseek" => Some(Operation::Seek { file: self.file(0)?, at: self.result }),
            "ftruncate" => Some(Operation::Resize { file: self.file(0)?, length: self.number(1)? }),
            "fsync" | "fdatasync" => Some(Operation::Sync { file: self.file(0)? }),
            "rename" => rename(path(0)?, path(1)?)?,
            "renameat" => rename(path(1)?, path(3)?)?,
            "renameat2" if self.argument(4)? == "0" => rename(path(1)?, path(3)?)?,
            "unlink" | "rmdir" => remove(path(0)?),
            "unlinkat" => remove(path(1)?),
            "mkdir" => make(path(0)?),
            "mkdirat" => make(path(1)?),
            "fcntl" if !self.argument(1)?.starts_with("F_DUPFD") => None,
            _ => Some(self.unknown(folder)),
        })
    }

    fn unknown(&self, folder: &Path) -> Operation {
        let numbers = self.arguments.iter().filter_map(|word| word.parse().ok());
        let paths = (0..self.arguments.len()).filter_map(|index| self.path(index, folder).ok().flatten());
        Operation::Unknown { call: self.name.to_owned(), files: numbers.collect(), paths: paths.collect() }
    }

    fn argument(&self, index: usize) -> Result<&'a str, String> {
        self.arguments.get(index).copied().ok_or_else(|| format!("it has no argument {index}"))
    }

    fn number(&self, index: usize) -> Result<usize, String> {
        self.argument(index)?.parse().map_err(|_| format!("argument {index} is no number"))
    }

    fn file(&self, index: usize) -> Result<i32, String> {
        self.argument(index)?.parse().map_err(|_| format!("argument {index} is no file"))
    }

    /// A path within the folder; nothing where it leads elsewhere.
    fn path(&self, index: usize, folder: &Path) -> Result<Option<String>, String> {
        let path = String::from_utf8_lossy(&text(self.argument(index)?)?).into_owned();
        // The calls of these names have a folder before each path.
        let is_in_other = |before: &str| self.name.contains("at") && before != "AT_FDCWD";
        if Path::new(&path).is_relative() && index > 0 && is_in_other(self.argument(index - 1)?) {
            return Err("this model knows the working folder alone".to_owned());
        }
        // Without `.` and doubled slashes.
        let whole: std::path::PathBuf = folder.join(path).components().collect();
        Ok(whole.strip_prefix(folder).ok().map(|path| path.to_string_lossy().into_owned()))
    }
}

/// The bytes of a text in hexadecimal digits.
fn text(word: &str) -> Result<Vec<u8>, String> {
    let inner = word.strip_prefix('"').and_then(|word| word.strip_suffix('"'));
    let inner = inner.ok_or_else(|| format!("{word} is no whole text"))?;
    let digits = |one| u8::from_str_radix(one, 16).map_err(|_| format!("{one} is no byte"));
    inner.split("\\x").skip(1).map(digits).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hex(text: &str) -> String {
        let digits: String = text.bytes().map(|byte| format!("\\x{byte:02x}")).collect();
        format!("\"{digits}\"")
    }

    #[test]
    fn calls_are_read_with_the_paths_of_the_folder() {
        let log = [
            format!("7 openat(AT_FDCWD, {}, O_RDONLY|O_CLOEXEC) = 3", hex("/lib/x.so")),
            format!("7 openat(AT_FDCWD, {}, O_RDWR|O_CREAT|O_EXCL, 0666) = 4", hex("out/a")),
            format!("7 write(4, {}, 3)  = 2", hex("abc")),
            format!("7 openat(AT_FDCWD, {}, O_RDWR) = -1 ENOENT (No such file or directory)", hex("out/b")),
            format!("7 renameat(AT_FDCWD, {}, AT_FDCWD, {}) = 0", hex("/d/out/a"), hex("out/b")),
            "7 fsync(4 <unfinished ...>".to_owned(),
            "8 +++ exited with 0 +++".to_owned(),
            "7 <... fsync resumed>)     = 0".to_owned(),
            format!("7 openat(AT_FDCWD, {}, O_RDONLY|O_CLOEXEC) = 5", hex(".")),
        ];
        let open = |file, path: &str, create| Operation::Open {
            file,
            path: path.to_owned(),
            create,
            truncate: false,
        };
        let expected = [
            open(4, "out/a", true),
            Operation::Write { file: 4, at: None, bytes: b"ab".to_vec() },
            Operation::Rename { from: "out/a".into(), to: "out/b".into() },
            Operation::Sync { file: 4 },
            open(5, "", false),
        ];
        assert_eq!(operations(&log.join("\n"), Path::new("/d")).unwrap(), expected);
    }

    #[test]
    fn what_was_cut_off_or_is_not_known_is_told() {
        let cut = "7 write(4, \"\\x61\"..., 30) = 30";
        assert!(operations(cut, Path::new("/d")).unwrap_err().contains("no whole text"));
        let link = format!("7 link({}, {}) = 0", hex("/d/out/a"), hex("/e"));
        let found = operations(&link, Path::new("/d")).unwrap();
        assert!(
            matches!(&found[..], [Operation::Unknown { call, paths, .. }] if call == "link" && paths == &["out/a"])
        );
    }
}
