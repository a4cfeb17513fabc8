// Volume files: opened, and read slice by slice if the header is accepted.
#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <stdexcept>
#include <tuple>

#include "formats/amrex.hpp"
#include "formats/files.hpp"
#include "formats/fits.hpp"
#include "formats/formats.hpp"
#include "formats/mgh.hpp"
#include "formats/nifti2.hpp"
#include "formats/npy.hpp"
#include "formats/vti.hpp"
#include "formats/zarr.hpp"
#include "fuzz/driver.hpp"
#include "options/option_list.hpp"
#include "options/option_values.hpp"
#include "ringsplat/formats/open.hpp"

namespace ringsplat::fuzz {
namespace {

using namespace files;

void read(VolumeSource& source, int z, std::span<std::byte> slice, std::byte before) {
  std::fill(slice.begin(), slice.end(), before);
  source.read_slices(z, 1, slice);
}

/// Reads all slices, and the first one twice more over different bytes, to find bytes that the reader leaves
/// unwritten. `available`: bytes of the file and those beside it; each holds at most `ratio` bytes of voxels.
/// A header that promises more must be refused before memory is allocated.
void use(VolumeSource& source, std::uint64_t available, std::uint64_t ratio) {
  const Grid& grid = source.grid();
  check(grid, "the grid");
  if (grid.bytes() / ratio > available)
    throw std::logic_error(fmt::format("a header's {} bytes are believed of {}", grid.bytes(), available));
  constexpr std::uint64_t most_bytes = 8 << 20;
  if (grid.bytes() > most_bytes) return;
  std::vector<std::byte> slice(grid.slice_bytes(Axis::z)), again(slice.size());
  for (int z = 0; z < grid.dims.z; ++z) read(source, z, slice, std::byte{0xA5});
  read(source, 0, slice, std::byte{0xA5});
  read(source, 0, again, std::byte{0x5A});
  if (slice != again) throw std::logic_error("reading a slice twice gives two results");
}

bool is_zipped(std::span<const std::byte> input) { return text_of(input).starts_with("\x1f\x8b"); }

bool contains(std::string_view text, std::string_view part) { return text.find(part) != text.npos; }

/// The sample volume's points from slice z to the next.
Vti vti_piece(int z) {
  Vti piece;
  piece.extent = piece.piece = fmt::format("0 4 0 3 {} {}", z, z + 1);
  piece.arrays = {{"a", "Int16", samples<short>().substr(std::size_t(z) * 40, 80)}};
  return piece;
}

/// The folder of headers and the files that they name.
const fs::path& folder_of_volumes() {
  static const fs::path folder = [] {
    const auto little = samples<short>();
    const fs::path path = scratch() / "volumes";
    if (!fs::create_directory(path)) return path;  // created by the parent process
    write(path / "data.raw", "123" + little);
    write(path / "data.raw.gz", gzip("123" + little));
    write(path / "data.zraw", zlib_stream(little));
    write(path / "a.img", little);
    for (int z = 0; z < nz; ++z) write(path / fmt::format("s{}.bin", z), slice_of_samples(z));
    for (const int z : {0, 1}) write(path / fmt::format("p{}.vti", z), vti_piece(z).file());
    return path;
  }();
  return folder;
}

constexpr std::uint64_t deflate_ratio = 1032, any_ratio = 100'000, bytes_beside = 1024;

void open_and_use(const std::string& name, std::span<const std::byte> input,
                  std::uint64_t ratio = deflate_ratio) {
  use(*open_volume(write(folder_of_volumes() / name, std::string(text_of(input)))),
      input.size() + bytes_beside, ratio);
}

/// `seeds` and the files of tests/data/bad whose names begin with `prefix`.
std::vector<Input> with_kept(const std::string& prefix, std::vector<Input> seeds) {
  std::set<fs::path> paths;  // sorted, as mutations depend on the order of seeds
  for (const auto& entry : fs::directory_iterator(RINGSPLAT_BAD_FILES))
    if (entry.path().filename().string().rfind(prefix, 0) == 0) paths.insert(entry.path());
  for (const auto& path : paths) seeds.push_back(slurp(path));
  return seeds;
}

std::vector<Input> with_header(std::string_view header,
                               const std::vector<std::pair<std::string, std::string>>& rest) {
  std::vector<Input> seeds;
  for (const auto& [fields, data] : rest) seeds.push_back(std::string(header) + fields + data);
  return seeds;
}

std::vector<Input> nrrd_seeds() {
  const auto little = samples<short>(), big = samples<short>(true), bytes = samples<std::uint8_t>();
  std::string hex;
  for (const char c : little) hex += fmt::format("{:02x}", static_cast<unsigned char>(c));
  return with_header(
      "NRRD0004\n# test\ndimension: 3\nsizes: 5 4 3\n",
      {{"type: short\nencoding: raw\nendian: little\nspacings: 1 2 3\n\n", little},
       {"type: unsigned char\nencoding: gzip\n\n", gzip(bytes)},
       {"type: short\nencoding: raw\nendian: big\nspace: left-posterior-superior\nspace directions: (1,0,0) "
        "(0,2,0) (0,0.5,3)\nspace origin: (-1,-2,3.5)\nkinds: domain domain domain\n\n",
        big},
       {"type: int16\nencoding: ascii\n\n", text_of_samples()},
       {"type: short\nencoding: hex\nendian: little\n\n", hex},
       {"type: float\nencoding: raw\nendian: little\nthicknesses: 1 1 1\naxis mins: 0 0 0\nlabels: \"x\" "
        "\"y\" "
        "\"z\"\n\n",
        samples<float>()},
       {"type: short\nencoding: raw\nendian: little\nbyte skip: 3\ndata file: data.raw\n", ""},
       {"type: short\nencoding: raw\nendian: little\nbyte skip: -1\ndata file: data.raw\n", ""},
       {"type: short\nencoding: gzip\nendian: little\nline skip: 0\nbyte skip: 3\ndata file: data.raw.gz\n",
        ""},
       {"type: short\nencoding: raw\nendian: little\ndata file: s%d.bin 0 2 1 2\n", ""},
       {"type: short\nencoding: raw\nendian: little\ndata file: LIST\ns0.bin\ns1.bin\ns2.bin\n", ""}});
}

void run_nrrd(std::span<const std::byte> input) {
  const auto text = text_of(input);
  open_and_use(contains(text, "data file") || contains(text, "datafile") ? "a.nhdr" : "a.nrrd", input);
}

/// With those of time points, vectors and colours.
std::vector<Input> all_nrrd_seeds() {
  auto seeds = nrrd_seeds();
  const auto little = samples<short>();
  const auto with = [&](const std::string& fields) {
    return "NRRD0005\ntype: short\nencoding: raw\nendian: little\n" + fields + "\n" + little;
  };
  for (const auto& more : {with("dimension: 4\nsizes: 5 4 1 3\nkinds: domain domain domain time\n"),
                           with("dimension: 4\nsizes: 3 5 4 1\nkinds: list domain domain domain\n"),
                           with("dimension: 4\nsizes: 3 5 4 1\nkinds: RGB-color space space space\nspace: "
                                "left-anterior-superior\n"
                                "space directions: none (1,0,0) (0,2,0) (0,0.5,3)\n"),
                           "NRRD0005\ntype: uint8\nencoding: gzip\ndimension: 4\nsizes: 5 4 1 3\n\n" +
                               gzip(samples<std::uint8_t>())})
    seeds.push_back(more);
  return seeds;
}

std::vector<Input> meta_seeds() {
  const auto little = samples<short>(), packed = zlib_stream(little);
  return with_kept(
      "meta",
      with_header(
          "ObjectType = Image\nNDims = 3\nDimSize = 5 4 3\nElementType = MET_SHORT\n",
          {{"BinaryData = True\nBinaryDataByteOrderMSB = False\nElementDataFile = LOCAL\n", little},
           {fmt::format("BinaryData = True\nBinaryDataByteOrderMSB = False\nCompressedData = True\n"
                        "CompressedDataSize = {}\nElementDataFile = LOCAL\n",
                        packed.size()),
            packed},
           {"BinaryData = False\nElementDataFile = LOCAL\n", text_of_samples()},
           {"TransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = 1 2 3\nCenterOfRotation = 0 0 0\n"
            "AnatomicalOrientation = RAI\nElementSpacing = 1 2 3\nElementNumberOfChannels = 1\n"
            "BinaryData = True\nBinaryDataByteOrderMSB = True\nHeaderSize = 3\nElementDataFile = data.raw\n",
            ""},
           {"BinaryData = True\nHeaderSize = -1\nElementDataFile = data.raw\n", ""},
           {"ElementNumberOfChannels = 3\nBinaryData = True\nElementDataFile = LOCAL\n",
            little + little + little},
           {"BinaryData = True\nCompressedData = True\nElementDataFile = data.zraw\n", ""},
           {"BinaryData = True\nElementDataFile = s%d.bin 0 2 1\n", ""},
           {"BinaryData = True\nElementDataFile = LIST\ns0.bin\ns1.bin\ns2.bin\n", ""}}));
}

void run_meta(std::span<const std::byte> input) {
  open_and_use(contains(text_of(input), "LOCAL") ? "a.mha" : "a.mhd", input);
}

std::vector<Input> nifti_seeds() {
  const auto little = samples<short>();
  Nifti pair, scaled, floats;
  pair.magic = "ni1";
  pair.offset = 0;
  scaled.slope = 2;
  scaled.intercept = -3;
  floats.datatype = 16;
  floats.bits = 32;
  Nifti four;
  four.dims[0] = 4, four.dims[4] = 2;
  Nifti2 five, colours;
  five.dims[0] = 5, five.dims[3] = 1, five.dims[5] = 3;
  five.sform = 0, five.qform = 1;
  colours.dims[3] = 1;
  colours.datatype = 128;
  return {Nifti().header() + little,       Nifti().header(true) + samples<short>(true),
          gzip(Nifti().header() + little), pair.header().substr(0, 348),
          scaled.header() + little,        floats.header() + samples<float>(),
          four.header() + little + little, Nifti2().header() + little,
          gzip(five.header() + little),    colours.header(true) + samples<std::uint8_t>()};
}

void run_nifti(std::span<const std::byte> input) {
  const auto text = text_of(input);
  const bool pair = text.size() >= 347 && text.substr(344, 3) == "ni1";
  open_and_use(is_zipped(input) ? "a.nii.gz" : pair ? "a.hdr" : "a.nii", input);
}

std::vector<Input> vtk_seeds() {
  const auto header = [](const char* kind, const char* type) {
    return fmt::format(
        "# vtk DataFile Version 3.0\ntest\n{}\nDATASET STRUCTURED_POINTS\nDIMENSIONS 5 4 3\nSPACING 1 2 3\n"
        "ORIGIN 0 0 0\nPOINT_DATA 60\nSCALARS values {} 1\nLOOKUP_TABLE default\n",
        kind, type);
  };
  const std::string vectors =
      "# vtk DataFile Version 3.0\ntest\nBINARY\nDATASET STRUCTURED_POINTS\nDIMENSIONS 5 4 1\nSPACING 1 2 3\n"
      "ORIGIN 0 0 0\nPOINT_DATA 20\nVECTORS values short\n";
  return {header("BINARY", "short") + samples<short>(true), header("ASCII", "short") + text_of_samples(),
          header("BINARY", "unsigned_char") + samples<std::uint8_t>(),
          header("BINARY", "float") + samples<float>(true), vectors + samples<short>(true)};
}

std::vector<Input> npy_seeds() {
  const auto little = samples<short>();
  const std::string bytes = samples<std::uint8_t>();
  return {npy("<i2", "(3, 4, 5)") + little,          npy(">i2", "(3, 4, 5)", 2) + samples<short>(true),
          npy("<i2", "(3, 4, 5)", 3, true) + little, npy("<f2", "(3, 4, 5)") + little,
          npy("|u1", "(1, 4, 5, 3)") + bytes,        npy("|u1", "(3, 1, 4, 5)") + bytes,
          npy("|b1", "(1, 1, 4, 5, 3)") + bytes};
}

std::vector<Input> vti_seeds() {
  std::vector<Input> seeds;
  for (const auto& [format, encoding, compressor] :
       {std::tuple("appended", "raw", ""), std::tuple("appended", "raw", "ZLib"),
        std::tuple("appended", "raw", "LZ4"), std::tuple("appended", "raw", "LZMA"),
        std::tuple("appended", "base64", "ZLib"), std::tuple("binary", "", ""),
        std::tuple("binary", "", "LZ4"), std::tuple("ascii", "", "")}) {
    Vti vti;
    vti.format = format, vti.encoding = encoding, vti.compressor = compressor;
    vti.big_endian = vti.wide_numbers = vti.format == "binary";
    vti.arrays = {{"a", "Int16", vti.format == "ascii" ? text_of_samples() : samples<short>(vti.big_endian)}};
    seeds.push_back(vti.file());
  }
  Vti cells;
  cells.extent = cells.piece = "1 6 0 4 0 1";
  cells.version = "2.2";
  cells.image += " Direction=\"0 1 0 1 0 0 0 0 1\"";
  cells.arrays = {{"rgb", "UInt8", samples<std::uint8_t>(), 3, true}};
  cells.cell_scalars = "rgb";
  seeds.push_back(cells.file());
  seeds.push_back(
      "<VTKFile type=\"ImageData\"><ImageData WholeExtent=\"0 1 0 0 0 2\"><Piece Extent=\"0 1 0 0 0 1\">"
      "<PointData><DataArray type=\"Int8\" Name=\"a\">1 2 3 4</DataArray></PointData></Piece><Piece "
      "Extent=\"0 1 0 "
      "0 1 2\"><PointData><DataArray type=\"Int8\" Name=\"a\">3 4 5 "
      "6</DataArray></PointData></Piece></ImageData>"
      "</VTKFile>");
  seeds.push_back(
      "<VTKFile type=\"PImageData\"><PImageData WholeExtent=\"0 4 0 3 0 2\" GhostLevel=\"0\"><Piece "
      "Extent=\"0 4 0 3 "
      "0 1\" Source=\"p0.vti\"/><Piece Extent=\"0 4 0 3 1 2\" Source=\"p1.vti\"/></PImageData></VTKFile>");
  return seeds;
}

void run_vti(std::span<const std::byte> input) {
  open_and_use(contains(text_of(input), "PImageData") ? "a.pvti" : "a.vti", input, any_ratio);
}

void run_tiff(std::span<const std::byte> input) {
  if (!text_of(input).starts_with("\x89PNG")) return open_and_use("a.tif", input, any_ratio);
  const fs::path folder = folder_of_volumes() / "png";
  fs::create_directories(folder);
  write(folder / "1.png", std::string(text_of(input)));
  use(*open_volume(folder), input.size(), any_ratio);
}

/// A header of words of four bytes, numbered from 1.
std::string mrc(int mode, const std::string& voxels, bool big_endian = false) {
  std::string file(1024, '\0');
  const auto put = [&](std::size_t word, auto value) {
    file.replace(4 * (word - 1), 4, bytes_of(value, big_endian));
  };
  for (const auto& [first, numbers] : {std::pair(std::size_t{1}, std::array{nx, ny, nz, mode}),
                                       std::pair(std::size_t{5}, std::array{0, 1, 2, nx}),
                                       std::pair(std::size_t{9}, std::array{ny, nz, 0, 0})})
    for (std::size_t k = 0; k < numbers.size(); ++k) put(first + k, numbers[k]);
  for (std::size_t k = 0; k < 3; ++k)
    put(11 + k, 10.0F * float(k + 1)), put(14 + k, 90.0F), put(17 + k, int(k + 1));
  put(16, 120.0F);
  put(54, big_endian ? 0x11110000 : 0x4444);
  return file + voxels;
}

std::vector<Input> mrc_seeds() {
  return {mrc(0, samples<std::int8_t>()), mrc(1, samples<short>(true), true), mrc(2, samples<float>()),
          mrc(12, samples<short>()), gzip(mrc(6, samples<short>()))};
}

void run_mrc(std::span<const std::byte> input) {
  open_and_use(is_zipped(input) ? "a.map.gz" : "a.mrc", input, 2 * deflate_ratio);
}

std::vector<Input> mgh_seeds() {
  Mgh bytes, nowhere;
  bytes.type = 0;
  bytes.sizes = {nx, ny, 1, nz};
  nowhere.has_place = false;
  return {Mgh().header() + samples<short>(true), bytes.header() + samples<std::uint8_t>(),
          gzip(nowhere.header() + samples<short>(true))};
}

void run_mgh(std::span<const std::byte> input) { open_and_use(is_zipped(input) ? "a.mgz" : "a.mgh", input); }

std::vector<Input> fits_seeds() {
  const auto big = samples<short>(true);
  const std::map<std::string, std::string> lengths{
      {"CUNIT1", "'kpc'"}, {"CUNIT2", "'kpc'"}, {"CUNIT3", "'kpc'"}, {"CDELT1", "2"},
      {"CDELT2", "-1D0"},  {"CRPIX3", "1"},     {"BLANK", "7"}};
  return {fits_cube(16, lengths) + big, fits_cube(16, {{"BZERO", "32768"}, {"BSCALE", "1"}}) + big,
          fits_cube(-32, {{"NAXIS", "4"}, {"NAXIS4", "1"}}) + samples<float>(true),
          fits({{"NAXIS", "0"}}) + fits_cube(8, {{"PCOUNT", "0"}}, "XTENSION= 'IMAGE   '") +
              samples<std::uint8_t>(),
          gzip(fits_cube(16) + big)};
}

void run_fits(std::span<const std::byte> input) {
  open_and_use(is_zipped(input) ? "a.fits.gz" : "a.fits", input, 2 * deflate_ratio);
}

constexpr std::int64_t most_voxels_in_chunks = 10'000;  // each may be a file

/// Parts: an array's metadata, and the bytes of both its blocks.
std::vector<Input> n5_seeds() {
  const auto block = samples<short>(true).substr(0, 80);
  const auto with_sizes = n5_json({{"2]", R"(2], "resolution": [1, 2, 3], "units": ["nm", "nm", "nm"])"}});
  return {input_of_parts({with_sizes, n5_head(2) + block}),
          input_of_parts({n5_json({{"raw", "gzip"}}), n5_head(2) + gzip(block)}),
          input_of_parts({n5_json({{"raw", "xz"}}), n5_head(2) + xz_stream(block)})};
}

void run_n5(std::span<const std::byte> input) {
  std::string metadata, block;
  take_parts(input, {&metadata, &block});
  const fs::path folder = scratch() / "n5";
  fs::create_directories(folder / "0/0");
  write(folder / "attributes.json", metadata);
  for (const char* name : {"0/0/0", "0/0/1"}) write(folder / name, block);
  const auto source = open_volume(folder);
  if (source->grid().voxels() <= most_voxels_in_chunks)
    use(*source, 4 * block.size() + metadata.size(), any_ratio);
}

/// Parts: an array's metadata, what its group or its attributes say, and the bytes of each chunk.
std::vector<Input> zarr_seeds() {
  const std::string bytes = R"({"name": "bytes", "configuration": {"endian": "little"}})";
  const std::string image = R"({"multiscales": [{"axes": [{"name": "z", "type": "space", "unit": "nanometer"},
 {"name": "y"}, {"name": "x"}], "datasets": [{"path": "0", "coordinateTransformations": [{"type": "scale",
 "scale": [1, 2, 3]}]}]}], "omero": {"channels": [{"label": "a"}]}})";
  const auto version_2 = [](const char* compressor) {
    return std::string(R"({"zarr_format": 2, "shape": [3, 4, 5], "chunks": [2, 4, 5], "dtype": ">i2",
 "compressor": )") +
           compressor + R"(, "fill_value": 7, "order": "F", "dimension_separator": "/", "filters": []})";
  };
  const auto chunk = zarr_chunk(0);
  return {input_of_parts({zarr_json(), image, chunk}),
          input_of_parts({zarr_json({{"}]", zarr_gzip}}), image, gzip(chunk)}),
          input_of_parts({version_2("null"), image, chunk}),
          input_of_parts({version_2(R"({"id": "zlib"})"), image, zlib_stream(chunk)}),
          input_of_parts(
              {zarr_json({{bytes, R"({"name": "sharding_indexed", "configuration": {"chunk_shape": [1, 2, 5],
 "codecs": [{"name": "transpose", "configuration": {"order": [2, 0, 1]}}, {"name": "bytes"}], "index_codecs":
 [{"name": "bytes"}, {"name": "crc32c"}]}})"}}),
               image,
               chunk.substr(0, 60) + bytes_of(0ULL) + bytes_of(20ULL) + bytes_of(20ULL) + bytes_of(20ULL) +
                   bytes_of(~0ULL) + bytes_of(~0ULL) + bytes_of(40ULL) + bytes_of(20ULL) + "abcd"}),
          input_of_parts({version_2(R"({"id": "blosc"})"), image,
                          std::string("\2\1\x33\2\x50\0\0\0\x50\0\0\0\x60\0\0\0", 16) + chunk})};
}

