"""nibabel: NIfTI-1, NIfTI-2 and MGH, of one and of several volumes."""
import nibabel
import numpy as np
from cases import FOLDER, case, voxels

# Right, anterior, superior of a step along x, y, z: a turned lattice, as a scanner's.
ANGLE = np.radians(20)
TURN = np.array([[np.cos(ANGLE), -np.sin(ANGLE), 0], [np.sin(ANGLE), np.cos(ANGLE), 0], [0, 0, 1]])
SPACING = np.array([0.5, 2.0, 3.0])
ORIGIN = np.array([10.0, -20.0, 30.0])
TO_LPS = np.array([-1, -1, 1])


def affine(unit=1.0):
    matrix = np.eye(4)
    matrix[:3, :3] = TURN * SPACING * unit
    matrix[:3, 3] = ORIGIN * unit
    return matrix


PLACE = {"spacing": list(SPACING), "origin": list(ORIGIN * TO_LPS),
         "direction": [list(column) for column in (TURN * TO_LPS[:, None]).T], "unit": "mm", "world": "patient"}
KINDS = {"nifti1": nibabel.Nifti1Image, "nifti2": nibabel.Nifti2Image}


def save(image, file, unit="mm"):
    image.header.set_xyzt_units(unit, "sec")
    nibabel.save(image, FOLDER / file)


for version, kind in KINDS.items():
    for ending in ("nii", "nii.gz"):
        for dtype in ("uint8", "int16", "float32"):
            volume = voxels(dtype)
            name = f"nibabel_{version}_{dtype}_{ending.replace('.', '_')}"
            save(kind(volume.T, affine()), f"{name}.{ending}")
            case(name, f"{name}.{ending}", volume, frames=1, channels=1, **PLACE)

    # The lattice's place by the quaternion alone, and in other units.
    volume = voxels("int16")
    image = kind(volume.T, affine())
    image.set_qform(affine(), code=1)
    image.set_sform(None, code=0)
    save(image, f"nibabel_{version}_qform.nii")
    case(f"nibabel_{version}_qform", f"nibabel_{version}_qform.nii", volume, **PLACE)
    for unit, millimetres in (("micron", 1e-3), ("meter", 1e3)):
        name = f"nibabel_{version}_{unit}"
        save(kind(volume.T, affine(1 / millimetres)), f"{name}.nii", unit)
        case(name, f"{name}.nii", volume, **PLACE)

    # A sheared lattice, and a quaternion beside it that says otherwise.
    sheared = affine()
    sheared[:3, 2] += 0.3 * sheared[:3, 0]
    image = kind(volume.T, sheared)
    image.set_sform(sheared, code=4)
    image.set_qform(np.eye(4), code=1)
    save(image, f"nibabel_{version}_sheared.nii")
    lengths = np.linalg.norm(sheared[:3, :3], axis=0)
    case(f"nibabel_{version}_sheared", f"nibabel_{version}_sheared.nii", volume, spacing=list(lengths),
         origin=PLACE["origin"], direction=[list(c) for c in (sheared[:3, :3] / lengths * TO_LPS[:, None]).T])

    # Values are 0.5 * stored - 3.
    scaled = (volume.astype("float64") * 0.5 - 3).astype("float32")
    image = kind(volume.T, affine())
    image.header.set_slope_inter(0.5, -3)
    save(image, f"nibabel_{version}_scaled.nii")
    case(f"nibabel_{version}_scaled", f"nibabel_{version}_scaled.nii", scaled, **PLACE)

    series = [voxels("int16", seed=n) for n in (1, 2, 3)]
    for ending in ("nii", "nii.gz"):
        name = f"nibabel_{version}_4d_{ending.replace('.', '_')}"
        save(kind(np.stack([v.T for v in series], axis=-1), affine()), f"{name}.{ending}")
        case(f"{name}_first", f"{name}.{ending}", series[0], frames=3, **PLACE)
        case(f"{name}_last", f"{name}.{ending}", series[2], frame=2, frames=3, **PLACE)

    vectors = np.stack([v.T for v in series], axis=-1)[:, :, :, None, :]
    image = kind(vectors, affine())
    image.header.set_intent("vector")
    save(image, f"nibabel_{version}_vectors.nii")
    case(f"nibabel_{version}_vectors", f"nibabel_{version}_vectors.nii", series[1], channel="1", channels=3, **PLACE)

    colours = np.stack([voxels("uint8", seed=n) for n in (1, 40, 90)], axis=-1)
    rgb = np.zeros(colours.shape[2::-1], dtype=[("R", "u1"), ("G", "u1"), ("B", "u1")])
    for n, field in enumerate("RGB"):
        rgb[field] = colours[..., n].T
    luminance = ((colours.astype(int) @ np.array([2126, 7152, 722]) + 5000) // 10000).astype("uint8")
    save(kind(rgb, affine()), f"nibabel_{version}_rgb.nii")
    case(f"nibabel_{version}_luminance", f"nibabel_{version}_rgb.nii", luminance, channels=3, **PLACE)
    case(f"nibabel_{version}_red", f"nibabel_{version}_rgb.nii", colours[..., 0], channel="r", **PLACE)

for ending in ("mgh", "mgz"):
    for dtype in ("uint8", "int16", "int32", "float32"):
        name, volume = f"mgh_{dtype}_{ending}", voxels(dtype)
        nibabel.save(nibabel.MGHImage(volume.T, affine()), FOLDER / f"{name}.{ending}")
        case(name, f"{name}.{ending}", volume, frames=1, channels=1, **PLACE)
    stack = np.stack([v.T for v in series], axis=-1)
    nibabel.save(nibabel.MGHImage(stack, affine()), FOLDER / f"mgh_4d.{ending}")
    case(f"mgh_4d_{ending}_first", f"mgh_4d.{ending}", series[0], frames=3, **PLACE)
    case(f"mgh_4d_{ending}_last", f"mgh_4d.{ending}", series[2], frame=2, frames=3, **PLACE)
