#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/byte_order.hpp"
#include "base/input_file.hpp"
#include "base/text.hpp"
#include "formats/channels.hpp"
#include "formats/formats.hpp"
#include "formats/limits.hpp"
#include "formats/stored_source.hpp"
#include "ringsplat/base/error.hpp"
#include "volume/forwarding_source.hpp"

namespace ringsplat::detail {
namespace {

/// The header of a NumPy array file (NumPy Enhancement Proposal 1, "numpy.lib.format"): a Python dictionary.
struct NpyHeader {
  ScalarType type = ScalarType::uint8;
  bool half = false;  ///< the voxels are binary16; `type` is uint16
  bool big_endian = false;
  bool fortran_order = false;       ///< the first axis is the fastest, else the last
  std::vector<std::int64_t> shape;  ///< as NumPy has it
  std::uint64_t end = 0;            ///< the byte after the header
};

constexpr std::size_t longest_header = 64 << 10;  // bytes; NumPy itself reads 10000

/// The text of Python's dictionary {'descr': '<f4', 'fortran_order': False, 'shape': (3, 4, 5), } as JSON.
std::string as_json(const std::string& dictionary) {
  std::string json;
  for (const char c : dictionary) {
    const bool closes = c == ')' || c == ']' || c == '}';
    if (std::isspace(static_cast<unsigned char>(c)) != 0) continue;
    if (c == 'L' && !json.empty() && std::isdigit(static_cast<unsigned char>(json.back())) != 0)
      continue;  // Python 2
    if (closes && json.ends_with(',')) json.pop_back();
    json += c == '\'' ? '"' : c == '(' ? '[' : c == ')' ? ']' : c;
    for (const auto& [python, word] : {std::pair("True", "true"), std::pair("False", "false")})
      if (json.ends_with(python)) json.replace(json.size() - std::strlen(python), std::string::npos, word);
  }
  return json;
}

void read_type(const std::string& descr, const std::filesystem::path& path, NpyHeader& header) {
  const auto name = std::string_view(descr).substr(descr.empty() ? 0 : 1);
  const auto* const known = number_type(name);
  const bool whole = name == "i8" || name == "u8";
  if (known == nullptr || whole || name != known->code ||
      std::string_view("<>|=").find(descr[0]) == std::string_view::npos)
    refuse(path,
           whole ? "64-bit numbers are not held exactly: save a.astype(np.int32) or a.astype(np.float32)"
                 : "save an array of real numbers of at most 32 bits or float64",
           "voxels of type '{}' cannot be rendered", excerpt(descr));
  header.half = name == "f2";
  header.type = header.half ? ScalarType::uint16 : known->type;
  header.big_endian = descr[0] == '>' || (descr[0] == '=' && std::endian::native == std::endian::big);
}

void read_dictionary(const std::string& text, const std::filesystem::path& path, NpyHeader& header) {
  const auto found = nlohmann::json::parse(as_json(text), nullptr, false);
  const bool sound = text.find(char(0)) == std::string::npos && found.is_object() && found.size() == 3 &&
                     found.contains("descr") && found.contains("fortran_order") && found.contains("shape") &&
                     found["fortran_order"].is_boolean() && found["shape"].is_array() &&
                     (found["descr"].is_string() || found["descr"].is_array());
  const auto is_size = [](const nlohmann::json& size) { return size.is_number_unsigned(); };
  if (!sound || !std::all_of(found["shape"].begin(), found["shape"].end(), is_size))
    throw InputError(fmt::format("{} has no readable NumPy header: '{}'", path.string(), excerpt(text)),
                     "write it with numpy.save");
  if (found["descr"].is_array())
    refuse(path, "save one of them: np.save('volume.npy', a['FIELD'])", "its array has several named fields");
  read_type(found["descr"], path, header);
  header.fortran_order = found["fortran_order"];
  header.shape = found["shape"].get<std::vector<std::int64_t>>();
}

/// Throws InputError for damaged headers, and for types that no volume may have, with what to do.
NpyHeader read_npy_header(const std::filesystem::path& path) {
  const InputFile file(path);
  std::array<unsigned char, 12> start{};
  const auto got = file.read_some(0, std::as_writable_bytes(std::span(start)));
  constexpr std::string_view magic = "\x93NUMPY";
  if (got < start.size() || std::memcmp(start.data(), magic.data(), magic.size()) != 0 || start[6] < 1 ||
      start[6] > 3)
    refuse(path, "write it with numpy.save", "it is no NumPy array file of format 1 to 3");
  // Two bytes in format 1, four since.
  const BinaryFields fields(std::as_bytes(std::span(start)), false);
  const std::uint64_t length = start[6] > 1 ? fields.at<std::uint32_t>(8) : fields.at<std::uint16_t>(8);
  const std::uint64_t begin = start[6] > 1 ? 12 : 10;
  if (length > longest_header || begin + length > file.size())
    refuse(path, "write it with numpy.save", "its NumPy header of {} bytes is cut short or endless", length);
  std::string text(std::size_t(length), '\0');
  file.read(begin, std::as_writable_bytes(std::span(text)));
  NpyHeader header;
  header.end = begin + length;
  read_dictionary(text, path, header);
  return header;
}

/// Which of the array's axes are what: [frame][z][y][x][component]; missing ones have 1.
struct Axes {
  int frames = 1, components = 1;
  glm::ivec3 dims{1};
};

std::string text_of(const std::vector<std::int64_t>& shape) { return fmt::format("({})", joined(shape)); }

/// Of four or five axes the last one is of components when it is as short as a colour's.
Axes axes_of(const NpyHeader& header, const std::filesystem::path& path) {
  constexpr const char* order = "axes are [z][y][x], [frame][z][y][x] or [z][y][x][1 to 4 components]";
  constexpr std::int64_t most_components = 4;
  auto sizes = mapped(header.shape, [&](std::int64_t size) {
    if (size < 1 || size > std::numeric_limits<int>::max())
      refuse(path, "every axis must have a size from 1 to 2^31 - 1", "its array has the shape {}",
             text_of(header.shape));
    return int(size);
  });
  if (sizes.size() < 2 || sizes.size() > 5)
    refuse(path, order, "its array has the shape {}", text_of(header.shape));
  Axes axes;
  if (sizes.size() > 3 && sizes.back() <= most_components) {
    axes.components = sizes.back();
    sizes.pop_back();
  }
  if (sizes.size() > 4) refuse(path, order, "its array has the shape {}", text_of(header.shape));
  if (sizes.size() == 4) {
    axes.frames = sizes.front();
    sizes.erase(sizes.begin());
  }
  for (int axis = 0; axis < int(sizes.size()); ++axis)
    axes.dims[axis] = sizes[sizes.size() - 1 - std::size_t(axis)];
  return axes;
}

}  // namespace

std::unique_ptr<VolumeSource> open_npy(const std::filesystem::path& path, const VolumeChoice& choice) {
  const auto header = read_npy_header(path);
  const auto axes = axes_of(header, path);
  if (header.fortran_order && header.shape.size() > 3)
    refuse(path, "save np.ascontiguousarray(a), whose axes are [frame][z][y][x] or [z][y][x][component]",
           "its array of shape {} is in Fortran order", text_of(header.shape));
  Grid grid;
  grid.dims = axes.dims;
  grid.type = header.type;
  if (header.fortran_order) {
    std::swap(grid.dims.x, grid.dims.z);
    std::swap(grid.direction[0], grid.direction[2]);
  }
  auto wide = interleaved_grid(grid, axes.components, path.string());
  StoredVoxels stored{.file = path,
                      .offset = header.end,
                      .big_endian = header.big_endian,
                      .type = header.type,
                      .half = header.half};
  stored.choose(wide.bytes(), axes.frames, chosen_frame(choice, axes.frames, path));
  if (header.half) grid.type = wide.type = ScalarType::float32;
  auto source =
      channel_source(stored_source(wide, {stored}), grid, axes.components, choice.channel, path.string());
  return with_notes(std::move(source), {.frames = axes.frames, .channels = axes.components});
}

std::unique_ptr<VolumeSource> refuse_npz(const std::filesystem::path& path, const VolumeChoice&) {
  refuse(path, "save one of them by itself: np.save('volume.npy', np.load('volume.npz')['NAME'])",
         "a .npz is an archive of arrays");
}

}  // namespace ringsplat::detail
