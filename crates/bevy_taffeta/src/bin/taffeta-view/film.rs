//! Where the pictures of a film go: into an MP4 by ffmpeg, or into PNG files.

use bevy_taffeta::taffeta_io::files;
use bevy_taffeta::taffeta_io::program::Failure;
use std::fs::{self, File};
use std::io::{self, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

/// A film under way.
pub enum Film {
    /// ffmpeg takes the pictures.
    Mp4(Encoder),
    /// A folder takes them.
    Folder(Folder),
}

impl Film {
    /// Starts a film of pictures of this size, `rate` of them a second. What the user should know comes with it.
    pub fn open(path: &Path, size: [u32; 2], rate: f64) -> Result<(Self, Vec<String>), Failure> {
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        match ending.as_deref() {
            _ if path.is_dir() => Folder::open(path, size),
            None => Folder::open(path, size),
            Some("mp4") => match Encoder::open(path, size, rate)? {
                Some(encoder) => Ok((Self::Mp4(encoder), Vec::new())),
                None => {
                    let folder = path.with_extension("");
                    let (film, mut notes) = Folder::open(&folder, size)?;
                    notes.push(format!(
                        "there is no ffmpeg to make {} with: the pictures go to {}; to have films, install ffmpeg \
                         (apt-get install ffmpeg, brew install ffmpeg, winget install ffmpeg)",
                        path.display(),
                        folder.display()
                    ));
                    Ok((film, notes))
                }
            },
            Some("png") => {
                Err(refused(path, "FILE.mp4 or a folder would do, or --picture for a single picture"))
            }
            Some(_) => Err(refused(path, "FILE.mp4 or a folder would do")),
        }
    }

    /// Adds a picture: rows of RGBA.
    pub fn add(&mut self, rgba: &[u8]) -> io::Result<()> {
        match self {
            Self::Mp4(encoder) => encoder.add(rgba),
            Self::Folder(folder) => folder.add(rgba),
        }
    }

    /// Completes the film, and says where it is; where it is of no picture, there is none.
    pub fn finish(self) -> io::Result<PathBuf> {
        match self {
            Self::Mp4(encoder) => encoder.finish(),
            Self::Folder(folder) => Ok(folder.path),
        }
    }
}

/// A path that no film can be written to.
fn refused(path: &Path, why: impl std::fmt::Display) -> Failure {
    Failure::Input(format!("{}: {why}", path.display()))
}

fn unwritable(path: &Path, error: &io::Error) -> Failure {
    refused(path, format!("cannot be written: {error}; a place that can be written to would do"))
}

/// PNG files in a folder.
pub struct Folder {
    path: PathBuf,
    size: [u32; 2],
    count: usize,
}

impl Folder {
    /// Makes the folder where there is none, and takes the pictures of an earlier film out of it.
    fn open(path: &Path, size: [u32; 2]) -> Result<(Film, Vec<String>), Failure> {
        let folder = Self { path: path.to_owned(), size, count: 0 };
        let removed = folder.clear().map_err(|error| unwritable(path, &error))?;
        let note = format!("{removed} pictures of an earlier film in {} are removed", path.display());
        Ok((Film::Folder(folder), (removed > 0).then_some(note).into_iter().collect()))
    }

    fn file(&self, number: usize) -> PathBuf {
        self.path.join(format!("frame_{number:04}.png"))
    }

    /// Removes earlier pictures, and finds out whether a file can be made; the number of those removed.
    fn clear(&self) -> io::Result<usize> {
        fs::create_dir_all(&self.path)?;
        let probe = self.path.join("frame.part");
        files::create(&probe)?;
        fs::remove_file(&probe)?;
        let mut removed = 0;
        while fs::remove_file(self.file(removed)).is_ok() {
            removed += 1;
        }
        Ok(removed)
    }

    fn add(&mut self, rgba: &[u8]) -> io::Result<()> {
        write_png(&self.file(self.count), rgba, self.size)?;
        self.count += 1;
        Ok(())
    }
}

/// Writes a picture as PNG, which has its name only when it is whole.
pub fn write_png(path: &Path, rgba: &[u8], [width, height]: [u32; 2]) -> io::Result<()> {
    let part = with_part(path);
    // What others have put there stays.
    let file = files::create(&part)?;
    let write = || -> io::Result<()> {
        let mut encoder = png::Encoder::new(BufWriter::new(file), width, height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let rgb: Vec<u8> = rgba.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&rgb)?;
        writer.finish()?;
        fs::rename(&part, path)
    };
    write().inspect_err(|_| drop(fs::remove_file(&part)))
}

/// Finds out whether a file can be made at a path, before there is anything to write.
pub fn probe(path: &Path) -> Result<(), Failure> {
    let part = with_part(path);
    let found = if path.is_dir() {
        Err(io::Error::from(io::ErrorKind::IsADirectory))
    } else {
        files::create(&part).and_then(|_| fs::remove_file(&part))
    };
    found.map_err(|error| unwritable(path, &error))
}

fn with_part(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".part");
    name.into()
}

