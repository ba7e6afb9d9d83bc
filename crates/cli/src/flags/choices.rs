//! Flags that choose from a list. Each list is that of a type of the library, with the words that
//! the help shows.

/// Declares the names of a list, and what each stands for: a variant of the same name.
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

choices! {
    /// How pair energies are computed.
    Energy for protomer::stability::run::EnergyMode {
        /// The plain sum over all pairs of charges.
        Direct,
        /// Levels of rising accuracy, the plain sum last: the decisions of the plain sum, by a
        /// variance model of the errors that is calibrated at the start.
        Calibrated,
        /// The same levels, for each pair of bodies the first whose error is likely below a
        /// tolerance.
        Approximate,
        /// Hard bodies without charges.
        None,
    }
}

choices! {
    /// One table of the benchmark.
    BenchPart for protomer::stability::bench::suite::Part {
        /// Moves per CPU-second of each energy mode against the number of charges.
        Charges,
        /// What a move with energies by levels is made of.
        Parts,
        /// Cost of a move against the number of bodies, at the same density.
        Bodies,
        /// Wall-clock time of independent replicas against the number of threads.
        Threads,
    }
}

choices! {
    /// How the squares of a lattice move at the start.
    StartVelocities for protomer::lattice::settings::Velocities {
        /// Every square turns against its neighbours, ω = ±(-1)^(i+j) speed: from the open state it
        /// closes, from any other it opens.
        Checkerboard,
        /// Every ω drawn evenly from -speed to speed.
        Random,
        /// Nothing moves.
        Rest,
        /// As at the temperature of the heat bath.
        Thermal,
    }
}

choices! {
    /// What the half-diagonal of the square of a body is.
    SquareSize for protomer::lattice::square_of_body::Size {
        /// The reach of the outline at the corners.
        Corners,
        /// Of the smallest square that holds the outline.
        Outside,
        /// Of the square with the area of the outline.
        Area,
    }
}

choices! {
    /// The axis along which to look at a body.
    ViewAxis for protomer::lattice::square_of_body::Axis {
        /// Found from the moments of inertia.
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
    /// How samples are dealt out to training, validation and test.
    Split for protomer::learning::train::SplitBy {
        /// Whole clusters: relatives never stand on both sides.
        Cluster,
        /// One by one: what leaks is what it scores above a split by cluster.
        Sample,
    }
}

choices! {
    /// What to do with residues that lack heavy atoms.
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
    /// Where the charges of a body sit.
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
    /// Symmetry asked of an arrangement.
    AskedSymmetry for protomer_body::assembly::Symmetry {
        /// None: every arrangement that differs in its contacts.
        None,
        /// All rotations about the axis.
        Cyclic,
        /// The whole group, half turns included.
        Dihedral,
    }
}

choices! {
    /// How a potential is found.
    Potential for protomer_field::PotentialModel {
        /// The linearised Poisson-Boltzmann equation.
        PoissonBoltzmann,
        /// The sum of the atoms' Debye-Hückel potentials in a uniform solvent: quicker, and blind to
        /// the dielectric boundary.
        DebyeHueckel,
    }
}

choices! {
    /// The dielectric boundary.
    DielectricSurface for protomer_field::SurfaceDefinition {
        /// Where a probe that rolls over the atoms cannot get in.
        SolventExcluded,
        /// The atoms themselves: crevices between them hold solvent.
        VanDerWaals,
        /// Where the centre of the probe gets: the atoms grown by its radius.
        SolventAccessible,
    }
}

choices! {
    /// Potential on the faces of the grid.
    BoundaryValues for protomer_field::BoundaryCondition {
        /// The sum of the atoms' Debye-Hückel potentials, each alone in the solvent.
        ScreenedAtoms,
        /// From a solve on a coarse grid twice as large: hardly depends on the margin.
        CoarseGrid,
    }
}

choices! {
    /// What voxels carry.
    VoxelChannel for protomer_field::voxels::Channel {
        /// 1 where the solvent-excluded surface passes through.
        Shape,
        /// 1 inside the surface.
        Solid,
        /// Electrostatic potential on the surface, kT/e.
        Potential,
        /// Kyte-Doolittle index of the residues near by.
        Hydropathy,
    }
}

choices! {
    /// How structures are turned.
    VoxelOrientation for protomer_field::voxels::Orientation {
        /// By a random rotation, from the seed and the structure's name.
        Random,
        /// With the principal axes along x, y, z.
        Principal,
        /// Not at all.
        Deposited,
    }
}

choices! {
    /// What is to be predicted.
    LearningTarget for protomer_learn::targets::Target {
        /// The label of the set as it is.
        Label,
        /// The space group, other settings of a group included.
        SpaceGroup,
        /// The crystal system of the space group.
        CrystalSystem,
        /// The point group of the space group.
        PointGroup,
        /// Whether the space group is polar.
        Polar,
    }
}

choices! {
    /// How channels are scaled.
    Scaling for protomer_learn::scaling::ScalingMode {
        /// Potential through arcsinh of a robust scale over occupied voxels, hydropathy by 4.5.
        Robust,
        /// Not at all.
        Raw,
        /// Each sample to mean 0 and deviation 1 over the box; a control that does harm.
        BoxStandardised,
    }
}

choices! {
    /// What is at the edges of a lattice.
    LatticeEdges for protomer_crystal::lattice::Edges {
        /// Nothing.
        Open,
        /// The opposite edge.
        Periodic,
    }
}

choices! {
    /// What the stress on a network is referred to.
    Stress for protomer_crystal::framework::StressKind {
        /// Force per area before loading.
        Nominal,
        /// Force per area under load.
        Cauchy,
    }
}