void run_zarr(std::span<const std::byte> input) {
  std::string array, image, values;
  take_parts(input, {&array, &image, &values});
  const fs::path folder = scratch() / "zarr";
  fs::remove_all(folder);
  for (const char* chunk : {"0.0.0", "0/0/0", "c/0/0/0", "c/1/0/0"}) {
    fs::create_directories((folder / "0" / chunk).parent_path());
    write(folder / "0" / chunk, values);
  }
  const bool version_2 = contains(array, "dtype");
  write(folder / "0" / (version_2 ? ".zarray" : "zarr.json"), array);
  write(
      folder / (version_2 ? ".zgroup" : "zarr.json"),
      version_2 ? "{}" : R"({"zarr_format": 3, "node_type": "group", "attributes": {"ome": )" + image + "}}");
  write(folder / ".zattrs", image);
  const auto source = open_volume(folder);
  if (source->grid().voxels() <= most_voxels_in_chunks) use(*source, 4 * values.size(), any_ratio);
}

/// Parts: Header, Cell_H, and the bytes of both files of values.
std::vector<Input> amrex_seeds() {
  std::vector<Input> seeds;
  for (const auto& plot : {Plotfile(), Plotfile(true, true)})
    seeds.push_back(input_of_parts({plot.header, plot.cells, plot.fabs[0], plot.fabs[1]}));
  return seeds;
}

