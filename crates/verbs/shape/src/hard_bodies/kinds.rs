//! Kinds of hard bodies from the settings: several shapes, and a spread of sizes.

use super::settings::HardBodySettings;
use super::start::BodyShape;
use anyhow::{Context, Result, bail};
use protomer_hpmc::body::HardBody;
use protomer_hpmc::crystal::UnitCell;
use protomer_hpmc::mixture::Mixture;
use protomer_io::atomic::sha256_hex;
use protomer_kernel::random::{CounterRng, Purpose};

/// Stream of the order of the kinds.
const ORDER: u32 = 1 << 8;
/// Stream of the sizes.
const SIZES: u32 = ORDER + 1;
/// Shares that differ by less, relative to each other, are the same.
const SAME_SHARE: f64 = 1e-9;
/// Largest deviation of a size, in standard deviations.
const FARTHEST: f64 = 3.0;

/// Shapes of all kinds of bodies.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Shapes(Vec<BodyShape>);

impl Shapes {
    /// Reads the shapes of settings.
    pub(super) fn read(settings: &HardBodySettings) -> Result<Self> {
        let mut shapes = Vec::new();
        for name in settings.shape.iter() {
            shapes.push(BodyShape::read(name)?);
        }
        let Some(first) = shapes.first() else {
            bail!("there is no --shape; give one or several");
        };
        let dimension = first.dimension();
        if let Some(other) = shapes
            .iter()
            .position(|shape| shape.dimension() != dimension)
        {
            bail!(
                "--shape {} has {dimension} dimensions and --shape {} {}; give shapes of the same space",
                settings.shape[0],
                settings.shape[other],
                shapes[other].dimension()
            );
        }
        let is_ellipsoid = |shape: &BodyShape| matches!(shape, BodyShape::Ellipsoid(_));
        if let Some(other) = shapes
            .iter()
            .position(|shape| is_ellipsoid(shape) != is_ellipsoid(first))
        {
            bail!(
                "--shape {} and --shape {} cannot be mixed: ellipsoids go with ellipsoids, balls included (ellipsoid:R,R,R)",
                settings.shape[0],
                settings.shape[other]
            );
        }
        Ok(Self(shapes))
    }

    pub(super) fn dimension(&self) -> usize {
        self.0[0].dimension()
    }

    /// The only shape; `None` of several.
    pub(super) fn single(&self) -> Option<&BodyShape> {
        match self.0.as_slice() {
            [shape] => Some(shape),
            _ => None,
        }
    }

    /// SHA-256 of the shapes and of the text from which the bodies start.
    pub(super) fn sha256(&self, start_text: Option<&str>) -> String {
        match self.0.as_slice() {
            [shape] => shape.sha256(start_text),
            shapes => {
                let hashes = shapes.iter().map(|shape| shape.sha256(start_text));
                sha256_hex(hashes.collect::<String>().as_bytes())
            }
        }
    }

    /// Kinds of bodies without their numbers, in the order of the shapes.
    pub(super) fn kinds<const D: usize>(
        &self,
        settings: &HardBodySettings,
    ) -> Result<Vec<HardBody<D>>> {
        let in_pieces = self.in_pieces();
        let body = |(shape, name): (&BodyShape, &String)| {
            let body = shape.body_scaled(settings.rounding_radius, 1.0, in_pieces);
            body.with_context(|| name.clone())
        };
        self.0.iter().zip(settings.shape.iter()).map(body).collect()
    }

    /// Whether bodies of one piece must be held as those of several.
    fn in_pieces(&self) -> bool {
        let has_pieces = self
            .0
            .iter()
            .any(|shape| matches!(shape, BodyShape::Pieces(_)));
        has_pieces && self.0.len() > 1
    }

    /// The bodies of the settings: each kind as often as its share says, in random order; with a spread each body has its own
    /// size.
    pub(super) fn mixture<const D: usize>(
        &self,
        settings: &HardBodySettings,
    ) -> Result<Mixture<D>> {
        self.mixture_in_order(settings, order(self.0.len(), settings))
    }

