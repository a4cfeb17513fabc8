// Zarr stores that are damaged, hostile or more than one volume. What libraries write is in tests/files.
#include "formats/bad_files.hpp"
#include "formats/zarr.hpp"

using namespace files;

namespace {

using Changes = std::map<std::string, std::string>;

Bad array(const char* what, const char* message, const Changes& changes) {
  return {what, message, [=](const Folder& f) { return write_zarr(f / "a.zarr", zarr_json(changes)); }};
}

const std::string bytes_codec = R"({"name": "bytes", "configuration": {"endian": "little"}})";
const std::string order = R"({"name": "transpose", "configuration": {"order": )";

/// All slices of a file in one shard, with chunks of one slice.
std::string sharded_json(const std::string& index = R"("index_codecs": [{"name": "bytes"}])") {
  return zarr_json({{"chunk_shape\": [2, 4, 5]", "chunk_shape\": [4, 4, 5]"},
                    {bytes_codec, R"({"name": "sharding_indexed", "configuration": {"chunk_shape": [1, 4, 5],
 "codecs": [{"name": "bytes"}], )" + index +
                                      "}}"}});
}

std::string place(std::uint64_t offset, std::uint64_t bytes) { return bytes_of(offset) + bytes_of(bytes); }

const std::string nowhere = std::string(16, '\xff');

fs::path write_shard(const fs::path& folder, const std::string& shard) {
  write_zarr(folder, sharded_json());
  write(folder / "c/0/0/0", shard);
  return folder;
}

Bad shard(const char* what, const char* message, const std::string& bytes) {
  return {what, message, [=](const Folder& f) { return write_shard(f / "a.zarr", bytes); }};
}

std::string image_json(const std::string& path, const std::string& scale = "[1, 2, 3]") {
  return R"({"zarr_format": 3, "node_type": "group", "attributes": {"ome": {"multiscales": [{"axes":
 [{"name": "z", "type": "space"}, {"name": "y"}, {"name": "x"}], "datasets": [{"path": ")" +
         path + R"(", "coordinateTransformations": [{"type": "scale", "scale": )" + scale + "}]}]}]}}}";
}

Bad image(const char* what, const char* message, const std::string& json) {
  return {what, message, [=](const Folder& f) {
            write_zarr(f / "a.zarr/0", zarr_json());
            write(f / "a.zarr/zarr.json", json);
            return f / "a.zarr";
          }};
}

const std::string group_json = R"({"zarr_format": 3, "node_type": "group"})";

}  // namespace

TEST_CASE("sizes and types that no array has are clear errors", "[bad]") {
  check_all({
      array("no JSON", "a.zarr/zarr.json: it is no JSON", {{"{\"zarr_format\"", "\"zarr_format\""}}),
      array("a list", "a.zarr/zarr.json: it is no JSON", {{"{\"zarr_format\"", "[{\"zarr_format\""}}),
      array("no shape",
            "its metadata cannot be read: [json.exception.out_of_range.403] key 'shape' not found",
            {{"\"shape\"", "\"shapes\""}}),
      array("a negative size", "zarr.json: -3 is no size", {{"[3,", "[-3,"}}),
      array("no size", "zarr.json: 0 is no size", {{"[3,", "[0,"}}),
      array("an endless size", "zarr.json: 1e+300 is no size", {{"[3,", "[1e300,"}}),
      array("a size in words", "type must be number, but is string", {{"[3,", "[\"3\","}}),
      array("one axis", "zarr.json: it has 1 axes", {{"[3, 4, 5]", "[3]"}}),
      array("many axes", "zarr.json: it has 17 axes", {{"[3, 4, 5]", "[1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1]"}}),
      array("chunks of other axes", "its shape does not fit its chunks", {{"[2, 4, 5]", "[2, 4]"}}),
      array("endless chunks", "its chunks are too large",
            {{"[2, 4, 5]", "[2147483647, 2147483647, 2147483647]"}}),
      array("more voxels than files hold", "cannot hold", {{"[3, 4, 5]", "[200000, 200000, 200]"}}),
      array("larger chunks than the file", "a.zarr/c/0/0/0: its chunks are damaged", {{"[2, 4", "[2000, 4"}}),
      array("texts", "its values are of type 'string'", {{"int16", "string"}}),
      array("complex numbers", "are of type 'complex64'; hint: only integers", {{"int16", "complex64"}}),
      array("a fill value beyond the type", "its fill value is 70000, which int16 does not hold",
            {{"\"fill_value\": 0", "\"fill_value\": 70000"}}),
      array("a fill value in words", "its fill value is 'much'",
            {{"\"fill_value\": 0", "\"fill_value\": \"much\""}}),
      array("a separator that leads elsewhere", "'/../' is no separator of numbers",
            {{"separator\": \"/\"", "separator\": \"/../\""}}),
      array("an unknown codec", "its codec 'bz2' is not read there; hint: write it anew, compressed by",
            {{"}}]", "}}, {\"name\": \"bz2\"}]"}}),
      array("two compressors", "its codec 'zstd' is not read there",
            {{"}}]", "}}, {\"name\": \"gzip\"}, {\"name\": \"zstd\"}]"}}),
      array("a codec without a name", "cannot use at() with number", {{"}}]", "}}, 3]"}}),
      array("axes in no order", "it transposes other axes than it has",
            {{bytes_codec, order + "[0, 1, 1]}}, " + bytes_codec}}),
      array("fewer axes in order", "it transposes other axes than it has",
            {{bytes_codec, order + "[1, 0]}}, " + bytes_codec}}),
      {"filters", "its filters change the values",
       [](const Folder& f) {
         return write(f / ".zarray", R"({"zarr_format": 2, "shape": [3, 4, 5], "chunks": [3, 4, 5],
 "dtype": "<i2", "compressor": null, "fill_value": 0, "order": "C", "filters": [{"id": "delta"}]})"),
                f.path();
       }},
  });
}

