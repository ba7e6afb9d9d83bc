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
        /// Bounds first, the plain sum where they leave the decision open: the decisions of the
        /// plain sum.
        Certified,
        /// The middle of the bounds, the plain sum for a pair of bodies whose bounds are wider than
        /// a tolerance.
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
        /// What a move with certified energies is made of.
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
