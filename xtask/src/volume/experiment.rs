//! What is run: scenes, stiffnesses and forms, and what was published of them.

use crate::root;
use taffeta::scene::VolumeForm;
use taffeta_io::Loaded;

/// A scene of `scenes/` that is run with several forms.
pub struct Experiment {
    /// The file's name without its ending.
    pub scene: &'static str,
    /// What it is, in a table.
    pub what: &'static str,
    /// Further stiffnesses of the structural springs [N/m].
    pub stiffnesses: &'static [f64],
    /// What Va, Choi and Hong 2023 publish of it.
    pub published: &'static [Published],
}

/// Largest losses that are published [%].
pub struct Published {
    /// Stiffness [N/m].
    pub k: f64,
    /// By springs alone.
    pub springs: Option<f64>,
    /// With their constraint.
    pub kept: Option<f64>,
}

/// A run of an experiment.
pub struct Variant {
    pub form: VolumeForm,
    /// Instead of the scene's own stiffness [N/m].
    pub k: Option<f64>,
}

/// The forms that every experiment is run with; those with another stiffness leave out the second.
pub const FORMS: [VolumeForm; 4] =
    [VolumeForm::Corrected, VolumeForm::Projected, VolumeForm::PaperShader, VolumeForm::None];

/// Stiffness in the scenes that have further ones [N/m].
pub const USUAL: f64 = 1000.0;

const fn kept(k: f64, loss: f64) -> Published {
    Published { k, springs: None, kept: Some(loss) }
}

const fn both(springs: f64, loss: f64) -> Published {
    Published { k: USUAL, springs: Some(springs), kept: Some(loss) }
}

/// Of all falls with k = 5,000 N/m they give the mean over their models alone.
pub const PUBLISHED_FALLS: Published = Published { k: 5000.0, springs: Some(95.35), kept: Some(5.61) };

const fn experiment(
    scene: &'static str,
    what: &'static str,
    stiffnesses: &'static [f64],
    published: &'static [Published],
) -> Experiment {
    Experiment { scene, what, stiffnesses, published }
}

/// All of them.
pub const ALL: [Experiment; 12] = [
    experiment(
        "fall_sphere",
        "sphere, fall",
        &[100.0, 5000.0],
        &[kept(100.0, 3.67), kept(1000.0, 2.69), kept(5000.0, 1.56)],
    ),
    experiment(
        "fall_torus",
        "torus, fall",
        &[100.0, 5000.0],
        &[kept(100.0, 11.71), kept(1000.0, 9.51), kept(5000.0, 7.12)],
    ),
    experiment("fall_bunny", "bunny, fall", &[5000.0], &[]),
    experiment("fall_armadillo", "armadillo, fall", &[5000.0], &[]),
    experiment("fall_dragon", "dragon, fall", &[5000.0], &[]),
    experiment("press_bunny", "bunny, pressed", &[], &[both(79.84, 0.33)]),
    experiment("press_armadillo", "armadillo, pressed", &[], &[both(80.35, 0.97)]),
    experiment("twist_pins", "cube, turned by 90°", &[], &[]),
    experiment("twist_torque", "cube, under a torque", &[], &[both(20.37, 0.02)]),
    experiment("poke", "ball, poked", &[], &[]),
    experiment("balloon", "bunny, inflated and deflated", &[], &[]),
    experiment("pile", "64 bodies, fall", &[], &[]),
];

impl Experiment {
    /// Its scene.
    pub fn load(&self) -> Result<Loaded, String> {
        let file = root().join("scenes").join(self.scene).with_extension("toml");
        taffeta_io::load_scene(&file, &[]).map_err(|error| error.to_string())
    }

    /// Its runs: first those with the scene's own stiffness.
    pub fn variants(&self) -> Vec<Variant> {
        let mut variants: Vec<Variant> = FORMS.iter().map(|&form| Variant { form, k: None }).collect();
        if self.scene == "fall_sphere" {
            // One is enough to show that it diverges.
            variants.push(Variant { form: VolumeForm::Printed, k: None });
        }
        for &k in self.stiffnesses {
            let forms = FORMS.iter().filter(|form| **form != VolumeForm::Projected);
            variants.extend(forms.map(|&form| Variant { form, k: Some(k) }));
        }
        variants
    }
}