void run_amrex(std::span<const std::byte> input) {
  Plotfile plot;
  take_parts(input, {&plot.header, &plot.cells, &plot.fabs[0], &plot.fabs[1]});
  const auto source = open_volume(plot.write_to(scratch() / "amrex"));
  use(*source, input.size() + bytes_beside, 2);  // boxes may share bytes
}

std::vector<Input> dicom_seeds() {
  Dicom plain, scaled, colour, three;
  plain.pixels = scaled.pixels = samples<short>().substr(0, 40);
  scaled.slope = "0.5";
  scaled.intercept = "-1024";
  colour.samples = 3;
  colour.pixels = samples<short>().substr(0, 120);
  three.pixels = samples<short>();
  scaled.more = Dicom::element(0x8, 0x103E, "LO", "Lung") + Dicom::element(0x20, 0x11, "IS", "2") +
                Dicom::element(0x20, 0x100, "IS", "1") + Dicom::element(0x18, 0x9087, "FD", bytes_of(5.0)) +
                Dicom::element(0x28, 0x1054, "LO", "HU");
  Input frames = three.bytes();
  frames.insert(frames.find(std::string("\x28\0\x10\0", 4)), Dicom::element(0x28, 8, "IS", "3"));
  // Pixels in fragments: an empty table of offsets, one fragment, the end.
  Input packed = plain.bytes();
  packed.replace(packed.find("1.2.840.10008.1.2.1"), 19, std::string("1.2.840.10008.1.2.5"));
  packed.resize(packed.rfind("OW"));
  packed += std::string("OB\0\0\xff\xff\xff\xff", 8) + std::string("\xfe\xff\0\xe0\0\0\0\0", 8) +
            std::string("\xfe\xff\0\xe0\x44\0\0\0", 8) + std::string("\x02\0\0\0\x40\0\0\0", 8) +
            std::string(60, '\0') + std::string("\xfe\xff\xdd\xe0\0\0\0\0", 8);
  return with_kept("dcm", {plain.bytes(), scaled.bytes(), colour.bytes(), frames, packed});
}

