//! The kernels of the network against loops in f64, and its backward passes against differences of
//! its forward passes.

use candle_core::{Device, Tensor, Var};
use protomer_convolution::Level;
use protomer_kernel::random::CounterRng;
use protomer_learn::BlockSettings;
use protomer_learn::block::{self, BlockParameters};
use protomer_learn::operations;

const CPU: Device = Device::Cpu;

fn noise(seed: u64, count: usize) -> Vec<f32> {
    let mut random = CounterRng::new(seed, 0, 0);
    (0..count)
        .map(|_| random.uniform_in(-1.0, 1.0) as f32)
        .collect()
}

fn grid(seed: u64, shape: &[usize]) -> Tensor {
    Tensor::from_vec(noise(seed, shape.iter().product()), shape, &CPU).unwrap()
}

fn numbers(tensor: &Tensor) -> Vec<f64> {
    tensor
        .flatten_all()
        .unwrap()
        .to_vec1::<f32>()
        .unwrap()
        .into_iter()
        .map(f64::from)
        .collect()
}

fn dot(a: &Tensor, b: &Tensor) -> f64 {
    numbers(a).iter().zip(numbers(b)).map(|(a, b)| a * b).sum()
}

/// Largest difference relative to the largest number.
fn difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let largest = b.iter().fold(1e-30, |m: f64, v| m.max(v.abs()));
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max)
        / largest
}

/// The convolution as its definition says, in f64.
fn obvious(x: &Tensor, w: &Tensor, b: &Tensor) -> Vec<f64> {
    let (samples, channels, depth, height, width) = x.dims5().unwrap();
    let (outputs, _, k, _, _) = w.dims5().unwrap();
    let (x, w, b) = (numbers(x), numbers(w), numbers(b));
    let inside = |p: usize, t: usize, edge: usize| (p + t).checked_sub(k / 2).filter(|q| *q < edge);
    let mut out = Vec::new();
    for s in 0..samples {
        for o in 0..outputs {
            for z in 0..depth {
                for y in 0..height {
                    for i in 0..width {
                        let mut sum = b[o];
                        for c in 0..channels {
                            for t in 0..k * k * k {
                                let source = (
                                    inside(z, t / (k * k), depth),
                                    inside(y, t / k % k, height),
                                    inside(i, t % k, width),
                                );
                                if let (Some(z), Some(y), Some(i)) = source {
                                    let place =
                                        (((s * channels + c) * depth + z) * height + y) * width + i;
                                    sum += w[(o * channels + c) * k * k * k + t] * x[place];
                                }
                            }
                        }
                        out.push(sum);
                    }
                }
            }
        }
    }
    out
}

/// The maximum over windows as its definition says.
fn obvious_pool(x: &[f64], edges: [usize; 3]) -> Vec<f64> {
    let [depth, height, width] = edges;
    let mut out = Vec::new();
    for channel in x.chunks(depth * height * width) {
        for z in 0..depth / 2 {
            for y in 0..height / 2 {
                for i in 0..width / 2 {
                    let value = |c: usize| {
                        channel
                            [((2 * z + c / 4) * height + 2 * y + c / 2 % 2) * width + 2 * i + c % 2]
                    };
                    out.push((0..8).map(value).fold(f64::NEG_INFINITY, f64::max));
                }
            }
        }
    }
    out
}

/// Samples, channels, outputs, edge of the kernel, and depth, height and width of the input.
type Sizes = (usize, usize, usize, usize, usize, usize, usize);

/// Shapes that reach every size of register tile, and odd ones.
const SHAPES: [Sizes; 13] = [
    (1, 1, 1, 1, 1, 1, 1),
    (2, 1, 3, 3, 2, 3, 5),
    (2, 3, 16, 3, 4, 5, 31),
    (1, 16, 32, 3, 6, 4, 15),
    (1, 5, 70, 3, 3, 2, 7),
    (2, 32, 64, 3, 2, 2, 4),
    (1, 19, 33, 3, 5, 2, 9),
    (2, 9, 17, 1, 3, 4, 6),
    (1, 33, 48, 1, 2, 2, 17),
    (1, 2, 5, 5, 4, 3, 6),
    (1, 7, 40, 5, 3, 6, 5),
    (1, 4, 16, 3, 2, 2, 70),
    (1, 1, 70, 3, 2, 3, 6),
];