TEST_CASE("damaged chunks are errors that name their file", "[bad]") {
  const auto damaged = [](const char* what, const char* message, const std::string& chunk) {
    return Bad{what, message, [=](const Folder& f) {
                 write_zarr(f / "a.zarr", zarr_json({{"}]", zarr_gzip}}), gzip);
                 write(f / "a.zarr/c/1/0/0", chunk);
                 return f / "a.zarr";
               }};
  };
  const auto packed = gzip(zarr_chunk(1)), slices = samples<short>() + std::string(40, 'x');
  const auto whole = place(0, 40) + place(40, 40) + place(80, 40);
  check_all({
      damaged("cut short", "a.zarr/c/1/0/0: the compressed data is cut short or damaged",
              packed.substr(0, packed.size() - 20)),
      damaged("overwritten", "a.zarr/c/1/0/0: the compressed data is cut short or damaged", "hello"),
      damaged("empty", "a.zarr/c/1/0/0: ", ""),
      damaged("another checksum", "c/1/0/0: the compressed data is cut short or damaged",
              packed.substr(0, packed.size() - 8) + "12345678"),
      shard("a shard without an index", "a.zarr/c/0/0/0: its chunks are not all in its index", "hello"),
      shard("a shard with a chunk outside", "do not lie within it", slices + place(200, 40) + whole),
      shard("a shard with an endless chunk", "do not lie within it", slices + place(40, ~0ULL - 1) + whole),
      shard("a shard with a short chunk", "its chunks are damaged", slices + place(0, 39) + whole),
  });
}

TEST_CASE("groups and images that lead to no array, or to several, are clear errors", "[bad]") {
  check_all({
      image("a level elsewhere", "a.zarr/zarr.json: its level '../b' leads out of the store",
            image_json("../b")),
      image("a level anywhere", "its level '/tmp' leads out of the store", image_json("/tmp")),
      image("an image that is its own level", "a.zarr/zarr.json: its level '.' leads to no array",
            image_json(".")),
      image("a level that is not there", "its level '1' leads to no array", image_json("1")),
      image("other axes", "its scales and translations do not fit its axes", image_json("0", "[1, 2]")),
      image("a size in words", "type must be number, but is string", image_json("0", "[1, \"2\", 3]")),
      image("no size", "spacing", image_json("0", "[1, 0, 3]")),
      {"an empty group", "the group holds none; hint: name the folder of an array or an image",
       [](const Folder& f) { return write(f / "zarr.json", group_json), f.path(); }},
      {"several arrays", "the group holds several: a, b; hint: name the folder of an array or an image",
       [](const Folder& f) {
         for (const char* array : {"a", "b"}) write_zarr(f / array, zarr_json());
         return write(f / "zarr.json", group_json), f.path();
       }},
  });
}

TEST_CASE("a Zarr array is read in layers of chunks, in any parts") {
  const Folder folder;
  for (const bool packed : {false, true}) {
    const auto json = packed ? zarr_json({{"}]", zarr_gzip}}) : zarr_json();
    const auto source = open_volume(write_zarr(folder / (packed ? "a" : "b"), json, packed ? gzip : nullptr));
    CHECK(source->concurrent());
    CHECK(source->layer_depth() == 2);
    CHECK(is_sample(*source));
  }
}

TEST_CASE("chunks that are in no file, or not in a shard, have the fill value") {
  const Folder folder;
  const auto fill = [](int n) {
    std::string text;
    for (int k = 0; k < n; ++k) text += bytes_of(short(-7));
    return text;
  };
  const auto minus = zarr_json({{"\"fill_value\": 0", "\"fill_value\": -7"}});
  fs::remove(write_zarr(folder / "a", minus) / "c/0/0/0");
  CHECK(read_all(*open_volume(folder / "a")) == fill(40) + samples<short>().substr(80));

  const auto shard =
      write_shard(folder / "b", samples<short>() + place(80, 40) + nowhere + place(0, 40) + nowhere);
  CHECK(read_all(*open_volume(shard)) ==
        samples<short>().substr(80, 40) + std::string(40, '\0') + slice_of_samples(0));
}

