//! S3: bodies of surface springs that keep their volume.

use crate::papers::curve;
use crate::report::look::{Look, grouped, speed, speeds};
use crate::report::page::Section;
use crate::report::table::{Cell, Table};
use crate::runs::behaviour::Behaviour;
use crate::runs::job::{Job, Quick};
use crate::runs::turns::Turns;

/// How the volume is kept: as the program calls it, and as the tables do.
const FORMS: [(&str, &str); 4] = [
    ("none", "springs only"),
    ("paper-shader", "as S3's program"),
    ("corrected", "corrected"),
    ("projected", "corrected and projected"),
];

const FORMS_WORDS: &str = "*As S3's program*: eq. 14 with Φ in place of Φ/h², as the authors' public shader has it by our reading; \
    the paper prints other equations, which blow up (below). *Corrected*: the right gradient and Φ/h². *Projected*: nodes are moved as \
    well. S3's 400 frames would be 0.04 s at one step of 0.1 ms each (`s3-frames` among the errata), ours are 6.7 s: its losses and \
    ours are not of the same fall.";

/// A scene with the name of its body, and what S3 prints of it.
struct Scene {
    name: &'static str,
    body: &'static str,
    label: &'static str,
    /// Its own stiffness, and further ones [N/m].
    stiffnesses: &'static [f64],
    /// Frames that a quick look takes, where it takes it.
    quick: Quick,
}

const fn scene(
    name: &'static str,
    body: &'static str,
    label: &'static str,
    stiffnesses: &'static [f64],
    quick: Quick,
) -> Scene {
    Scene { name, body, label, stiffnesses, quick }
}

const FALLS: [Scene; 5] = [
    scene("fall_sphere", "sphere", "sphere", &[1000.0, 100.0, 5000.0], Quick::Frames(60)),
    scene("fall_torus", "torus", "torus", &[1000.0, 100.0, 5000.0], Quick::Frames(60)),
    scene("fall_bunny", "bunny", "bunny", &[1000.0, 5000.0], Quick::Out),
    scene("fall_armadillo", "armadillo", "armadillo", &[1000.0, 5000.0], Quick::Out),
    scene("fall_dragon", "dragon", "dragon", &[1000.0, 5000.0], Quick::Out),
];
const OTHERS: [Scene; 4] = [
    scene("press_bunny", "bunny", "bunny, pressed (fig. 10)", &[1000.0], Quick::Out),
    scene("press_armadillo", "armadillo", "armadillo, pressed (fig. 10)", &[1000.0], Quick::Out),
    scene("twist_torque", "cube", "cube, twisted by a torque (fig. 11)", &[1000.0], Quick::Frames(60)),
    scene("twist_pins", "cube", "cube, turned by 90°", &[1000.0], Quick::Frames(60)),
];

/// Scenes that S3 does not have.
const OWN: [Scene; 3] = [
    scene("poke", "ball", "ball, poked", &[300.0], Quick::Out),
    scene("balloon", "bunny", "bunny, inflated and deflated", &[300.0], Quick::Out),
    scene(PILE, "ball0", "64 bodies, fall", &[150.0], Quick::Out),
];
/// The scene of many bodies.
const PILE: &str = "pile";

/// All scenes.
fn all() -> impl Iterator<Item = &'static Scene> {
    FALLS.iter().chain(&OTHERS).chain(&OWN)
}

/// Names of a scene's bodies.
fn bodies(scene: &Scene) -> Vec<String> {
    let of_pile = |i: usize| format!("{}{}", ["ball", "ring", "cube"][i % 3], i / 3);
    if scene.name == PILE { (0..64).map(of_pile).collect() } else { vec![scene.body.to_owned()] }
}

/// Whether a scene is run by a form: springs alone follow no volume that changes, and `projected` has each scene's own stiffness.
fn is_run(scene: &Scene, form: &str, k: f64) -> bool {
    match form {
        "none" => scene.name != "balloon",
        "projected" => k == scene.stiffnesses[0],
        _ => true,
    }
}

