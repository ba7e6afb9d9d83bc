//! What several tests share.

use protomer_kernel::shape::builders::by_name;
use protomer_kernel::shape::polytope::Polytope;
use protomer_md::bath::Ensemble;
use protomer_md::body::Kind;
use protomer_md::engine::Settings;
use protomer_md::pair::central::Central;
use protomer_md::pair::radial::Attraction;
use protomer_md::pair::{Form, Interaction};
use serde_json::Value;

pub const FORMS: [Form; 3] = [Form::Contact, Form::FaceSum, Form::Smooth];

pub fn polytope(name: &str) -> Polytope {
    Polytope::from_shape(&by_name(name).unwrap()).unwrap()
}

/// A body of unit volume.
pub fn kind(name: &str) -> Kind {
    let kind = Kind::from_polytope(&polytope(name)).unwrap();
    kind.of_unit_volume().unwrap()
}

/// Motion at constant energy.
pub fn settings(interaction: impl Into<Interaction>, time_step: f64) -> Settings {
    Settings {
        interaction: interaction.into(),
        time_step,
        ensemble: Ensemble::Nve,
        seed: 1,
        is_threaded: false,
    }
}

/// Attraction in addition to the repulsion, and a term between the centroids.
pub fn attractive(form: Form, strength: f64, central: Central) -> Interaction {
    Interaction {
        form,
        attraction: Attraction {
            strength,
            cut_off: 2.5,
        },
        central,
    }
}

pub fn numbers(value: &Value) -> Vec<f64> {
    let numbers = value.as_array().unwrap().iter();
    numbers.map(|number| number.as_f64().unwrap()).collect()
}