TEST_CASE("the level of an image has the image's place, wherever it is opened from") {
  const Folder folder;
  write_zarr(folder / "a.zarr/0", zarr_json());
  write(folder / "a.zarr/zarr.json", image_json("0"));
  for (const char* name : {"a.zarr", "a.zarr/", "a.zarr/0", "a.zarr/../a.zarr/0/"}) {
    const auto source = open_volume(folder / name);
    CHECK(source->grid().spacing == glm::dvec3(3, 2, 1));
    CHECK(source->notes().world == World::microscope);
    CHECK(source->notes().unit.empty());
  }
}

TEST_CASE("of an image's levels the finest that fits is shown, unless one is named") {
  const Folder folder;
  write_zarr(folder / "a.zarr/0", zarr_json());
  write_zarr(folder / "a.zarr/1", zarr_json({{"[3, 4, 5]", "[2, 2, 3]"}}));
  const std::string finest = R"(0", "coordinateTransformations": []}, {"path": "1)";
  write(folder / "a.zarr/zarr.json", image_json(finest, "[2, 2, 2]"));
  const auto dims_and_level = [&](const char* name, std::optional<double> memory, bool coarser = false) {
    VolumeChoice choice;
    choice.memory = memory;
    choice.coarser = coarser;
    const auto source = open_volume(folder / name, {}, choice);
    std::string level;
    for (const auto& fact : source->facts())
      if (fact.field == "level") level = fact.value;
    return fmt::format("{} {}", source->grid().slices(Axis::x), level);
  };
  constexpr double bytes_of_finest = 2 * 3 * 4 * 5;
  CHECK(dims_and_level("a.zarr", std::nullopt) == "5 1 of 2");
  CHECK(dims_and_level("a.zarr", bytes_of_finest) == "5 1 of 2");
  CHECK(dims_and_level("a.zarr", bytes_of_finest - 1) == "3 2 of 2");
  CHECK(dims_and_level("a.zarr", 1) == "3 2 of 2");
  CHECK(dims_and_level("a.zarr/0", 1) == "5 1 of 2");
  CHECK(dims_and_level("a.zarr/1", std::nullopt) == "3 2 of 2");
  CHECK(dims_and_level("a.zarr", std::nullopt, true) == "3 2 of 2");
  CHECK(dims_and_level("a.zarr", 1, true) == "3 2 of 2");  // there is no coarser one
  CHECK(dims_and_level("a.zarr/0", std::nullopt, true) == "5 1 of 2");
}

namespace {

/// The sample volume in N5, in two blocks, each behind a head; what a test changes are words of the metadata.
fs::path write_n5(const fs::path& folder, const Changes& changes = {}, const std::string& head = n5_head(1)) {
  fs::create_directories(folder / "0/0");
  write(folder / "attributes.json", n5_json(changes));
  write(folder / "0/0/0", n5_head(2) + samples<short>(true).substr(0, 80));
  write(folder / "0/0/1", head + samples<short>(true).substr(80));
  return folder;
}

Bad n5(const char* what, const char* message, const Changes& changes, const std::string& head = n5_head(1)) {
  return {what, message, [=](const Folder& f) { return write_n5(f / "a.n5", changes, head); }};
}

}  // namespace

TEST_CASE("an N5 array may have blocks that are not there", "[zarr]") {
  const Folder folder;
  const auto path = write_n5(folder / "a.n5");
  CHECK((read_all(*open_volume(path)) == samples<short>()));
  fs::remove(path / "0/0/1");
  CHECK((read_all(*open_volume(path)) == samples<short>().substr(0, 80) + std::string(40, '\0')));
}

TEST_CASE("N5 arrays that are damaged are refused", "[bad]") {
  const std::string block = "its chunks are not of the size that the metadata say";
  check_all({
      n5("no type", "key 'dataType' not found", {{"dataType", "type"}}),
      n5("objects", "values are of type 'object'", {{"int16", "object"}}),
      n5("no sizes", "0 is no size", {{"[5, 4, 3]", "[5, 0, 3]"}}),
      n5("two sizes", "its shape does not fit its chunks", {{"[5, 4, 2]", "[5, 4]"}}),
      n5("LZ4 in frames", "its codec 'LZ4 in frames' is not read there", {{"raw", "lz4"}}),
      n5("steps", "its metadata cannot be read",
         {{"\"dataType", "\"resolution\": [1, \"two\", 3], \"dataType"}}),
      n5("no step", "spacing 0 2 3", {{"\"dataType", "\"resolution\": [0, 2, 3], \"dataType"}}),
      n5("kind of block", "have other axes than the array", {},
         std::string("\0\1\0\3", 4) + n5_head(1).substr(4)),
      n5("axes of a block", "have other axes than the array", {},
         std::string("\0\0\0\2", 4) + n5_head(1).substr(4)),
      n5("small block", block.c_str(), {}, n5_head(0)),
      n5("large block", block.c_str(), {}, n5_head(3)),
      n5("block of more than there is", "damaged, or not of the size", {}, n5_head(2)),
      n5("no head", "have other axes than the array", {}, ""),
      n5("no gzip", "cut short or damaged", {{"raw", "gzip"}}),
  });
}
