"""Error of an image against a reference, over the pixels of a mask; the same definitions as `hemicube compare`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.float64]

FLOOR = 0.01  # share of the mean that is added where a pixel's value divides
BLOCK = 4

COLUMNS = ["mae", "rms", "relmse", "p95", "p99", "max", "energy", "block_mae", "block_rms", "non_finite"]


def compare(test: Image, reference: Image, mask: NDArray[np.bool_]) -> dict[str, float]:
    """Figures by the names in `COLUMNS`. Pixels with NaN or infinite values are counted and left out of the rest."""
    finite = np.isfinite(test).all(axis=2)
    used = mask & finite
    t, r = test[used], reference[used]
    mean, error = np.abs(r).mean(), np.abs(t - r)
    pixel = error.sum(axis=1) / (np.abs(r).sum(axis=1) + FLOOR * mean * r.shape[1])
    blocks = _block_differences(test - reference, used)
    return {
        "mae": error.mean() / mean,
        "rms": np.sqrt((error**2).mean()) / mean,
        "relmse": (error**2 / (r**2 + FLOOR * mean**2)).mean(),
        "p95": np.percentile(pixel, 95),
        "p99": np.percentile(pixel, 99),
        "max": pixel.max(),
        "energy": t.sum() / r.sum(),
        "block_mae": np.abs(blocks).mean() / mean,
        "block_rms": np.sqrt((blocks**2).mean()) / mean,
        "non_finite": int((mask & ~finite).sum()),
    }


def _block_differences(difference: Image, used: NDArray[np.bool_]) -> Image:
    """Mean differences of the whole blocks of 4 × 4 pixels: noise fades in them, bias stays."""
    height, width = (n - n % BLOCK for n in used.shape)
    split = height // BLOCK, BLOCK, width // BLOCK, BLOCK
    whole = used[:height, :width].reshape(split).all(axis=(1, 3))
    return difference[:height, :width].reshape(*split, 3).mean(axis=(1, 3))[whole]
