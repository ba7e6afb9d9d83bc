//! Random and degenerate clusters of atoms.

/// SplitMix64 (Steele, Lea, Flood, OOPSLA 2014, 453).
pub struct Dice(pub u64);

impl Dice {
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
    pub fn below(&mut self, bound: usize) -> usize {
        (self.unit() * bound as f64) as usize
    }
    pub fn direction(&mut self) -> [f64; 3] {
        loop {
            let v = [0; 3].map(|_| 2.0 * self.unit() - 1.0);
            let n = v.iter().map(|x| x * x).sum::<f64>().sqrt();
            if n > 1e-3 && n < 1.0 {
                return v.map(|x| x / n);
            }
        }
    }
}

/// A cluster of `count` atoms in one of several awkward styles: a chain of touching atoms, atoms
/// whose probe-expanded spheres just touch, a cubic lattice, a gas, duplicates.
pub fn cluster(seed: u64, count: usize) -> Vec<(f64, f64, f64, f64)> {
    let mut dice = Dice(seed.wrapping_mul(0x1234_5678_9abc_def1));
    let radii = [1.2, 1.52, 1.55, 1.7, 1.8];
    let style = dice.below(5);
    let mut atoms: Vec<(f64, f64, f64, f64)> = vec![(0.0, 0.0, 0.0, radii[dice.below(5)])];
    while atoms.len() < count {
        let (x, y, z, r) = atoms[dice.below(atoms.len())];
        let radius = radii[dice.below(5)];
        let [u, v, w] = dice.direction();
        let ball = |d: f64| (x + u * d, y + v * d, z + w * d, radius);
        let n = atoms.len();
        let next = match style {
            0 => ball(r + radius + [0.0, 1e-12, -1e-12, 1e-6, -1e-3][dice.below(5)]),
            1 => ball(r + radius + 2.8 + [0.0, 1e-12, -1e-12, 1e-6, -1e-3][dice.below(5)]),
            2 => {
                let step = [1.5, 2.8, 3.4, 4.6][(seed % 4) as usize];
                (
                    (n % 4) as f64 * step,
                    (n / 4 % 4) as f64 * step,
                    (n / 16) as f64 * step,
                    1.7,
                )
            }
            3 => {
                let size = 2.5 * (count as f64).cbrt();
                let mut coordinate = || size * dice.unit();
                (coordinate(), coordinate(), coordinate(), radius)
            }
            _ if dice.unit() < 0.2 => (x, y, z, r),
            _ => ball(1.3 + 2.5 * dice.unit()),
        };
        atoms.push(next);
    }
    atoms
}
