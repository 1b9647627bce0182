"""Error of an image against a reference, over the pixels of a mask."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.float64]


def compare(image: Image, reference: Image, mask: NDArray[np.bool_]) -> dict[str, float]:
    """All figures but `energy` are errors relative to the reference's mean; colour channels count as separate values."""
    truth, value = reference[mask], image[mask]
    finite = np.isfinite(value).all(axis=1)
    value = np.where(finite[:, None], value, 0)
    mean = truth.mean()
    error = np.abs(value - truth) / mean
    pixel = error.mean(axis=1)
    return {
        "mae": error.mean(),
        "mae_4x4": _block_mae(image, reference, mask) / mean,
        "rms": np.sqrt((error**2).mean()),
        "relmse": ((value - truth) ** 2 / (truth**2 + 1e-2 * mean**2)).mean(),
        "p95": np.percentile(pixel, 95),
        "p99": np.percentile(pixel, 99),
        "max": pixel.max(),
        "energy": value.mean() / mean,
        "not_finite": int((~finite).sum()),
    }


def _block_mae(image: Image, reference: Image, mask: NDArray[np.bool_]) -> float:
    """Mean absolute error of averages over 4 × 4 pixels, where the mask covers the whole block: noise fades, bias stays."""
    height, width = (n - n % 4 for n in mask.shape)
    whole = mask[:height, :width].reshape(height // 4, 4, width // 4, 4).all(axis=(1, 3))
    difference = np.nan_to_num(image - reference)[:height, :width]
    blocks = difference.reshape(height // 4, 4, width // 4, 4, 3).mean(axis=(1, 3))
    return float(np.abs(blocks[whole]).mean()) if whole.any() else float("nan")
