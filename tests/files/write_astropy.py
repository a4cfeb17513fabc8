"""astropy: FITS cubes, in the first part of a file and behind it, of all types, scaled, of one and several volumes."""
import gzip

import numpy as np
from astropy.io import fits
from cases import FOLDER, case, voxels

PLAIN = {"spacing": [1, 1, 1], "origin": [0, 0, 0], "direction": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "unit": "",
         "world": "lattice"}


def save(name, *parts, expected, ending="fits", **wanted):
    fits.HDUList(list(parts)).writeto(FOLDER / f"{name}.{ending}")
    case(name, f"{name}.{ending}", expected, **{**PLAIN, **wanted})


def header(**cards):
    return fits.Header([(key.replace("_", "-"), value) for key, value in cards.items()])


# Those that FITS does not have are stored as others, with BZERO.
for dtype in ("int8", "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64"):
    volume = voxels(dtype)
    save(f"fits_{dtype}", fits.PrimaryHDU(volume), expected=volume, frames=1, channels=1)

volume = voxels("int16")
lengths = {f"CUNIT{k}": "kpc" for k in (1, 2, 3)}
steps = {"CDELT1": 0.5, "CDELT2": -2.0, "CDELT3": 3.25, "CRPIX1": 3.0, "CRVAL1": 10.0, "CRPIX2": 1.0, "CRPIX3": 1.0,
         "CRVAL3": -4.0}
save("fits_lengths", fits.PrimaryHDU(volume, header(**lengths, **steps)), expected=volume, unit="kpc",
     spacing=[0.5, 2, 3.25], origin=[9, 0, -4], direction=[[1, 0, 0], [0, -1, 0], [0, 0, 1]])
save("fits_of_the_sky", fits.PrimaryHDU(volume, header(CUNIT1="deg", CUNIT2="deg", CUNIT3="m/s", **steps)),
     expected=volume)
save("fits_extension", fits.PrimaryHDU(voxels("uint8")[0]),
     fits.BinTableHDU.from_columns([fits.Column("a", "PE()", array=np.array([[1, 2], [3]], dtype=object))]),
     fits.ImageHDU(volume, name="SCI"), expected=volume)
save("fits_degenerate", fits.PrimaryHDU(volume[None]), expected=volume, frames=1)
save("fits_stokes", fits.PrimaryHDU(volume[:, None]), expected=volume, frames=1)
several = np.stack([voxels("int16", seed=n) for n in (1, 2, 3)])
save("fits_several", fits.PrimaryHDU(several), expected=several[1], frame=1, frames=3)

scaled = fits.PrimaryHDU(volume.astype("float32") * 0.5 - 3)
scaled.scale("int16", bscale=0.5, bzero=-3)
save("fits_scaled", scaled, expected=volume.astype("float32") * 0.5 - 3)
save("fits_gzip", fits.PrimaryHDU(volume), fits.ImageHDU(several), expected=volume, ending="fits.gz")
(FOLDER / "behind.fits.gz").write_bytes(gzip.compress((FOLDER / "fits_extension.fits").read_bytes()))
case("fits_gzip_extension", "behind.fits.gz", volume, **PLAIN)
