// HDF5 datasets: layouts, types, choices, coordinates, and what is refused.
#include <fmt/format.h>

#include <atomic>
#include <limits>

#include "decode/readers.hpp"
#include "formats/captured_log.hpp"
#include "formats/hdf5_files.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/formats/open.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"

using namespace files;
using Catch::Matchers::Contains;

namespace {

void pack(hid_t creation) {
  H5Pset_shuffle(creation);
  H5Pset_deflate(creation, 4);
}

fs::path sample_file(const Folder& folder, const Hdf5& dataset = {}) {
  return write_hdf5(folder / "a.h5", {dataset});
}

std::string refusal(const fs::path& path, const VolumeChoice& choice = {}) {
  const std::string text = message_of([&] { read_all(*open_volume(path, {}, choice)); });
  CHECK(text.find('\n') == std::string::npos);
  CHECK_THAT(text, Contains("hint: "));
  return text;
}

/// A filter that leaves chunks as they are and counts how many it is asked to decode.
constexpr H5Z_filter_t counting_id = 400;
std::atomic<int> decoded{0};

size_t count_decoded(unsigned flags, size_t, const unsigned*, size_t bytes, size_t*, void**) {
  if ((flags & H5Z_FLAG_REVERSE) != 0) ++decoded;
  return bytes;
}

void counted(hid_t creation) {
  static const H5Z_class2_t filter{H5Z_CLASS_T_VERS, counting_id, 1,       1,
                                   "counting",       nullptr,     nullptr, count_decoded};
  H5Zregister(&filter);
  H5Pset_filter(creation, counting_id, 0, 0, nullptr);
}

}  // namespace

TEST_CASE("an HDF5 dataset has its voxels whatever its layout, byte order and filters are") {
  std::vector<Hdf5> all(7);
  all[1].creation = [](hid_t id) { H5Pset_layout(id, H5D_COMPACT); };
  all[2].type = H5T_STD_I16BE;
  all[3].chunk = {2, 3, 4};
  all[4].chunk = {2, 3, 4};
  all[4].creation = pack;
  all[5].chunk = {3, 4, 5};
  all[5].type = H5T_STD_I16BE;
  all[5].creation = [](hid_t id) { H5Pset_fletcher32(id); };
  all[6].chunk = {1, 4, 5};
  all[6].creation = [](hid_t id) { H5Pset_scaleoffset(id, H5Z_SO_INT, 0); };
  for (const bool newest : {false, true})
    for (std::size_t k = 0; k < all.size(); ++k) {
      CAPTURE(k, newest);
      const Folder folder;
      const auto source = open_volume(write_hdf5(folder / "a.h5", {all[k]}, newest));
      CHECK(source->concurrent());
      CHECK(source->layer_depth() == (all[k].chunk.empty() ? 1 : int(all[k].chunk[0])));
      CHECK(is_sample(*source));
    }
}

TEST_CASE("HDF5 numbers keep their type, and wide ones become float64 where that is exact") {
  const Folder folder;
  const auto type_of = [&](const Hdf5& dataset) {
    return open_volume(sample_file(folder, dataset))->grid().type;
  };
  CHECK(type_of({.type = H5T_STD_U8LE}) == ScalarType::uint8);
  CHECK(type_of({.type = H5T_STD_U32BE}) == ScalarType::uint32);
  CHECK(type_of({.type = H5T_IEEE_F32BE}) == ScalarType::float32);
  CHECK(type_of({.type = H5T_IEEE_F64LE}) == ScalarType::float64);
  Hdf5 wide{.type = H5T_STD_I64LE};
  CHECK(type_of(wide) == ScalarType::float64);
  CHECK(read_all(*open_volume(sample_file(folder, wide))) != samples<double>());
  const std::int64_t values[2] = {-(std::int64_t{1} << 53), 7};
  wide.dims = {1, 1, 2};
  wide.memory = H5T_NATIVE_INT64;
  wide.voxels.assign(reinterpret_cast<const char*>(values), sizeof(values));
  CHECK(read_all(*open_volume(sample_file(folder, wide))) == bytes_of(-9007199254740992.0) + bytes_of(7.0));
  const std::int64_t large[2] = {std::numeric_limits<std::int64_t>::min(), 7};
  wide.voxels.assign(reinterpret_cast<const char*>(large), sizeof(large));
  CHECK_THAT(refusal(sample_file(folder, wide)), Contains("-9223372036854775808 has no exact float64"));
}

