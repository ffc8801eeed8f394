//! The bytes behind a glTF's buffers: the binary part of a GLB, data URIs, and files that lie where they may.

use super::document::Buffer;
use crate::files::Given;
use base64::Engine;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use std::borrow::Cow;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

/// Standard base 64; padding may be left out.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// Loads buffers.
pub(super) struct Loader<'a> {
    /// The glTF's own folder; `None` for a mesh given as data.
    pub folder: Option<&'a Path>,
    /// Further folders in which buffers may lie.
    pub within: &'a [PathBuf],
    /// Files to take in place of those of the disk.
    pub given: Option<&'a Given>,
    /// The binary part of a GLB.
    pub binary: Option<&'a [u8]>,
}

impl<'a> Loader<'a> {
    /// The data of each buffer, as long as its `byteLength`.
    pub fn load(&self, buffers: &[Buffer]) -> Result<Vec<Cow<'a, [u8]>>, String> {
        let mut files = Vec::new();
        let mut data = Vec::with_capacity(buffers.len());
        for (index, buffer) in buffers.iter().enumerate() {
            let found = self.load_one(index, buffer, &mut files);
            data.push(found.map_err(|what| format!("buffer {index}: {what}"))?);
        }
        Ok(data)
    }

    fn load_one(
        &self,
        index: usize,
        buffer: &Buffer,
        files: &mut Vec<PathBuf>,
    ) -> Result<Cow<'a, [u8]>, String> {
        let Some(uri) = &buffer.uri else {
            let binary = self.binary.filter(|_| index == 0);
            let binary = binary.ok_or("it has no uri, and the file has no binary part for it")?;
            return Ok(Cow::Borrowed(prefix(binary, buffer.byte_length)?));
        };
        if let Some(text) = strip_scheme(uri, "data") {
            let mut bytes = decode_data(text)?;
            let length = prefix(&bytes, buffer.byte_length)?.len();
            bytes.truncate(length);
            return Ok(Cow::Owned(bytes));
        }
        let path = self.resolve(uri)?;
        // Otherwise a small document could ask for one large file many times.
        if files.contains(&path) {
            return Err(format!("`{uri}` is another buffer already; name each file once"));
        }
        let bytes = match self.given {
            Some(given) => {
                prefix(given.get(&path).unwrap_or_default(), buffer.byte_length).map(Cow::Borrowed)
            }
            None => read(&path, buffer.byte_length).map(Cow::Owned),
        };
        files.push(path);
        bytes.map_err(|what| format!("`{uri}` {what}"))
    }

    /// The file that `uri` names, if it lies where it may.
    fn resolve(&self, uri: &str) -> Result<PathBuf, String> {
        let Some(folder) = self.folder else {
            return Err(format!(
                "`{uri}` is a file of its own, and a mesh given as data has none; use a GLB"
            ));
        };
        let outside = || format!("`{uri}` is outside the scene's folder; put the file beside the glTF");
        let name =
            decode_percent(uri).ok_or_else(|| format!("`{uri}` has a % that is not followed by UTF-8"))?;
        if has_scheme(uri) || name.contains('\\') {
            return Err(outside());
        }
        if let Some(given) = self.given {
            let path = folder.join(&name);
            let missing = || format!("`{uri}` is not among the files that were given");
            return given.get(&path).map(|_| path).ok_or_else(missing);
        }
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let real =
            |path: &Path| path.canonicalize().map_err(|error| format!("`{uri}` cannot be read: {error}"));
        let folder = real(folder)?;
        let wanted = plain(&folder, Path::new(&name)).ok_or_else(outside)?;
        let roots: Vec<PathBuf> = self.within.iter().filter_map(|root| root.canonicalize().ok()).collect();
        let inside =
            |path: &Path| path.starts_with(&folder) || roots.iter().any(|root| path.starts_with(root));
        // Before anything is looked for, so that an answer does not say what is there.
        if !inside(&wanted) {
            return Err(outside());
        }
        // And after links have been followed.
        let found = real(&folder.join(&name))?;
        if inside(&found) { Ok(found) } else { Err(outside()) }
    }
}

