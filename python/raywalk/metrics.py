"""What compares pictures: the metrics of ``raywalk-render validate``.

Pictures are uint8 arrays (height, width, 3), red, green, blue, of one size. A mask is an array
(height, width) of bool or uint8; pixels where it is not 0 count. All raise
:class:`raywalk.UsageError` for other arrays and :class:`raywalk.Error` where nothing can be
compared.
"""

from __future__ import annotations

from numpy.typing import ArrayLike

from . import _native

__all__ = ["fsim", "mean_squared_error", "psnr_db", "ssim", "ws_psnr_db"]


def mean_squared_error(a: ArrayLike, b: ArrayLike, mask: ArrayLike | None = None) -> float:
    """Mean of (a - b)^2 over all channels of the pixels that count; squared 8-bit levels."""
    return _native.mean_squared_error(a, b, mask)


def psnr_db(a: ArrayLike, b: ArrayLike, mask: ArrayLike | None = None) -> float:
    """Peak signal-to-noise ratio over RGB in dB; infinite for equal pictures."""
    return _native.psnr_db(a, b, mask)


def ws_psnr_db(a: ArrayLike, b: ArrayLike, mask: ArrayLike | None = None) -> float:
    """WS-PSNR of whole panoramas in dB: as :func:`psnr_db`, rows weighted by solid angle."""
    return _native.ws_psnr_db(a, b, mask)


def ssim(a: ArrayLike, b: ArrayLike) -> float:
    """Structural similarity on luma, -1 to 1, 1 for equal luma. At least 8 x 8 pixels."""
    return _native.ssim(a, b)


def fsim(a: ArrayLike, b: ArrayLike) -> float:
    """Feature similarity on luma, above 0 to 1, 1 for equal pictures. At least 8 x 8 pixels."""
    return _native.fsim(a, b)
