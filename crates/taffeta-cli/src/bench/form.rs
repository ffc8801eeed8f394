//! Which equations a bench is asked for: of a volume, or of implicit constraints.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use taffeta::scene::{ConstraintForm, VolumeForm};

/// Equations by name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// How a volume is kept.
    Volume(VolumeForm),
    /// How implicit constraints are solved.
    Ice(ConstraintForm),
}

/// All of them, ours first.
const FORMS: [Form; 7] = [
    Form::Volume(VolumeForm::Corrected),
    Form::Volume(VolumeForm::Projected),
    Form::Volume(VolumeForm::PaperShader),
    Form::Volume(VolumeForm::Printed),
    Form::Volume(VolumeForm::None),
    Form::Ice(ConstraintForm::Compliant),
    Form::Ice(ConstraintForm::Primal),
];

impl Form {
    /// Its name, as scenes have it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Volume(form) => form.name(),
            Self::Ice(form) => form.name(),
        }
    }

    /// How a volume is kept, if it says that.
    pub fn of_volume(self) -> Option<VolumeForm> {
        if let Self::Volume(form) = self { Some(form) } else { None }
    }

    /// The names of those that `fits`.
    pub fn names(fits: impl Fn(Self) -> bool) -> String {
        FORMS.into_iter().filter(|&form| fits(form)).map(Self::name).collect::<Vec<_>>().join(", ")
    }
}

/// Takes the name of a form on the command line.
pub fn parser() -> impl TypedValueParser<Value = Form> {
    PossibleValuesParser::new(FORMS.map(Form::name))
        .try_map(|text| FORMS.into_iter().find(|form| form.name() == text).ok_or("no form"))
}