fn parameters(shape: (usize, usize, usize, usize)) -> (Tensor, Tensor) {
    let (channels, outputs, k, seed) = shape;
    (
        grid(seed as u64 + 100, &[outputs, channels, k, k, k]),
        grid(seed as u64 + 200, &[outputs]),
    )
}

#[test]
fn every_level_convolves_as_the_definition_says() {
    for level in Level::available() {
        for (i, (samples, channels, outputs, k, depth, height, width)) in
            SHAPES.into_iter().enumerate()
        {
            let x = grid(i as u64, &[samples, channels, depth, height, width]);
            let (weight, bias) = parameters((channels, outputs, k, i));
            let expected = obvious(&x, &weight, &bias);
            let parameters = BlockParameters {
                weight,
                bias,
                norm: None,
            };
            for pool in [false, true] {
                let settings = BlockSettings {
                    width: outputs,
                    kernel: k,
                    groups: None,
                    pool,
                };
                let found = numbers(&block::fused(level, &x, &parameters, &settings).unwrap());
                let mut expected: Vec<f64> = expected.iter().map(|v| v.max(0.0)).collect();
                if pool {
                    expected = obvious_pool(&expected, [depth, height, width]);
                }
                let error = difference(&found, &expected);
                assert!(error < 2e-6, "{level:?} shape {i} pool {pool}: {error}");
            }
        }
    }
}

#[test]
fn empty_parts_of_the_input_are_skipped_without_a_trace() {
    for (i, (samples, channels, outputs, k, depth, height, width)) in SHAPES.into_iter().enumerate()
    {
        let x = grid(i as u64, &[samples, channels, depth, height, width]);
        let few = grid(i as u64 + 50, &[samples, channels, depth, height, width])
            .ge(0.8f32)
            .unwrap();
        let x = (x * few.to_dtype(candle_core::DType::F32).unwrap()).unwrap();
        let (weight, bias) = parameters((channels, outputs, k, i));
        let expected = obvious(&x, &weight, &bias)
            .iter()
            .map(|v| v.max(0.0))
            .collect::<Vec<_>>();
        let parameters = BlockParameters {
            weight,
            bias,
            norm: None,
        };
        let settings = BlockSettings {
            width: outputs,
            kernel: k,
            groups: None,
            pool: false,
        };
        for level in Level::available() {
            let found = numbers(&block::fused(level, &x, &parameters, &settings).unwrap());
            assert!(difference(&found, &expected) < 2e-6, "{level:?} shape {i}");
        }
    }
}

/// Gradients of <g, block(x)> in x, weight, bias, and weight and bias of the normalisation.
fn gradients(
    route: impl Fn(&Tensor, &BlockParameters) -> protomer_learn::Result<Tensor>,
    variables: &[Var],
    without_input: bool,
) -> (Tensor, Vec<Vec<f64>>) {
    let mut tensors: Vec<Tensor> = variables.iter().map(|v| v.as_tensor().clone()).collect();
    if without_input {
        tensors.insert(0, Tensor::zeros(1, candle_core::DType::F32, &CPU).unwrap());
    }
    let norm = (tensors.len() > 3).then(|| (tensors[3].clone(), tensors[4].clone()));
    let parameters = BlockParameters {
        weight: tensors[1].clone(),
        bias: tensors[2].clone(),
        norm,
    };
    let out = route(&tensors[0], &parameters).unwrap();
    let g = grid(999, out.dims());
    let store = (&out * &g).unwrap().sum_all().unwrap().backward().unwrap();
    (
        out.detach(),
        variables
            .iter()
            .map(|v| numbers(store.get(v).unwrap()))
            .collect(),
    )
}