/// Frames a second that S3 prints of the falls with its constraint: on its CPU, on its GPU.
const FALL_FPS: [(&str, Option<f64>, Option<f64>); 3] = [
    ("bunny", Some(44.23), None),
    ("armadillo", Some(28.19), Some(54.5)),
    ("dragon", Some(9.42), Some(39.39)),
];
/// Largest losses that S3 prints of the others [%]: springs only, with its constraint; and frames a second.
const OTHER_LOSS: [(&str, [f64; 2], &str); 3] = [
    ("press_bunny", [79.84, 0.33], "37.31"),
    ("press_armadillo", [80.35, 0.97], "18.59"),
    ("twist_torque", [20.37, 0.02], "125.17 springs, 123.69 kept"),
];
/// Largest losses that S3 prints by stiffness [%].
const STIFF_LOSS: [(&str, [(f64, f64); 3]); 2] = [
    ("sphere", [(100.0, 3.67), (1000.0, 2.69), (5000.0, 1.56)]),
    ("torus", [(100.0, 11.71), (1000.0, 9.51), (5000.0, 7.12)]),
];

fn job_name(scene: &Scene, form: &str, k: f64) -> String {
    format!("s3-{}-{form}-{k}", scene.name.replace('_', "-"))
}

/// Of these each model has a row on a GPU.
const GPU_FORMS: [(&str, &str); 2] = [FORMS[0], FORMS[2]];

fn gpu_name(model: &str, form: &str) -> String {
    format!("s3-gpu-{model}-{form}")
}

/// All runs.
pub fn jobs() -> Vec<Job> {
    let mut jobs = Vec::new();
    for scene in all() {
        for &k in scene.stiffnesses {
            for (form, _) in FORMS.into_iter().filter(|(form, _)| is_run(scene, form, k)) {
                let mut sets: Vec<String> =
                    bodies(scene).iter().map(|body| format!("body.{body}.volume.form={form}")).collect();
                if k != scene.stiffnesses[0] {
                    sets.push(format!("body.{}.springs.structural.k={k}", scene.body));
                }
                jobs.push(Job::scene(job_name(scene, form, k), scene.name, &sets, scene.quick));
            }
        }
    }
    for scene in all() {
        for (name, threads) in added_names(scene).into_iter().zip([Some(1), None]) {
            jobs.push(Job::turns(name, Turns { scene: scene.name, threads }, Quick::Out));
        }
    }
    for (model, ..) in FALL_FPS {
        for (form, _) in GPU_FORMS {
            let words = format!("bench volume --mesh models/{model}.ply --form {form} --json --backend gpu");
            jobs.push(Job::bench(gpu_name(model, form), words, Quick::Whole).on_gpu());
        }
    }
    let printed = ["body.sphere.volume.form=printed".to_owned()];
    jobs.push(Job::scene(PRINTED, "fall_sphere", &printed, Quick::Frames(60)));
    for (form, _) in FORMS {
        let cpu = format!("bench volume --n 20000 --form {form} --json");
        jobs.push(Job::bench(format!("s3-bench-{form}-1t"), format!("{cpu} --threads 1"), Quick::Frames(3)));
        jobs.push(Job::bench(format!("s3-bench-{form}"), cpu.clone(), Quick::Frames(3)));
        jobs.push(
            Job::bench(format!("s3-bench-{form}-gpu"), format!("{cpu} --backend gpu"), Quick::Whole).on_gpu(),
        );
    }
    jobs
}

/// The fall by the equations as they are printed.
const PRINTED: &str = "s3-fall-sphere-printed";

/// What came out.
pub fn sections(look: &Look) -> Vec<Section> {
    vec![
        fall_speeds(look),
        bench_speeds(look),
        losses(look),
        pressed(look),
        stiffness(look),
        own(look),
        curves(look),
    ]
}

