//! The charge part of a binding free energy: a complex minus its parts, on the same grid.
//!
//! With the solvation energies G = ½ Σ q u of the three solutes ([`crate::poisson_boltzmann`]), and the
//! Coulomb energy between the two parts in the inner permittivity,
//!
//! ΔG = G(complex) - G(first) - G(second) + l/ε_in Σ_i Σ_j q_i q_j / r_ij,
//!
//! the first sum over charges of the first part, the second over those of the second. The bodies are
//! rigid, so nothing else depends on the charges. All three solutes are solved on the points of one grid: what the surfaces of
//! complex and parts have in common then has the same error in both, which cancels (Gilson and Honig,
//! Proteins 4, 7 (1988)).
//!
//! Two grids. The coarse one, `COARSER` times coarser, reaches far out and gives the fine one the
//! potential on its faces. The energies on both show the error. How a grid happens to cut the surface
//! dominates that of a single energy, hardly depends on the salt, and cancels in its differences. Their error
//! falls with the square of the spacing h, so they are extrapolated to h = 0 (Richardson):
//!
//! D = D(h) + (D(h) - D(s h)) / (s² - 1).
//!
//! Ions that follow Boltzmann factors. The dielectric model says how ions respond. With Boltzmann
//! factors ([`IonResponse::Boltzmann`]) highly charged parts hold more ions than the linear equation
//! lets them, and their attraction depends less on the salt. Grids and differences stay the same.
//!
//! Other charges. With ions that respond in proportion the energies are quadratic in the charges. A
//! change dq in one part changes ΔG by
//!
//! dq · (φ_complex - φ_part) + W_complex(dq) - W_part(dq),
//!
//! where φ are the potentials of the charges as they are, without what dq's own part has in both, and W is the solvation energy of
//! dq alone in each solute: what the charge loses by the solvent that the partner displaces.

use crate::charged_sphere::ChargedSphere;
use crate::dielectric::DielectricModel;
use crate::grid::Grid;
use crate::ion_response::IonResponse;
use crate::poisson_boltzmann::{ChargedSolute, Potential, SoluteOnGrid, SolveSettings, grid_for};
use crate::surface::surface_of;
use crate::{FieldError, Result};
use protomer_kernel::{Electrolyte, Vec3};

/// Ratio of the spacings of the coarse and the fine grid.
const COARSER: f64 = 1.4;
/// Largest spacing of the coarse grid, Å.
const COARSEST_ANGSTROM: f64 = 1.1;
/// Distance by which the coarse grid reaches further than the fine one, in Debye lengths of the
/// lowest salt.
const DEBYE_LENGTHS: f64 = 1.5;
/// Least and largest distance by which the coarse grid reaches further than the fine one, Å.
const FURTHER_ANGSTROM: [f64; 2] = [10.0, 60.0];
/// Largest spacing of the fine grid, Å: on a coarser one the two grids would be too alike.
const COARSEST_FINE_ANGSTROM: f64 = 0.9;

/// Two rigid solutes in the place where they bind.
#[derive(Debug, Clone, Copy)]
pub struct BoundPair<'a> {
    /// Atoms of the two solutes, in one frame.
    pub parts: [&'a [ChargedSphere]; 2],
    /// Solute and solvent; its salt does not matter.
    pub dielectric: &'a DielectricModel,
    /// The fine grid and the solver.
    pub settings: &'a SolveSettings,
}

/// Charges that are added to a part.
#[derive(Debug, Clone, PartialEq)]
pub struct AddedCharges {
    /// The part, 0 or 1.
    pub part: usize,
    /// The charges, at places inside its surface.
    pub charges: Vec<ChargedSphere>,
}

/// The charge part of a binding free energy.
#[derive(Debug, Clone, PartialEq)]
pub struct BindingEnergy {
    /// Coulomb energy between the parts in the inner permittivity, kT.
    pub coulomb_kt: f64,
    /// Binding energy in each electrolyte.
    pub at_salts: Vec<BindingEnergyAtSalt>,
    /// Response to each set of added charges, in the first electrolyte.
    pub added: Vec<ChargeResponse>,
    /// The coarse and the fine grid.
    pub grids: [Grid; 2],
}