/// Settings of a block for an input of this shape; none if an edge is too short to be pooled.
fn block_settings(shape: Sizes, groups: Option<usize>, pool: bool) -> Option<BlockSettings> {
    let (_, _, width, kernel, depth, height, length) = shape;
    let is_short = [depth, height, length].iter().any(|edge| *edge < 2);
    (!(pool && is_short)).then_some(BlockSettings {
        width,
        kernel,
        groups,
        pool,
    })
}

fn variables(seed: u64, shape: Sizes, groups: Option<usize>) -> Vec<Var> {
    let (samples, channels, outputs, k, depth, height, width) = shape;
    let x = grid(seed, &[samples, channels, depth, height, width]);
    let (weight, bias) = parameters((channels, outputs, k, seed as usize));
    let mut tensors = vec![x, weight, bias];
    if groups.is_some() {
        tensors.extend([grid(seed + 300, &[outputs]), grid(seed + 400, &[outputs])]);
    }
    tensors
        .iter()
        .map(|t| Var::from_tensor(t).unwrap())
        .collect()
}

/// Outputs and gradients of two implementations agree.
fn require_equal(
    case: &str,
    (output, gradients): (&Tensor, &[Vec<f64>]),
    (expected_output, expected_gradients): (&Tensor, &[Vec<f64>]),
) {
    assert!(
        difference(&numbers(output), &numbers(expected_output)) < 1e-5,
        "{case}"
    );
    for (which, (gradient, expected)) in gradients.iter().zip(expected_gradients).enumerate() {
        // A convolution's bias in front of a normalisation over its own channel has gradient 0.
        let scale = expected.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let error = difference(gradient, expected) * scale / scale.max(1.0);
        assert!(error < 2e-5, "{case} gradient {which}: {error}");
    }
}

#[test]
fn the_fused_block_has_the_gradients_of_the_composed_one() {
    for (i, shape) in SHAPES.into_iter().enumerate() {
        let (_, channels, outputs, kernel, ..) = shape;
        for groups in [None, Some(1), (outputs % 2 == 0).then_some(outputs / 2)] {
            // With the second bias most outputs are cut off, and even without pooling listing
            // the rest pays.
            for (pool, shift) in [(false, 0.0), (true, 0.0), (false, -0.8), (true, -0.8)] {
                let Some(settings) = block_settings(shape, groups, pool) else {
                    continue;
                };
                let variables = variables(i as u64, shape, groups);
                if groups.is_none() && shift != 0.0 {
                    let cut = shift * ((channels * kernel.pow(3)) as f64).sqrt();
                    variables[2]
                        .set(&Tensor::full(cut as f32, outputs, &CPU).unwrap())
                        .unwrap();
                }
                let (z, expected) =
                    gradients(|x, p| block::composed(x, p, &settings), &variables, false);
                for level in Level::available() {
                    let (y, found) = gradients(
                        |x, p| block::fused(level, x, p, &settings),
                        &variables,
                        false,
                    );
                    let case = format!("{level:?} shape {i} {settings:?}");
                    require_equal(&case, (&y, &found), (&z, &expected));
                }
            }
        }
    }
}

/// The input is data, mostly zeros: only parameters have gradients.
#[test]
fn gradients_skip_empty_parts_without_a_trace() {
    let wide = [(1, 2, 20, 3, 2, 4, 130), (2, 3, 16, 3, 8, 8, 9)];
    for (i, shape) in SHAPES.into_iter().chain(wide).enumerate() {
        for limit in [-0.99, -0.9, -0.6] {
            for groups in [None, Some(1)] {
                for pool in [false, true] {
                    let Some(settings) = block_settings(shape, groups, pool) else {
                        continue;
                    };
                    let all = variables(i as u64, shape, groups);
                    let few = grid(i as u64 + 50, all[0].dims()).le(limit).unwrap();
                    let x =
                        (all[0].detach() * few.to_dtype(candle_core::DType::F32).unwrap()).unwrap();
                    let (z, expected) =
                        gradients(|_, p| block::composed(&x, p, &settings), &all[1..], true);
                    for level in Level::available() {
                        let (y, found) = gradients(
                            |_, p| block::fused(level, &x, p, &settings),
                            &all[1..],
                            true,
                        );
                        let case = format!("{level:?} shape {i} {settings:?}");
                        require_equal(&case, (&y, &found), (&z, &expected));
                    }
                }
            }
        }
    }
}