fn fall_speeds(look: &Look) -> Section {
    let mut table = speeds(
        "s3-speed",
        "Figures 5 and 6: the falls, all frames in which the body touches the floor, on as many threads as help. A frame of \
         ours is 1/60 s in 34 sub-steps; S3 prints frames a second with drawing (GTX 1070, i7-7700), \
         of models with other numbers of triangles, and does not say how many steps a frame has.",
        "S3, frames/s: CPU; GPU",
    );
    for scene in &FALLS {
        let fps = FALL_FPS.iter().find(|(label, ..)| *label == scene.label);
        let fps = fps.map_or((None, None), |(_, cpu, gpu)| (*cpu, *gpu));
        for (form, what) in FORMS {
            let number = |fps: Option<f64>| fps.map_or_else(|| "–".to_owned(), |fps| format!("{fps:.2}"));
            let published = match (form, fps) {
                ("corrected" | "paper-shader", (Some(_), _) | (_, Some(_))) => {
                    Cell::Theirs(format!("{}; {}", number(fps.0), number(fps.1)))
                }
                _ => Cell::none(),
            };
            let job = job_name(scene, form, scene.stiffnesses[0]);
            let label = format!("{}, {what}", scene.label);
            table.row(speed(
                look,
                &label,
                &job,
                published,
                "no: other meshes and machine, its CPU has one thread, steps a frame unknown, theirs draws",
            ));
        }
    }
    for (model, _, fps) in FALL_FPS {
        for (form, what) in GPU_FORMS {
            let published = if form == "none" { None } else { fps };
            let published = published.map_or_else(Cell::none, |fps| Cell::Theirs(format!("–; {fps:.2}")));
            let alike = "no: other meshes, another GPU, steps a frame unknown, theirs draws";
            table.row(speed(
                look,
                &format!("{model}, {what}, GPU"),
                &gpu_name(model, form),
                published,
                alike,
            ));
        }
    }
    Section::new("S3: speed of the falls").words(FORMS_WORDS).table(table)
}

fn bench_speeds(look: &Look) -> Section {
    let mut table = speeds(
        "s3-forms",
        "What keeping the volume costs: a torus of 19,908 triangles by each form. S3 prints of its GPU over its CPU: 4.27 times for \
         springs, 2.54 times with the constraint.",
        "S3",
    );
    for (form, what) in FORMS {
        for (device, ending) in [("1 thread", "-1t"), ("as many threads as help", ""), ("GPU", "-gpu")] {
            let job = format!("s3-bench-{form}{ending}");
            let label = format!("{what}, {device}");
            table.row(speed(look, &label, &job, Cell::none(), "ours beside ours"));
        }
    }
    Section::new("S3: what it costs to keep a volume").table(table).table(added(look))
}

/// The runs of what keeping its volume costs a scene: on one thread, and on as many as help.
fn added_names(scene: &Scene) -> [String; 2] {
    ["-1t", ""].map(|ending| format!("s3-added-{}{ending}", scene.name.replace('_', "-")))
}

fn added(look: &Look) -> Table {
    let mut table = Table::new(
        "s3-added",
        "The same bodies with each scene's own stiffness in free fall, so that all forms have the same to do; 25 rounds in which \
         each form has its turn. *Added* is what keeping the volume takes in addition: the median over the rounds, and the \
         quartiles. It should be at most 60 % from 20,000 triangles on, and 30 % is the aim.",
        &[
            "bodies of",
            "triangles",
            "springs",
            "device",
            "springs only, steps/s",
            "corrected, steps/s",
            "added, %",
            "corrected and projected, steps/s",
            "added, %",
        ],
    );
    for scene in all() {
        for job in &added_names(scene) {
            let rate = |form: usize| {
                look.cell(job, move |value| {
                    Some(grouped(value["steps_per_s"][form].as_f64()?.round() as u64))
                })
            };
            let ratio = |form: usize| {
                look.cell(job, move |value| {
                    let percent = |index: usize| Some((value["ratio"][form][index].as_f64()? - 1.0) * 1e2);
                    Some(format!("{:.0} ({:.0} to {:.0})", percent(0)?, percent(1)?, percent(2)?))
                })
            };
            table.row(vec![
                Cell::words(scene.label),
                look.count(job, "triangles"),
                look.count(job, "springs"),
                look.cell(job, |value| value["device"].as_str().map(str::to_owned)),
                rate(0),
                rate(1),
                ratio(0),
                rate(2),
                ratio(1),
            ]);
        }
    }
    table
}

