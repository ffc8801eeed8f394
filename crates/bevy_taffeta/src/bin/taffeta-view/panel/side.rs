//! At the right of the picture: how it is drawn, and all values of the scene.

use super::room::{Left, Shown};
use super::values;
use crate::changes::Changes;
use crate::colours::{Range, shade, viridis};
use crate::grab::Grab;
use crate::looks::{Colouring, Lines, Looks};
use crate::stage::StageRoot;
use bevy::platform::collections::HashSet;
use bevy::prelude::*;
use bevy_egui::egui::{self, CollapsingHeader, Color32, Panel, RichText, ScrollArea, Ui};
use bevy_taffeta::prelude::*;
use bevy_taffeta::taffeta::scene::Time;
use bevy_taffeta::{FromScene, Running};

type Worlds<'w, 's> = Query<
    'w,
    's,
    (Entity, &'static mut SoftWorld, &'static mut Environment, Option<&'static Running>),
    With<StageRoot>,
>;
type Bodies<'w, 's> = Query<'w, 's, (Entity, &'static FromScene, &'static Name, &'static mut SoftMaterial)>;
type Colliders<'w, 's> =
    Query<'w, 's, (Entity, &'static FromScene, &'static Name, &'static mut SoftCollider)>;

/// Shows the panel.
pub fn show(
    mut left: ResMut<Left>,
    shown: Res<Shown>,
    mut looks: ResMut<Looks>,
    mut changes: ResMut<Changes>,
    mut worlds: Worlds,
    mut bodies: Bodies,
    mut colliders: Colliders,
) {
    if shown.values {
        left.show(
            Panel::right("values").resizable(true).default_size(340.0).size_range(300.0..=560.0),
            |ui| {
                ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
                    ui.add_space(4.0);
                    drawing(ui, &mut looks);
                    let waiting = &mut changes.bypass_change_detection().waiting;
                    if let Ok((root, mut world, environment, running)) = worlds.single_mut()
                        && settings(ui, world.bypass_change_detection(), environment, running)
                    {
                        waiting.insert(root);
                    }
                    materials(ui, &mut bodies, waiting);
                    feel(ui, &mut colliders, waiting);
                });
            },
        );
    }
}

/// Shows which colour is which value, in the picture.
pub fn show_legend(left: Res<Left>, looks: Res<Looks>, range: Res<Range>) {
    if looks.colouring != Colouring::Plain
        && let Some(ui) = &left.0
    {
        legend(ui, looks.colouring, &range);
    }
}

/// Shows a copy of a value, and puts back what was changed: what is only looked at does not count as changed.
fn edit<T: Clone>(ui: &mut Ui, value: &mut T, job: impl FnOnce(&mut Ui, &mut T) -> bool) -> bool {
    let mut copy = value.clone();
    let changed = job(ui, &mut copy);
    if changed {
        *value = copy;
    }
    changed
}

fn section(ui: &mut Ui, title: &str, open: bool, job: impl FnOnce(&mut Ui)) {
    CollapsingHeader::new(RichText::new(title).strong().size(14.0)).default_open(open).show(ui, job);
}

/// How the scene is drawn.
fn drawing(ui: &mut Ui, looks: &mut ResMut<Looks>) {
    let mut changed = looks.as_ref().clone();
    section(ui, "view", true, |ui| {
        ui.horizontal(|ui| {
            for one in Colouring::ALL {
                ui.selectable_value(&mut changed.colouring, one, one.name());
            }
        });
        ui.horizontal(|ui| {
            ui.checkbox(&mut changed.surfaces, "surfaces");
            ui.checkbox(&mut changed.colliders, "colliders");
            ui.checkbox(&mut changed.lines[0], "wireframe");
        });
        ui.horizontal_wrapped(|ui| {
            ui.label("springs");
            for (lines, on) in Lines::ALL.iter().zip(&mut changed.lines).skip(1) {
                let [r, g, b] = lines.colour();
                ui.checkbox(on, RichText::new(lines.name()).color(Color32::from_rgb(r, g, b)));
            }
        });
    });
    if changed != **looks {
        **looks = changed;
    }
}

/// Solver, time, world; returns whether the simulation is to be built again.
fn settings(
    ui: &mut Ui,
    world: &mut SoftWorld,
    mut environment: Mut<Environment>,
    running: Option<&Running>,
) -> bool {
    let mut changed = false;
    section(ui, "solver", true, |ui| changed |= edit(ui, &mut world.solver, values::solver));
    section(ui, "time", false, |ui| {
        let steps = |time: &Time| (time.dt, time.max_step);
        let before = steps(&world.time);
        edit(ui, &mut world.time, values::time);
        // How many frames a film has is no matter of the simulation.
        changed |= steps(&world.time) != before;
        if let Some(running) = running {
            limits(ui, running);
        }
    });
    section(ui, "world", false, |ui| {
        if edit(ui, &mut environment.bypass_change_detection().0, values::world) {
            // The engine takes these up while it runs.
            environment.set_changed();
        }
    });
    changed
}

/// The step that the scene can stand.
fn limits(ui: &mut Ui, running: &Running) {
    let limit = running.simulation().largest_stable_step();
    if limit.is_finite() {
        super::fields::row(ui, "stable up to", |ui| {
            ui.weak(format!("{} s at rest", super::fields::number(limit)));
        });
    }
}

/// What bodies are made of.
fn materials(ui: &mut Ui, bodies: &mut Bodies, waiting: &mut HashSet<Entity>) {
    let mut all: Vec<_> = bodies.iter_mut().collect();
    all.sort_by_key(|(_, from, ..)| from.0);
    let single = all.len() == 1;
    for (body, from, name, material) in &mut all {
        ui.push_id(("body", from.0), |ui| {
            section(ui, &format!("body {name}"), single, |ui| {
                if edit(ui, material.bypass_change_detection(), values::material) {
                    waiting.insert(*body);
                }
            });
        });
    }
}

/// How colliders feel.
fn feel(ui: &mut Ui, colliders: &mut Colliders, waiting: &mut HashSet<Entity>) {
    let mut all: Vec<_> = colliders.iter_mut().collect();
    all.sort_by_key(|(_, from, ..)| from.0);
    for (entity, from, name, collider) in &mut all {
        ui.push_id(("collider", from.0), |ui| {
            section(ui, &format!("collider {name}"), false, |ui| {
                if edit(ui, &mut collider.bypass_change_detection().0, values::collider) {
                    waiting.insert(*entity);
                }
            });
        });
    }
}

/// Says, in the picture, that a vertex in the hand waits for time to go on.
pub fn show_waiting(left: Res<Left>, grab: Res<Grab>) {
    let (true, Some(ui)) = (grab.waits, &left.0) else { return };
    let free = ui.available_rect_before_wrap();
    let painter = ui.ctx().layer_painter(egui::LayerId::new(egui::Order::Middle, "waiting".into()));
    let (ink, font) = (Color32::from_rgb(40, 44, 52), egui::FontId::proportional(14.0));
    let words = "paused: the grabbed vertex moves when you resume (space) or advance one frame ( . or N )";
    let words = painter.layout(words.to_owned(), font, ink, (free.width() - 48.0).max(80.0));
    let at = egui::pos2(free.center().x - 0.5 * words.size().x, free.top() + 14.0);
    let back = egui::Rect::from_min_size(at, words.size()).expand2(egui::vec2(10.0, 6.0));
    painter.rect_filled(back, 4.0, Color32::from_white_alpha(215));
    painter.galley(at, words, ink);
}

/// Which colour is which value.
fn legend(ui: &Ui, colouring: Colouring, range: &Range) {
    let free = ui.available_rect_before_wrap();
    let (title, factor) = colouring.legend();
    let (width, height) = (200.0_f32.min(free.width() - 40.0), 12.0);
    let at = egui::pos2(free.left() + 16.0, free.bottom() - 62.0);
    let painter = ui.ctx().layer_painter(egui::LayerId::new(egui::Order::Middle, "legend".into()));
    let back = egui::Rect::from_min_size(at - egui::vec2(8.0, 6.0), egui::vec2(width + 16.0, 56.0));
    painter.rect_filled(back, 4.0, Color32::from_white_alpha(215));
    let (ink, font) = (Color32::from_rgb(40, 44, 52), egui::FontId::proportional(12.0));
    painter.text(at, egui::Align2::LEFT_TOP, title, font.clone(), ink);
    let steps = 64;
    for step in 0..steps {
        let share = (step as f32 + 0.5) / steps as f32;
        let [r, g, b] = viridis(shade(colouring, share)).map(|c| (255.0 * c) as u8);
        let from = at + egui::vec2(width * step as f32 / steps as f32, 17.0);
        let size = egui::vec2(width / steps as f32 + 0.5, height);
        painter.rect_filled(egui::Rect::from_min_size(from, size), 0.0, Color32::from_rgb(r, g, b));
    }
    for (share, align) in
        [(0.0, egui::Align2::LEFT_TOP), (0.5, egui::Align2::CENTER_TOP), (1.0, egui::Align2::RIGHT_TOP)]
    {
        let words = super::fields::rounded(f64::from(share * range.top * factor), 2);
        painter.text(at + egui::vec2(width * share, 31.0), align, words, font.clone(), ink);
    }
}
