"""Random decompositions of a volume, as MPI programs have them: seeded, the same on every rank."""

import numpy as np


def cuts(random, size, parts):
    """Bounds of `parts` uneven pieces; some may be empty."""
    inner = np.sort(random.integers(0, size + 1, parts - 1))
    return [0, *inner.tolist(), size]


def boxes(random, shape, most=4):
    """Bricks that cover a volume once, as (start, end)."""
    bounds = [cuts(random, size, int(random.integers(1, most + 1))) for size in shape]
    return [
        ((z0, y0, x0), (z1, y1, x1))
        for z0, z1 in zip(bounds[0], bounds[0][1:])
        for y0, y1 in zip(bounds[1], bounds[1][1:])
        for x0, x1 in zip(bounds[2], bounds[2][1:])
        if z0 < z1 and y0 < y1 and x0 < x1
    ]


def with_strides(random, block):
    """The same values in another layout: Fortran's, reversed, or with gaps."""
    form = int(random.integers(4))
    if form == 0:
        return np.ascontiguousarray(block)
    if form == 1:
        return np.asfortranarray(block)
    if form == 2:
        return np.ascontiguousarray(block[::-1, :, ::-1])[::-1, :, ::-1]
    return np.repeat(block, 2, axis=1)[:, ::2]


def add_random_blocks(session, volume, seed, rank=0, ranks=1):
    """This rank's blocks of a random decomposition, some ranks having none. Returns (number, slices) of each."""
    random = np.random.default_rng(seed)
    added = []
    for start, end in boxes(random, volume.shape):
        owner = int(random.integers(ranks))
        place = tuple(slice(a, b) for a, b in zip(start, end))
        block = with_strides(random, volume[place])
        if owner == rank:
            added.append((session.add_block(start, block), place))
    return added