TEST_CASE("truth values and enumerations are labels") {
  const Folder folder;
  const Id type(H5Tenum_create(H5T_STD_I8LE));
  for (std::int8_t value = 0; value < 2; ++value)
    H5Tenum_insert(type.get(), value == 0 ? "FALSE" : "TRUE", &value);
  const Hdf5 dataset{
      .dims = {1, 1, 2}, .type = type.get(), .memory = type.get(), .voxels = std::string("\1\0", 2)};
  const auto source = open_volume(sample_file(folder, dataset));
  CHECK(source->grid().type == ScalarType::int8);
  CHECK(source->notes().labels);
  CHECK(read_all(*source) == std::string("\1\0", 2));
}

TEST_CASE("every chunk is decoded once, by slices in order and by layers") {
  for (const hsize_t depth : {1, 5, 7, 12}) {
    CAPTURE(depth);
    const Folder folder;
    Hdf5 dataset{.dims = {12, 6, 6}, .chunk = {depth, 2, 3}, .creation = counted};
    dataset.voxels.clear();
    for (int n = 0; n < 12 * 6 * 6; ++n) dataset.voxels += bytes_of(short(n));
    const auto path = sample_file(folder, dataset);
    const int chunks = int((12 + depth - 1) / depth) * 3 * 2;
    // As the program does, which does not know this filter.
    std::optional<detail::StoredVoxels> in_place;
    const auto source = detail::read_hdf5(path, {}, in_place);
    CHECK_FALSE(in_place);
    decoded = 0;
    CHECK(read_all(*source) == dataset.voxels);
    CHECK(decoded == chunks);
    decoded = 0;
    std::string all;
    for (int z = 0; z < 12; ++z) all += read_slice(*source, z);
    CHECK(all == dataset.voxels);
    CHECK(decoded == chunks);
  }
}

TEST_CASE("a layer of chunks that is too large for memory is cut into even layers") {
  const Folder folder;
  const auto path = write_hdf5(folder / "large.h5", [](hid_t file) {
    add(file, {.dims = {64, 4096, 4096}, .type = H5T_STD_U8LE, .voxels = "", .chunk = {64, 64, 64}});
    const hsize_t first[3] = {0, 0, 0};
    const std::string chunk(64 * 64 * 64, 'v');
    H5Dwrite_chunk(opened(file, "/volume").get(), H5P_DEFAULT, 0, first, chunk.size(), chunk.data());
  });
  CHECK(open_volume(path)->layer_depth() == 16);  // 256 MiB
}

TEST_CASE("the only volume of an HDF5 file is taken, several are listed") {
  const Folder folder;
  const auto text = [](hid_t file) {
    const Id root(opened(file, "/"));
    put_text(root.get(), "made by", "a test");
  };
  const auto one = write_hdf5(folder / "one.h5", [&](hid_t file) {
    text(file);
    add(file, {.name = "/a/b/volume"});
    add(file, {.name = "/a/table", .dims = {10, 6}});
    add(file, {.name = "/times", .dims = {60}});
  });
  CHECK(read_all(*open_volume(one)) == samples<short>());
  CHECK(read_all(*open_volume(one.string() + ":/a")) == samples<short>());
  CHECK(read_all(*open_volume(one.string() + ":a/b/volume")) == samples<short>());
  CHECK(open_volume(one.string() + ":/a/table")->grid().dims == glm::ivec3(6, 10, 1));
  CHECK_THAT(refusal(one.string() + ":/times"), Contains("no three dimensions"));
  CHECK_THAT(refusal(one.string() + ":/a/c"), Contains("object 'c' doesn't exist"));

  const auto two =
      write_hdf5(folder / "two.h5", {{.name = "/low"}, {.name = "/high", .type = H5T_IEEE_F32LE}});
  CHECK_THAT(refusal(two),
             Contains("two.h5 holds several datasets: /high (3x4x5 float32), /low (3x4x5 int16); "
                      "hint: name one: ") &&
                 Contains("two.h5:/high"));
  std::vector<Hdf5> many;
  for (int k = 0; k < 30; ++k) many.push_back({.name = "/v" + std::to_string(100 + k)});
  CHECK_THAT(refusal(write_hdf5(folder / "many.h5", many)), Contains("/v119") && Contains("and 10 more"));
}

TEST_CASE("a path that exists as a whole comes before a dataset in a file") {
  const Folder folder;
  const auto inner = write_hdf5(folder / "a.h5", {{.name = "/x.h5"}, {.name = "/y"}});
  write_hdf5(folder / "a.h5:x.h5", {{.voxels = std::string(120, 'w')}});
  CHECK(read_all(*open_volume(folder / "a.h5:x.h5")) == std::string(120, 'w'));
  CHECK(read_all(*open_volume(folder / "a.h5:/x.h5")) == samples<short>());
  CHECK_THAT(refusal(folder / "b.h5:/x"), Contains("cannot open"));
}

