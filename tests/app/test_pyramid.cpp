// ringsplat pyramid: what it writes opens as what it was made of, on any ranks and after an interruption.
#include <algorithm>
#include <map>
#include <random>
#include <span>

#include "app/workshop.hpp"
#include "ringsplat/formats/open.hpp"
#include "ringsplat/volume/reduced.hpp"
#include "support/catch.hpp"

using namespace ringsplat;
using namespace ringsplat::app_test;

namespace {

const std::string head = std::string(RINGSPLAT_TEST_DATA) + "/head.nrrd";

std::map<std::string, std::string> content_of(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) files[fs::relative(entry.path(), folder).string()] = read_text(entry.path());
  return files;
}

std::string voxels_of(VolumeSource& source) {
  std::string voxels(source.grid().bytes(), '\0');
  source.read_slices(0, source.grid().dims.z, std::as_writable_bytes(std::span(voxels)));
  return voxels;
}

/// Slice by slice.
bool same_voxels(VolumeSource& a, VolumeSource& b) {
  if (a.grid().dims != b.grid().dims) return false;
  std::vector<std::byte> of_a(a.grid().slice_bytes(Axis::z)), of_b(of_a.size());
  for (int z = 0; z < a.grid().dims.z; ++z) {
    a.read_slices(z, 1, of_a);
    b.read_slices(z, 1, of_b);
    if (of_a != of_b) return false;
  }
  return true;
}

/// A Zarr array of 16 bits in which only some chunks have values, others than their neighbours'.
void write_sparse(const fs::path& folder, const glm::ivec3& dims, const glm::ivec3& chunk,
                  const std::vector<glm::ivec3>& filled) {
  const auto list = [](const glm::ivec3& v) {
    return "[" + std::to_string(v.z) + "," + std::to_string(v.y) + "," + std::to_string(v.x) + "]";
  };
  fs::create_directories(folder);
  write_text(folder / ".zarray",
             R"({"zarr_format":2,"dtype":"<u2","compressor":null,"fill_value":7,"order":"C",)"
             R"("filters":null,"shape":)" +
                 list(dims) + R"(,"chunks":)" + list(chunk) + "}");
  std::mt19937 random(5);
  for (const auto& at : filled) {
    std::string values(2 * std::size_t(chunk.x) * std::size_t(chunk.y) * std::size_t(chunk.z), '\0');
    for (std::size_t k = 0; k < values.size(); k += 2) values[k] = char(random());
    write_text(folder / (std::to_string(at.z) + "." + std::to_string(at.y) + "." + std::to_string(at.x)),
               values);
  }
}

/// Makes a pyramid by two ranks. Returns the peak resident memory of the one that had more, in MiB.
int peak_memory(const std::string& volume, const std::string& store) {
  const TemporaryFolder peaks;
  const std::string watching = R"("$@" & p=$!; while h=$(grep VmHWM /proc/$p/status); do echo "$h" > )" +
                               quoted(peaks / "of_") + R"($p; sleep 0.02; done; wait $p)";
  const Ended ended = run_command(quoted(RINGSPLAT_MPIEXEC) + " -n 2 sh -c " + quoted(watching) + " sh " +
                                  command_of(RINGSPLAT_PROGRAM, {"pyramid", volume, store}));
  INFO(ended.err);
  REQUIRE(ended.code == 0);
  const auto files = content_of(fs::path(peaks / "."));
  CHECK(files.size() == 2);
  int most = 0;
  for (const auto& [name, line] : files)
    most = std::max(most, std::stoi(line.substr(line.find(':') + 1)) >> 10);
  return most;
}

}  // namespace

TEST_CASE("a pyramid's levels are the volume and its halves, where they were in the world", "[mpi]") {
  const TemporaryFolder folder;
  const fs::path alone = folder / "alone/head.zarr", together = folder / "together/head.zarr";
  fs::create_directories(alone.parent_path());
  fs::create_directories(together.parent_path());
  succeeded(run_program({"pyramid", head, alone.string()}));
  succeeded(run_program({"pyramid", head, together.string()}, 3));
  CHECK(content_of(alone) == content_of(together));

  const auto file = open_volume(head), finest = open_volume(alone),
             coarse = open_volume(alone, {}, {.memory = 1e6}), half = reduced_source(*file, {2, true});
  CHECK(facts_of(finest->grid()) == facts_of(file->grid()));
  CHECK(voxels_of(*finest) == voxels_of(*file));
  CHECK(coarse->grid().dims == half->grid().dims);
  CHECK(glm::distance(coarse->grid().origin, half->grid().origin) < 1e-12);
  CHECK(voxels_of(*coarse) == voxels_of(*half));
  CHECK(finest->notes().world == World::patient);
  CHECK(finest->notes().unit == file->notes().unit);
}

