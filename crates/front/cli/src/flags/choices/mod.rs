//! Flags that choose from a list. Each list mirrors an enum of the library and adds the help texts.

/// Declares a list of names; each stands for the variant of the same name.
macro_rules! choices {
    (
        $(#[$about:meta])*
        $name:ident for $target:ty { $($(#[$help:meta])* $variant:ident),* $(,)? }
    ) => {
        $(#[$about])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
        pub enum $name {
            $($(#[$help])* $variant),*
        }

        impl From<$name> for $target {
            fn from(chosen: $name) -> Self {
                match chosen {
                    $($name::$variant => Self::$variant),*
                }
            }
        }
    };
}

#[cfg(feature = "learning")]
pub mod learning;

choices! {
    /// The dielectric boundary.
    DielectricSurface for protomer_field::SurfaceDefinition {
        /// The solvent-excluded surface, which a probe rolling over the atoms cannot enter.
        SolventExcluded,
        /// The surface of the atoms: crevices between them contain solvent.
        VanDerWaals,
        /// The solvent-accessible surface: the atoms enlarged by the probe radius.
        SolventAccessible,
    }
}

choices! {
    /// Potential on the faces of the grid.
    BoundaryValues for protomer_field::BoundaryCondition {
        /// The sum of the atoms' Debye-Hückel potentials, each alone in the solvent.
        ScreenedAtoms,
        /// The solution on a coarse grid twice as large: almost independent of the margin.
        CoarseGrid,
    }
}
