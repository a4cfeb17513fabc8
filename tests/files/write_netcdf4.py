"""netCDF-4 by netCDF4: coordinates, packed values, fill values, time."""
import netCDF4
import numpy as np

from cases import FOLDER, case, voxels

SHAPE = (6, 5, 7)  # height, latitude, longitude
volume = voxels("float32", SHAPE)


def create(name, axes, variable, kind, data, attributes=None, **keywords):
    """axes: {name: (coordinates, {attribute: value}), or a size}, in the order of the variable's dimensions."""
    with netCDF4.Dataset(FOLDER / f"{name}.nc", "w") as file:
        for axis, described in axes.items():
            values, more = (None, {}) if isinstance(described, int) else described
            file.createDimension(axis, described if values is None else len(values))
            if values is not None:
                made = file.createVariable(axis, "f8", (axis,))
                made[:] = values
                made.setncatts(more)
        made = file.createVariable(variable, kind, tuple(axes), **keywords)
        made.set_auto_maskandscale(False)
        made.setncatts(attributes or {})
        made[:] = data


metres = {"units": "m"}
regular = {
    "z": (np.arange(6) * 3.0 + 100, metres | {"positive": "up"}),
    "y": (np.arange(5) * 2.0 - 4, metres),
    "x": (np.arange(7) * 1.5, metres),
}
create("regular", regular, "temperature", "f4", volume, {"units": "K", "long_name": "temperature"}, zlib=True,
       chunksizes=(4, 5, 3))
case("netcdf_regular", "regular.nc", volume, spacing=[1.5, 2, 3], origin=[0, -4, 100], unit="m", world="lattice",
     direction=[[1, 0, 0], [0, 1, 0], [0, 0, 1]], frames=1, channels=1)

downwards = dict(regular)
downwards["z"] = (np.arange(6) * 3.0 + 100, metres | {"positive": "down"})
downwards["y"] = (4 - np.arange(5) * 2.0, metres)
create("downwards", downwards, "temperature", "f4", volume)
case("netcdf_downwards", "downwards.nc", volume, spacing=[1.5, 2, 3], origin=[0, 4, -100],
     direction=[[1, 0, 0], [0, -1, 0], [0, 0, -1]])

# Longitude is the slowest here: the lattice's first axis is height.
turned = {
    "lon": (np.arange(6) * 0.5 + 10, {"units": "degrees_east"}),
    "lat": (np.arange(5) * -0.5 + 50, {"units": "degrees_north"}),
    "height": (np.arange(7) * 0.5, {"units": "degrees", "axis": "Z"}),
}
create("turned", turned, "wind", "f4", volume)
case("netcdf_turned", "turned.nc", volume, spacing=[0.5, 0.5, 0.5], origin=[10, 50, 0], unit="degrees",
     direction=[[0, 0, 1], [0, -1, 0], [1, 0, 0]])

packed = voxels("int16", SHAPE)
create("packed", regular, "pressure", "i2", packed, {"scale_factor": 0.5, "add_offset": 1000.0, "missing_value": -99},
       fill_value=-32768)
case("netcdf_packed", "packed.nc", (packed * 0.5 + 1000).astype("float32"))

film = np.stack([voxels("float32", SHAPE, seed) for seed in range(4)])
timed = {"time": (np.arange(4) * 6.0, {"units": "hours since 2000-01-01"})} | regular
create("film", timed, "temperature", "f4", film, zlib=True)
case("netcdf_film", "film.nc", film[3], frame=3, frames=4, spacing=[1.5, 2, 3], unit="m")

create("no_coordinates", {"level": 6, "row": 5, "column": 7}, "v", "f4", volume)
case("netcdf_no_coordinates", "no_coordinates.nc", volume, spacing=[1, 1, 1])
create("odd_units", {"z": (np.arange(6) * 2.0, metres), "y": 5, "x": 7}, "v", "i4", packed.astype("i4"))
case("netcdf_odd_units", "odd_units.nc", packed.astype("int32"), spacing=[1, 1, 1])
