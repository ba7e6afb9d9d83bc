//! Choices of the verbs of voxel sets and networks.

choices! {
    /// Channels of voxels.
    VoxelChannel for protomer_field::voxels::Channel {
        /// 1 where the solvent-excluded surface passes through the voxel.
        Shape,
        /// 1 inside the surface.
        Solid,
        /// Electrostatic potential on the surface, kT/e.
        Potential,
        /// Kyte-Doolittle index of nearby residues.
        Hydropathy,
        /// Edge of the voxels, Å: shows the size of structures scaled to the grid.
        Spacing,
        /// Shape of the second body of an interface.
        #[value(name = "partner_shape")]
        PartnerShape,
        /// Potential of the second body of an interface, kT/e.
        #[value(name = "partner_potential")]
        PartnerPotential,
        /// Hydropathy of the second body of an interface.
        #[value(name = "partner_hydropathy")]
        PartnerHydropathy,
    }
}

choices! {
    /// The quantity to predict.
    LearningTarget for protomer_learn::targets::Target {
        /// The label of the set, unchanged.
        Label,
        /// The space group; all settings of a group count as one.
        SpaceGroup,
        /// The crystal system of the space group.
        CrystalSystem,
        /// The point group of the space group.
        PointGroup,
        /// Whether the space group is polar.
        Polar,
        /// The label as a number.
        Number,
    }
}

choices! {
    /// Scaling of the channels.
    Scaling for protomer_learn::scaling::ScalingMode {
        /// Potential: arcsinh of the value over a robust scale of the occupied voxels; hydropathy:
        /// divided by 4.5.
        Robust,
        /// No scaling.
        Raw,
        /// Each sample standardised to mean 0 and deviation 1 over the box; a harmful control.
        BoxStandardised,
    }
}