TEST_CASE("HDF5 is known by its signature, with any ending and behind a user's block") {
  const Folder folder;
  write_hdf5(folder / "plain", {Hdf5{}});
  CHECK(read_all(*open_volume(folder / "plain")) == samples<short>());
  write(folder / "classic.nc", "CDF\1" + std::string(100, '\0'));
  CHECK_THAT(refusal(folder / "classic.nc"), Contains("classic netCDF") && Contains("nccopy -k nc4"));
  fs::rename(folder / "classic.nc", folder / "old.mnc");
  CHECK_THAT(refusal(folder / "old.mnc"), Contains("MINC 1") && Contains("mincconvert -2"));
  write(folder / "old.hdf", "\x0e\x03\x13\x01" + std::string(100, '\0'));
  CHECK_THAT(refusal(folder / "old.hdf"), Contains("HDF4"));
  write(folder / "text.h5", "no HDF5 at all");
  CHECK_THAT(refusal(folder / "text.h5"), Contains("text.h5 is no HDF5 file"));
  write(folder / "block.h5", std::string(512, '\0') + slurp(folder / "plain"));
  CHECK(read_all(*open_volume(folder / "block.h5")) == samples<short>());
}

TEST_CASE("more dimensions are time before and components behind") {
  const Folder folder;
  const std::string other(120, 'w');
  Hdf5 film{
      .dims = {2, nz, ny, nx}, .voxels = samples<short>() + other, .chunk = {1, 2, 4, 5}, .creation = pack};
  const auto path = sample_file(folder, film);
  CHECK(open_volume(path)->notes().frames == 2);
  CHECK(read_all(*open_volume(path)) == samples<short>());
  CHECK(read_all(*open_volume(path, {}, {.frame = 1})) == other);
  CHECK_THAT(refusal(path, {.frame = 2}), Contains("holds 2 volumes"));
  CHECK_THAT(refusal(path, {.channel = "0"}), Contains("one value a voxel"));

  std::string pairs;
  for (std::size_t at = 0; at < 120; at += 2) pairs += "??" + samples<short>().substr(at, 2);
  const auto vectors = sample_file(folder, {.dims = {nz, ny, nx, 2}, .voxels = pairs, .chunk = {1, 4, 5, 2}});
  CHECK(read_all(*open_volume(vectors, {}, {.channel = "1"})) == samples<short>());
  CHECK_THAT(refusal(vectors), Contains("vector of 2 numbers"));
  CHECK_THAT(refusal(sample_file(folder, {.dims = {5, 5, 6, 7, 8}, .voxels = ""})),
             Contains("never written"));
  const auto five =
      sample_file(folder, {.dims = {2, 5, 2, 2, 3}, .voxels = samples<short>() + samples<short>()});
  CHECK(open_volume(five, {}, {.channel = "2"})->notes().frames == 2);
  const auto six = sample_file(folder, {.dims = {2, 5, 2, 2, 3, 5}, .voxels = std::string(1200, 'x')});
  CHECK_THAT(refusal(six), Contains("cannot be told"));
}

TEST_CASE("coordinates give a dataset its place, and turn axes that run down") {
  const Folder folder;
  const auto with_axes = [&](const std::vector<double>& z, const std::string& positive) {
    static int number = 0;
    return write_hdf5(folder / std::to_string(++number), [&](hid_t file) {
      add(file, {.attributes = [](hid_t id) {
            put_text(id, "long_name", "salt");
            put_text(id, "units", "g");
            put_numbers(id, "_FillValue", {-999});
          }});
      add(file, axis("/lev", z, "m"));
      add(file, axis("/lat", {8, 6, 4, 2}, "m"));
      add(file, axis("/lon", {0, 1.5, 3, 4.5, 6}, "m"));
      put_text(opened(file, "/lev").get(), "positive", positive);
      put_scales(file, "/volume", {"/lev", "/lat", "/lon"});
    });
  };
  const auto up = open_volume(with_axes({10, 13, 16}, "up"));
  CHECK(up->grid().spacing == glm::dvec3(1.5, 2, 3));
  CHECK(up->grid().origin == glm::dvec3(0, 8, 10));
  CHECK(up->grid().direction == glm::dmat3({1, 0, 0}, {0, -1, 0}, {0, 0, 1}));
  CHECK(up->notes().unit == "m");
  CHECK(up->notes().quantity == "salt (g)");
  CHECK(up->notes().fill == -999);
  const auto down = open_volume(with_axes({10, 13, 16}, "down"));
  CHECK(down->grid().origin.z == -10);
  CHECK(down->grid().direction[2] == glm::dvec3(0, 0, -1));
  const CapturedLog log;
  const auto uneven = open_volume(with_axes({10, 11, 16}, "up"));
  CHECK(uneven->grid().spacing.z == 3);
  CHECK_THAT(log.text(), Contains("along lev are not evenly spaced"));
}

