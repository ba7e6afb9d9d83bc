//! From settings to a network, a state on its rods, and a time step.

use super::given_state::GivenState;
use super::settings::{LatticeSettings, NamedTimeStep, TimeStep};
use anyhow::{Result, bail};
use protomer_linkage::CrystalError;
use protomer_linkage::lattice::time_step::automatic_time_step;
use protomer_linkage::lattice::{Motion, Network, Started, State};

/// Energies and forces of charges below this share of kT are nothing.
const NO_INTERACTION: f64 = 1e-6;

/// A lattice at its start.
#[derive(Debug, Clone, PartialEq)]
pub struct Begun {
    /// The topology: which corners the rods join.
    pub network: Network,
    /// The first state.
    pub state: State,
    /// Standard deviation about the coherent state of the random angles that were drawn.
    pub angle_spread_drawn: f64,
    /// Standard deviation about the coherent state of the angles that the rods allowed.
    pub angle_spread: f64,
    /// Number of random starts that were discarded because squares overlapped.
    pub discarded_draws: u32,
    /// Hash of the state from which it starts; empty for a coherent lattice.
    pub input_sha256: String,
}

/// Builds the network of these settings and its initial state. Random angles are redrawn while
/// squares that collide overlap.
///
/// # Errors
/// Names the invalid setting, or says why the rod lengths cannot be satisfied.
///
/// ```
/// use protomer_linkage_verbs::lattice::{settings::LatticeSettings, start::begin};
/// let settings = LatticeSettings { rows: 3, columns: 3, ..LatticeSettings::default() };
/// let begun = begin(&settings)?;
/// assert_eq!(begun.network.squares.len(), 9);
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn begin(settings: &LatticeSettings) -> Result<Begun> {
    begin_unless(settings, &|| false)
}

/// Variant of [`begin()`] that ends when `stops` says that the work must stop: large random angles
/// at short rods take long.
///
/// # Errors
/// As [`begin()`], and [`CrystalError::Stopped`].
pub fn begin_unless(settings: &LatticeSettings, stops: &dyn Fn() -> bool) -> Result<Begun> {
    settings.check()?;
    let network = network(settings)?;
    if let Some(state) = &settings.state {
        let given = GivenState::read(state, settings.frame, network.squares.len())?;
        return begun_on_rods(settings, network, &given);
    }
    if settings.frame.is_some() {
        bail!("--frame is that of a file to start from; add --state FILE.gsd");
    }
    let start = settings.first_state();
    let must_be_apart = settings.collisions && !settings.paper && settings.angle_spread > 0.0;
    let started = if must_be_apart {
        start.build_apart_unless(&network, stops)
    } else {
        start.build_unless(&network, 0, stops)
    };
    let started = started.map_err(|error| with_advice(error, &network))?;
    Ok(Begun::new(network, started, String::new()))
}

/// Begins where squares are given.
///
/// # Errors
/// As [`begin()`], and for squares that are off their rods.
pub fn begin_from(settings: &LatticeSettings, given: &GivenState) -> Result<Begun> {
    settings.check()?;
    begun_on_rods(settings, network(settings)?, given)
}

fn begun_on_rods(
    settings: &LatticeSettings,
    network: Network,
    given: &GivenState,
) -> Result<Begun> {
    let started = given.on_rods(&network, settings)?;
    Ok(Begun::new(network, started, given.sha256()))
}

impl Begun {
    fn new(network: Network, started: Started, input_sha256: String) -> Self {
        Self {
            network,
            state: started.state,
            angle_spread_drawn: started.angle_spread_drawn,
            angle_spread: started.angle_spread_reached,
            discarded_draws: started.discarded_draws,
            input_sha256,
        }
    }
}

/// Whether the work was stopped on request.
pub fn is_stopped(error: &anyhow::Error) -> bool {
    matches!(error.downcast_ref(), Some(CrystalError::Stopped))
}

fn with_advice(error: CrystalError, network: &Network) -> anyhow::Error {
    let advice = match error {
        CrystalError::OverConstrained { .. } if network.cell_mass.is_some() => {
            "straight rows and columns across periodic edges constrain each other redundantly; \
             start from another angle, such as start = 0.3"
        }
        CrystalError::OverConstrained { .. } if network.cell.is_some() => {
            "straight rows and columns across periodic edges constrain each other redundantly; \
             remove one rod of each with removed_rods"
        }
        // These errors explain themselves.
        CrystalError::OverConstrained { .. }
        | CrystalError::Overlap { .. }
        | CrystalError::Stopped => return error.into(),
        _ => {
            "the rods cannot have their lengths in this start; start from 'open', lower \
             angle_spread, or change the sizes and rods that do not fit"
        }
    };
    anyhow::Error::from(error).context(advice)
}

/// The topology: which corners the rods join.
///
/// # Errors
/// Names the square or rod that does not exist.
pub fn network(settings: &LatticeSettings) -> Result<Network> {
    Ok(settings.plan().network()?)
}

/// The time step of a run: the given one, or the longest that conserves the energy.
///
/// # Errors
/// For an invalid network or state.
pub fn time_step(settings: &LatticeSettings, begun: &Begun) -> Result<f64> {
    match settings.time_step {
        TimeStep::Fixed(step) => Ok(step),
        TimeStep::Named(NamedTimeStep::Auto) => {
            let (network, kt) = (&begun.network, settings.temperature.unwrap_or(0.0));
            let forces = settings.motion()?.forces(network, &begun.state)?;
            Ok(automatic_time_step(network, &begun.state, forces, kt)?)
        }
    }
}

/// The warning of charges that do not act at the start: so screened, or so far apart, that their energy and
/// forces are nothing.
///
/// # Errors
/// For an invalid network or state.
pub fn charge_warning(settings: &LatticeSettings, begun: &Begun) -> Result<Option<String>> {
    let Some(screening) = settings.screening else {
        return Ok(None);
    };
    let alone = Motion {
        charges: settings.motion()?.charges,
        ..Motion::default()
    };
    let mut accelerations = vec![0.0; begun.state.positions.len()];
    let mut largest = 0.0_f64;
    for force in alone.forces(&begun.network, &begun.state)? {
        let positions = &begun.state.positions;
        largest = largest.max(
            force
                .accelerate(&begun.network, positions, &mut accelerations)
                .abs(),
        );
    }
    for acceleration in accelerations {
        largest = largest.max(acceleration.abs());
    }
    let nothing = NO_INTERACTION * screening.kt;
    // NaN is no small number: charges that meet are told of by the run.
    Ok((largest <= nothing).then(|| {
        format!(
            "the charges of neighbouring squares do not act on each other at the start (their energy and forces are below \
             {NO_INTERACTION} kT): {} charges with a Debye length of {} Å and {} Å per half-diagonal; check these numbers",
            settings.charges.len(),
            screening.debye_length_angstrom,
            settings.half_diagonal_angstrom.unwrap_or(f64::NAN)
        )
    }))
}

impl LatticeSettings {
    /// Total number of steps.
    pub fn total_steps(&self, time_step: f64) -> u64 {
        self.steps
            .unwrap_or_else(|| (self.time / time_step - 1e-9).ceil().max(0.0) as u64)
    }
}
