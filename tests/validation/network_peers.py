"""The benchmark network in PyTorch and TensorFlow compared with ours: CPU milliseconds per sample and peak memory, one thread.

    cargo build --release -p protomer-learn --example benchmark_net
    pip install torch tensorflow-cpu
    python tests/validation/network_peers.py [--rounds 3] [--seconds 3]

The network: input 8 x 3 x 32^3; convolutions 3 x 3 x 3 to 16, 32, 64 channels, each with ReLU and pooling by 2; global
average; a linear layer to 10; Adam, cross entropy, f32. Every program runs alone, one after the other, in each round, so
that what the machine does meets all of them. A library that is not installed is left out with a line that says so.
"""

import argparse
import importlib.util
import os
import resource
import subprocess
import sys
import time
from collections.abc import Callable

SAMPLES, CHANNELS, EDGE, CLASSES = 8, 3, 32, 10
WIDTHS = (16, 32, 64)
OURS = "target/release/examples/benchmark_net"
BUILD = "cargo build --release -p protomer-learn --example benchmark_net"


def cost(work: Callable[[], object], seconds: float) -> float:
    """CPU milliseconds per sample of `work`, repeated for about `seconds`."""
    for _ in range(3):
        work()
    start, repeats = time.process_time(), 0
    while time.process_time() - start < seconds:
        work()
        repeats += 1
    return 1e3 * (time.process_time() - start) / (repeats * SAMPLES)


def report(infer: Callable[[], object], train: Callable[[], object], seconds: float) -> None:
    inference, training = cost(infer, seconds), cost(train, seconds)
    peak_mib = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"inference {inference:6.2f}  training {training:6.2f} CPU ms per sample, peak {peak_mib:5.0f} MiB")


def pytorch(seconds: float, channels_last: bool) -> None:
    import torch

    torch.set_num_threads(1)
    torch.manual_seed(0)
    blocks: list[torch.nn.Module] = []
    for inputs, outputs in zip((CHANNELS, *WIDTHS), WIDTHS, strict=False):
        blocks += [torch.nn.Conv3d(inputs, outputs, 3, padding=1), torch.nn.ReLU(), torch.nn.MaxPool3d(2)]
    head = [torch.nn.AdaptiveAvgPool3d(1), torch.nn.Flatten(), torch.nn.Linear(WIDTHS[-1], CLASSES)]
    network = torch.nn.Sequential(*blocks, *head)
    layout = torch.channels_last_3d if channels_last else torch.contiguous_format
    network = network.to(memory_format=layout)
    batch = torch.randn(SAMPLES, CHANNELS, EDGE, EDGE, EDGE).to(memory_format=layout)
    labels = torch.arange(SAMPLES) % CLASSES
    adam = torch.optim.Adam(network.parameters(), lr=1e-3)

    def infer() -> None:
        with torch.inference_mode():
            network(batch)

    def train() -> None:
        adam.zero_grad(set_to_none=True)
        torch.nn.functional.cross_entropy(network(batch), labels).backward()
        adam.step()

    report(infer, train, seconds)


def tensorflow(seconds: float) -> None:
    os.environ["TF_CPP_MIN_LOG_LEVEL"] = "3"
    os.environ["CUDA_VISIBLE_DEVICES"] = ""
    import tensorflow as tf

    tf.config.threading.set_intra_op_parallelism_threads(1)
    tf.config.threading.set_inter_op_parallelism_threads(1)
    keras = tf.keras
    layers = [keras.layers.Input((EDGE, EDGE, EDGE, CHANNELS))]
    for width in WIDTHS:
        layers += [keras.layers.Conv3D(width, 3, padding="same", activation="relu"), keras.layers.MaxPool3D(2)]
    layers += [keras.layers.GlobalAveragePooling3D(), keras.layers.Dense(CLASSES)]
    network = keras.Sequential(layers)
    batch = tf.random.normal((SAMPLES, EDGE, EDGE, EDGE, CHANNELS), seed=0)
    labels = tf.range(SAMPLES) % CLASSES
    adam = keras.optimizers.Adam(1e-3)
    loss_of = keras.losses.SparseCategoricalCrossentropy(from_logits=True)
    adam.build(network.trainable_variables)

    @tf.function
    def infer() -> object:
        return network(batch, training=False)

    @tf.function
    def train() -> object:
        with tf.GradientTape() as tape:
            loss = loss_of(labels, network(batch, training=True))
        gradients = tape.gradient(loss, network.trainable_variables)
        adam.apply_gradients(zip(gradients, network.trainable_variables, strict=True))
        return loss

    report(lambda: infer().numpy(), lambda: train().numpy(), seconds)


PEERS = {
    "torch": lambda seconds: pytorch(seconds, channels_last=False),
    "torch, channels last": lambda seconds: pytorch(seconds, channels_last=True),
    "tensorflow": tensorflow,
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=3.0, help="CPU seconds for each figure")
    parser.add_argument("--only", choices=PEERS, help="run this one, here")
    chosen = parser.parse_args()
    if chosen.only:
        PEERS[chosen.only](chosen.seconds)
        return
    if not os.path.exists(OURS):
        sys.exit(f"{OURS} is missing; build it, from the root of the project: {BUILD}")
    one_thread = os.environ | {"OMP_NUM_THREADS": "1", "RAYON_NUM_THREADS": "1"}
    programs = {"protomer": [OURS, str(EDGE), str(SAMPLES), str(chosen.seconds)]}
    for name in PEERS:
        if importlib.util.find_spec(name.split(",")[0]) is None:
            print(f"{name}: not installed, left out")
            continue
        programs[name] = [sys.executable, __file__, "--only", name, "--seconds", str(chosen.seconds)]
    for round_number in range(chosen.rounds):
        for name, command in programs.items():
            done = subprocess.run(command, env=one_thread, capture_output=True, text=True, check=False)
            if done.returncode != 0:
                sys.exit(f"{name}: {' '.join(command)} failed\n{done.stderr}")
            print(f"round {round_number + 1}  {name:22}", done.stdout.strip().replace("\n", f"\n{'':32}"), flush=True)


if __name__ == "__main__":
    main()