/// The first `length` of `bytes`.
fn prefix(bytes: &[u8], length: u64) -> Result<&[u8], String> {
    let wanted = usize::try_from(length).ok().and_then(|length| bytes.get(..length));
    wanted.ok_or_else(|| format!("byteLength says {length} bytes, but there are {}", bytes.len()))
}

/// `name` in `folder`, without `.` and `..`; `None` where it does not start there.
fn plain(folder: &Path, name: &Path) -> Option<PathBuf> {
    let mut path = folder.to_owned();
    for component in name.components() {
        match component {
            Component::Normal(part) => path.push(part),
            Component::CurDir => {}
            Component::ParentDir => {
                path.pop();
            }
            Component::RootDir | Component::Prefix(_) => return None,
        }
    }
    Some(path)
}

/// Reads the first `length` bytes of a file.
fn read(path: &Path, length: u64) -> Result<Vec<u8>, String> {
    let cannot = |error: std::io::Error| format!("cannot be read: {error}");
    let file = crate::files::open(path).map_err(cannot)?;
    let found = file.metadata().map_err(cannot)?.len();
    if found < length {
        return Err(format!("has {found} bytes, but byteLength says {length}"));
    }
    let mut bytes = Vec::new();
    bytes
        .try_reserve_exact(length as usize)
        .map_err(|_| format!("does not fit into memory: {length} bytes"))?;
    file.take(length).read_to_end(&mut bytes).map_err(cannot)?;
    if (bytes.len() as u64) < length {
        return Err(format!("became shorter while it was read, than the {length} bytes of byteLength"));
    }
    Ok(bytes)
}

/// The data of a URI `data:[TYPE][;base64],DATA`, from TYPE on.
fn decode_data(text: &str) -> Result<Vec<u8>, String> {
    let (kind, data) = text.split_once(',').ok_or("its data URI has no comma")?;
    if !kind.ends_with(";base64") {
        return Err("its data URI is not in base 64".to_owned());
    }
    BASE64.decode(data).map_err(|error| format!("its data URI is not in base 64: {error}"))
}

/// What follows `SCHEME:`, in any case.
fn strip_scheme<'a>(uri: &'a str, scheme: &str) -> Option<&'a str> {
    let (found, rest) = uri.split_once(':')?;
    found.eq_ignore_ascii_case(scheme).then_some(rest)
}

/// Whether the URI starts with a scheme (RFC 3986, 3.1), or a drive.
fn has_scheme(uri: &str) -> bool {
    let Some((scheme, _)) = uri.split_once(':') else { return false };
    scheme.starts_with(|c: char| c.is_ascii_alphabetic())
        && scheme.chars().all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c))
}

/// Replaces each `%` and two hexadecimal digits by the byte they mean.
fn decode_percent(uri: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.bytes();
    while let Some(byte) = rest.next() {
        bytes.push(match byte {
            b'%' => {
                let mut digit = || char::from(rest.next()?).to_digit(16);
                (digit()? * 16 + digit()?) as u8
            }
            other => other,
        });
    }
    String::from_utf8(bytes).ok()
}

#[cfg(test)]
mod tests {
    use super::{decode_data, decode_percent, has_scheme};

    #[test]
    fn uris_are_taken_apart() {
        assert_eq!(decode_percent("a%20b%C3%bC.bin").unwrap(), "a bü.bin");
        for bad in ["%", "%f", "%ff", "%+1", "%zz", "a%é"] {
            assert_eq!(decode_percent(bad), None, "{bad}");
        }
        assert!(
            has_scheme("http://x/y") && has_scheme("file:x") && has_scheme("C:/x") && !has_scheme("./a:b")
        );
    }

    #[test]
    fn data_is_decoded_with_and_without_padding() {
        for text in ["application/octet-stream;base64,AAEC/w==", ";base64,AAEC/w"] {
            assert_eq!(decode_data(text).unwrap(), [0, 1, 2, 255]);
        }
        assert!(decode_data("text/plain,abc").unwrap_err().contains("not in base 64"));
        assert!(decode_data(";base64,A A").unwrap_err().contains("not in base 64"));
        assert!(decode_data("base64").unwrap_err().contains("no comma"));
    }
}
