//! Physical constants, and what one kT is worth.

/// Elementary charge, C (exact, SI 2019).
pub const ELEMENTARY_CHARGE_COULOMB: f64 = 1.602_176_634e-19;
/// Boltzmann constant, J/K (exact, SI 2019).
pub const BOLTZMANN_JOULE_PER_KELVIN: f64 = 1.380_649e-23;
/// Avogadro constant, 1/mol (exact, SI 2019).
pub const AVOGADRO_PER_MOL: f64 = 6.022_140_76e23;
/// Vacuum permittivity, F/m (CODATA 2022).
pub const VACUUM_PERMITTIVITY_FARAD_PER_METRE: f64 = 8.854_187_818_8e-12;

/// Particles per Å³ at a concentration of 1 mol/L.
pub const NUMBER_DENSITY_PER_MOLAR: f64 = AVOGADRO_PER_MOL * 1e-27;

/// Kilojoules in a thermochemical kilocalorie.
pub const KILOJOULES_PER_KILOCALORIE: f64 = 4.184;

/// The thermal energy of one mole, k_B T N_A in kJ/mol: what one kT is worth.
///
/// ```
/// let kilojoule_per_mol = protomer_kernel::units::kilojoule_per_mol_per_kt(298.15);
/// assert!((kilojoule_per_mol - 2.479).abs() < 1e-3);
/// ```
pub fn kilojoule_per_mol_per_kt(temperature_kelvin: f64) -> f64 {
    BOLTZMANN_JOULE_PER_KELVIN * temperature_kelvin * AVOGADRO_PER_MOL * 1e-3
}