void run_dicom(std::span<const std::byte> input) {
  // In a folder of its own, as the reader looks beside it for a series.
  fs::create_directories(folder_of_volumes() / "dicom");
  open_and_use("dicom/a.dcm", input, any_ratio);
}

/// Input: a line with the name, a line of command-line options without dashes, the bytes.
std::vector<Input> raw_seeds() {
  const auto little = samples<short>(), big = samples<short>(true);
  return {"head_5x4x3_int16.raw\n\n" + little,
          "x.bin\ndims=5x4x3 type=int16 endian=big offset=0 spacing=1x2x3\n" + big,
          "x.raw\ndims=5x4x3 type=int16 offset=3\nabc" + little,
          "HEAD_5X4X3_u8.RAW\nspacing=0.5\n" + samples<std::uint8_t>()};
}

std::string take_line(std::string_view& text) {
  const auto end = std::min(text.find('\n'), text.size());
  const std::string line(text.substr(0, end));
  text.remove_prefix(std::min(end + 1, text.size()));
  return line;
}

RawDescription description_of(const std::string& line) {
  RawDescription raw;
  std::istringstream words(line);
  for (std::string word; words >> word;) {
    const auto equals = std::min(word.find('='), word.size());
    const std::string key = word.substr(0, equals), value = word.substr(std::min(equals + 1, word.size()));
    if (key == "dims") raw.dims = app::parse_dims(value, "--dims");
    if (key == "type") raw.type = scalar_type_from(value);
    if (key == "endian") raw.big_endian = value == "big";
    if (key == "spacing") raw.spacing = app::parse_spacing(value, "--spacing");
    if (key == "offset") raw.offset = std::uint64_t(app::read_number<int>(value, "--offset"));
  }
  return raw;
}