/// With g fixed, <g, conv(x, w)> is linear in x and in w: both gradients give it back.
#[test]
fn the_convolution_and_its_gradients_are_adjoint() {
    for level in Level::available() {
        for (i, shape) in SHAPES.into_iter().enumerate() {
            let outputs = shape.2;
            // Shifted so far up that the ReLU cuts nothing off; pooling lists the gradients, the
            // plain block uses all.
            for pool in [false, true] {
                let variables = variables(i as u64, shape, None);
                variables[2]
                    .set(&Tensor::full(1e3f32, outputs, &CPU).unwrap())
                    .unwrap();
                let Some(settings) = block_settings(shape, None, pool) else {
                    continue;
                };
                let (_, found) = gradients(
                    |x, p| block::fused(level, x, p, &settings),
                    &variables,
                    false,
                );
                let both: Vec<f64> = (0..2)
                    .map(|v| {
                        found[v]
                            .iter()
                            .zip(numbers(&variables[v]))
                            .map(|(g, v)| g * v)
                            .sum()
                    })
                    .collect();
                let size: f64 = found[0]
                    .iter()
                    .zip(numbers(&variables[0]))
                    .map(|(g, v)| (g * v).abs())
                    .sum();
                assert!(
                    (both[0] - both[1]).abs() < 3e-6 * size,
                    "{level:?} shape {i}: {both:?}"
                );
                if !pool {
                    variables[2]
                        .set(&Tensor::zeros(outputs, candle_core::DType::F32, &CPU).unwrap())
                        .unwrap();
                    let y = obvious(&variables[0], &variables[1], &variables[2]);
                    let g = noise(999, y.len());
                    let direct: f64 = y.iter().zip(g).map(|(y, g)| y * f64::from(g)).sum();
                    assert!(
                        (both[0] - direct).abs() < 3e-6 * size,
                        "{level:?} shape {i}: {both:?} {direct}"
                    );
                }
            }
        }
    }
}

/// (L(v + h u) - L(v - h u)) / 2 h against <grad, u> for a random direction u of each variable.
fn check_direction(name: &str, forward: impl Fn(&[Tensor]) -> Tensor, shapes: &[Vec<usize>]) {
    let variables: Vec<Var> = shapes
        .iter()
        .enumerate()
        .map(|(i, shape)| Var::from_tensor(&grid(i as u64 + 7, shape)).unwrap())
        .collect();
    let tensors: Vec<Tensor> = variables.iter().map(|v| v.as_tensor().clone()).collect();
    let out = forward(&tensors);
    let g = grid(31, out.dims());
    let store = (&out * &g).unwrap().sum_all().unwrap().backward().unwrap();
    for (i, variable) in variables.iter().enumerate() {
        let u = grid(i as u64 + 77, variable.dims());
        let loss = |h: f64| {
            let mut moved: Vec<Tensor> = tensors.iter().map(Tensor::detach).collect();
            moved[i] = (&moved[i] + (&u * h).unwrap()).unwrap();
            dot(&forward(&moved), &g)
        };
        // Short, so that few of the ReLUs and maxima in between change sides.
        let h = 2e-4;
        let expected = (loss(h) - loss(-h)) / (2.0 * h);
        let found = dot(store.get(variable).unwrap(), &u);
        let size = 1.0 + numbers(&g).iter().map(|v| v.abs()).sum::<f64>().sqrt();
        assert!(
            (found - expected).abs() < 1e-2 * size,
            "{name}, variable {i}: {found} and by differences {expected}"
        );
    }
}

