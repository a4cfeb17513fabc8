"""ITK: NRRD, MetaImage, NIfTI and legacy VTK, of one and of several volumes, vectors and colours."""
import itk
import numpy as np
from cases import FOLDER, case, voxels

ANGLE = np.radians(20)
TURN = np.array([[np.cos(ANGLE), -np.sin(ANGLE), 0], [np.sin(ANGLE), np.cos(ANGLE), 0], [0, 0, 1]])
SPACING = [0.5, 2.0, 3.0]
ORIGIN = [10.0, -20.0, 30.0]
PLACE = {"spacing": SPACING, "origin": ORIGIN, "direction": [list(column) for column in TURN.T], "unit": "mm",
         "world": "patient"}


def image_of(array, is_vector=False):
    image = itk.image_from_array(np.ascontiguousarray(array), is_vector=is_vector)
    more = image.GetImageDimension() - 3
    direction = np.eye(3 + more)
    direction[:3, :3] = TURN
    image.SetSpacing(SPACING + [1.0] * more)
    image.SetOrigin(ORIGIN + [0.0] * more)
    image.SetDirection(itk.matrix_from_array(direction))
    return image


def save(image, file, packed=False):
    itk.imwrite(image, str(FOLDER / file), compression=packed)


for ending in ("nrrd", "nhdr", "mha", "mhd", "nii"):
    for packed in (False, True):
        if packed and ending == "nii":
            continue
        for dtype in ("uint8", "int16", "float32"):
            volume = voxels(dtype)
            name = f"itk_{ending}_{dtype}{'_packed' if packed else ''}"
            save(image_of(volume), f"{name}.{ending}", packed)
            case(name, f"{name}.{ending}", volume, frames=1, channels=1, **PLACE)

        # ITK names no space for four axes in NRRD.
        place = {key: PLACE[key] for key in ("spacing", "origin", "direction")}
        series = [voxels("float32", seed=n) for n in (1, 2, 3)]
        name = f"itk_{ending}_4d{'_packed' if packed else ''}"
        save(image_of(np.stack(series)), f"{name}.{ending}", packed)
        case(f"{name}_first", f"{name}.{ending}", series[0], frames=3, **place)
        case(f"{name}_last", f"{name}.{ending}", series[2], frame=2, frames=3, **place)

        colours = np.stack([voxels("uint8", seed=n) for n in (1, 40, 90)], axis=-1)
        luminance = ((colours.astype(int) @ np.array([2126, 7152, 722]) + 5000) // 10000).astype("uint8")
        name = f"itk_{ending}_colours{'_packed' if packed else ''}"
        save(image_of(colours, is_vector=True), f"{name}.{ending}", packed)
        case(f"{name}_luminance", f"{name}.{ending}", luminance, channels=3, **PLACE)
        case(f"{name}_blue", f"{name}.{ending}", colours[..., 2], channel="b", **PLACE)

        vectors = np.stack(series, axis=-1)
        name = f"itk_{ending}_vectors{'_packed' if packed else ''}"
        save(image_of(vectors, is_vector=True), f"{name}.{ending}", packed)
        case(name, f"{name}.{ending}", series[1], channel="1", channels=3, **PLACE)

# Legacy VTK has no directions.
volume = voxels("int16")
image = itk.image_from_array(volume)
image.SetSpacing(SPACING)
image.SetOrigin(ORIGIN)
itk.imwrite(image, str(FOLDER / "itk_legacy.vtk"))
case("itk_legacy", "itk_legacy.vtk", volume, spacing=SPACING, origin=ORIGIN)
