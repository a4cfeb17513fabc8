"""Costs that are not negative, fitted to what was measured."""
import itertools
import math


def solve(matrix, right):
    """x with matrix x = right, by Gaussian elimination; None where the matrix is singular."""
    size = len(right)
    rows = [list(row) + [value] for row, value in zip(matrix, right)]
    for k in range(size):
        pivot = max(range(k, size), key=lambda i: abs(rows[i][k]))
        if abs(rows[pivot][k]) < 1e-12:
            return None
        rows[k], rows[pivot] = rows[pivot], rows[k]
        for i in range(k + 1, size):
            factor = rows[i][k] / rows[k][k]
            rows[i] = [a - factor * b for a, b in zip(rows[i], rows[k])]
    x = [0.0] * size
    for k in reversed(range(size)):
        x[k] = (rows[k][size] - sum(rows[k][j] * x[j] for j in range(k + 1, size))) / rows[k][k]
    return x


def non_negative(rows, targets):
    """The x >= 0 with the least sum of (row x - target)². Few unknowns only: it tries each choice of those that are zero."""
    unknowns = len(rows[0])
    # Columns of length one, so that units do not matter.
    lengths = [math.sqrt(sum(row[k] ** 2 for row in rows)) or 1.0 for k in range(unknowns)]
    scaled = [[value / length for value, length in zip(row, lengths)] for row in rows]
    gram = [[sum(row[a] * row[b] for row in scaled) for b in range(unknowns)] for a in range(unknowns)]
    right = [sum(row[a] * target for row, target in zip(scaled, targets)) for a in range(unknowns)]
    best, least = [0.0] * unknowns, 0.0
    for count in range(1, unknowns + 1):
        for chosen in itertools.combinations(range(unknowns), count):
            x = solve([[gram[a][b] for b in chosen] for a in chosen], [right[a] for a in chosen])
            if x is None or min(x) < 0:
                continue
            # At a minimum the squares' sum is that of the targets less this.
            remainder = -sum(value * right[a] for a, value in zip(chosen, x))
            if remainder < least:
                least = remainder
                best = [0.0] * unknowns
                for a, value in zip(chosen, x):
                    best[a] = value
    return [value / length for value, length in zip(best, lengths)]