    /// The bodies of the settings on the sites of a crystal: as its sites have their kinds, or in random order where these are
    /// all alike.
    ///
    /// # Errors
    /// If the crystal has other kinds, or others shares of them, than the settings.
    pub(super) fn mixture_on<const D: usize>(
        &self,
        settings: &HardBodySettings,
        cell: &UnitCell<D>,
    ) -> Result<Mixture<D>> {
        let composition = cell.composition();
        if composition.len() <= 1 {
            return self.mixture(settings);
        }
        require_composition(settings, &composition)?;
        self.mixture_in_order(settings, cell.kinds_of_bodies(settings.bodies))
    }

    fn mixture_in_order<const D: usize>(
        &self,
        settings: &HardBodySettings,
        kind_of: Vec<u32>,
    ) -> Result<Mixture<D>> {
        let kinds = self.kinds::<D>(settings)?;
        if settings.spread == 0.0 {
            return Ok(Mixture::new(kinds, kind_of)?);
        }
        let mut bodies = Vec::with_capacity(kind_of.len());
        for (number, kind) in kind_of.iter().enumerate() {
            let size = 1.0 + settings.spread * deviation(settings.seed, number as u64);
            let shape = &self.0[*kind as usize];
            let scaled = shape.body_scaled(settings.rounding_radius * size, size, self.in_pieces());
            bodies.push(scaled.with_context(|| settings.shape[*kind as usize].clone())?);
        }
        let numbers = (0..bodies.len() as u32).collect();
        Ok(Mixture::new(bodies, numbers)?)
    }
}

/// Checks that shapes and shares are those of a crystal with so many sites of each kind.
fn require_composition(settings: &HardBodySettings, composition: &[usize]) -> Result<()> {
    let (start, shapes, kinds) = (&settings.start, settings.shape.len(), composition.len());
    if shapes != kinds {
        bail!("{start} has sites for {kinds} shapes, and there are {shapes}; give {kinds} --shape");
    }
    let [sites, shares] = [
        composition[0] as f64,
        settings.share.first().copied().unwrap_or(1.0),
    ];
    let fits = |(share, count): (&f64, &usize)| {
        let [share, count] = [share * sites, *count as f64 * shares];
        (share - count).abs() <= SAME_SHARE * count
    };
    if !settings.share.iter().zip(composition).all(fits) {
        let divisor = composition.iter().copied().fold(0, greatest_common_divisor);
        let wanted: Vec<String> = composition
            .iter()
            .map(|count| format!("--share {}", count / divisor.max(1)))
            .collect();
        bail!(
            "the sites of {start} have other shares; give {}, or leave --share out",
            wanted.join(" ")
        );
    }
    Ok(())
}

fn greatest_common_divisor(first: usize, second: usize) -> usize {
    match second {
        0 => first,
        _ => greatest_common_divisor(second, first % second),
    }
}

/// The kind of each body, as the shares say, shuffled.
fn order(kinds: usize, settings: &HardBodySettings) -> Vec<u32> {
    let shares = match settings.share.as_slice() {
        [] => vec![1.0; kinds],
        shares => shares.to_vec(),
    };
    let (total, count): (f64, usize) = (shares.iter().sum(), settings.bodies);
    let mut kind_of = Vec::with_capacity(count);
    let mut sum = 0.0;
    for (kind, share) in shares.iter().enumerate() {
        sum += share;
        kind_of.resize((count as f64 * sum / total).round() as usize, kind as u32);
    }
    if kinds > 1 {
        let mut rng = CounterRng::for_purpose(settings.seed, ORDER, 0, Purpose::HardBodyStart);
        for place in (1..kind_of.len()).rev() {
            kind_of.swap(place, rng.index(place + 1));
        }
    }
    kind_of
}