TEST_CASE("packed values are scaled, and their fill value with them") {
  const Folder folder;
  const auto path = sample_file(
      folder,
      {.dims = {1, 1, 2}, .voxels = bytes_of(short(10)) + bytes_of(short(-1)), .attributes = [](hid_t id) {
         put_numbers(id, "scale_factor", {0.5});
         put_numbers(id, "add_offset", {100});
         put_numbers(id, "_FillValue", {-1});
       }});
  const auto source = open_volume(path);
  CHECK(source->grid().type == ScalarType::float32);
  CHECK(source->notes().fill == 99.5);
  CHECK(read_all(*source) == bytes_of(105.0F) + bytes_of(99.5F));
}

TEST_CASE("MINC's slices have their own scales, its dimensions their directions") {
  const Folder folder;
  const auto minc = [&](const std::vector<hsize_t>& scaled, const std::string& order) {
    return write_hdf5(folder / fmt::format("{}{}.mnc", scaled.size(), order), [&](hid_t file) {
      add(file, {.name = "/minc-2.0/image/0/image", .attributes = [&](hid_t id) {
                   put_text(id, "dimorder", order);
                   put_numbers(id, "valid_range", {-1000, 1000});
                 }});
      const auto numbers = [&](const char* name, const std::vector<double>& values) {
        Hdf5 made = axis(std::string("/minc-2.0/image/0/") + name, values, "");
        made.dims = scaled;
        add(file, made);
      };
      numbers("image-min", {0, -500, -1000});
      numbers("image-max", {1, 500, 3000});
      for (const char* name : {"xspace", "yspace", "zspace"}) {
        add(file, axis(std::string("/minc-2.0/dimensions/") + name, {0}, "mm"));
        const Id said(opened(file, std::string("/minc-2.0/dimensions/") + name));
        put_numbers(said.get(), "step", {name[0] == 'y' ? -2.0 : 3.0});
        put_numbers(said.get(), "start", {name[0] == 'z' ? 30.0 : 10.0});
        if (name[0] == 'z') put_numbers(said.get(), "direction_cosines", {0, 0.6, 0.8});
      }
    });
  };
  const auto source = open_volume(minc({3}, "zspace,yspace,xspace"));
  CHECK(source->grid().type == ScalarType::float32);
  CHECK(source->grid().spacing == glm::dvec3(3, 2, 3));
  CHECK(source->grid().origin == glm::dvec3(-10, -28, 24));
  CHECK(source->grid().direction == glm::dmat3({-1, 0, 0}, {0, 1, 0}, {0, -0.6, 0.8}));
  CHECK(source->notes().world == World::patient);
  const double low[] = {0, -500, -1000}, slope[] = {1.0 / 2000, 0.5, 2};
  for (int z : {2, 0, 1}) {
    const auto bytes = read_slice(*source, z);
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x) {
        const double value = low[z] + slope[z] * (sample<short>(x, y, z) + 1000.0);
        CHECK(reinterpret_cast<const float*>(bytes.data())[y * nx + x] == Approx(value));
      }
  }
  CHECK_THAT(refusal(minc({3, 1}, "zspace,yspace,xspace")), Contains("not scaled slice by slice"));
  CHECK_THAT(refusal(minc({3}, "zspace,yspace")), Contains("dimorder does not name its 3 dimensions"));
  CHECK_THAT(refusal(minc({3}, "zspace,yspace,xfrequency")), Contains("none of space"));
}

