//! Vectors of the plane as pairs of numbers, and the few sums over arrays that every module needs.

/// x and y.
pub(crate) type Vector = [f64; 2];

#[inline(always)]
pub(crate) fn plus(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1]]
}

#[inline(always)]
pub(crate) fn minus(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1]]
}

#[inline(always)]
pub(crate) fn scaled(a: Vector, factor: f64) -> Vector {
    [a[0] * factor, a[1] * factor]
}

#[inline(always)]
pub(crate) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// a_x b_y - a_y b_x.
#[inline(always)]
pub(crate) fn cross(a: Vector, b: Vector) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

#[inline(always)]
pub(crate) fn norm(a: Vector) -> f64 {
    a[0].hypot(a[1])
}

#[inline(always)]
pub(crate) fn unit(a: Vector) -> Vector {
    let length = norm(a);
    [a[0] / length, a[1] / length]
}

/// The vector turned by 90° anticlockwise.
#[inline(always)]
pub(crate) fn left_of(a: Vector) -> Vector {
    [-a[1], a[0]]
}

/// The vector turned by an angle, given its cosine and sine.
#[inline(always)]
pub(crate) fn turned(a: Vector, [cosine, sine]: Vector) -> Vector {
    [cosine * a[0] - sine * a[1], sine * a[0] + cosine * a[1]]
}

/// Cosine and sine of an angle.
#[inline(always)]
pub(crate) fn direction(angle: f64) -> Vector {
    let (sine, cosine) = angle.sin_cos();
    [cosine, sine]
}

/// The largest |x| of an array; NaN entries are passed over.
pub(crate) fn largest_magnitude(numbers: &[f64]) -> f64 {
    numbers.iter().fold(0.0, |most, x| most.max(x.abs()))
}
