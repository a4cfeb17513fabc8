#include "app/world_axes.hpp"

#include <fstream>

#include "support/catch.hpp"
#include "support/temporary_folder.hpp"

using ringsplat::app::world_is_patient;
using ringsplat::support::TemporaryFolder;

namespace {

std::filesystem::path made(const std::filesystem::path& file, const std::string& bytes = {}) {
  std::ofstream(file, std::ios::binary) << bytes;
  return file;
}

}  // namespace

TEST_CASE("A folder of DICOM files is a patient's, a folder of TIFF pages is not") {
  const TemporaryFolder folder;
  made(folder / "IM0001");
  CHECK(world_is_patient(folder.path()));
  made(folder / "page1.tif");
  CHECK_FALSE(world_is_patient(folder.path()));
}

TEST_CASE("A file is a patient's when its format or its header says so") {
  const TemporaryFolder folder;
  CHECK(world_is_patient(made(folder / "head.NII.GZ")));
  CHECK(world_is_patient(made(folder / "IM0001", std::string(128, '\0') + "DICM")));
  CHECK(world_is_patient(made(folder / "a.nrrd", "NRRD0004\nspace: left-posterior-superior\n\n")));
  CHECK_FALSE(world_is_patient(made(folder / "b.nrrd", "NRRD0004\nspacings: 1 1 1\n\nspace:")));
  CHECK_FALSE(world_is_patient(made(folder / "c_4x4x4_uint8.raw", std::string(64, '\0'))));
  CHECK_FALSE(world_is_patient(made(folder / "d.vtk")));
}
