#!/usr/bin/env python3
"""Checks scripts/study perceptual with planted defects; exits with 77 where its packages are missing.

usage: check_perceptual.py FOLDER_OF_SCRIPTS [PYTHON]

PYTHON, where it is there, is the interpreter that has the packages.
"""

import os
import sys

if len(sys.argv) > 2 and os.access(sys.argv[2], os.X_OK):
    os.execv(sys.argv[2], [sys.argv[2], *sys.argv[:2]])

try:
    import flip_evaluator  # noqa: F401
    import numpy
    import skimage  # noqa: F401
except ImportError as missing:
    print(f"skipped: {missing.name} is missing")
    sys.exit(77)


def main():
    sys.dont_write_bytecode = True
    sys.path.insert(0, sys.argv[1])
    from studies.perceptual import measure

    y, x = numpy.mgrid[0:96, 0:96]
    grey = 120 + 60 * numpy.sin(x / 9) * numpy.cos(y / 7)
    truth = numpy.stack([grey, 0.8 * grey, 0.6 * grey], axis=2).round().astype(numpy.uint8)
    noise = numpy.random.default_rng(1).integers(-20, 21, truth.shape)
    noisy = numpy.clip(truth.astype(int) + noise, 0, 255).astype(numpy.uint8)
    brighter = truth + numpy.uint8(1)
    shifted = numpy.roll(truth, 2, axis=1)

    assert measure(truth, truth) == (1.0, 0.0)
    for name, picture in {"noise": noisy, "a shift": shifted}.items():
        ssim, flip = measure(picture, truth)
        print(f"{name}: SSIM {ssim:.4f}, FLIP {flip:.4f}")
        assert ssim < 0.985, name
        assert flip > 0.08, name
    ssim, flip = measure(brighter, truth)
    print(f"one level brighter: SSIM {ssim:.4f}, FLIP {flip:.4f}")
    assert ssim > 0.99
    assert 0 < flip < 0.05


if __name__ == "__main__":
    main()