TEST_CASE("a pyramid's picture has the bits of its volume's", "[mpi]") {
  const TemporaryFolder folder;
  const std::string store = folder / "head.zarr", of_file = folder / "file.exr",
                    of_store = folder / "store.exr";
  succeeded(run_program({"pyramid", head, store}, 2));
  for (const Words& part : {Words{}, {"--crop", "10:90,:,30:100"}}) {
    succeeded(run_program(joined({"render", head, "-o", of_file, "--size", "96"}, part)));
    succeeded(run_program(joined({"render", store, "-o", of_store, "--size", "96"}, part), 3));
    CHECK(same_pictures(of_file, of_store));
  }
}

TEST_CASE("boxes and slices count voxels of a pyramid's finest level, whichever is read") {
  const TemporaryFolder folder;
  const std::string store = folder / "head.zarr", by_finest = folder / "by_finest.exr",
                    by_level = folder / "by_level.exr";
  succeeded(run_program({"pyramid", head, store}));
  const auto shape = [&](const std::string& memory) {
    const Ended ended = succeeded(
        run_program({"info", store, "--clip", "10:91,:,31:33", "--memory", memory, "--crop", "8:120,:,:"}));
    const auto at = ended.out.find("clip ");
    return ended.out.substr(at + 11, ended.out.find('\n', at) - at - 11);
  };
  CHECK(shape("1G") == "10:91,0:128,31:33 of 112 x 128 x 124");
  CHECK(shape("1M") == "5:46,0:64,15:17 of 56 x 64 x 62");
  succeeded(run_program(
      {"render", store, "--slice", "z=61", "--memory", "1M", "-o", by_finest, "--size", "64"}, 2));
  succeeded(run_program({"render", store + "/1", "--slice", "z=30", "-o", by_level, "--size", "64"}));
  CHECK(same_pictures(by_finest, by_level));
}

TEST_CASE("a coarser level is as dense as the finest") {
  const TemporaryFolder folder;
  const std::string store = folder / "head.zarr", finest = folder / "finest.exr",
                    level = folder / "level.exr";
  succeeded(run_program({"pyramid", head, store}));
  for (const char* const function : {"mr-soft", "auto"}) {
    succeeded(run_program({"render", store, "-o", finest, "--size", "96", "--tf", function}));
    succeeded(
        run_program({"render", store, "-o", level, "--size", "96", "--tf", function, "--memory", "1M"}));
    const Ended ended = succeeded(run_program({"compare", level, finest, "--fail-above", "16"}));
    INFO(ended.out);
  }
}

TEST_CASE("--error tells what a pyramid's level costs against its finest one") {
  const TemporaryFolder folder;
  const std::string even = folder / "even_128x120x130_uint8.raw", of_even = folder / "even.zarr",
                    of_head = folder / "head.zarr", picture = folder / "x.png";
  write_text(even, std::string(128 * 120 * 130, 'x'));
  succeeded(run_program({"pyramid", even, of_even}));
  succeeded(run_program({"pyramid", head, of_head}));
  const auto cost = [&](const std::string& store, const std::string& memory) {
    const Ended ended =
        succeeded(run_program({"render", store, "-o", picture, "--size", "64", "--memory", memory, "--error",
                               "field", "--error-pixels", "300", "--tf", "grey", "--range", "0:255"}));
    const std::string said = ended.out + ended.err, words = "against the finest: ";
    const auto at = said.find(words);
    return at == std::string::npos ? -1 : std::stod(said.substr(at + words.size()));
  };
  const double nothing = cost(of_even, "500K"), something = cost(of_head, "1M");
  CHECK(nothing >= 0);
  CHECK(nothing < 1e-3);
  CHECK(something > 0.1);
  CHECK(something < 40);
  CHECK(cost(of_head, "1G") < 0);
}

TEST_CASE("of labels a pyramid takes every second voxel") {
  const TemporaryFolder folder;
  const std::string store = folder / "labels.zarr";
  succeeded(run_program({"pyramid", head, store, "--labels"}));
  const auto file = open_volume(head), half = reduced_source(*file, {2, false});
  CHECK(voxels_of(*open_volume(store + "/1")) == voxels_of(*half));
}

