//! One spring of a network: its length or angle, and its energy with derivatives.

use protomer_kernel::jet::{Jet, cross, dot};
use std::f64::consts::{PI, TAU};

/// Rest angles nearer to straight than this (rad) use the form that is smooth there.
const NEARLY_STRAIGHT: f64 = 1e-6;

/// Kind of spring, by the length or angle that it resists.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Kind {
    Rod,
    /// The signed angle in the plane, from the first bond to the second.
    PlaneHinge,
    Hinge,
    /// A hinge at rest when straight.
    StraightHinge,
    Torsion,
}

/// The difference between two places.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bond {
    pub from: usize,
    pub to: usize,
    pub image: [i32; 3],
}

/// A spring ½ k (φ - φ0)².
#[derive(Debug, Clone)]
pub(super) struct Term {
    pub kind: Kind,
    pub stiffness: f64,
    pub rest_value: f64,
    pub bonds: Vec<Bond>,
    /// Start of the block of the Hessian of each pair of bond ends, row end before column end;
    /// `None` above the diagonal.
    pub blocks: Vec<Option<u32>>,
}

impl Term {
    /// A spring whose bonds are these vectors as built, at rest there if `rest_value` is absent.
    pub fn new(
        kind: Kind,
        stiffness: f64,
        rest_value: Option<f64>,
        bonds: Vec<Bond>,
        vectors: &[[f64; 3]],
    ) -> Self {
        let built = kind.measure(vectors);
        let rest_value = match (kind, rest_value) {
            (_, None) => built,
            // On the side on which it is built.
            (Kind::PlaneHinge, Some(angle)) if built < 0.0 => -angle,
            (_, Some(rest_value)) => rest_value,
        };
        let is_straight = kind == Kind::Hinge && (PI - rest_value).abs() < NEARLY_STRAIGHT;
        Self {
            kind: if is_straight {
                Kind::StraightHinge
            } else {
                kind
            },
            stiffness,
            rest_value,
            bonds,
            blocks: Vec::new(),
        }
    }

    /// Nodes of the bonds, two per bond.
    pub fn ends(&self) -> Vec<usize> {
        let mut ends = Vec::with_capacity(2 * self.bonds.len());
        for bond in &self.bonds {
            ends.extend([bond.from, bond.to]);
        }
        ends
    }

    /// ½ k (φ - φ0)².
    pub fn energy(&self, vectors: &[[f64; 3]]) -> f64 {
        let away = self.deviation(self.kind.measure(vectors));
        0.5 * self.stiffness * away * away
    }

    /// Deviation from rest, by the shorter way around for angles in a circle.
    fn deviation(&self, value: f64) -> f64 {
        let away = value - self.rest_value;
        match self.kind {
            Kind::PlaneHinge | Kind::Torsion => away - TAU * (away / TAU).round(),
            Kind::Rod | Kind::Hinge | Kind::StraightHinge => away,
        }
    }

    /// ½ k (φ - φ0)², from the jet of φ.
    fn spring<const N: usize>(&self, value: Jet<N>) -> Jet<N> {
        let away = self.deviation(value.value);
        let k = self.stiffness;
        value.chain(0.5 * k * away * away, k * away, k)
    }

    /// Energy of a rod over the three components of its bond.
    pub fn rod_energy(&self, vectors: &[[f64; 3]; 3]) -> Jet<3> {
        let d = variables(vectors, 0);
        self.spring(dot(&d, &d).sqrt())
    }

    /// Energy of a hinge over the six components of its bonds.
    pub fn hinge_energy(&self, vectors: &[[f64; 3]; 3]) -> Jet<6> {
        let (a, b) = (variables(vectors, 0), variables(vectors, 1));
        match self.kind {
            Kind::PlaneHinge => self.spring(plane_angle(&a, &b)),
            Kind::StraightHinge => square_of_bend(&a, &b) * (2.0 * self.stiffness),
            _ => self.spring(angle(&a, &b)),
        }
    }

    /// Energy of a torsion over the nine components of its bonds.
    pub fn torsion_energy(&self, vectors: &[[f64; 3]; 3]) -> Jet<9> {
        let [a, b, c] = [0, 1, 2].map(|index| variables(vectors, index));
        self.spring(dihedral(&a, &b, &c))
    }
}

impl Kind {
    /// Length or angle of a spring with these vectors as bonds.
    fn measure(self, vectors: &[[f64; 3]]) -> f64 {
        let vector = |index: usize| vectors[index].map(Jet::<0>::constant);
        match self {
            Self::Rod => vectors[0].iter().map(|x| x * x).sum::<f64>().sqrt(),
            Self::PlaneHinge => plane_angle(&vector(0), &vector(1)).value,
            Self::Hinge | Self::StraightHinge => angle(&vector(0), &vector(1)).value,
            Self::Torsion => dihedral(&vector(0), &vector(1), &vector(2)).value,
        }
    }
}

fn variables<const N: usize>(vectors: &[[f64; 3]; 3], index: usize) -> [Jet<N>; 3] {
    [0, 1, 2].map(|i| Jet::variable(vectors[index][i], 3 * index + i))
}

/// A quarter of (π - θ)², as arcsin² (|û_a + û_b|/2), smooth where θ = π.
fn square_of_bend(a: &[Jet<6>; 3], b: &[Jet<6>; 3]) -> Jet<6> {
    let (la, lb) = (dot(a, a).sqrt().recip(), dot(b, b).sqrt().recip());
    let sum = [0, 1, 2].map(|i| a[i] * la + b[i] * lb);
    let quarter = dot(&sum, &sum) * 0.25;
    quarter.arcsine_of_root_squared()
}

/// The angle from a to b in the plane, positive anticlockwise.
fn plane_angle<const N: usize>(a: &[Jet<N>; 3], b: &[Jet<N>; 3]) -> Jet<N> {
    Jet::atan2(&(a[0] * b[1] - a[1] * b[0]), &(a[0] * b[0] + a[1] * b[1]))
}

/// The angle between a and b, 0 to π.
fn angle<const N: usize>(a: &[Jet<N>; 3], b: &[Jet<N>; 3]) -> Jet<N> {
    let normal = cross(a, b);
    Jet::atan2(&dot(&normal, &normal).sqrt(), &dot(a, b))
}

/// The dihedral angle about b: atan2(|b| a · (b × c), (a × b) · (b × c)).
fn dihedral<const N: usize>(a: &[Jet<N>; 3], b: &[Jet<N>; 3], c: &[Jet<N>; 3]) -> Jet<N> {
    let (first, second) = (cross(a, b), cross(b, c));
    Jet::atan2(&(dot(b, b).sqrt() * dot(a, &second)), &dot(&first, &second))
}