TEST_CASE("voxels that lie in other files are refused") {
  const Folder folder;
  write(folder / "voxels.raw", samples<short>());
  const auto outside = folder / "voxels.raw";
  CHECK_THAT(refusal(sample_file(
                 folder, {.voxels = "",
                          .creation = [&](hid_t id) { H5Pset_external(id, outside.c_str(), 0, 120); }})),
             Contains("its voxels lie in other files"));
  write_hdf5(folder / "there.h5", {Hdf5{}});
  const auto linking = write_hdf5(folder / "here.h5", [&](hid_t file) {
    H5Lcreate_external("there.h5", "/volume", file, "link", H5P_DEFAULT, H5P_DEFAULT);
    H5Lcreate_soft("/link", file, "soft", H5P_DEFAULT, H5P_DEFAULT);
  });
  CHECK_THAT(refusal(linking), Contains("holds no dataset"));
  CHECK_THAT(refusal(linking.string() + ":/link"), Contains("links to other files are not followed"));
  CHECK_THAT(refusal(linking.string() + ":/soft"), Contains("links to other files are not followed"));
  const auto gathering =
      sample_file(folder, {.voxels = "", .creation = [&](hid_t id) {
                             const hsize_t dims[3] = {nz, ny, nx};
                             const Id space(H5Screate_simple(3, dims, nullptr));
                             H5Pset_virtual(id, space.get(), "there.h5", "/volume", space.get());
                           }});
  CHECK_THAT(refusal(gathering), Contains("a virtual dataset"));
}

TEST_CASE("what HDF5 lacks or the file does not hold is said") {
  const Folder folder;
  const auto with_filter = [](hid_t id) {
    const unsigned values[1] = {0};
    H5Pset_filter(id, 32015, H5Z_FLAG_OPTIONAL, 1, values);
  };
  CHECK_THAT(refusal(sample_file(folder, {.chunk = {1, 4, 5}, .creation = with_filter})),
             Contains("filter Zstandard (32015)") && Contains("HDF5_PLUGIN_PATH"));
  CHECK_THAT(refusal(sample_file(folder, {.voxels = "", .chunk = {1, 4, 5}})), Contains("never written"));
  const auto cut = sample_file(folder, {.dims = {30, 40, 50}, .voxels = std::string(120'000, 'v')});
  fs::resize_file(cut, 60'000);
  CHECK_THAT(refusal(cut), Contains("a.h5"));
  const auto flipped =
      sample_file(folder, {.chunk = {3, 4, 5}, .creation = [](hid_t id) { H5Pset_fletcher32(id); }});
  std::string bytes = slurp(flipped);
  bytes[bytes.find(samples<short>()) + 20] ^= 1;
  write(flipped, bytes);
  CHECK_THAT(refusal(flipped), Contains("/volume: slices 0 to 2 cannot be read") && Contains("HDF5: "));
}

TEST_CASE("an HDF5 file that changes while it is read is refused") {
  const Folder folder;
  const auto path = sample_file(folder);
  const auto source = open_volume(path);
  fs::last_write_time(path, fs::last_write_time(path) + std::chrono::seconds(5));
  CHECK_THAT(message_of([&] { read_all(*source); }), Contains("has changed since it was opened"));
}

TEST_CASE("voxels that a file holds as they are in one piece are read from it, others decoded") {
  const Folder folder;
  const auto offset_of = [&](const fs::path& file, const VolumeChoice& choice = {}) {
    std::optional<detail::StoredVoxels> found;
    const auto decoded = detail::read_hdf5(file, choice, found);
    const auto read = read_all(*open_volume(file, {}, choice));
    CHECK(read == read_all(*decoded));
    return found ? std::int64_t(found->offset) : -1;
  };
  const auto plain = sample_file(folder);
  CHECK(offset_of(plain) == std::int64_t(slurp(plain).find(samples<short>())));
  const auto big = sample_file(folder, {.type = H5T_STD_I16BE});
  CHECK(offset_of(big) == std::int64_t(slurp(big).find(samples<short>(true))));
  const auto film =
      sample_file(folder, {.dims = {2, nz, ny, nx}, .voxels = samples<short>() + samples<short>()});
  const auto first = offset_of(film);
  CHECK(offset_of(film, {.frame = 1}) == first + std::int64_t(samples<short>().size()));
  CHECK(offset_of(sample_file(folder, {.type = H5T_STD_I32LE})) >= 0);
  CHECK(offset_of(sample_file(folder, {.type = H5T_STD_I64LE})) < 0);
  CHECK(offset_of(sample_file(folder, {.chunk = {1, 4, 5}})) < 0);
}

TEST_CASE("files on which HDF5 itself crashes are refused") {
  const fs::path folder = fs::path(RINGSPLAT_TEST_DATA) / "../fuzz/crashes/hdf5";
  for (const char* name : {"heap_beyond_memory", "object_beyond_memory", "reference_beyond_memory"})
    CHECK_THAT(refusal(folder / name), Contains("hdf5"));
}