/// A deviation of a size in standard deviations: normal, drawn again beyond the farthest.
fn deviation(seed: u64, body: u64) -> f64 {
    let mut rng = CounterRng::for_purpose(seed, SIZES, body, Purpose::HardBodyStart);
    loop {
        let [number, _] = rng.normal_pair();
        if number.abs() <= FARTHEST {
            return number;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_common::settings::Words;

    fn settings(shapes: &[&str]) -> HardBodySettings {
        HardBodySettings {
            shape: Words(shapes.iter().map(|name| (*name).to_owned()).collect()),
            bodies: 400,
            ..HardBodySettings::default()
        }
    }

    #[test]
    fn kinds_come_in_their_shares_and_in_random_order() {
        let settings = HardBodySettings {
            share: vec![3.0, 1.0],
            ..settings(&["polygon:4", "polygon:5"])
        };
        let mixture = Shapes::read(&settings)
            .unwrap()
            .mixture::<2>(&settings)
            .unwrap();
        let second = mixture.kind_of().iter().filter(|kind| **kind == 1);
        assert_eq!(second.count(), 100);
        assert!(mixture.kind_of()[..300].contains(&1));
    }

    #[test]
    fn sizes_spread_about_the_shape_with_their_deviation() {
        let settings = HardBodySettings {
            spread: 0.1,
            rounding_radius: 0.2,
            ..settings(&["cube"])
        };
        let mixture = Shapes::read(&settings)
            .unwrap()
            .mixture::<3>(&settings)
            .unwrap();
        let exact = mixture.kinds()[0].volume;
        let sizes: Vec<f64> = mixture
            .kinds()
            .iter()
            .map(|kind| kind.rounding_radius / 0.2)
            .collect();
        let mean = sizes.iter().sum::<f64>() / 400.0;
        let variance = sizes.iter().map(|size| (size - mean).powi(2)).sum::<f64>() / 400.0;
        assert!((mean - 1.0).abs() < 0.02 && (variance.sqrt() - 0.1).abs() < 0.01);
        assert!(sizes.iter().all(|size| (0.7..=1.3).contains(size)));
        let unit = HardBodySettings {
            spread: 0.0,
            ..settings
        };
        let one = Shapes::read(&unit).unwrap().mixture::<3>(&unit).unwrap();
        assert!((exact / one.kinds()[0].volume - sizes[0].powi(3)).abs() < 1e-9);
    }

    #[test]
    fn sites_of_a_crystal_have_their_kinds() {
        let settings = HardBodySettings {
            bodies: 64,
            start: "nacl".into(),
            ..settings(&["cube", "octahedron"])
        };
        let shapes = Shapes::read(&settings).unwrap();
        let on = |name: &str, share: &[f64]| {
            let settings = HardBodySettings {
                share: share.to_vec(),
                start: name.into(),
                ..settings.clone()
            };
            shapes.mixture_on(&settings, &UnitCell::<3>::by_name(name).unwrap())
        };
        let cell = UnitCell::<3>::by_name("nacl").unwrap();
        for share in [&[][..], &[2.0, 2.0]] {
            let mixture = on("nacl", share).unwrap();
            assert_eq!(mixture.kind_of(), cell.kinds_of_bodies(64));
        }
        let words = on("nacl", &[2.0, 1.0]).unwrap_err().to_string();
        assert!(words.contains("give --share 1 --share 1"), "{words}");
        // Sites that are alike are filled at random, as the shares say.
        let mixture = on("fcc", &[3.0, 1.0]).unwrap();
        let second = mixture.kind_of().iter().filter(|kind| **kind == 1);
        assert_eq!(second.count(), 16);
        assert_ne!(mixture.kind_of(), on("fcc", &[1.0, 1.0]).unwrap().kind_of());
        let three = HardBodySettings {
            shape: Words(["cube", "octahedron", "cube"].map(String::from).to_vec()),
            ..settings.clone()
        };
        let words = Shapes::read(&three).unwrap().mixture_on(&three, &cell);
        let words = words.unwrap_err().to_string();
        assert!(words.contains("give 2 --shape"), "{words}");
    }

    #[test]
    fn shapes_of_two_spaces_do_not_mix() {
        let error = Shapes::read(&settings(&["cube", "polygon:4"])).unwrap_err();
        assert!(
            error.to_string().contains("give shapes of the same space"),
            "{error}"
        );
        assert!(
            Shapes::read(&settings(&[]))
                .unwrap_err()
                .to_string()
                .contains("--shape")
        );
    }
}