void run_raw(std::span<const std::byte> input) {
  auto text = text_of(input);
  std::string name = take_line(text);
  constexpr std::size_t longest_name = 255;  // bytes, on most file systems
  name.resize(std::min(name.size(), longest_name));
  static_cast<void>(detail::parse_raw_name(name));
  const RawDescription raw = description_of(take_line(text));
  // A name without folders that the file system accepts.
  std::replace_if(
      name.begin(), name.end(), [](char c) { return c == '/' || c == '\0'; }, '_');
  const fs::path folder = folder_of_volumes() / "raw";
  fs::remove_all(folder);  // of the last input
  fs::create_directories(folder);
  const fs::path path = write(folder / ("n" + name.substr(0, 200)), std::string(text));
  use(*open_volume(path, raw), input.size(), 1);
}

using Words = std::vector<std::string_view>;

// Lists of words, as many to a line as fit.
// clang-format off
const Words nrrd_words{
    "type: ", "encoding: ", "endian: ", "sizes: ", "dimension: ", "spacings: ", "space directions: ",
    "(1,0,0)", "none", "space: ", "space dimension: 3", "space origin: ", "data file: ", "LIST",
    "byte skip: ", "line skip: ", "gzip", "bzip2", "ascii", "hex", "raw", "little", "big", "kinds: ",
    "vector", "domain", "block", "block size: ", "double", "int64", "uint", "%d", "%n", "%s", "%100000d",
    "content: ", "key:=value", "NRRD0005", "NRRD0001", "centerings: cell", "units: \"mm\"",
    "measurement frame: ", "min: ", "max: ", "old min: ", "sample units: ", "number: ", "-", "a.nhdr", ".",
    "/dev/null", "left-posterior-superior-time", "scanner-xyz"};
