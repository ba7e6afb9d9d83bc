//! What a symmetric arrangement of a pattern leaves free, and the recipe that it makes.

use protomer_body::assembly::Recipe;

/// Tilts and spins of the kinds of bodies, stagger of the rings and opening between neighbours.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Coordinates {
    /// Tilt of each kind of body, degrees.
    pub tilt_degrees: Vec<f64>,
    /// Spin of each kind of body, degrees.
    pub spin_degrees: Vec<f64>,
    /// Azimuth of the upper ring over the angle between neighbours.
    pub stagger: f64,
    /// Distance that neighbours keep beyond contact and gap, Å.
    pub opening_angstrom: f64,
}

impl Coordinates {
    /// The pattern with these tilts and spins.
    pub fn recipe(&self, pattern: &Recipe) -> Recipe {
        let mut recipe = pattern.clone();
        for site in recipe.rings.iter_mut().flatten() {
            site.tilt_radian = self.tilt_degrees[site.body].to_radians();
            site.spin_radian = self.spin_degrees[site.body].to_radians();
        }
        recipe.stagger = self.stagger;
        recipe.opening_angstrom = self.opening_angstrom;
        recipe
    }

    /// Number of free coordinates: those of a stack of two rings include the stagger.
    pub fn count(&self, rings: usize) -> usize {
        2 * self.tilt_degrees.len() + rings
    }

    /// The coordinates with one of them moved by a step; `None` where the opening would be negative.
    pub fn moved(&self, coordinate: usize, steps: &Steps, sign: f64) -> Option<Self> {
        let kinds = self.tilt_degrees.len();
        let mut moved = self.clone();
        match coordinate {
            tilt if tilt < kinds => moved.tilt_degrees[tilt] += sign * steps.angle_degrees,
            spin if spin < 2 * kinds => {
                moved.spin_degrees[spin - kinds] += sign * steps.angle_degrees;
            }
            opening if opening == 2 * kinds => moved.opening_angstrom += sign * steps.angstrom,
            _ => moved.stagger += sign * steps.stagger,
        }
        (moved.opening_angstrom >= 0.0).then_some(moved)
    }

    /// The same arrangement with angles from -180 to 180 degrees.
    pub fn wrapped(mut self) -> Self {
        for angle in self.tilt_degrees.iter_mut().chain(&mut self.spin_degrees) {
            let turns = (*angle / 360.0).round();
            *angle -= 360.0 * turns;
        }
        self
    }
}

/// Steps of a refinement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Steps {
    /// Step of tilts and spins, degrees.
    pub angle_degrees: f64,
    /// Step of the opening, Å.
    pub angstrom: f64,
    /// Step of the stagger.
    pub stagger: f64,
}

impl Steps {
    /// Steps of half the size.
    pub fn halved(self) -> Self {
        Self {
            angle_degrees: 0.5 * self.angle_degrees,
            angstrom: 0.5 * self.angstrom,
            stagger: 0.5 * self.stagger,
        }
    }
}

/// All combinations of the tilts and spins for this many kinds of bodies, the last kind changing fastest.
pub(super) fn grid(kinds: usize, tilts: &[f64], spins: &[f64]) -> Vec<Coordinates> {
    let choices = tilts.len() * spins.len();
    let mut points = Vec::with_capacity(choices.pow(kinds as u32));
    for mut number in 0..choices.pow(kinds as u32) {
        let (mut tilt_degrees, mut spin_degrees) = (vec![0.0; kinds], vec![0.0; kinds]);
        for kind in (0..kinds).rev() {
            let choice = number % choices;
            number /= choices;
            tilt_degrees[kind] = tilts[choice / spins.len()];
            spin_degrees[kind] = spins[choice % spins.len()];
        }
        points.push(Coordinates {
            tilt_degrees,
            spin_degrees,
            stagger: 0.0,
            opening_angstrom: 0.0,
        });
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_body::assembly::RecipeSite;

    #[test]
    fn the_grid_has_every_combination_once() {
        let points = grid(2, &[0.0, 45.0, 90.0], &[0.0, 30.0]);
        assert_eq!(points.len(), 36);
        for (number, point) in points.iter().enumerate() {
            assert!(!points[..number].contains(point));
        }
        assert_eq!(points[35].tilt_degrees, [90.0, 90.0]);
    }

    #[test]
    fn coordinates_move_one_by_one_and_reach_the_recipe() {
        let pattern = Recipe::dihedral(4, &[RecipeSite::upright(0), RecipeSite::upright(1)]);
        let start = grid(2, &[10.0], &[20.0]).remove(0);
        let steps = Steps {
            angle_degrees: 5.0,
            angstrom: 1.0,
            stagger: 0.1,
        };
        assert_eq!(start.count(2), 6);
        let ways = (0..start.count(2)).filter_map(|k| start.moved(k, &steps, 1.0));
        let recipes: Vec<Recipe> = ways.map(|moved| moved.recipe(&pattern)).collect();
        for (number, recipe) in recipes.iter().enumerate() {
            assert!(*recipe != start.recipe(&pattern) && !recipes[..number].contains(recipe));
        }
        assert_eq!(recipes.len(), 6);
        assert_eq!(start.moved(4, &steps, -1.0), None, "bodies would overlap");
        let turned = Coordinates {
            tilt_degrees: vec![190.0, -540.0],
            ..start
        };
        assert_eq!(turned.wrapped().tilt_degrees, [-170.0, 180.0]);
    }
}
