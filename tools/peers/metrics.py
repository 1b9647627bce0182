"""Error of an image against a reference, over the pixels of a mask; the same definitions as `hemicube compare`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.float64]

FLOOR = 0.01  # share of the mean that is added where a pixel's value divides
BLOCK = 4

COLUMNS = ["mae", "rms", "relmse", "p95", "p99", "max", "energy", "block_mae", "block_rms", "non_finite_test"]


def compare(test: Image, reference: Image, mask: NDArray[np.bool_]) -> dict[str, float]:
    """Figures by the names in `COLUMNS`. Pixels with NaN or infinite values are counted and left out of the rest."""
    finite = np.isfinite(test).all(axis=2)
    used = mask & finite
    t, r = test[used], reference[used]
    mean, error = np.abs(r).mean(), np.abs(t - r)
    pixel = error.sum(axis=1) / (np.abs(r).sum(axis=1) + FLOOR * mean * r.shape[1])
    blocks, weights = _block_differences(test - reference, used)
    return {
        "mae": error.mean() / mean,
        "rms": np.sqrt((error**2).mean()) / mean,
        "relmse": (error**2 / (r**2 + FLOOR * mean**2)).mean(),
        "p95": np.percentile(pixel, 95),
        "p99": np.percentile(pixel, 99),
        "max": pixel.max(),
        "energy": t.sum() / r.sum(),
        "block_mae": np.average(np.abs(blocks).mean(axis=1), weights=weights) / mean,
        "block_rms": np.sqrt(np.average((blocks**2).mean(axis=1), weights=weights)) / mean,
        "non_finite_test": int((mask & ~finite).sum()),
    }


def _block_differences(difference: Image, used: NDArray[np.bool_]) -> tuple[Image, NDArray[np.int64]]:
    """Mean differences over blocks of 4 × 4 pixels, and how many pixels each has: noise fades in them, bias stays."""
    rows, columns = np.nonzero(used)
    block = rows // BLOCK * used.shape[1] + columns // BLOCK
    pixels = np.bincount(block)
    sums = np.stack([np.bincount(block, channel) for channel in difference[used].T], axis=1)
    return sums[pixels > 0] / pixels[pixels > 0, None], pixels[pixels > 0]
