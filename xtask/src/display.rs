//! Whether tests can open a window: a display that nobody sees, and the libraries that a window is made with.

use crate::{apt, vulkan};
use std::process::{Command, Stdio};

/// What is looked for when a window opens, and the packages that have it.
const LIBRARIES: [(&str, &str); 5] = [
    ("libX11.so.6", "libx11-6"),
    ("libX11-xcb.so.1", "libx11-xcb1"),
    ("libXcursor.so.1", "libxcursor1"),
    ("libXi.so.6", "libxi6"),
    ("libxkbcommon-x11.so.0", "libxkbcommon-x11-0"),
];
const SERVER: (&str, &str) = ("Xvfb", "xvfb");

/// Finds them, or installs them, or says what would do. Only Linux needs it.
pub fn provide() -> Result<(), String> {
    if !cfg!(target_os = "linux") {
        return Ok(());
    }
    apt::provide(&missing(), "the test of the viewer's window needs it")
}

fn missing() -> Vec<(&'static str, &'static str)> {
    let mut missing: Vec<_> =
        LIBRARIES.into_iter().filter(|(library, _)| !vulkan::linker_knows(library)).collect();
    let help = Command::new(SERVER.0).arg("-help").stdout(Stdio::null()).stderr(Stdio::null()).status();
    if help.is_err() {
        missing.push(SERVER);
    }
    missing
}