const Words meta_words{
    "NDims = ", "DimSize = ", "ElementType = ", "MET_UCHAR", "MET_FLOAT", "MET_LONG_LONG", "MET_UCHAR_ARRAY",
    "ElementDataFile = ", "LOCAL", "LIST", "LIST 2", "%d", "%s%n", "%100000d", "s%d.bin", "HeaderSize = ",
    "CompressedData = True", "CompressedDataSize = ", "BinaryData = False", "ElementNumberOfChannels = ",
    "BinaryDataByteOrderMSB = True", "ElementSpacing = ", "ElementSize = ", "Offset = ", "TransformMatrix = ",
    "ElementToIntensityFunctionSlope = ", "Modality = ", "ObjectType = ", "ObjectSubType = ", "Color = ",
    "AnatomicalOrientation = ", "Comment = ", "Name = ", "ID = ", "Orientation = ", "Rotation = ", "a.mhd",
    "data.zraw", "."};
const Words nifti_words{"n+1", "ni1", "n+2", "\x1f\x8b", "\x5c\x01", "\x01\x5c", "\x1c\x02", "\x02\x1c"};
const Words dicom_words{
    "DICM", "OW", "OB", "UN", "SQ", "US", "1.2.840.10008.1.2", "1.2.840.10008.1.2.2",
    "1.2.840.10008.1.2.1.99", "1.2.840.10008.1.2.4.50", "1.2.840.10008.1.2.4.70", "1.2.840.10008.1.2.4.90",
    "1.2.840.10008.1.2.5", "MONOCHROME1", "RGB", "PALETTE COLOR", "\xff\xff\xff\xff", "\xfe\xff\xdd\xe0",
    "\xfe\xff\x0d\xe0", "\xe0\x7f\x10"};
