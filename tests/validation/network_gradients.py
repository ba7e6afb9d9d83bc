"""A trained network in numpy: what it says about a grid, and the gradient with respect to the grid (used by residual_b22.py).

Blocks of a convolution, ReLU and the maximum over 2 x 2 x 2 voxels, without normalisation; a head on averages and maxima; a number with
its spread. The weights are those of `model.safetensors`.
"""

import json
from itertools import product

import numpy as np


def read_safetensors(path):
    """The arrays of a file, and the text that the program keeps with them."""
    content = path.read_bytes()
    length = int.from_bytes(content[:8], "little")
    head, data = json.loads(content[8 : 8 + length]), content[8 + length :]
    told = json.loads(head.pop("__metadata__")["protomer"])
    arrays = {}
    for name, known in head.items():
        begin, end = known["data_offsets"]
        arrays[name] = np.frombuffer(data[begin:end], np.float32).reshape(known["shape"])
    return arrays, told


def shifted(grid, reach):
    """The grid (C, n, n, n) moved by every offset of the kernel, (offsets, C, n³), with zeros from outside."""
    n = grid.shape[1]
    padded = np.pad(grid, [(0, 0)] + [(reach, reach)] * 3)
    views = [padded[:, i : i + n, j : j + n, k : k + n] for i, j, k in product(range(2 * reach + 1), repeat=3)]
    return np.array(views).reshape(len(views), grid.shape[0], -1)


class Network:
    def __init__(self, run):
        self.arrays, told = read_safetensors(run / "model.safetensors")
        self.blocks = len(told["network"]["blocks"])
        self.mean, self.spread = told["normal"]["mean"], told["normal"]["spread"]
        transform = dict(zip(told["channels"], told["scaling"]["transforms"]))["potential"]
        self.scale = transform["arcsinh"]["scale"]
        self.potential = told["channels"].index("potential")

    def predict(self, grid, gradient=False):
        """The number for a grid (C, n, n, n) in the units of the set; with it the gradient with respect to the potential, if wanted."""
        x = grid.astype(np.float32)
        raw = x[self.potential] / self.scale
        x[self.potential] = np.clip(np.arcsinh(raw), -4.0, 4.0)
        kept = []
        for block in range(self.blocks):
            weight, bias = self.arrays[f"blocks.{block}.weight"], self.arrays[f"blocks.{block}.bias"]
            reach, n = weight.shape[2] // 2, x.shape[1]
            flat = np.moveaxis(weight.reshape(*weight.shape[:2], -1), 2, 1).reshape(len(weight), -1)
            out = (flat @ shifted(x, reach).reshape(flat.shape[1], -1) + bias[:, None]).reshape(-1, n, n, n)
            active, half = out > 0, n // 2
            out = np.where(active, out, 0)
            cubes = out[:, : 2 * half, : 2 * half, : 2 * half].reshape(-1, half, 2, half, 2, half, 2)
            cubes = np.moveaxis(cubes, (2, 4, 6), (4, 5, 6)).reshape(-1, half, half, half, 8)
            largest = cubes.argmax(axis=4)
            kept.append((weight, active, largest, n))
            x = cubes.max(axis=4)
        channels, last = len(x), x.shape[1] ** 3
        flat = x.reshape(channels, -1)
        head = self.arrays["head.weight"][0]
        number = head[:channels] @ flat.mean(axis=1) + head[channels:] @ flat.max(axis=1) + self.arrays["head.bias"][0]
        number = self.mean + self.spread * float(number)
        if not gradient:
            return number
        slope = np.repeat(head[:channels, None] / last, last, axis=1)
        slope[np.arange(channels), flat.argmax(axis=1)] += head[channels:]
        slope = slope.reshape(x.shape)
        for weight, active, largest, n in reversed(kept):
            half = n // 2
            cubes = np.where(np.arange(8) == largest[..., None], slope[..., None], 0)
            cubes = np.moveaxis(cubes.reshape(-1, half, half, half, 2, 2, 2), (4, 5, 6), (2, 4, 6))
            inner = np.zeros(active.shape, np.float32)
            inner[:, : 2 * half, : 2 * half, : 2 * half] = cubes.reshape(-1, 2 * half, 2 * half, 2 * half)
            inner *= active
            # The gradient of a cross-correlation is one with the kernel turned about.
            turned = np.moveaxis(weight[:, :, ::-1, ::-1, ::-1].reshape(*weight.shape[:2], -1), (1, 2), (0, 1)).reshape(weight.shape[1], -1)
            slope = (turned @ shifted(inner, weight.shape[2] // 2).reshape(turned.shape[1], -1)).reshape(-1, n, n, n)
        inside = np.abs(np.arcsinh(raw)) < 4.0
        return number, self.spread * slope[self.potential] * inside / (self.scale * np.sqrt(1 + raw**2))