/// The charge part of a binding free energy in one electrolyte.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BindingEnergyAtSalt {
    /// ΔG, kT: in the first electrolyte that of the fine grid, in the others with the extrapolated effect
    /// of the salt.
    pub energy_kt: f64,
    /// Expected error of ΔG, kT, from the two grids.
    pub error_kt: f64,
    /// Difference from the first electrolyte, extrapolated, kT.
    pub salt_effect_kt: f64,
    /// Expected error of the effect of the salt, kT: half of what the extrapolation changed.
    pub salt_effect_error_kt: f64,
}

/// Response of ΔG to added charges.
///
/// ```
/// use protomer_field::binding::ChargeResponse;
/// let response = ChargeResponse { first_order_kt: -3.0, second_order_kt: 0.5 };
/// assert_eq!(response.change_kt(1.0), -2.5);
/// assert_eq!(response.change_kt(-1.0), 3.5);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChargeResponse {
    /// Change of ΔG of first order, kT.
    pub first_order_kt: f64,
    /// Change of ΔG of second order, kT.
    pub second_order_kt: f64,
}

impl ChargeResponse {
    /// The change of ΔG by these charges times a factor, kT.
    pub fn change_kt(&self, factor: f64) -> f64 {
        factor * (self.first_order_kt + factor * self.second_order_kt)
    }
}

