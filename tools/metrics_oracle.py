"""The figures that the tests of the error metrics are held against, by NumPy in 64-bit floats.

Run: python3 tools/metrics_oracle.py   (needs numpy)
"""

import numpy as np

WIDTH, HEIGHT, CHANNELS = 18, 13, 3


def pictures():
    """Test, reference and mask of src/image/metrics/tests.rs."""
    i, c = np.meshgrid(np.arange(WIDTH * HEIGHT), np.arange(CHANNELS), indexing="ij")
    reference = ((i * 7919 + c * 104729) % 1000) / 500.0
    test = reference + ((i * 31 + c * 17) % 13 - 6) / 100.0
    mask = np.arange(WIDTH * HEIGHT) % 7 != 0
    return test.astype(np.float32).astype(float), reference.astype(np.float32).astype(float), mask


def figures(test, reference, mask):
    t, r = test[mask], reference[mask]
    mean = np.abs(r).mean()
    relative = np.abs(t - r).sum(1) / (np.abs(r).sum(1) + 0.01 * CHANNELS * mean)
    blocks_x = np.arange(WIDTH * HEIGHT) % WIDTH // 4
    blocks = (np.arange(WIDTH * HEIGHT) // WIDTH // 4) * 1000 + blocks_x
    means = [(m.sum(), test[m].mean(0), reference[m].mean(0)) for m in (mask & (blocks == b) for b in np.unique(blocks)) if m.any()]
    return {
        "mean": mean,
        "mae": np.abs(t - r).mean() / mean,
        "rms": np.sqrt(((t - r) ** 2).mean()) / mean,
        "relmse": ((t - r) ** 2 / (r**2 + 0.01 * mean**2)).mean(),
        "p95": np.percentile(relative, 95),
        "p99": np.percentile(relative, 99),
        "max": relative.max(),
        "energy": t.sum() / r.sum(),
        "block_mae": sum(n * np.abs(a - b).mean() for n, a, b in means) / mask.sum() / mean,
        "block_rms": np.sqrt(sum(n * ((a - b) ** 2).mean() for n, a, b in means) / mask.sum()) / mean,
    }


def flip_exposures():
    """Andersson et al. 2021, section 3, for the grey values of the test in src/image/flip/hdr.rs."""
    y = 0.02 * np.arange(1, 102) ** 2
    k0, k1, k2, k3, k4, k5 = 0.36 * 2.51, 0.6 * 0.03, 0.0, 0.36 * 2.43, 0.6 * 0.59, 0.14
    roots = np.roots([k0 - 0.85 * k3, k1 - 0.85 * k4, k2 - 0.85 * k5])
    x = roots.max()
    start, stop = np.log2(x / y.max()), np.log2(x / np.median(y))
    return {"start": start, "stop": stop, "exposures": max(2, int(np.ceil(stop - start)))}


if __name__ == "__main__":
    test, reference, mask = pictures()
    for title, values in (
        ("all pixels", figures(test, reference, np.ones_like(mask))),
        ("masked", figures(test, reference, mask)),
        ("FLIP", flip_exposures()),
    ):
        print(title)
        for name, value in values.items():
            print(f"  {name:10} {value:.10g}")
