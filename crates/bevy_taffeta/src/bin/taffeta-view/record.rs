//! Films and pictures without a window: one frame of the simulation a picture.

use crate::args::Args;
use crate::film::{self, Film};
use crate::say;
use crate::stage::Opened;
use crate::studio::Studio;
use bevy_taffeta::taffeta_io::program::{Failure, complain};
use indicatif::{ProgressBar, ProgressStyle};
use std::io;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// How a film ended.
enum Ending {
    Done,
    Interrupted,
    /// The simulation cannot go on.
    Halted(String),
    /// A picture cannot be written.
    Unwritten(io::Error),
}

/// Makes a film of the scene: its start, and a picture of each frame that follows.
pub fn film(args: &Args, opened: &Opened, path: &Path) -> Result<(), Failure> {
    let time = &opened.loaded.scene.time;
    let (count, rate) = (args.frames.unwrap_or(time.frames), args.fps.unwrap_or(1.0 / time.dt));
    let (mut film, notes) = Film::open(path, args.size, rate)?;
    notes.iter().for_each(|note| say(&format!("note: {note}")));
    let stop = stop_on_ctrl_c()?;
    let mut studio = Studio::open(args, opened)?;
    say(&studio.device());
    let clock = Instant::now();
    let (ending, kept) = shoot(&mut studio, &mut film, count, &stop);
    let seconds = clock.elapsed().as_secs_f64();
    let finished = film.finish();
    let kept = match (&finished, kept) {
        (Ok(_), 0) | (Err(_), _) => "nothing is kept".to_owned(),
        (Ok(place), 1) => format!("1 picture is in {}", place.display()),
        (Ok(place), _) => format!("{kept} pictures are in {}", place.display()),
    };
    let ending = match (ending, finished) {
        // What went wrong first is what is said.
        (Ending::Done | Ending::Interrupted, Err(error)) => Ending::Unwritten(error),
        (ending, _) => ending,
    };
    match ending {
        Ending::Done => {
            let long = f64::from(count) / rate;
            say(&format!("{kept}: {long:.1} s at {rate:.4} a second, made in {seconds:.1} s"));
            Ok(())
        }
        Ending::Interrupted => Err(Failure::Interrupted(format!("interrupted: {kept}"))),
        Ending::Halted(why) => Err(Failure::Work(format!("{why}\n{kept}"))),
        Ending::Unwritten(error) => Err(Failure::Work(format!("{}: {error}\n{kept}", path.display()))),
    }
}

/// Takes the pictures of a film; how that ended, and how many were kept.
fn shoot(studio: &mut Studio, film: &mut Film, count: u32, stop: &AtomicBool) -> (Ending, usize) {
    let bar = progress(count);
    let (mut ending, mut kept) = (Ending::Done, 0);
    let mut keep = |pictures: Vec<Vec<u8>>| -> io::Result<()> {
        for picture in pictures {
            film.add(&picture)?;
            kept += 1;
            bar.inc(1);
        }
        Ok(())
    };
    for number in 0..count {
        if stop.load(Ordering::Relaxed) {
            ending = Ending::Interrupted;
            break;
        }
        if let Err(why) = studio.shoot(number > 0) {
            ending = Ending::Halted(why);
            break;
        }
        if let Err(error) = keep(studio.taken()) {
            ending = Ending::Unwritten(error);
            break;
        }
    }
    if !matches!(ending, Ending::Unwritten(_))
        && let Err(error) = keep(studio.rest())
    {
        ending = Ending::Unwritten(error);
    }
    bar.finish_and_clear();
    (ending, kept)
}

/// Makes a picture of one frame.
pub fn picture(args: &Args, opened: &Opened, path: &Path) -> Result<(), Failure> {
    if path.extension().is_none_or(|ending| !ending.eq_ignore_ascii_case("png")) {
        return Err(Failure::Input(format!("--picture {}: FILE.png would do", path.display())));
    }
    film::probe(path)?;
    let stop = stop_on_ctrl_c()?;
    let mut studio = Studio::open(args, opened)?;
    say(&studio.device());
    let last = args.at_frame.unwrap_or(opened.loaded.scene.time.frames);
    let bar = progress(last);
    for frame in 0..last {
        if stop.load(Ordering::Relaxed) {
            return Err(Failure::Interrupted(format!("interrupted at frame {frame}: no picture was made")));
        }
        studio.pass().map_err(|why| Failure::Work(format!("{why}\nno picture was made")))?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    let shot = studio.shoot(false);
    let picture = shot.ok().and_then(|()| studio.rest().pop());
    let picture = picture.ok_or_else(|| Failure::Work("the GPU does not hand out the picture".into()))?;
    film::write_png(path, &picture, args.size)
        .map_err(|error| Failure::Work(format!("{}: {error}", path.display())))?;
    say(&format!("frame {last} is in {}", path.display()));
    Ok(())
}

/// A bar on standard error, which hides itself where that is not a terminal.
fn progress(frames: u32) -> ProgressBar {
    let bar = ProgressBar::new(frames.into());
    let template = "{bar:40} frame {pos}/{len}, {per_sec}, {eta} left";
    // The template is ours and right; were it not, the plain bar serves.
    bar.with_style(ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()))
}

/// Whether the user wants it to end, from now on.
fn stop_on_ctrl_c() -> Result<Arc<AtomicBool>, Failure> {
    let stop = Arc::new(AtomicBool::new(false));
    let seen = Arc::clone(&stop);
    let asked = move || {
        if seen.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
        complain("stopping after this frame; once more to stop at once");
    };
    ctrlc::set_handler(asked).map_err(|error| Failure::Work(format!("cannot listen for Ctrl-C: {error}")))?;
    Ok(stop)
}