impl BoundPair<'_> {
    /// Solves of [`binding_energy`](Self::binding_energy), each on both grids.
    ///
    /// ```
    /// use protomer_field::binding::BoundPair;
    /// assert_eq!(BoundPair::solves(2, 0), 6, "the complex and its two parts in each salt");
    /// ```
    pub fn solves(salts: usize, added: usize) -> usize {
        3 * salts + 2 * added
    }

    /// The charge part of the binding free energy in electrolytes that differ in their salt only, and
    /// what added charges would change in the first of them. `solved` is called after each solve and
    /// may end the work by an error.
    ///
    /// ```
    /// use protomer_field::binding::BoundPair;
    /// use protomer_field::{ChargedSphere, DielectricModel, FieldError, SolveSettings};
    /// use protomer_kernel::{Electrolyte, Vec3};
    /// let ion = |x, charge_e| {
    ///     [ChargedSphere { centre: Vec3::new(x, 0.0, 0.0), radius_angstrom: 2.0, charge_e }]
    /// };
    /// let salts = [Electrolyte::in_water(298.15, 0.05)?, Electrolyte::in_water(298.15, 0.5)?];
    /// let pair = BoundPair {
    ///     parts: [&ion(0.0, 1.0), &ion(5.0, -1.0)],
    ///     dielectric: &DielectricModel::new(salts[0]),
    ///     settings: &SolveSettings { spacing_angstrom: 0.7, ..SolveSettings::default() },
    /// };
    /// let found = pair.binding_energy(&salts, &[], &mut || Ok::<(), FieldError>(()))?;
    /// // Salt weakens the attraction of opposite charges.
    /// assert!(found.at_salts[1].salt_effect_kt > 0.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`solve`](crate::solve), for electrolytes that differ in more than their salt, for added
    /// charges among ions that follow Boltzmann factors, and those of `solved`.
    pub fn binding_energy<E: From<FieldError>>(
        &self,
        electrolytes: &[Electrolyte],
        added: &[AddedCharges],
        solved: &mut dyn FnMut() -> std::result::Result<(), E>,
    ) -> std::result::Result<BindingEnergy, E> {
        let Some(first) = electrolytes.first() else {
            return Err(FieldError::BadInput("there is no electrolyte; give one".into()).into());
        };
        if self.settings.spacing_angstrom > COARSEST_FINE_ANGSTROM {
            return Err(E::from(FieldError::BadSetting {
                setting: "spacing",
                value: self.settings.spacing_angstrom,
                requirement: "0.05 to 0.9 Å, so that a second grid can be coarser",
            }));
        }
        if !added.is_empty() && self.dielectric.ion_response != IonResponse::Linear {
            let reason = "the effect of added charges rests on the linear equation; leave them out, or \
                          use ions that respond in proportion";
            return Err(FieldError::BadInput(reason.into()).into());
        }
        let dielectric = DielectricModel {
            electrolyte: *first,
            ..*self.dielectric
        };
        let complex = [self.parts[0], self.parts[1]].concat();
        let settings = self.settings_of_grids(electrolytes);
        // Both grids around the complex: parts are solved on its points, so that errors cancel.
        let grids = [
            grid_for(&complex, &settings[0], dielectric.ion_response)?,
            grid_for(&complex, &settings[1], dielectric.ion_response)?,
        ];
        let mut solve = |spheres: &[ChargedSphere], is_wanted: &dyn Fn(&AddedCharges) -> bool| {
            let work = Work {
                spheres,
                dielectric: &dielectric,
                settings: &settings,
                grids: &grids,
                electrolytes,
            };
            let wanted: Vec<&AddedCharges> =
                added.iter().filter(|added| is_wanted(added)).collect();
            work.solve(&wanted, solved)
        };
        let of_complex = solve(&complex, &|_| true)?;
        let of_parts = [
            solve(self.parts[0], &|added| added.part == 0)?,
            solve(self.parts[1], &|added| added.part != 0)?,
        ];
        // The same in all electrolytes, as the inner permittivity has no salt.
        let coulomb_kt = self.coulomb_kt(&dielectric);
        let energies = |grid: usize, salt: usize| {
            let [first, second] = of_parts.each_ref().map(|part| part.energies_kt[salt][grid]);
            of_complex.energies_kt[salt][grid] - first - second + coulomb_kt
        };
        let ratio = grids[0].spacing_angstrom / grids[1].spacing_angstrom;
        let salts = 0..electrolytes.len();
        let on_grids: Vec<[f64; 2]> = salts
            .map(|salt| [energies(0, salt), energies(1, salt)])
            .collect();
        Ok(BindingEnergy {
            coulomb_kt,
            at_salts: extrapolated(&on_grids, ratio),
            added: self.responses(added, &of_complex, &of_parts, &dielectric),
            grids,
        })
    }

    /// Settings of the coarse and of the fine grid.
    fn settings_of_grids(&self, electrolytes: &[Electrolyte]) -> [SolveSettings; 2] {
        let lengths = electrolytes.iter().map(Electrolyte::debye_length_angstrom);
        let [least, most] = FURTHER_ANGSTROM;
        // Wide enough that the potential on the coarse faces has decayed even at the lowest salt.
        let further = (DEBYE_LENGTHS * lengths.fold(0.0, f64::max)).clamp(least, most);
        let fine = *self.settings;
        let coarse = SolveSettings {
            spacing_angstrom: (COARSER * fine.spacing_angstrom).min(COARSEST_ANGSTROM),
            margin_angstrom: fine.margin_angstrom + further,
            ..fine
        };
        [coarse, fine]
    }

    /// l/ε_in Σ q_i q_j / r_ij over the charges of both parts, kT.
    fn coulomb_kt(&self, dielectric: &DielectricModel) -> f64 {
        let mut sum = 0.0;
        for charge in self.parts[0] {
            if charge.charge_e != 0.0 {
                sum += charge.charge_e * coulomb_at(&charge.centre, self.parts[1], dielectric);
            }
        }
        sum
    }

    fn responses(
        &self,
        added: &[AddedCharges],
        complex: &Solved,
        parts: &[Solved; 2],
        dielectric: &DielectricModel,
    ) -> Vec<ChargeResponse> {
        // Added charges of each part are solved in their
        // order; a counter per part finds them again.
        let mut next_in_part = [0; 2];
        let mut responses = Vec::with_capacity(added.len());
        for (of_complex, added) in complex.added.iter().zip(added) {
            let part = added.part.min(1);
            let of_part = &parts[part].added[next_in_part[part]];
            next_in_part[part] += 1;
            let partner = self.parts[1 - part];
            let coulomb = |charge: &ChargedSphere| {
                charge.charge_e * coulomb_at(&charge.centre, partner, dielectric)
            };
            let with_partner: f64 = added.charges.iter().map(coulomb).sum();
            responses.push(ChargeResponse {
                first_order_kt: of_complex.mutual_kt - of_part.mutual_kt + with_partner,
                second_order_kt: of_complex.own_kt - of_part.own_kt,
            });
        }
        responses
    }
}

/// l/ε_in Σ q/r of these charges at a place, kT/e.
fn coulomb_at(place: &Vec3, charges: &[ChargedSphere], dielectric: &DielectricModel) -> f64 {
    let bjerrum = dielectric.electrolyte.vacuum_bjerrum_length_angstrom();
    let terms = charges
        .iter()
        .map(|charge| charge.charge_e / (charge.centre - place).norm());
    bjerrum / dielectric.inner_permittivity * terms.sum::<f64>()
}

