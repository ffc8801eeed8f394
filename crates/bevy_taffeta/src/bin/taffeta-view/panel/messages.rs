//! What the engine has to say: what it refuses, why it stands still, what was saved.

use super::room::Left;
use crate::grab::Grab;
use crate::play::{Notices, Restart};
use bevy::prelude::*;
use bevy_egui::egui::{Color32, Frame, Panel, RichText, Ui};

const RED: Color32 = Color32::from_rgb(176, 24, 32);
const PALE_RED: Color32 = Color32::from_rgb(253, 232, 232);
const GREEN: Color32 = Color32::from_rgb(20, 110, 60);
const PALE_GREEN: Color32 = Color32::from_rgb(230, 246, 235);

/// Shows messages, if there are any.
pub fn show(
    mut left: ResMut<Left>,
    mut notices: ResMut<Notices>,
    grab: Res<Grab>,
    mut restart: MessageWriter<Restart>,
) {
    if let Some(why) = &notices.diverged {
        strip(&mut left, "diverged", PALE_RED, |ui| {
            ui.label(RichText::new(why).color(RED));
            if ui.button("⟲ start again").clicked() {
                restart.write(Restart);
            }
        });
    }
    let refused =
        notices.refused.iter().map(|why| format!("{why} (the simulation continues with the values before)"));
    for (index, why) in refused.chain(grab.refused.clone()).enumerate() {
        let name = if index == 0 { "refused" } else { "refused hand" };
        strip(&mut left, name, PALE_RED, |ui| {
            ui.label(RichText::new(why).color(RED));
        });
    }
    let mut read = false;
    if let Some(done) = &notices.done {
        let (words, colours) = match done {
            Ok(words) => (words, (GREEN, PALE_GREEN)),
            Err(words) => (words, (RED, PALE_RED)),
        };
        strip(&mut left, "done", colours.1, |ui| {
            ui.label(RichText::new(words).color(colours.0));
            read = ui.small_button("×").clicked();
        });
    }
    if read {
        notices.done = None;
    }
}

fn strip(left: &mut Left, name: &'static str, fill: Color32, job: impl FnOnce(&mut Ui)) {
    let frame = Frame::new().fill(fill).inner_margin(6.0);
    left.show(Panel::top(name).frame(frame), |ui| {
        ui.horizontal_wrapped(job);
    });
}
