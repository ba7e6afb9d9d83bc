//! The smallest value of a smooth convex function.

use std::collections::VecDeque;

/// Steps remembered.
const MEMORY: usize = 10;
/// Largest number of iterations.
const MOST_ITERATIONS: usize = 500;
/// Minimisation ends when no component of the gradient exceeds this.
const FLAT: f64 = 1e-7;
/// Sufficient decrease (Nocedal and Wright, *Numerical Optimization*, 2006, equation 3.4).
const SUFFICIENT: f64 = 1e-4;
/// Largest number of halvings of a step.
const MOST_HALVINGS: usize = 40;

/// A step that was taken.
struct Step {
    /// s: the change of the point.
    step: Vec<f64>,
    /// y: the change of the gradient.
    change: Vec<f64>,
    /// 1 / (s y).
    inverse: f64,
}

/// A point, the value there, and the gradient.
#[derive(Clone)]
struct State {
    point: Vec<f64>,
    value: f64,
    gradient: Vec<f64>,
}

/// Minimises a function with the limited-memory method of Broyden, Fletcher, Goldfarb and Shanno.
/// `function` returns the value at a point and overwrites the gradient.
pub(super) fn minimise(
    start: Vec<f64>,
    mut function: impl FnMut(&[f64], &mut [f64]) -> f64,
) -> Vec<f64> {
    let mut gradient = vec![0.0; start.len()];
    let value = function(&start, &mut gradient);
    let mut state = State {
        point: start,
        value,
        gradient,
    };
    let mut history: VecDeque<Step> = VecDeque::new();
    for _ in 0..MOST_ITERATIONS {
        if state
            .gradient
            .iter()
            // All components, not the norm: the bound then does not depend on their number.
            .all(|component| component.abs() < FLAT)
        {
            break;
        }
        let direction = direction(&state.gradient, &history);
        let next = search(&state, &direction, &mut function);
        // Also ends if the value is NaN, which compares with nothing.
        if next.value.partial_cmp(&state.value) != Some(std::cmp::Ordering::Less) {
            break; // Rounding hides any further decrease.
        }
        let step = difference(&next.point, &state.point);
        let change = difference(&next.gradient, &state.gradient);
        let curvature = dot(&step, &change);
        // The approximate Hessian stays positive definite only from steps
        // with s y > 0. A convex function has no others except by rounding.
        if curvature > 0.0 {
            history.push_back(Step {
                step,
                change,
                inverse: 1.0 / curvature,
            });
            if history.len() > MEMORY {
                history.pop_front();
            }
        }
        state = next;
    }
    state.point
}

/// The gradient times the approximate inverse Hessian: the two-loop recursion (Nocedal and Wright,
/// algorithm 7.4). A step goes against it.
fn direction(gradient: &[f64], history: &VecDeque<Step>) -> Vec<f64> {
    let mut direction = gradient.to_vec();
    let mut projections = Vec::with_capacity(history.len());
    // Newest to oldest.
    for past in history.iter().rev() {
        let projection = past.inverse * dot(&past.step, &direction);
        for (d, y) in direction.iter_mut().zip(&past.change) {
            *d -= projection * y;
        }
        projections.push(projection);
    }
    if let Some(last) = history.back() {
        // H₀ = (s y) / (y y), the curvature along the newest
        // step, so that a step of length 1 is a good first try.
        let scale = 1.0 / (last.inverse * dot(&last.change, &last.change));
        for d in &mut direction {
            *d *= scale;
        }
    }
    // Oldest to newest; the projections were pushed in the other order.
    for (past, projection) in history.iter().zip(projections.iter().rev()) {
        let correction = projection - past.inverse * dot(&past.change, &direction);
        for (d, s) in direction.iter_mut().zip(&past.step) {
            *d += correction * s;
        }
    }
    direction
}

/// Halves the step until the decrease suffices.
fn search(
    from: &State,
    direction: &[f64],
    function: &mut impl FnMut(&[f64], &mut [f64]) -> f64,
) -> State {
    // Positive, as the direction is H times the gradient: a decrease exists along it.
    let slope = dot(&from.gradient, direction);
    let mut next = from.clone();
    // The full quasi-Newton step comes first: near the minimum it is what converges fast.
    let mut length = 1.0;
    for _ in 0..MOST_HALVINGS {
        for ((n, p), d) in next.point.iter_mut().zip(&from.point).zip(direction) {
            *n = p - length * d;
        }
        next.value = function(&next.point, &mut next.gradient);
        if next.value <= from.value - SUFFICIENT * length * slope {
            break;
        }
        length *= 0.5;
    }
    // Not better after all halvings: the caller compares the
    // values and ends.
    next
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}