TEST_CASE("a pyramid that was interrupted is gone on with, and nothing else is written to") {
  const TemporaryFolder folder;
  const std::string store = folder / "head.zarr", whole = folder / "whole/head.zarr",
                    other = folder / "other.nrrd";
  fs::create_directories(folder / "whole");
  succeeded(run_program({"pyramid", head, whole}));
  // A limit on files' sizes that the metadata and the small chunks of the last column keep.
  std::uintmax_t largest = 0;
  for (const auto& [name, text] : content_of(whole)) largest = std::max<std::uintmax_t>(largest, text.size());
  const Ended cut = run_command("prlimit --fsize=" + std::to_string(largest - 1) + " " +
                                command_of(RINGSPLAT_PROGRAM, {"pyramid", head, store}));
  CHECK(cut.code == 3);
  CHECK(cut.err.find("cannot be written") != std::string::npos);
  CHECK(fs::exists(fs::path(store) / ".begun"));
  CHECK_FALSE(fs::exists(fs::path(store) / ".zattrs"));

  succeeded(run_program({"synth", "ball", "-o", other, "--dims", "70"}));
  check_refused(run_program({"pyramid", other, store}), "was begun for another volume");
  check_refused(run_program({"pyramid", head, store, "--labels"}), "or with other options");
  // As other ranks left it: the last chunk of a layer without the first.
  const fs::path layer = fs::path(store) / "0/0";
  fs::create_directories(layer / "1");
  fs::copy_file(fs::path(whole) / "0/0/1/1", layer / "1/1", fs::copy_options::overwrite_existing);
  fs::remove(layer / "0/0");
  succeeded(run_program({"pyramid", head, store}));
  CHECK(content_of(store) == content_of(whole));
  check_refused(run_program({"pyramid", head, store}), "is there already");
  check_refused(run_program({"pyramid", head, folder / "none/x.zarr"}), "cannot be made");
  check_refused(run_program({"pyramid", head, folder / "x.zarr", "--channel", "0,1"}), "shows one channel");
}

TEST_CASE("a part of a pyramid is given in voxels of the finest level, and may be finer than the whole") {
  const TemporaryFolder folder;
  const std::string store = folder / "ball.zarr", file = folder / "ball.nrrd";
  succeeded(run_program({"synth", "ball", "-o", file, "--dims", "150x130x140", "--type", "uint16"}));
  succeeded(run_program({"pyramid", file, store}));
  const VoxelBox box{{65, 10, 70}, {129, 70, 130}};
  VolumeChoice part{.memory = 1e6, .crop = [&](const Grid&) { return box; }};
  const auto from_file = open_volume(file, {}, part), from_store = open_volume(store, {}, part);
  CHECK(from_store->grid().dims == box.dims());
  CHECK(facts_of(from_store->grid()) == facts_of(from_file->grid()));
  CHECK(voxels_of(*from_store) == voxels_of(*from_file));

  part.memory = 1e5;  // half of each axis fits
  const auto coarse = open_volume(store, {}, part);
  CHECK(coarse->grid().dims == glm::ivec3(33, 30, 30));
  CHECK(glm::distance(coarse->grid().origin, glm::dvec3(64.5, 10.5, 70.5)) < 1e-12);
  check_refused(run_program({"info", store, "--crop", ":,:,100:141"}),
                "--crop: the z part, '100:141', does not lie");
}

TEST_CASE("a rank that makes a pyramid takes at most 256 MiB, of thick layers and wide slices", "[mpi]") {
  const TemporaryFolder folder;
  const std::string volume = folder / "volume.zarr", store = folder / "store.zarr";
  SECTION("layers of 256 MiB") {
    write_sparse(volume, {2048, 2048, 32}, glm::ivec3(64), {{3, 4, 0}, {15, 15, 0}, {16, 16, 0}, {8, 8, 0}});
  }
  SECTION("slices of 98 MiB") {
    write_sparse(volume, {7168, 7167, 2}, {1024, 1024, 1}, {{3, 1, 0}, {4, 2, 0}, {3, 3, 1}, {6, 6, 0}});
  }
  const int peak = peak_memory(volume, store);
  CHECK(peak > 16);
#ifndef __SANITIZE_ADDRESS__  // it keeps what was freed
  CHECK(peak < 256);
#endif
  const auto file = open_volume(volume), finest = open_volume(store + "/0"),
             half = reduced_source(*file, {2, true});
  CHECK(same_voxels(*finest, *file));
  CHECK(same_voxels(*open_volume(store + "/1"), *half));
}
