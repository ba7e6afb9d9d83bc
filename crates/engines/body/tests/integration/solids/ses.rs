//! The solvent-excluded solid of a few atoms, by enumeration: slow and obvious.
//!
//! The probe's centre may be anywhere outside every ball of radius r + p about an atom. A point
//! belongs to the solid if no such centre is within p of it, so its signed distance is p -
//! (distance to the nearest allowed centre). That nearest centre lies on one sphere, on the circle
//! of two, or at a point of three.

use protomer_body::surface::ImplicitSolid;
use protomer_kernel::Vec3;

pub struct SlowExcluded {
    pub atoms: Vec<(Vec3, f64)>,
    pub probe: f64,
    circles: Vec<(Vec3, Vec3, f64)>,
    corners: Vec<Vec3>,
}

impl SlowExcluded {
    pub fn new(atoms: &[(f64, f64, f64, f64)], probe: f64) -> Self {
        let atoms: Vec<(Vec3, f64)> = atoms
            .iter()
            .map(|&(x, y, z, r)| (Vec3::new(x, y, z), r))
            .collect();
        let mut solid = Self {
            atoms,
            probe,
            circles: Vec::new(),
            corners: Vec::new(),
        };
        let n = solid.atoms.len();
        for i in 0..n {
            for j in 0..i {
                let Some(circle) = solid.circle(i, j) else {
                    continue;
                };
                solid.circles.push(circle);
                for k in 0..j {
                    solid.add_corners(circle, k);
                }
            }
        }
        solid
    }

    fn reach(&self, i: usize) -> f64 {
        self.atoms[i].1 + self.probe
    }

    /// Centre, axis and radius of the circle of two expanded spheres.
    fn circle(&self, i: usize, j: usize) -> Option<(Vec3, Vec3, f64)> {
        let (a, b) = (self.atoms[i].0, self.atoms[j].0);
        let (ra, rb) = (self.reach(i), self.reach(j));
        let d = (b - a).norm();
        if d < 1e-9 {
            return None;
        }
        let along = (d * d + ra * ra - rb * rb) / (2.0 * d);
        let square = ra * ra - along * along;
        let axis = (b - a) / d;
        (square > 0.0).then(|| (a + axis * along, axis, square.sqrt()))
    }

    fn add_corners(&mut self, (centre, axis, radius): (Vec3, Vec3, f64), k: usize) {
        // Points x = centre + radius u, u a unit vector across the axis, with |x - c_k| = R_k.
        let arm = self.atoms[k].0 - centre;
        let across = arm - axis * arm.dot(&axis);
        let length = across.norm();
        if length < 1e-9 {
            return;
        }
        let cosine = (arm.norm_squared() + radius * radius - self.reach(k).powi(2))
            / (2.0 * radius * length);
        if cosine.abs() > 1.0 {
            return;
        }
        let (e1, e2) = (across / length, axis.cross(&(across / length)));
        for sine in [1.0, -1.0].map(|s: f64| s * (1.0 - cosine * cosine).sqrt()) {
            let corner = centre + (e1 * cosine + e2 * sine) * radius;
            if self.is_allowed(&corner) {
                self.corners.push(corner);
            }
        }
    }

    fn is_allowed(&self, x: &Vec3) -> bool {
        (0..self.atoms.len()).all(|i| (x - self.atoms[i].0).norm() >= self.reach(i) - 1e-9)
    }

    /// The nearest allowed probe centre.
    fn nearest(&self, p: &Vec3) -> Vec3 {
        if self.is_allowed(p) {
            return *p;
        }
        let mut best = (f64::INFINITY, *p);
        let mut offer = |x: Vec3, allowed: bool| {
            let distance = (x - p).norm_squared();
            if distance < best.0 && (allowed || self.is_allowed(&x)) {
                best = (distance, x);
            }
        };
        self.corners.iter().for_each(|&corner| offer(corner, true));
        for i in 0..self.atoms.len() {
            let c = self.atoms[i].0;
            offer(
                c + (p - c).try_normalize(1e-12).unwrap_or(Vec3::x()) * self.reach(i),
                false,
            );
        }
        for &(centre, axis, radius) in &self.circles {
            let arm = p - centre;
            let across = (arm - axis * arm.dot(&axis)).try_normalize(1e-9);
            let any = axis
                .cross(&if axis.x.abs() < 0.8 {
                    Vec3::x()
                } else {
                    Vec3::y()
                })
                .normalize();
            offer(centre + across.unwrap_or(any) * radius, false);
        }
        best.1
    }
}

impl ImplicitSolid for SlowExcluded {
    fn signed_distance(&self, p: &Vec3) -> f64 {
        self.probe - (self.nearest(p) - p).norm()
    }
    fn project(&self, p: &Vec3) -> (Vec3, Vec3) {
        let centre = self.nearest(p);
        match (centre - p).try_normalize(1e-12) {
            Some(normal) => (centre - normal * self.probe, normal),
            None => {
                let depth = |(c, r): &(Vec3, f64)| (p - c).norm() - r;
                let (c, r) = self
                    .atoms
                    .iter()
                    .min_by(|a, b| depth(a).total_cmp(&depth(b)))
                    .unwrap();
                let normal = (p - c).normalize();
                (c + normal * *r, normal)
            }
        }
    }
    fn bounds(&self) -> (Vec3, Vec3) {
        let balls = super::Balls(self.atoms.clone());
        balls.bounds()
    }
    fn cover(&self) -> Vec<(Vec3, f64)> {
        self.atoms
            .iter()
            .map(|(c, r)| (*c, r + self.probe))
            .collect()
    }
}