const Words tiff_words{
    "II", "MM", "ImageJ=", "images=", "channels=", "slices=", "frames=", "spacing=", "unit=um\n", "<OME", "<Pixels ",
    "DimensionOrder=\"XYTZC\"", "SizeC=\"", "SizeZ=\"", "SizeT=\"", "<TiffData ", "IFD=\"", "FirstC=\"", "FirstZ=\"",
    "PlaneCount=\"", "<!--", "-->", "<Channel ", "SamplesPerPixel=\"3\"", "PhysicalSizeX=\"", "1e-308", "/>",
    "9223372036854775807", "-1"};
const Words vtk_words{
    "ASCII", "BINARY", "DATASET STRUCTURED_POINTS", "DIMENSIONS ", "SPACING ", "ORIGIN ", "ASPECT_RATIO ",
    "POINT_DATA ", "CELL_DATA ", "SCALARS values ", "COLOR_SCALARS values 3", "VECTORS values float",
    "TENSORS values float", "LOOKUP_TABLE default", "unsigned_char", "unsigned_short", "int", "long",
    "double", "bit", "vtktypeint64", "FIELD FieldData 1", "STRUCTURED_GRID", "# vtk DataFile Version 5.1"};
const Words vti_words{
    "ImageData", "WholeExtent=\"", "Extent=\"", "Direction=\"1 0 0 0 1 0 0 0 1\"", "Spacing=\"1 1 1\"", "Origin=\"", "<Piece ",
    "</Piece>", "PointData", "CellData", "Scalars=\"", "<DataArray ", "type=\"UInt8\"", "Float64", "Int64", "format=\"",
    "ascii", "binary", "appended", "offset=\"", "NumberOfComponents=\"3\"", "encoding=\"base64\"", "raw",
    "compressor=\"vtkZLibDataCompressor\"", "vtkLZ4DataCompressor", "vtkLZMADataCompressor", "header_type=\"UInt64\"",
    "PImageData", "GhostLevel=\"1\"", "Source=\"p0.vti\"", "byte_order=\"BigEndian\"", "<AppendedData ", "_", "<!DOCTYPE x [<!ENTITY a \"b\">]>", "&a;", "<!-- -->", "<![CDATA["};
