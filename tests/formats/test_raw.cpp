#include <fmt/format.h>

#include "formats/captured_log.hpp"
#include "formats/files.hpp"
#include "formats/formats.hpp"
#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"

using namespace files;

TEST_CASE("names of raw files tell their size and type", "[raw]") {
  const auto named = ringsplat::detail::parse_raw_name("/data/foot_v2_256x255x128_float32.raw");
  REQUIRE(named);
  CHECK(named->dims == glm::ivec3(256, 255, 128));
  CHECK(named->type == ScalarType::float32);
  CHECK_FALSE(ringsplat::detail::parse_raw_name("foot.raw"));
  CHECK_FALSE(ringsplat::detail::parse_raw_name("foot_256x256_uint8.raw"));
  CHECK_THROWS_AS(ringsplat::detail::parse_raw_name("a_1x1x1_int64.raw"), InputError);
}

TEST_CASE("a description completes and overrides the name", "[raw]") {
  const Folder folder;
  const auto path = write(folder / "a_5x4x3_uint8.raw", "??" + samples<short>(true));
  RawDescription raw;
  raw.type = ScalarType::int16;
  raw.offset = 2;
  raw.big_endian = true;
  raw.spacing = glm::dvec3(1, 2, 3);
  const auto source = open_volume(path, raw);
  CHECK(source->concurrent());
  CHECK(source->grid().spacing == glm::dvec3(1, 2, 3));
  CHECK((read_all(*source) == samples<short>()));
}

TEST_CASE("floats that make sense only in the other byte order are warned of", "[raw]") {
  const Folder folder;
  const auto of = [&](auto zero, bool stored_big, double scale) {
    std::string bytes;
    for (int i = 0; i < 60; ++i)
      bytes += bytes_of(decltype(zero)(scale * (i % 7) * (1.0 + i / 61.0)), stored_big);
    return write(folder / (sizeof(zero) == 4 ? "a_5x4x3_float32.raw" : "a_5x4x3_float64.raw"), bytes);
  };
  const auto told = [&](const fs::path& path, bool read_big) {
    const CapturedLog log;
    RawDescription raw;
    raw.big_endian = read_big;
    open_volume(path, raw);
    return log.text();
  };
  for (const bool big : {false, true})
    for (const double scale : {1.0, 1e4}) {
      const std::string right = big ? "give --endian big" : "give --endian little";
      CHECK(told(of(0.0F, big, scale), big).empty());
      CHECK(told(of(0.0, big, scale), big).empty());
      const auto other = folder / fmt::format("{}{}_5x4x3_float32.raw", big, scale);
      fs::rename(of(0.0F, big, scale), other);
      CHECK(says(told(other, !big), right));
    }
  // Densities in g/cm³, as cosmologists have them.
  CHECK(told(of(0.0F, false, 1e-29), false).empty());
}

TEST_CASE("an offset allows bytes behind the voxels, none are allowed without", "[raw]") {
  const Folder folder;
  RawDescription raw;
  raw.dims = glm::ivec3(5, 4, 3);
  raw.type = ScalarType::uint8;
  raw.offset = 0;
  const auto path = write(folder / "a.raw", samples<std::uint8_t>() + "tail");
  CHECK((read_all(*open_volume(path, raw)) == samples<std::uint8_t>()));
  raw.offset.reset();
  const auto complaint = message_of([&] { open_volume(path, raw); });
  CHECK(says(complaint, "needs 60 bytes"));
  CHECK(says(complaint, "has 64"));
}

TEST_CASE("voxels beyond 4 GiB are read from their place", "[raw]") {
  const Folder folder;
  const auto path = folder / "sparse_1024x1024x4100_uint8.raw";
  {
    std::ofstream out(path, std::ios::binary);
    out.seekp(std::streamoff(1024) * 1024 * 4100 - 1);
    out.put('\7');
  }
  const auto source = open_volume(path);
  const auto slice = read_slice(*source, 4099);
  CHECK(slice.back() == '\7');
  CHECK(slice.front() == '\0');
}
