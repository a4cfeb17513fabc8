#include "formats/hdf5_files.hpp"
#include "fuzz/driver.hpp"

namespace ringsplat::fuzz {
namespace {

using namespace files;

void pack(hid_t creation) {
  H5Pset_shuffle(creation);
  H5Pset_deflate(creation, 9);
}

void netcdf(hid_t file) {
  add(file, {.chunk = {2, 4, 5}, .creation = pack, .attributes = [](hid_t id) {
               put_text(id, "long_name", "salt");
               put_numbers(id, "_FillValue", {-50});
               put_numbers(id, "scale_factor", {0.5});
             }});
  add(file, axis("/lev", {1, 2, 3}, "m"));
  add(file, axis("/lat", {8, 6, 4, 2}, "degrees_north"));
  add(file, axis("/lon", {0, 1, 2, 3, 4}, "degrees_east"));
  put_scales(file, "/volume", {"/lev", "/lat", "/lon"});
}

void vtkhdf(hid_t file) {
  add(file, {.name = "/VTKHDF/PointData/density"});
  const Id root(opened(file, "/VTKHDF"));
  put_text(root.get(), "Type", "ImageData");
  put_numbers(root.get(), "WholeExtent", {0, nx - 1, 0, ny - 1, 0, nz - 1});
  put_numbers(root.get(), "Direction", {0, -1, 0, 1, 0, 0, 0, 0, 1});
}

void openpmd(hid_t file) {
  add(file, {.name = "/data/100/meshes/rho", .attributes = [](hid_t id) {
               put_numbers(id, "gridSpacing", {3, 2, 1});
               put_numbers(id, "gridUnitSI", {0.5});
             }});
  add(file, {.name = "/data/200/meshes/rho"});
  const Id root(opened(file, "/"));
  put_text(root.get(), "openPMD", "1.1.0");
  put_text(root.get(), "basePath", "/data/%T/");
}

}  // namespace

std::vector<Input> hdf5_seeds() {
  const fs::path path = scratch() / "seed.h5";
  const auto bytes = [&](const std::function<void(hid_t)>& fill, bool newest = false) {
    Input input = slurp(write_hdf5(path, fill, newest));
    fs::remove(path);
    return input;
  };
  std::vector<Input> seeds;
  for (const bool newest : {false, true}) {
    seeds.push_back(bytes([](hid_t file) { add(file, {.type = H5T_STD_I16BE}); }, newest));
    seeds.push_back(bytes([](hid_t file) { add(file, {.chunk = {2, 3, 4}, .creation = pack}); }, newest));
  }
  seeds.push_back(bytes(
      [](hid_t file) {
        add(file, {.name = "/a/low", .creation = [](hid_t id) { H5Pset_layout(id, H5D_COMPACT); }});
        add(file, {.name = "/film", .dims = {3, 4, 5, 1, 1}});
      },
      true));
  for (const auto& fill : {netcdf, vtkhdf, openpmd}) seeds.push_back(bytes(fill));
  return seeds;
}

}  // namespace ringsplat::fuzz
