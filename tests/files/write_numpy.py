"""Raw files by NumPy: that the comparison itself works."""
from cases import FOLDER, case, voxels

for dtype in ("uint8", "int16", "float32"):
    volume = voxels(dtype)
    name = f"numpy_7x5x6_{dtype}.raw"
    volume.tofile(FOLDER / name)
    case(f"numpy_raw_{dtype}", name, volume, spacing=[1, 1, 1], world="lattice", frames=1, channels=1)
