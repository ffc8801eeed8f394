//! WGSL files that say what they import, and the source of a kernel that is put together from them.

use std::collections::BTreeMap;

/// A WGSL file: the name by which others import it, and its text.
///
/// ```
/// use taffeta_gpu::{Shader, Shaders};
///
/// const SQUARE: Shader = ("square.wgsl", "fn square(x: f32) -> f32 { return x * x; }");
/// assert_eq!(Shaders::new([SQUARE]).files().count(), 1);
/// ```
pub type Shader = (&'static str, &'static str);

/// The files of a folder, by their names below it: `shaders!("springs", ["spring.wgsl", "grid.wgsl"])` are
/// `springs/spring.wgsl` and `springs/grid.wgsl`, which stand beside the file that says so.
#[macro_export]
macro_rules! shaders {
    ($folder:literal, [$($file:literal),+ $(,)?]) => {
        &[$((concat!($folder, "/", $file), include_str!($file))),+]
    };
}

/// WGSL files by name. A line `#import springs/spring.wgsl` has the file of that name in the same source, once, however
/// often it is imported. A name without `.wgsl` stands for a file that is chosen from outside, or by the file that a
/// source begins with: `#import tile.wgsl as memory`.
///
/// ```
/// use taffeta_gpu::Shaders;
///
/// let shaders = Shaders::new([
///     ("math/square.wgsl", "fn square(x: f32) -> f32 { return x * x; }"),
///     (
///         "area.wgsl",
///         "#import math/square.wgsl
/// @group(2) @binding(0) var<storage, read_write> area: f32;
/// @compute @workgroup_size(1)
/// fn measure() { area = 3.14159 * square(0.25); }",
///     ),
/// ]);
/// assert_eq!(shaders.file_of("measure"), Some("area.wgsl"));
/// let source = shaders.source("area.wgsl", &[])?;
/// assert!(source.starts_with("fn square(x: f32)"));
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Shaders(BTreeMap<&'static str, &'static str>);

/// A source that grows by what is imported.
struct Linker<'s> {
    files: &'s Shaders,
    choices: BTreeMap<&'s str, &'s str>,
    /// Files that were begun, and whether they are done.
    seen: BTreeMap<&'s str, bool>,
    source: String,
}

impl Shaders {
    /// These files.
    ///
    /// # Panics
    /// Where two have the same name: a mistake of ours.
    pub fn new(files: impl IntoIterator<Item = Shader>) -> Self {
        Self::default().with(files)
    }

    /// The same and more.
    ///
    /// # Panics
    /// As [`Self::new`].
    pub fn with(mut self, files: impl IntoIterator<Item = Shader>) -> Self {
        for (name, text) in files {
            assert!(self.0.insert(name, text).is_none(), "two shaders are called `{name}`");
        }
        self
    }

    /// Names and texts.
    pub fn files(&self) -> impl Iterator<Item = Shader> {
        self.0.iter().map(|(&name, &text)| (name, text))
    }

    /// Names of the files that have entry points.
    pub fn with_kernels(&self) -> impl Iterator<Item = &'static str> {
        self.files().filter(|(_, text)| text.contains("\n@compute")).map(|(name, _)| name)
    }

    /// The file that has an entry point.
    pub fn file_of(&self, entry: &str) -> Option<&'static str> {
        let function = format!("\nfn {entry}(");
        self.with_kernels().find(|name| self.0[name].contains(&function))
    }

    /// All that `file` imports, then the file. `choices` are names that stand for files.
    ///
    /// # Errors
    /// Says which file imports what is not there, or itself.
    pub fn source(&self, file: &str, choices: &[(&str, &str)]) -> Result<String, String> {
        let mut linker = Linker {
            files: self,
            choices: choices.iter().copied().collect(),
            seen: BTreeMap::new(),
            source: String::new(),
        };
        let (&file, text) =
            self.0.get_key_value(file).ok_or_else(|| format!("there is no shader `{file}`"))?;
        let as_name = |line: &'static str| line.strip_prefix("#import ")?.split_once(" as ");
        linker.choices.extend(text.lines().filter_map(as_name).map(|(file, name)| (name, file)));
        linker.add(file)?;
        Ok(linker.source)
    }
}

