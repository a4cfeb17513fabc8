"""AMReX plotfiles, after AMReX's documentation: yt, which cannot write them, must read what the cases say."""
import numpy as np
import yt

from cases import FOLDER, case, voxels

yt.set_log_level("error")
# RealDescriptors: how many bits there are and what they are for, and the order of the bytes.
REALS = {"<f4": "((8, (32 8 23 0 1 9 0 127)),(4, (4 3 2 1)))", ">f4": "((8, (32 8 23 0 1 9 0 127)),(4, (1 2 3 4)))",
         "<f8": "((8, (64 11 52 0 1 12 0 1023)),(8, (8 7 6 5 4 3 2 1)))",
         ">f8": "((8, (64 11 52 0 1 12 0 1023)),(8, (1 2 3 4 5 6 7 8)))"}


def box(first, end):
    return "({} {} (0,0,0))".format(*("({},{},{})".format(*corner) for corner in (first, np.array(end) - 1)))


def write_level(folder, level, boxes, fields, kind):
    """Boxes are pairs of first and end cells in x, y, z; every second one is in another file."""
    files, places = [b"", b""], []
    (folder / f"Level_{level}").mkdir()
    for number, (first, end) in enumerate(boxes):
        places.append(f"FabOnDisk: Cell_D_{number % 2:05d} {len(files[number % 2])}\n")
        part = tuple(slice(low, high) for low, high in zip(first[::-1], end[::-1]))
        files[number % 2] += f"FAB {REALS[kind]}{box(first, end)} {len(fields)}\n".encode()
        files[number % 2] += b"".join(np.ascontiguousarray(field[part], kind).tobytes() for field in fields)
    for number, data in enumerate(files):
        (folder / f"Level_{level}/Cell_D_{number:05d}").write_bytes(data)
    table = f"{len(boxes)},{len(fields)}\n" + "\n".join("0.0," * len(fields) for _ in boxes) + "\n"
    (folder / f"Level_{level}/Cell_H").write_text(
        f"1\n1\n{len(fields)}\n0\n({len(boxes)} 0\n" + "".join(box(*one) + "\n" for one in boxes) + f")\n{len(boxes)}\n"
        + "".join(places) + "\n" + table + "\n" + table)


def write(name, kind, names, levels, low=(-1.5, 2.0, 0.25), cell=(0.5, 1.0, 0.125)):
    """`levels`: of each the fields and the boxes."""
    folder = FOLDER / name
    folder.mkdir()
    shape = np.array(levels[0][0][0].shape[::-1])
    low, cell = np.array(low), np.array(cell)
    spell = lambda numbers: " ".join(f"{number:.17g}" for number in numbers) + " \n"
    text = f"HyperCLaw-V1.1\n{len(names)}\n" + "".join(f"{one}\n" for one in names) + f"3\n0.125\n{len(levels) - 1}\n"
    text += spell(low) + spell(low + shape * cell) + "2 " * (len(levels) - 1) + "\n"
    text += "".join(box((0, 0, 0), shape * 2**level) + " " for level in range(len(levels))) + "\n"
    text += "3 " * len(levels) + "\n" + "".join(spell(cell / 2**level) for level in range(len(levels))) + "0\n0\n"
    for level, (fields, boxes) in enumerate(levels):
        text += f"{level} {len(boxes)} 0.125\n3\n"
        for first, end in boxes:
            text += "".join(spell(low[k] + cell[k] / 2**level * np.array([first[k], end[k]])) for k in range(3))
        text += f"Level_{level}/Cell\n"
        write_level(folder, level, boxes, fields, kind)
    (folder / "Header").write_text(text)
    check(folder, names, levels, low, cell)
    for number, field in enumerate(levels[0][0]):
        only = len(names) == 1
        case(f"{name}_{number}", name, field, channel=None if only else names[number] if number else "0", channels=len(names),
             of_channels=[[one, None, None, False] for one in names], spacing=list(cell), origin=list(low + cell / 2),
             direction=np.eye(3).tolist(), unit="", world="lattice", frames=1)


def check(folder, names, levels, low, cell):
    data = yt.load(folder)
    shape = levels[0][0][0].shape[::-1]
    grid = data.covering_grid(0, data.domain_left_edge, shape)
    assert np.allclose(data.domain_left_edge.d, low) and np.allclose(grid.dds.d, cell)
    for axis, along in enumerate(("x", "y", "z")):
        first = grid["boxlib", along].d[0, 0, 0]
        assert np.isclose(first, low[axis] + cell[axis] / 2), (along, first)
    # Of level 0 alone: where there are finer cells yt takes their mean.
    for one in data.index.grids:
        if one.Level > 0:
            continue
        first = np.round((one.LeftEdge.d - low) / cell).astype(int)
        part = tuple(slice(at, at + size) for at, size in zip(first, one.ActiveDimensions))
        for name, field in zip(names, levels[0][0]):
            assert (one["boxlib", name].d == field.transpose(2, 1, 0)[part]).all(), (folder, name)


SPLIT = [((0, 0, 0), (4, 5, 6)), ((4, 0, 0), (7, 2, 6)), ((4, 2, 0), (7, 5, 3)), ((4, 2, 3), (7, 5, 6))]
for kind, title in (("<f4", "float32"), (">f4", "float32_big"), ("<f8", "float64"), (">f8", "float64_big")):
    fields = [voxels(kind[1:], seed=seed) for seed in (1, 2, 3)]
    write(f"amrex_{title}", kind, ["density", "xmom", "x velocity" if kind == "<f4" else "Temp"], [(fields, SPLIT)])
write("amrex_one_box", "<f8", ["phi"], [([voxels("float64")], [((0, 0, 0), (7, 5, 6))])])
finer = [voxels("float64", (12, 10, 14), seed) for seed in (4, 5)]
write("amrex_levels", "<f8", ["density", "Temp"],
      [([voxels("float64", seed=seed) for seed in (1, 2)], SPLIT), (finer, [((2, 2, 2), (8, 6, 8))])])
