"""Closed forms of scenes whose voxels depend on z alone, for rays that cross all of them with this cosine to the z axis.

Where value, and so opacity, rises linearly from 0 to a over a length l, the optical depth is l ((1 - a) ln(1 - a) + a) / a.
"""
import math

import numpy

from .files import linear


def depth(count, opacity, rise=1):
    """Of so many even voxels, to whose centres opacity rises over `rise` voxels from both sides."""
    return -math.log1p(-opacity) * (count - 1) + 2 * rise * ((1 - opacity) * math.log1p(-opacity) + opacity) / opacity


def front_to_back(*media):
    """(depth, colour)s, to the colours of rays by their cosine."""
    def colours(cosine):
        through, out = numpy.ones_like(cosine), numpy.zeros((*cosine.shape, 4))
        for depth, colour in media:
            opacity = -numpy.expm1(-depth / cosine)
            out += (through * opacity)[..., None] * [*linear(colour), 1]
            through = through * (1 - opacity)
        return out
    return colours