impl<'s> Linker<'s> {
    /// Appends what a file imports, then the rest of it.
    fn add(&mut self, file: &'s str) -> Result<(), String> {
        match self.seen.get(file) {
            Some(true) => return Ok(()),
            Some(false) => return Err(format!("`{file}` imports itself")),
            None => self.seen.insert(file, false),
        };
        let text = self.files.0[file];
        for line in text.lines() {
            let Some(import) = line.strip_prefix("#import ") else { continue };
            let name = import.split(" as ").next().unwrap_or(import);
            let wanted = self.choices.get(name).copied().unwrap_or(name);
            let (&wanted, _) = self
                .files
                .0
                .get_key_value(wanted)
                .ok_or_else(|| format!("`{file}` imports `{name}`, and there is no such shader"))?;
            self.add(wanted).map_err(|why| format!("{why}, imported by `{file}`"))?;
        }
        for line in text.lines().filter(|line| !line.starts_with("#import ")) {
            self.source.push_str(line);
            self.source.push('\n');
        }
        self.seen.insert(file, true);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILES: [Shader; 6] = [
        ("a.wgsl", "// A\n\n#import b.wgsl\n#import c.wgsl\n\n@compute @workgroup_size(1)\nfn main() {}\n"),
        ("b.wgsl", "#import c.wgsl\nfn b() {}\n"),
        ("c.wgsl", "fn c() {}"),
        ("d.wgsl", "#import e\n\n@compute @workgroup_size(1)\nfn other() {}\n"),
        ("f.wgsl", "#import g.wgsl\n"),
        ("g.wgsl", "#import f.wgsl\n"),
    ];

    #[test]
    fn a_source_has_each_file_once_and_before_those_that_import_it() {
        let source = Shaders::new(FILES).source("a.wgsl", &[]);
        let wanted = "fn c() {}\nfn b() {}\n// A\n\n\n@compute @workgroup_size(1)\nfn main() {}\n";
        assert_eq!(source.as_deref(), Ok(wanted));
    }

    #[test]
    fn a_name_stands_for_a_file_that_is_chosen() {
        let shaders = Shaders::new(FILES).with([("own.wgsl", "#import b.wgsl as e\n#import d.wgsl\n")]);
        let of = |file, choices: &[(&str, &str)]| shaders.source(file, choices).expect("a source");
        assert!(of("d.wgsl", &[("e", "c.wgsl"), ("unused", "nothing.wgsl")]).starts_with("fn c() {}\n\n@"));
        assert!(
            of("own.wgsl", &[("e", "c.wgsl")]).starts_with("fn c() {}\nfn b() {}\n\n@"),
            "its own choice"
        );
    }

    #[test]
    fn an_entry_point_is_found_in_its_file() {
        let shaders = Shaders::new(FILES);
        assert_eq!(shaders.file_of("other"), Some("d.wgsl"));
        assert_eq!(shaders.file_of("b"), None, "no kernel");
        assert_eq!(shaders.with_kernels().collect::<Vec<_>>(), ["a.wgsl", "d.wgsl"]);
    }

    #[test]
    fn what_is_not_there_and_circles_are_told_by_the_files() {
        let shaders = Shaders::new(FILES);
        let why = |file| shaders.source(file, &[]).expect_err(file);
        assert_eq!(why("d.wgsl"), "`d.wgsl` imports `e`, and there is no such shader");
        assert_eq!(why("nothing.wgsl"), "there is no shader `nothing.wgsl`");
        assert_eq!(why("f.wgsl"), "`f.wgsl` imports itself, imported by `g.wgsl`, imported by `f.wgsl`");
    }

    #[test]
    #[should_panic(expected = "two shaders are called `c.wgsl`")]
    fn a_name_is_one_files() {
        let _ = Shaders::new(FILES).with([("c.wgsl", "")]);
    }
}
