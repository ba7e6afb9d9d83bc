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
    /// Method of computing pair energies.
    Energy for protomer::stability::run::EnergyMode {
        /// The direct sum over all pairs of charges.
        Direct,
        /// Intervals that surely hold the sum, refined until they decide: the decisions of the direct
        /// sum, proven. Slower than calibrated energies.
        Certified,
        /// Levels of rising accuracy, the plain sum last: the decisions of the plain sum, by a
        /// variance model of the errors that is calibrated at the start.
        Calibrated,
        /// Levels of rising accuracy, for each pair of bodies the first whose error is likely below
        /// a tolerance.
        Approximate,
        /// Hard bodies without charges.
        None,
    }
}

choices! {
    /// Starting states of the replicas of a sweep.
    ReplicaStarts for protomer::stability::run::Starts {
        /// All replicas from the assembly.
        Assembly,
        /// All replicas from bodies scattered at random, each from others.
        Fluid,
        /// Replicas 0, 2, ... from the assembly, 1, 3, ... from the fluid: whether they come to
        /// agree shows whether they are in equilibrium.
        Both,
    }
}

choices! {
    /// One table of the benchmark.
    BenchPart for protomer::stability::bench::suite::Part {
        /// Moves per CPU-second of each energy mode against the number of charges.
        Charges,
        /// The parts that make up a move with energies by levels.
        Parts,
        /// Cost of a move against the number of bodies, at the same density.
        Bodies,
        /// Wall-clock time of independent replicas against the number of threads.
        Threads,
    }
}

choices! {
    /// Velocities of the squares of a lattice at the start.
    StartVelocities for protomer_lattices::lattice::settings::Velocities {
        /// Every square turns against its neighbours, ω = ±(-1)^(i+j) speed: from the open state it
        /// closes, from any other it opens.
        Checkerboard,
        /// Every ω drawn evenly from -speed to speed.
        Random,
        /// All velocities are zero.
        Rest,
        /// Thermal velocities at the temperature of the heat bath.
        Thermal,
    }
}

choices! {
    /// Definition of the half-diagonal of the square of a body.
    SquareSize for protomer_lattices::lattice::square_of_body::Size {
        /// The distance from the centre to the outline at the corners.
        Corners,
        /// Half-diagonal of the smallest square that contains the outline.
        Outside,
        /// Half-diagonal of the square with the area of the outline.
        Area,
    }
}

choices! {
    /// The axis of projection of a body.
    ViewAxis for protomer_lattices::lattice::square_of_body::Axis {
        /// The axis found from the moments of inertia.
        Auto,
        /// The body's x axis.
        X,
        /// The body's y axis.
        Y,
        /// The body's z axis.
        Z,
    }
}

choices! {
    /// Treatment of residues that lack heavy atoms.
    Missing for protomer_body::structure::MissingAtoms {
        /// Keep the residue as it is.
        Keep,
        /// Leave the residue out.
        Skip,
        /// Refuse the structure.
        Fail,
    }
}

choices! {
    /// Model of the charges of a body.
    Charges for protomer_body::chemistry::ChargeModel {
        /// Partial charges of a force field on every heavy atom.
        ForceField,
        /// Formal charges on the charged groups.
        Formal,
        /// No charges.
        None,
    }
}

choices! {
    /// Contents of the B factors of an exported structure.
    ExportValues for protomer::export::ResidueValues {
        /// The net charge of the residue, e.
        Charge,
        /// The Kyte-Doolittle hydropathy index; zero where it has none.
        Hydropathy,
    }
}

choices! {
    /// The viewer of a script.
    ExportViewer for protomer::export::Viewer {
        /// UCSF ChimeraX: a .cxc file.
        Chimerax,
        /// PyMOL: a .pml file.
        Pymol,
    }
}

choices! {
    /// Symmetry required of an arrangement.
    AskedSymmetry for protomer_body::assembly::Symmetry {
        /// No symmetry: every arrangement with distinct contacts.
        None,
        /// All rotations about the axis.
        Cyclic,
        /// The full group, including half turns.
        Dihedral,
    }
}

choices! {
    /// The model of the potential.
    Potential for protomer_field::PotentialModel {
        /// The linearised Poisson-Boltzmann equation.
        PoissonBoltzmann,
        /// The sum of the atoms' Debye-Hückel potentials in a uniform solvent: faster, but
        /// ignores the dielectric boundary.
        DebyeHueckel,
    }
}

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

choices! {
    /// Boundary condition of a lattice.
    LatticeEdges for protomer_crystal::lattice::Edges {
        /// Edges with nothing beyond them.
        Open,
        /// Edges that continue at the opposite edge.
        Periodic,
    }
}

choices! {
    /// Reference area of the stress on a network.
    Stress for protomer_crystal::framework::StressKind {
        /// Force per undeformed area.
        Nominal,
        /// Force per deformed area.
        Cauchy,
    }
}
