//! The network as a whole: where it starts, that it learns, and that the same seed gives the same
//! numbers.

use candle_core::{Device, Tensor};
use protomer_kernel::random::CounterRng;
use protomer_learn::{
    Adam, AdamSettings, BlockSettings, GlobalPooling, Network, NetworkSettings, cross_entropy,
};

fn settings(groups: Option<usize>, pooling: GlobalPooling) -> NetworkSettings {
    let block = |width| BlockSettings {
        width,
        kernel: 3,
        groups,
        pool: true,
    };
    NetworkSettings {
        channels: 3,
        classes: 4,
        blocks: vec![block(8), block(16)],
        pooling,
    }
}

fn noise(seed: u64, samples: usize, channels: usize, edge: usize) -> Tensor {
    let mut random = CounterRng::new(seed, 0, 0);
    let count = samples * channels * edge.pow(3);
    let values: Vec<f32> = (0..count)
        .map(|_| random.uniform_in(-1.7, 1.7) as f32)
        .collect();
    Tensor::from_vec(values, (samples, channels, edge, edge, edge), &Device::Cpu).unwrap()
}

/// The parameters after some steps, as bits.
fn train(steps: usize, threads: usize, settings: &NetworkSettings) -> Vec<Vec<u32>> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .unwrap();
    pool.install(|| {
        let network = Network::new(settings, 3, &Device::Cpu).unwrap();
        let mut adam = Adam::new(network.parameters(), AdamSettings::default()).unwrap();
        let (batch, labels) = (noise(1, 5, 3, 9), [0, 1, 2, 3, 0]);
        for _ in 0..steps {
            let loss =
                cross_entropy(&network.forward(&batch).unwrap(), &labels, &[1.0; 5]).unwrap();
            adam.step(&loss.backward().unwrap(), 1e-2, Some(1.0))
                .unwrap();
        }
        let bits = |value: Tensor| value.flatten_all().unwrap().to_vec1::<f32>().unwrap();
        let parameters = network.parameters().iter();
        parameters
            .map(|(_, p)| {
                bits(p.as_tensor().clone())
                    .into_iter()
                    .map(f32::to_bits)
                    .collect()
            })
            .collect()
    })
}

#[test]
fn the_same_seed_gives_the_same_bits_with_one_thread_and_with_two() {
    for groups in [None, Some(4)] {
        let settings = settings(groups, GlobalPooling::AverageAndMaximum);
        let one = train(3, 1, &settings);
        assert_eq!(one, train(3, 1, &settings));
        assert_eq!(one, train(3, 2, &settings));
        assert_ne!(one, train(2, 1, &settings));
    }
}

#[test]
fn training_starts_from_the_prior() {
    for pooling in [GlobalPooling::Average, GlobalPooling::AverageAndMaximum] {
        for groups in [None, Some(2)] {
            let network = Network::new(&settings(groups, pooling), 5, &Device::Cpu).unwrap();
            let logits = network.forward(&noise(2, 8, 3, 16)).unwrap();
            let labels = [0, 1, 2, 3, 0, 1, 2, 3];
            let loss = cross_entropy(&logits, &labels, &[1.0; 8])
                .unwrap()
                .to_scalar::<f32>()
                .unwrap();
            assert!((loss / 4f32.ln() - 1.0).abs() < 0.05, "{loss}");
            network
                .set_head_bias(&[0.7f32.ln(), 0.1f32.ln(), 0.1f32.ln(), 0.1f32.ln()])
                .unwrap();
            let logits = network.forward(&noise(2, 8, 3, 16)).unwrap();
            let loss = cross_entropy(&logits, &[0; 8], &[1.0; 8])
                .unwrap()
                .to_scalar::<f32>()
                .unwrap();
            assert!((loss + 0.7f32.ln()).abs() < 0.1, "{loss}");
        }
    }
}

#[test]
fn eight_samples_of_noise_are_learnt_by_heart() {
    for groups in [None, Some(4)] {
        let network = Network::new(
            &settings(groups, GlobalPooling::AverageAndMaximum),
            11,
            &Device::Cpu,
        )
        .unwrap();
        let mut adam = Adam::new(network.parameters(), AdamSettings::default()).unwrap();
        let (batch, labels) = (noise(4, 8, 3, 8), [0, 1, 2, 3, 0, 1, 2, 3]);
        let right = (0..200).any(|_| {
            let logits = network.forward(&batch).unwrap();
            let chosen = logits.argmax(1).unwrap().to_vec1::<u32>().unwrap();
            let loss = cross_entropy(&logits, &labels, &[1.0; 8]).unwrap();
            adam.step(&loss.backward().unwrap(), 1e-2, Some(1.0))
                .unwrap();
            chosen == labels
        });
        assert!(right, "groups {groups:?}");
    }
}

#[test]
fn adam_goes_on_from_its_memory() {
    let settings = settings(None, GlobalPooling::Average);
    let (batch, labels) = (noise(1, 4, 3, 8), [0, 1, 2, 3]);
    let step = |network: &Network, adam: &mut Adam| {
        let loss = cross_entropy(&network.forward(&batch).unwrap(), &labels, &[1.0; 4]).unwrap();
        adam.step(&loss.backward().unwrap(), 1e-2, None).unwrap()
    };
    let first = Network::new(&settings, 3, &Device::Cpu).unwrap();
    let mut adam = Adam::new(first.parameters(), AdamSettings::default()).unwrap();
    for _ in 0..2 {
        step(&first, &mut adam);
    }
    let second = Network::new(&settings, 99, &Device::Cpu).unwrap();
    for (name, parameter) in first.parameters() {
        second
            .set_parameter(name, &parameter.as_tensor().copy().unwrap())
            .unwrap();
    }
    let mut other = Adam::new(second.parameters(), AdamSettings::default()).unwrap();
    other.load_state(&adam.state()).unwrap();
    assert_eq!(other.steps(), 2);
    assert!(step(&first, &mut adam) == step(&second, &mut other));
    for ((_, a), (_, b)) in first.parameters().iter().zip(second.parameters()) {
        let flat = |p: &Tensor| p.flatten_all().unwrap().to_vec1::<f32>().unwrap();
        assert_eq!(flat(a), flat(b));
    }
    assert!(other.load_state(&adam.state()[1..]).is_err());
}

#[test]
fn what_does_not_fit_is_refused_with_a_reason() {
    let network = Network::new(&settings(None, GlobalPooling::Average), 1, &Device::Cpu).unwrap();
    let message = |batch: Tensor| network.forward(&batch).unwrap_err().to_string();
    assert!(message(noise(1, 1, 2, 8)).contains("3 channels"));
    assert!(message(noise(1, 1, 3, 3)).contains("at least 4 voxels"));
    assert!(network.set_head_bias(&[0.0; 3]).is_err());
    let mut bad = settings(Some(3), GlobalPooling::Average);
    assert!(
        Network::new(&bad, 1, &Device::Cpu)
            .unwrap_err()
            .to_string()
            .contains("block 0")
    );
    bad.blocks.clear();
    assert!(Network::new(&bad, 1, &Device::Cpu).is_err());
    let logits = noise(1, 1, 1, 2).reshape((4, 2)).unwrap();
    assert!(cross_entropy(&logits, &[0, 1, 2, 0], &[1.0; 4]).is_err());
    assert!(cross_entropy(&logits, &[0; 4], &[0.0; 4]).is_err());
    assert!(cross_entropy(&logits, &[0; 3], &[1.0; 3]).is_err());
}