/// Largest and mean loss of a run [%].
fn loss(look: &Look, job: &str) -> [Cell; 2] {
    ["max_loss", "mean_loss"].map(|key| look.cell(job, move |value| Some(percent(value[key].as_f64()?))))
}

fn percent(share: f64) -> String {
    let percent = share * 1e2;
    if percent >= 0.01 { format!("{percent:.2}") } else { format!("{percent:.1e}") }
}

/// A table of losses without rows yet.
fn of_losses(name: &'static str, caption: &str) -> Table {
    let mut columns = vec!["model".to_owned(), "k, N/m".to_owned()];
    columns.extend(FORMS.iter().flat_map(|(_, what)| [format!("{what}: largest"), "mean".to_owned()]));
    Table { name, caption: caption.to_owned(), columns, rows: Vec::new() }
}

/// What a scene loses by each form [%].
fn loss_row(look: &Look, scene: &Scene, k: f64) -> Vec<Cell> {
    let mut row = vec![Cell::words(scene.label), Cell::words(format!("{k}"))];
    for (form, _) in FORMS {
        let runs = is_run(scene, form, k);
        row.extend(if runs { loss(look, &job_name(scene, form, k)) } else { [Cell::none(), Cell::none()] });
    }
    row
}

fn own(look: &Look) -> Section {
    let mut table = of_losses(
        "s3-own",
        "The largest and the mean |V − V₀|/V₀ over all frames [%], V₀ the volume to keep; of 64 bodies, of the one that is off most. \
         The balloon is to have three times its volume, then half of it: springs alone follow neither.",
    );
    OWN.iter().for_each(|scene| table.row(loss_row(look, scene, scene.stiffnesses[0])));
    Section::new("S3: scenes of our own").table(table)
}

const DIFFERENCES: &str = "What differs from S3:

- S3 does not give the mass of a node, the size of a model or the height of the fall. Here a node has 1 kg, the largest extent is 2 m, \
    the lowest node starts 0.5 m above the floor, and every spring has a damping of 200 kg/s (none in the twists). S3's own step: \
    `--set time.max_step=1e-4`.
- S3's program gives back hardly anything of what contact takes in a step, so its loss grows with time and with the step: in the first \
    two seconds of the sphere's fall 3.00 % with steps of 0.5 ms, 1.22 % with 0.2 ms, 0.61 % with 0.1 ms.
- The plate that presses comes down at 0.4 m/s to half the body's height. The torque is 20 N·m for each of the 81 nodes of the \
    cube's top; undamped, the cube swings ever wider, so its numbers depend on how long it runs.
- The models are those that `cargo xtask models` fetches; S3's have other numbers of triangles.";

fn losses(look: &Look) -> Section {
    let mut table = of_losses(
        "s3-loss",
        "Figures 7 and 8: the largest and the mean |V − V₀|/V₀ over the frames of the falls [%]. S3 prints of its \
                  largest, as means over its models with 5,000 N/m, 95.35 for springs only and 5.61 with its constraint. More \
                  than 100 is a body turned inside out.",
    );
    for scene in &FALLS {
        for &k in scene.stiffnesses.iter().filter(|&&k| k != 100.0) {
            table.row(loss_row(look, scene, k));
        }
    }
    let printed = look.cell(PRINTED, |value| {
        let frame = value["diverged"].as_u64();
        Some(frame.map_or_else(|| "holds".to_owned(), |frame| format!("blows up in frame {frame}")))
    });
    let mut form = Table::new(
        "s3-printed",
        "Equations 10 and 14 exactly as they are printed; the errata say why.",
        &["model", "k, N/m", "as printed"],
    );
    form.row(vec![Cell::words("sphere"), Cell::words("1000"), printed]);
    Section::new("S3: volume lost in the falls").table(table).table(form).words(DIFFERENCES)
}