/// An ffmpeg that is at work.
pub struct Encoder {
    child: Child,
    path: PathBuf,
    part: PathBuf,
    count: usize,
}

impl Encoder {
    /// Starts ffmpeg; `None` where there is none.
    fn open(path: &Path, [width, height]: [u32; 2], rate: f64) -> Result<Option<Self>, Failure> {
        probe(path)?;
        let part = with_part(path);
        let mut command = Command::new("ffmpeg");
        command
            .args(["-loglevel", "error", "-y", "-f", "rawvideo", "-pixel_format", "rgba"])
            .args(["-video_size", &format!("{width}x{height}"), "-framerate", &rate.to_string(), "-i", "-"])
            // This form of H.264 is played everywhere; it has colours for pairs of rows and columns.
            .args(["-vf", "crop=trunc(iw/2)*2:trunc(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv"])
            .args(["-c:v", "libx264", "-crf", "18", "-pix_fmt", "yuv420p", "-movflags", "+faststart"])
            .args(["-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "bt709", "-f", "mp4"])
            .arg(&part)
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        // Ctrl-C is for us: ffmpeg is to complete the film.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        match command.spawn() {
            Ok(child) => Ok(Some(Self { child, path: path.to_owned(), part, count: 0 })),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(Failure::Work(format!("ffmpeg cannot start: {error}"))),
        }
    }

    fn add(&mut self, rgba: &[u8]) -> io::Result<()> {
        let pipe = self.child.stdin.as_mut().ok_or(io::ErrorKind::BrokenPipe)?;
        let written = pipe.write_all(rgba);
        if written.as_ref().is_err_and(|error| error.kind() == io::ErrorKind::BrokenPipe) {
            // It has gone, and says why.
            return Err(io::Error::other(self.last_words()));
        }
        self.count += 1;
        written
    }

    /// What ffmpeg complains of.
    fn last_words(&mut self) -> String {
        let mut words = Vec::new();
        if let Some(pipe) = self.child.stderr.as_mut() {
            // What cannot be read is not told.
            let _ = pipe.read_to_end(&mut words);
        }
        let words = String::from_utf8_lossy(&words);
        let words = if words.trim().is_empty() { "what it wrote is not whole" } else { words.trim() };
        format!("ffmpeg failed: {words}")
    }

    fn finish(mut self) -> io::Result<PathBuf> {
        // Its end of file.
        drop(self.child.stdin.take());
        let words = self.last_words();
        let done = self.child.wait()?;
        if self.count > 0 {
            // Some do not fail where the disk is full for their last words.
            if !done.success() || !is_whole(&self.part)? {
                return Err(io::Error::other(words));
            }
            fs::rename(&self.part, &self.path)?;
        }
        Ok(self.path.clone())
    }
}

impl Drop for Encoder {
    fn drop(&mut self) {
        // One that was not finished is not needed any more; an ffmpeg without pictures leaves an empty file.
        let _ = self.child.kill();
        let _ = self.child.wait();
        let _ = fs::remove_file(&self.part);
    }
}

/// Whether an MP4 has its index, and ends where its boxes say (ISO/IEC 14496-12, 4.2).
fn is_whole(path: &Path) -> io::Result<bool> {
    let mut file = File::open(path)?;
    let end = file.metadata()?.len();
    let (mut at, mut has_index) = (0, false);
    while at < end {
        let mut head = Vec::new();
        file.seek(SeekFrom::Start(at))?;
        Read::take(&file, 16).read_to_end(&mut head)?;
        head.resize(16, 0);
        let (short, kind, long) = (&head[..4], &head[4..8], &head[8..]);
        let number = |bytes: &[u8]| bytes.iter().fold(0, |sum, &byte| sum << 8 | u64::from(byte));
        let size = match number(short) {
            0 => end - at,
            1 => number(long),
            size => size,
        };
        if size < 8 || size > end - at {
            return Ok(false);
        }
        has_index |= kind == b"moov";
        at += size;
    }
    Ok(has_index)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_film_that_ends_too_early_is_not_whole() {
        let small =
            |kind: &[u8], bytes: usize| [&(8 + bytes as u32).to_be_bytes(), kind, &vec![7; bytes]].concat();
        let large = [&1_u32.to_be_bytes()[..], b"mdat", &26_u64.to_be_bytes(), &[7; 10]].concat();
        let film = [small(b"ftyp", 24), small(b"moov", 100), large].concat();
        let path = std::env::temp_dir().join(format!("taffeta-view-whole-{}.mp4", std::process::id()));
        let whole = |bytes: &[u8]| {
            fs::write(&path, bytes).unwrap();
            is_whole(&path).unwrap()
        };
        assert!(whole(&film));
        for end in [0, 5, 32, 60, 139, 150, film.len() - 1] {
            assert!(!whole(&film[..end]), "{end} bytes");
        }
        assert!(!whole(&small(b"mdat", 9)), "no index");
        fs::remove_file(&path).unwrap();
    }
}