#[test]
fn backward_passes_agree_with_differences() {
    let conv = vec![vec![2, 2, 3, 2, 5], vec![3, 2, 3, 3, 3], vec![3]];
    check_direction(
        "convolution",
        |t| operations::convolution3d(&t[0], &t[1], &t[2]).unwrap(),
        &conv,
    );
    let one = vec![vec![2, 4, 3, 4, 5]];
    check_direction(
        "global average",
        |t| operations::global_average_pool(&t[0]).unwrap(),
        &one,
    );
    check_direction("maximum", |t| operations::max_pool3d(&t[0]).unwrap(), &one);
    check_direction(
        "global maximum",
        |t| operations::global_maximum_pool(&t[0]).unwrap(),
        &one,
    );
    let norm = vec![vec![2, 4, 3, 4, 5], vec![4], vec![4]];
    check_direction(
        "norm",
        |t| operations::group_norm(&t[0], 2, &t[1], &t[2]).unwrap(),
        &norm,
    );
    for groups in [None, Some(2)] {
        for pool in [false, true] {
            let mut shapes = vec![vec![2, 3, 4, 5, 6], vec![4, 3, 3, 3, 3], vec![4]];
            if groups.is_some() {
                shapes.extend([vec![4], vec![4]]);
            }
            let settings = BlockSettings {
                width: 4,
                kernel: 3,
                groups,
                pool,
            };
            let forward = |t: &[Tensor]| {
                let norm = groups.map(|_| (t[3].clone(), t[4].clone()));
                let parameters = BlockParameters {
                    weight: t[1].clone(),
                    bias: t[2].clone(),
                    norm,
                };
                block::fused(Level::best(), &t[0], &parameters, &settings).unwrap()
            };
            check_direction(&format!("block {settings:?}"), forward, &shapes);
        }
    }
}

#[test]
fn of_equal_values_the_first_has_the_gradient() {
    let x =
        Var::from_tensor(&Tensor::ones((1, 1, 2, 2, 2), candle_core::DType::F32, &CPU).unwrap())
            .unwrap();
    let first = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let weight = Tensor::ones((1, 1, 1, 1, 1), candle_core::DType::F32, &CPU).unwrap();
    let parameters = BlockParameters {
        weight,
        bias: Tensor::zeros(1, candle_core::DType::F32, &CPU).unwrap(),
        norm: None,
    };
    let settings = BlockSettings {
        width: 1,
        kernel: 1,
        groups: None,
        pool: true,
    };
    let routes: [(&str, Tensor); 3] = [
        ("pool", operations::max_pool3d(&x).unwrap()),
        ("global", operations::global_maximum_pool(&x).unwrap()),
        (
            "fused",
            block::fused(Level::best(), &x, &parameters, &settings).unwrap(),
        ),
    ];
    for (name, out) in routes {
        let store = out.sum_all().unwrap().backward().unwrap();
        assert_eq!(numbers(store.get(&x).unwrap()), first, "{name}");
    }
}

#[test]
fn what_is_not_a_number_stays_visible() {
    for place in 0..8 {
        let mut values = vec![-1.0f32; 8];
        values[place] = f32::NAN;
        let x = Tensor::from_vec(values, (1, 1, 2, 2, 2), &CPU).unwrap();
        let weight = Tensor::ones((1, 1, 1, 1, 1), candle_core::DType::F32, &CPU).unwrap();
        let bias = Tensor::zeros(1, candle_core::DType::F32, &CPU).unwrap();
        let parameters = BlockParameters {
            weight,
            bias,
            norm: None,
        };
        for level in Level::available() {
            for pool in [false, true] {
                let settings = BlockSettings {
                    width: 1,
                    kernel: 1,
                    groups: None,
                    pool,
                };
                let out = numbers(&block::fused(level, &x, &parameters, &settings).unwrap());
                assert!(
                    out.iter().any(|v| v.is_nan()),
                    "{level:?} corner {place} pool {pool}"
                );
            }
        }
    }
}