const Words npy_words{
    "\x93NUMPY", "{", "}", "'descr': ", "'fortran_order': ", "True", "False", "'shape': ", "(", ")", ",", ", }", "<f4",
    ">f8", "|u1", "<i8", "|O", "<f2", "=i4", "3L", "(3, 4, 5, 1)", "4294967296", "2147483647"};
const Words hdf5_words{
    "TREE", "SNOD", "HEAP", "GCOL", "OHDR", "OCHK", "FRHP", "BTHD", "FADB", "EADB", "volume", "DIMENSION_LIST",
    "VTKHDF", "WholeExtent", "gridSpacing", "_FillValue", "\xff\xff\xff\xff\xff\xff\xff\xff"};
const Words zarr_words{
    "zarr_format", "node_type", "array", "group", "shape", "chunk_grid", "chunk_shape", "chunk_key_encoding", "separator", "fill_value",
    "NaN", "-Infinity", "0x7fc00000", "codecs", "bytes", "transpose", "order", "blosc", "zstd", "gzip", "lz4", "crc32c",
    "sharding_indexed", "index_codecs", "index_location", "start", "float16", "float64", "int64", "uint64", "bool", "<f4", "|u1", "<i8",
    "dimension_names", "axes", "channel", "time", "\"t\"", "\"c\"", "datasets", "path", "..", "scale", "translation", "ome", "null"};
const Words n5_words{
    "dimensions", "blockSize", "dataType", "compression", "type", "raw", "gzip", "zstd", "blosc", "xz", "lz4", "resolution",
    "pixelResolution", "unit", "units", "axes", "\"c\"", "\"t\"", "uint8", "int64", "float64", "1e9", "-1", "null", "\0\0\0\3"};
const Words fits_words{
    "SIMPLE  = T", "END     ", "BITPIX  = ", "NAXIS   = ", "NAXIS1  = ", "NAXIS4  = ", "BSCALE  = ", "BZERO   = ", "BLANK   = ",
    "XTENSION= 'IMAGE   '", "'BINTABLE'", "PCOUNT  = ", "GCOUNT  = ", "CUNIT1  = 'm'", "CDELT1  = ", "-32", "-64", "2147483647", "/"};
const Words amrex_words{
    "HyperCLaw-V1.1", "((0,0,0) (4,3,2) (0,0,0))", "(1,1,1)", "FabOnDisk: ", "Cell_D_00000", "..", "/", "FAB ", "8 7 6 5 4 3 2 1",
    "1e300", "nan", "-536870912", "536870912", "65536", "18446744073709551615", "(1,0,0)", "\n"};
const Words raw_words{
    "dims=", "type=", "endian=", "offset=", "spacing=", "big", "little", "uint8", "float", "float64", "5x4x3",
    "_5x4x3_int16.raw", "1x1x1", "x"};
// clang-format on

}  // namespace

std::vector<Driver> volume_drivers() {
  folder_of_volumes();  // made here, so that no child makes its own
  return {{"nrrd", run_nrrd, all_nrrd_seeds, nrrd_words, 6000},
          {"meta", run_meta, meta_seeds, meta_words, 6000},
          {"nifti", run_nifti, nifti_seeds, nifti_words, 6000},
          {"dicom", run_dicom, dicom_seeds, dicom_words, 800},
          {"tiff", run_tiff, tiff_seeds, tiff_words, 800},
          {"vtk", [](auto input) { open_and_use("a.vtk", input); }, vtk_seeds, vtk_words, 6000},
          {"vti", run_vti, vti_seeds, vti_words, 6000},
          {"npy", [](auto input) { open_and_use("a.npy", input, 2); }, npy_seeds, npy_words, 6000},
          {"hdf5", [](auto input) { open_and_use("a.h5", input, any_ratio); }, hdf5_seeds, hdf5_words, 800},
          {"mrc", run_mrc, mrc_seeds, {"MAP ", "IMOD", "DD\x11\x11", "\x1f\x8b"}, 6000},
          {"mgh", run_mgh, mgh_seeds, {"\x1f\x8b", std::string_view("\0\0\0\1", 4), "\x7f\xc0"}, 6000},
          {"fits", run_fits, fits_seeds, fits_words, 6000},
          {"n5", run_n5, n5_seeds, n5_words, 1000},
          {"zarr", run_zarr, zarr_seeds, zarr_words, 400},
          {"amrex", run_amrex, amrex_seeds, amrex_words, 1500},
          {"raw", run_raw, raw_seeds, raw_words, 1500}};
}

}  // namespace ringsplat::fuzz
