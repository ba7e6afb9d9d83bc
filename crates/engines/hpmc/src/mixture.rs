//! Kinds of bodies, and which body is of which kind.

use crate::body::HardBody;
use crate::{Result, error::require};

/// Kinds of bodies and the kind of each.
///
/// ```
/// use protomer_hpmc::{body::HardBody, mixture::Mixture};
/// let (small, large) = (HardBody::<2>::ball(0.5)?, HardBody::<2>::ball(1.0)?);
/// let mixture = Mixture::new(vec![small, large], vec![0, 0, 1])?;
/// assert_eq!((mixture.len(), mixture.widest()), (3, 1.0));
/// # Ok::<(), protomer_hpmc::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Mixture<const D: usize> {
    pub(crate) kinds: Vec<HardBody<D>>,
    pub(crate) kind_of: Vec<u32>,
}

impl<const D: usize> Mixture<D> {
    /// Bodies of these kinds; `kind_of` holds the number of the kind of each.
    ///
    /// ```
    /// use protomer_hpmc::{body::HardBody, mixture::Mixture};
    /// let ball = HardBody::<3>::ball(1.0)?;
    /// assert!(Mixture::new(vec![ball.clone()], vec![0, 0]).is_ok());
    /// assert!(Mixture::new(vec![ball], vec![0, 1]).is_err(), "there is no second kind");
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    ///
    /// # Errors
    /// Without a kind, and for the number of a kind that there is not. If one kind is made of pieces, all must be; the same for ellipsoids.
    pub fn new(kinds: Vec<HardBody<D>>, kind_of: Vec<u32>) -> Result<Self> {
        require(
            "the number of kinds",
            kinds.len() as f64,
            "at least 1",
            !kinds.is_empty(),
        )?;
        let largest = kind_of.iter().copied().max().unwrap_or(0);
        let holds = (largest as usize) < kinds.len();
        require(
            "the number of a kind",
            f64::from(largest),
            "below that of the kinds",
            holds,
        )?;
        let in_pieces = kinds.iter().filter(|kind| kind.pieces().is_some()).count();
        let are_alike = in_pieces == 0 || in_pieces == kinds.len();
        require(
            "the number of kinds in pieces",
            in_pieces as f64,
            "none or all",
            are_alike,
        )?;
        let ellipsoids = kinds
            .iter()
            .filter(|kind| kind.half_axes().is_some())
            .count();
        let are_alike = ellipsoids == 0 || ellipsoids == kinds.len();
        require(
            "the number of kinds that are ellipsoids",
            ellipsoids as f64,
            "none or all",
            are_alike,
        )?;
        Ok(Self { kinds, kind_of })
    }

    /// Equal bodies.
    ///
    /// ```
    /// use protomer_hpmc::{body::HardBody, mixture::Mixture};
    /// let balls = Mixture::equal(HardBody::<3>::ball(1.0)?, 5);
    /// assert_eq!((balls.kinds().len(), balls.kind_of()), (1, &[0; 5][..]));
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    pub fn equal(body: HardBody<D>, count: usize) -> Self {
        Self {
            kinds: vec![body],
            kind_of: vec![0; count],
        }
    }

    /// Number of bodies.
    pub fn len(&self) -> usize {
        self.kind_of.len()
    }

    /// Whether there are no bodies.
    pub fn is_empty(&self) -> bool {
        self.kind_of.is_empty()
    }

    /// Kinds of bodies.
    pub fn kinds(&self) -> &[HardBody<D>] {
        &self.kinds
    }

    /// Number of the kind of each body.
    pub fn kind_of(&self) -> &[u32] {
        &self.kind_of
    }

    /// Body of a number.
    pub fn body(&self, number: usize) -> &HardBody<D> {
        &self.kinds[self.kind_of[number] as usize]
    }

    /// Radius of the ball about its centre that holds any of the bodies.
    ///
    /// ```
    /// use protomer_hpmc::{body::HardBody, mixture::Mixture};
    /// let kinds = vec![HardBody::<3>::ball(0.5)?, HardBody::<3>::ball(2.0)?];
    /// assert_eq!(Mixture::new(kinds, vec![0, 0, 1])?.widest(), 2.0);
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    pub fn widest(&self) -> f64 {
        self.kinds
            .iter()
            .map(|kind| kind.outer_radius)
            .fold(0.0, f64::max)
    }

    /// Mean volume of a body.
    ///
    /// ```
    /// use protomer_hpmc::{body::HardBody, mixture::Mixture};
    /// let (small, large) = (HardBody::<3>::ball(1.0)?, HardBody::<3>::ball(2.0)?);
    /// let expected = (3.0 * small.volume + large.volume) / 4.0;
    /// let mixture = Mixture::new(vec![small, large], vec![0, 0, 0, 1])?;
    /// assert!((mixture.mean_volume() - expected).abs() < 1e-12);
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    pub fn mean_volume(&self) -> f64 {
        let volumes = (0..self.len()).map(|number| self.body(number).volume);
        volumes.sum::<f64>() / self.len().max(1) as f64
    }
}