/// Extrapolates the energies on the coarse and on the fine grid in each electrolyte, kT, given the
/// ratio of the spacings.
fn extrapolated(on_grids: &[[f64; 2]], ratio: f64) -> Vec<BindingEnergyAtSalt> {
    // Richardson for an error in h²: 1/(s² - 1).
    let per_difference = 1.0 / (ratio * ratio - 1.0);
    let first = on_grids.first().copied().unwrap_or_default();
    let at_salt = |[coarse, fine]: &[f64; 2]| {
        let effects = [coarse - first[0], fine - first[1]];
        let correction = (effects[1] - effects[0]) * per_difference;
        let salt_effect_kt = effects[1] + correction;
        BindingEnergyAtSalt {
            // The energy itself is not extrapolated: how the
            // grid cuts the surface does not fall smoothly.
            energy_kt: first[1] + salt_effect_kt,
            error_kt: ((fine - coarse) * per_difference).abs(),
            salt_effect_kt,
            salt_effect_error_kt: 0.5 * correction.abs(),
        }
    };
    on_grids.iter().map(at_salt).collect()
}

/// One of the three solutes.
struct Work<'a> {
    spheres: &'a [ChargedSphere],
    dielectric: &'a DielectricModel,
    settings: &'a [SolveSettings; 2],
    grids: &'a [Grid; 2],
    electrolytes: &'a [Electrolyte],
}

/// Results that are kept of one solute.
struct Solved {
    /// Solvation energies on the coarse and the fine grid in each electrolyte, kT.
    energies_kt: Vec<[f64; 2]>,
    added: Vec<AddedInSolute>,
}

/// Added charges in one solute, kT.
struct AddedInSolute {
    /// Energy of the added charges with the charges as they are, through the reaction field: the
    /// mean of that of either in the field of the other. Both are equal but for errors of the grid,
    /// and the energy of all charges together holds their mean.
    mutual_kt: f64,
    /// Solvation energy of the added charges alone.
    own_kt: f64,
}

impl Work<'_> {
    fn solve<E: From<FieldError>>(
        &self,
        added: &[&AddedCharges],
        solved: &mut dyn FnMut() -> std::result::Result<(), E>,
    ) -> std::result::Result<Solved, E> {
        let model = self.dielectric;
        let solid = surface_of(self.spheres, model.surface, model.probe_angstrom)?;
        let on_grid = |grid: Grid| SoluteOnGrid::new(&*solid, self.spheres, model, grid);
        let solutes = [on_grid(self.grids[0])?, on_grid(self.grids[1])?];
        let charged = OnGrids::new(&solutes, self.spheres)?;
        let mut energies_kt = Vec::with_capacity(self.electrolytes.len());
        let mut in_reaction_kt = Vec::new();
        for electrolyte in self.electrolytes {
            let [coarse, fine] = charged.solve(electrolyte, self.settings)?;
            // In the first electrolyte only, to which the responses refer.
            if energies_kt.is_empty() {
                in_reaction_kt = added
                    .iter()
                    .map(|addition| in_reaction(&addition.charges, &fine))
                    .collect();
            }
            energies_kt.push([coarse, fine].map(|potential| potential.solvation_energy_kt));
            solved()?;
        }
        // Its sources are as large as the grid; they go before those of the added charges are made.
        drop(charged);
        let mut added_energies = Vec::with_capacity(added.len());
        for (addition, in_reaction_kt) in added.iter().zip(in_reaction_kt) {
            let alone = OnGrids::new(&solutes, &addition.charges)?;
            let [_, fine] = alone.solve(&self.dielectric.electrolyte, self.settings)?;
            added_energies.push(AddedInSolute {
                // The mean of both directions, which the energy of all charges would hold.
                mutual_kt: 0.5 * (in_reaction_kt + in_reaction(self.spheres, &fine)),
                own_kt: fine.solvation_energy_kt,
            });
            solved()?;
        }
        Ok(Solved {
            energies_kt,
            added: added_energies,
        })
    }
}

