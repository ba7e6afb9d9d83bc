//! From selected atoms to charged sites.
//!
//! | module | one idea |
//! |---|---|
//! | [`amino_acid`] | the twenty amino acids: names, heavy atoms |
//! | [`hydropathy`] | the scale of hydropathy |
//! | `additives` | molecules of the crystallisation, which do not belong to the protein |
//! | [`residue_names`] | other residue names: modified residues and their parents, force fields, caps, nucleotides, waters |
//! | [`ions`] | ions by their residue names |
//! | `cofactors` | charges of cofactors, nucleotides and sugars by their residue names |
//! | [`protonation`] | titratable groups, model pKa values, Henderson-Hasselbalch |
//! | [`templates`] | AMBER ff94 charges of each residue |
//! | [`charges`] | the charge of one residue, distributed over its atoms |
//! | [`mutation`] | mutations without new coordinates |
//! | [`radii`] | radii for the surface |
//! | [`titration`] | titratable groups as changes of charge on a background, with polar hydrogens |
//! | `treatment` | how a residue that is not one of the twenty is treated, in words |
//! | [`sites`] | the sites and residues of a body, from a whole selection |

pub(crate) mod additives;
pub mod amino_acid;
pub mod charges;
pub(crate) mod cofactors;
pub mod hydropathy;
pub mod ions;
pub mod mutation;
pub mod protonation;
pub mod radii;
pub mod residue_names;
pub mod sites;
pub mod templates;
pub mod titration;
pub(crate) mod treatment;

pub use amino_acid::AminoAcid;
pub use charges::ChargeModel;
pub use hydropathy::{HYDROPATHY_SCALE, LARGEST_HYDROPATHY};
pub use mutation::{Mutation, mutate, parse_mutations};
pub use protonation::{
    PkaSource, Protonate, Protonated, ResidueProtonation, StructureProtonation, StructureTitration,
};
pub use sites::{ChargedSites, SiteSettings, build_protonated_sites, build_sites, sites_of_points};