fn pressed(look: &Look) -> Section {
    let mut head = vec!["scene", "S3: springs only", "S3: kept", "S3, frames/s"];
    head.extend(FORMS.iter().map(|(_, what)| *what));
    head.push("ms a frame, corrected");
    let mut table = Table::new(
        "s3-press",
        "Figures 10 and 11: the largest loss [%]. All of these are without weight here; for the pressing because springs of 1,000 N/m do \
         not carry 1 kg a node. The torque is ours: S3 names neither it nor masses, so the twist's numbers compare in kind alone.",
        &head,
    );
    for scene in &OTHERS {
        let published = OTHER_LOSS.iter().find(|(name, ..)| *name == scene.name);
        let mut row = vec![Cell::words(scene.label)];
        row.extend([0, 1].map(|index| Cell::theirs(published.map(|(_, losses, _)| losses[index]), 2)));
        row.push(published.map_or_else(Cell::none, |(.., fps)| Cell::Theirs((*fps).to_owned())));
        let job = |form| job_name(scene, form, scene.stiffnesses[0]);
        for (form, _) in FORMS {
            let [largest, _] = loss(look, &job(form));
            row.push(largest);
        }
        row.push(look.cell(&job("corrected"), |value| {
            Some(crate::report::look::short(value["ms_per_frame"]["median"].as_f64()?))
        }));
        table.row(row);
    }
    Section::new("S3: pressed and twisted").table(table)
}

fn stiffness(look: &Look) -> Section {
    let mut table = Table::new(
        "s3-stiffness",
        "The largest loss of falls by stiffness [%]. S3: the stiffer the springs, the less is lost. By its program it is so here too for \
         ball and torus, though by less; the bunny, the armadillo and the dragon lose more where they are stiffer (table above).",
        &["model", "k, N/m", "S3: kept", "as S3's program", "corrected", "springs only"],
    );
    for (label, printed) in STIFF_LOSS {
        let Some(scene) = FALLS.iter().find(|scene| scene.label == label) else { continue };
        for (k, published) in printed {
            let [shader, corrected, none] = ["paper-shader", "corrected", "none"].map(|form| {
                let [largest, _] = loss(look, &job_name(scene, form, k));
                largest
            });
            let published = Cell::theirs(Some(published), 2);
            table.row(vec![
                Cell::words(label),
                Cell::words(format!("{k}")),
                published,
                shader,
                corrected,
                none,
            ]);
        }
    }
    Section::new("S3: loss by stiffness").table(table)
}

fn curves(look: &Look) -> Section {
    let mut section = Section::new("S3: volume over time");
    for scene in all() {
        let curve = |(form, what): (&str, &'static str)| {
            let done: Behaviour = look.of(&job_name(scene, form, scene.stiffnesses[0]))?;
            Some((what, done.curve))
        };
        let curves: Vec<_> = FORMS.into_iter().filter_map(curve).collect();
        if !curves.is_empty() {
            let name = format!("s3-{}", scene.name.replace('_', "-"));
            section = section.plot(curve::volume(&name, scene.label, &curves));
        }
    }
    section
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runs::job::What;
    use crate::runs::scenes;

    #[test]
    fn every_scene_takes_what_is_set_if_its_mesh_is_there() {
        for job in jobs() {
            if let What::Scene(scene) = &job.what {
                let loaded = scenes::load(scene.name, &scene.sets);
                let missing = |error: &String| error.contains("cargo xtask models");
                assert!(loaded.as_ref().err().is_none_or(missing), "{}: {:?}", job.name, loaded.err());
            }
        }
    }
}