/// Energy of charges in the reaction field of others, kT.
fn in_reaction(charges: &[ChargedSphere], potential: &Potential) -> f64 {
    let terms = charges
        .iter()
        .map(|charge| charge.charge_e * potential.reaction_at(&charge.centre));
    terms.sum()
}

/// Charges in a solute on both grids.
struct OnGrids<'a>([ChargedSolute<'a>; 2]);

impl<'a> OnGrids<'a> {
    fn new(solutes: &'a [SoluteOnGrid<'a>; 2], charges: &'a [ChargedSphere]) -> Result<Self> {
        let [coarse, fine] = solutes;
        Ok(Self([
            coarse.with_charges(charges)?,
            fine.with_charges(charges)?,
        ]))
    }

    fn solve(
        &self,
        electrolyte: &Electrolyte,
        settings: &[SolveSettings; 2],
    ) -> Result<[Potential; 2]> {
        let coarse = self.0[0].solve(electrolyte, &settings[0])?;
        let fine = self.0[1].solve_within(&coarse, electrolyte, &settings[1])?;
        Ok([coarse, fine])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COARSE: SolveSettings = SolveSettings {
        spacing_angstrom: 0.7,
        margin_angstrom: 8.0,
        cells_multiple: 8,
        boundary: crate::BoundaryCondition::ScreenedAtoms,
        relative_tolerance: 1e-7,
        memory_limit_bytes: 1 << 30,
    };

    fn water(salt_molar: f64) -> Electrolyte {
        Electrolyte::in_water(298.15, salt_molar).unwrap()
    }

    fn sphere(x: f64, radius_angstrom: f64, charge_e: f64) -> ChargedSphere {
        ChargedSphere {
            centre: Vec3::new(x, 0.0, 0.0),
            radius_angstrom,
            charge_e,
        }
    }

    fn energy(
        parts: [&[ChargedSphere]; 2],
        salts: &[Electrolyte],
        added: &[AddedCharges],
    ) -> BindingEnergy {
        let pair = BoundPair {
            parts,
            dielectric: &DielectricModel::new(salts[0]),
            settings: &COARSE,
        };
        let mut solves = 0;
        let mut count = || {
            solves += 1;
            Ok::<(), FieldError>(())
        };
        let found = pair.binding_energy(salts, added, &mut count).unwrap();
        assert_eq!(solves, BoundPair::solves(salts.len(), added.len()));
        found
    }

    /// Debye and Hückel: λ_B q q' exp(-κ (r - 2b)) / (r (1 + κ b)²), with ions up to b = 4 Å.
    #[test]
    fn far_apart_the_charge_part_is_the_screened_energy_of_two_ions() {
        let salts = [0.01, 0.1, 0.3].map(water);
        let (r, b) = (22.0, 4.0);
        let found = energy(
            [&[sphere(0.0, 2.0, 1.0)], &[sphere(r, 2.0, -2.0)]],
            &salts,
            &[],
        );
        let exact = |salt: &Electrolyte| {
            let kappa = salt.inverse_debye_length_per_angstrom();
            let screened = (-kappa * (r - 2.0 * b)).exp() / (1.0 + kappa * b).powi(2);
            -2.0 * salt.bjerrum_length_angstrom() / r * screened
        };
        let first = exact(&salts[0]);
        for (salt, found) in salts.iter().zip(&found.at_salts) {
            let exact = exact(salt);
            assert!((found.energy_kt - exact).abs() < 0.02, "{exact} {found:?}");
            let effect = exact - first;
            assert!(
                (found.salt_effect_kt - effect).abs() < 0.01,
                "{effect} {found:?}"
            );
        }
    }

    /// The slow twin: everything computed again with the changed charges.
    #[test]
    fn the_response_to_added_charges_is_that_of_solving_again() {
        let salts = [water(0.1)];
        let first = [sphere(0.0, 2.5, 1.0), sphere(2.0, 2.0, -0.4)];
        let second = [sphere(5.6, 2.2, -0.8), sphere(8.0, 1.8, 0.5)];
        let place = |x| sphere(x, 1.5, 1.0);
        let added = [
            AddedCharges {
                part: 1,
                charges: vec![place(5.6)],
            },
            AddedCharges {
                part: 0,
                charges: vec![place(2.0)],
            },
        ];
        let found = energy([&first, &second], &salts, &added);
        for (response, factor, part, index) in [
            (0, 0.8, 1, 0),
            (0, 1.6, 1, 0),
            (1, 0.4, 0, 1),
            (1, -1.0, 0, 1),
        ] {
            let mut parts = [first, second];
            parts[part][index].charge_e += factor;
            let again = energy([&parts[0], &parts[1]], &salts, &[]);
            let exact = again.at_salts[0].energy_kt - found.at_salts[0].energy_kt;
            let change = found.added[response].change_kt(factor);
            let allowed = 1e-3 * exact.abs().max(1.0);
            assert!(
                (change - exact).abs() < allowed,
                "{factor}: {change} {exact}"
            );
        }
    }

    /// The slow twin: complex and parts solved one by one, each on a grid of its size.
    #[test]
    fn boltzmann_factors_weaken_the_effect_of_salt_on_high_charges() {
        let salts = [water(0.05), water(0.5)];
        let parts = [[sphere(0.0, 8.0, 12.0)], [sphere(16.5, 8.0, -12.0)]];
        let effect = |ion_response: IonResponse| {
            let dielectric = DielectricModel {
                ion_response,
                ..DielectricModel::new(salts[0])
            };
            let pair = BoundPair {
                parts: [&parts[0], &parts[1]],
                dielectric: &dielectric,
                settings: &COARSE,
            };
            let mut nothing = || Ok::<(), FieldError>(());
            let found = pair.binding_energy(&salts, &[], &mut nothing).unwrap();
            let added = [AddedCharges {
                part: 0,
                charges: parts[0].to_vec(),
            }];
            let responses = pair.binding_energy(&salts[..1], &added, &mut nothing);
            assert_eq!(responses.is_ok(), ion_response == IonResponse::Linear);
            found.at_salts[1].salt_effect_kt
        };
        let boltzmann = IonResponse::Boltzmann(crate::SaltValence::ONE_TO_ONE);
        let one_by_one = |spheres: &[ChargedSphere], electrolyte: Electrolyte| {
            let dielectric = DielectricModel {
                ion_response: boltzmann,
                ..DielectricModel::new(electrolyte)
            };
            let settings = SolveSettings {
                spacing_angstrom: 0.9,
                margin_angstrom: 24.0,
                ..COARSE
            };
            let solved = crate::solve(spheres, &dielectric, &settings).unwrap();
            solved.solvation_energy_kt
        };
        let difference = |spheres: &[ChargedSphere]| {
            one_by_one(spheres, salts[1]) - one_by_one(spheres, salts[0])
        };
        let exact = difference(&parts.concat()) - difference(&parts[0]) - difference(&parts[1]);
        let (nonlinear, linear) = (effect(boltzmann), effect(IonResponse::Linear));
        assert!(
            (nonlinear / exact - 1.0).abs() < 0.02,
            "{nonlinear} {exact}"
        );
        assert!(nonlinear < 0.95 * linear, "{nonlinear} {linear}");
    }

    #[test]
    fn an_error_of_the_second_order_is_taken_out_of_the_effect_of_the_salt() {
        // 5 + c h² and 3 + 2 c h², with h = 1.4 and 1, and c = 0.3.
        let on_grids = [[5.0 + 0.3 * 1.96, 5.3], [3.0 + 0.6 * 1.96, 3.6]];
        let found = extrapolated(&on_grids, 1.4);
        assert_eq!(found[0].salt_effect_kt, 0.0);
        assert!((found[1].salt_effect_kt + 2.0).abs() < 1e-12);
        assert!((found[1].salt_effect_error_kt - 0.15).abs() < 1e-12);
        assert!((found[0].error_kt - 0.3).abs() < 1e-12);
        assert!((found[1].energy_kt - 3.3).abs() < 1e-12);
    }

    #[test]
    fn work_ends_where_the_caller_ends_it() {
        let parts: [&[ChargedSphere]; 2] = [&[sphere(0.0, 2.0, 1.0)], &[sphere(6.0, 2.0, 1.0)]];
        let salts = [water(0.1)];
        let pair = BoundPair {
            parts,
            dielectric: &DielectricModel::new(salts[0]),
            settings: &COARSE,
        };
        let mut stop = || Err(FieldError::BadInput("stopped".into()));
        let error = pair.binding_energy(&salts, &[], &mut stop).unwrap_err();
        assert_eq!(error.to_string(), "stopped");
    }
}
