//! The charge part of a binding free energy in words.

use super::result::{Binding, BindingCondition, ExchangeRow};
use crate::stability::affinity::ERROR_KCAL_PER_MOL;
use protomer_common::answer::{Answer, columns, counted, heading};
use protomer_field::IonModel;

impl Answer for Binding {
    fn text(&self) -> String {
        let mut parts = vec![
            self.bodies_in_words(),
            self.interface_in_words(),
            self.ions_in_words(),
            self.table(),
            self.affinity_in_words(),
        ];
        parts.extend(self.slopes_in_words());
        parts.extend(self.exchanges.as_deref().map(exchanges_in_words));
        parts.join("\n")
    }
}

impl Binding {
    fn bodies_in_words(&self) -> String {
        let mut rows = vec![heading([
            "body",
            "chains",
            "atoms",
            "residues",
            "net charge (e)",
        ])];
        for body in &self.bodies {
            rows.push(vec![
                body.name.clone(),
                body.chains.join(" "),
                body.atoms.to_string(),
                body.residues.to_string(),
                format!("{:+.2}", body.net_charge_e),
            ]);
        }
        columns(&rows)
    }

    fn interface_in_words(&self) -> String {
        let overlaps = if self.overlaps { "yes" } else { "no" };
        let contacts = counted(self.native_contacts, "residue contact", "residue contacts");
        format!(
            "{contacts}, closest atoms {:.2} Å apart, hard bodies overlap: {overlaps}",
            self.closest_angstrom
        )
    }

    fn ions_in_words(&self) -> String {
        match self.ions {
            IonModel::Linear => "charge part: linear Poisson-Boltzmann equation",
            IonModel::Boltzmann => "charge part: Poisson-Boltzmann equation with Boltzmann factors",
        }
        .into()
    }

    fn table(&self) -> String {
        let has_uptake = self
            .conditions
            .iter()
            .any(|condition| condition.protons_taken_up.is_some());
        let mut rows = vec![heading([
            "salt (M)",
            "pH",
            "charge part (kT)",
            "error",
            "effect of salt (kT)",
            "error",
            "affinity (kcal/mol)",
            "log10 K_D integrated (M)",
            "fast interaction (kT)",
        ])];
        if has_uptake {
            rows[0].push("protons taken up".into());
        }
        for condition in &self.conditions {
            let mut row = vec![
                format!("{:.4}", condition.salt_molar),
                ph_in_words(condition.ph),
                format!("{:.1}", condition.poisson_boltzmann_kt),
                format!("{:.1}", condition.error_kt),
                format!("{:+.2}", condition.salt_effect_kt),
                format!("{:.2}", condition.salt_effect_error_kt),
                format!("{:.1}", condition.delta_g_kcal_per_mol),
                integrated_in_words(condition),
                terms_in_words(condition),
            ];
            if let Some(protons) = condition.protons_taken_up {
                row.push(format!("{protons:+.2}"));
            }
            rows.push(row);
        }
        columns(&rows)
    }

    fn affinity_in_words(&self) -> String {
        format!(
            "affinity: standard binding free energy at 1 M, estimated from {} and the effect of \
             salt and pH; calibrated on 45 complexes with an error of {ERROR_KCAL_PER_MOL:.1} kcal/mol",
            self.affinity.contacts_in_words()
        )
    }

    fn slopes_in_words(&self) -> Vec<String> {
        let mut lines = Vec::new();
        for fit in &self.slopes {
            let (Some(slope), Some(error)) = (fit.d_ln_k_d_ln_salt, fit.d_ln_k_d_ln_salt_error)
            else {
                continue;
            };
            let at_ph = match self.slopes.len() {
                1 => String::new(),
                _ => format!(" at pH {}", ph_in_words(fit.ph)),
            };
            lines.push(format!(
                "d ln K / d ln c = {slope:+.2} (error {error:.2}){at_ph}; K is the association constant, and \
                 only charges count"
            ));
        }
        lines
    }
}

fn ph_in_words(ph: Option<f64>) -> String {
    ph.map_or("-".into(), |ph| format!("{ph:.2}"))
}

fn integrated_in_words(condition: &BindingCondition) -> String {
    match (condition.log10_kd_molar, condition.log10_kd_error) {
        (Some(value), Some(error)) => format!("{value:.1} ± {error:.1}"),
        _ => "-".into(),
    }
}

/// The energy of the fast interaction; with its terms where there are several.
fn terms_in_words(condition: &BindingCondition) -> String {
    let total = format!("{:.2}", condition.energy_kt);
    if condition.terms_kt.len() < 2 {
        return total;
    }
    let terms = condition.terms_kt.iter();
    let terms: Vec<String> = terms.map(|(name, kt)| format!("{name} {kt:.2}")).collect();
    format!("{total} ({})", terms.join(", "))
}

fn exchanges_in_words(exchanges: &[ExchangeRow]) -> String {
    let mut rows = vec![heading([
        "exchange",
        "body",
        "change of charge (e)",
        "change of the charge part (kT)",
        "linear",
        "own desolvation",
    ])];
    for row in exchanges {
        rows.push(vec![
            row.mutation.clone(),
            row.name.body.clone(),
            format!("{:+.2}", row.charge_change_e),
            format!("{:+.2}", row.energy_change_kt),
            format!("{:+.2}", row.first_order_kt),
            format!("{:+.2}", row.second_order_kt),
        ]);
    }
    format!(
        "exchanges of charge at the interface, at the first salt:\n{}",
        columns(&rows)
    )
}
