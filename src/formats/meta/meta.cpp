#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <string_view>
#include <utility>
#include <vector>

#include "base/input_file.hpp"
#include "base/text.hpp"
#include "formats/channels.hpp"
#include "formats/formats.hpp"
#include "formats/limits.hpp"
#include "formats/meta/header.hpp"
#include "formats/numbered_name.hpp"
#include "formats/piece_files.hpp"
#include "formats/stored_source.hpp"
#include "formats/text_reader.hpp"
#include "formats/text_source.hpp"
#include "ringsplat/base/error.hpp"
#include "volume/forwarding_source.hpp"

namespace ringsplat::detail {
namespace {

constexpr const char* pattern_hint = "write it as 'NAME%03d.raw FIRST LAST STEP'";

[[noreturn]] void fail_data_file(const std::filesystem::path& path, const MetaHeader& header,
                                 const std::string& what, const std::string& hint) {
  throw InputError(fmt::format("{}: ElementDataFile '{}' {}", path.string(), excerpt(header.data_file), what),
                   hint);
}

struct Numbering {
  std::int64_t first = 1, last = 0, step = 1;
};

/// Splits "NAME FIRST LAST STEP". The name may have blanks only when all three numbers are given.
std::pair<NumberedName, Numbering> parse_pattern(const std::filesystem::path& path, const MetaHeader& header,
                                                 std::int64_t files) {
  const auto words = words_of(header.data_file);
  const auto numbers = words.size() > 4 ? 3 : words.size() - 1;
  auto name_end = header.data_file.size();
  std::vector<std::int64_t> given;
  for (std::size_t i = words.size() - numbers; i < words.size(); ++i) {
    const auto number = number_in<std::int32_t>(words[i]);
    if (!number || *number < 0)
      fail_data_file(path, header, fmt::format("has '{}' where a whole number belongs", excerpt(words[i])),
                     pattern_hint);
    given.push_back(*number);
  }
  for (std::size_t i = 0; i < numbers; ++i)
    name_end = header.data_file.find_last_not_of(" \t", header.data_file.find_last_of(" \t", name_end) - 1);
  const NumberedName pattern(header.data_file.substr(0, numbers > 0 ? name_end + 1 : std::string::npos));
  if (!pattern.valid())
    fail_data_file(path, header,
                   "is no pattern of file names: it needs one %d and nothing else with a percent sign",
                   pattern_hint);
  Numbering range;
  if (!given.empty()) range.first = given[0];
  range.last = given.size() > 1 ? given[1] : range.first + files - 1;
  if (given.size() > 2)
    range.step = given[2];
  else if (files > 1)
    range.step = (range.last - range.first) / (files - 1);
  return {pattern, range};
}

std::vector<std::string> names_of_pattern(const std::filesystem::path& path, const MetaHeader& header,
                                          std::int64_t files) {
  const auto [pattern, range] = parse_pattern(path, header, files);
  if (range.step < 1)
    fail_data_file(path, header, fmt::format("counts in steps of {}", range.step), pattern_hint);
  const auto found = range.last < range.first ? 0 : (range.last - range.first) / range.step + 1;
  if (found != files)
    fail_data_file(path, header, fmt::format("names {} files, DimSize asks for {}", found, files),
                   "correct the numbers behind the name, or DimSize");
  std::vector<std::string> names;
  for (std::int64_t i = 0; i < files; ++i) names.push_back(pattern.with(range.first + i * range.step));
  return names;
}

/// The lines behind the header; empty ones are skipped.
std::vector<std::string> names_of_list(const std::filesystem::path& path, const MetaHeader& header,
                                       std::int64_t files) {
  const InputFile file(path);
  const auto bytes = file.size() - header.end;
  constexpr std::uint64_t longest_name = 4096;
  if (bytes / longest_name > std::uint64_t(files))
    fail_data_file(path, header, fmt::format("is followed by {} bytes", bytes), "give one file name a line");
  TextReader text(file, header.end);
  std::vector<std::string> names;
  for (auto line = text.line(); line; line = text.line())
    if (const auto name = trimmed(*line); !name.empty()) names.push_back(name);
  if (std::int64_t(names.size()) != files)
    fail_data_file(path, header, fmt::format("names {} files, DimSize asks for {}", names.size(), files),
                   "give one file name a line");
  return names;
}

bool is_list(const MetaHeader& header) { return words_of(header.data_file).front() == "LIST"; }

/// "LIST 2" and "LIST 3" say how many dimensions a file has; without a number it is one less than the volume.
int dimensions_of_a_file(const std::filesystem::path& path, const MetaHeader& header) {
  const auto words = words_of(header.data_file);
  int dimensions = header.dimensions - 1;
  if (is_list(header) && words.size() > 1) {
    const auto number = number_in<int>(
        lower_case(words[1]).ends_with('d') ? words[1].substr(0, words[1].size() - 1) : words[1]);
    if (words.size() > 2 || !number || *number < 2 || *number > 3)
      fail_data_file(path, header, "cannot be read", "a LIST is of files of 2 or 3 dimensions");
    dimensions = *number;
  }
  if (dimensions < 2)
    fail_data_file(path, header, "names files of single lines", "put whole slices into files");
  return dimensions;
}

/// `grid`: of one frame.
std::unique_ptr<VolumeSource> open_slice_files(const std::filesystem::path& path, const MetaHeader& header,
                                               const Grid& grid, int frame) {
  if (!header.binary || header.compressed)
    fail_data_file(path, header,
                   fmt::format("names several files of {}", header.binary ? "compressed voxels" : "text"),
                   "write the volume into one file");
  const std::int64_t files_of_frame = dimensions_of_a_file(path, header) > 2 ? 1 : grid.dims.z;
  const auto files =
      std::int64_t(bytes_of_volumes(path, std::uint64_t(files_of_frame), std::uint64_t(header.frames)));
  const auto names =
      is_list(header) ? names_of_list(path, header, files) : names_of_pattern(path, header, files);
  const auto first = names.begin() + std::ptrdiff_t(frame * files_of_frame);
  std::vector<std::filesystem::path> chosen;
  for (auto name = first; name != first + std::ptrdiff_t(files_of_frame); ++name)
    chosen.push_back(path.parent_path() / *name);
  return piece_files_source(grid, chosen, [header](const Grid& piece, const std::filesystem::path& file) {
    const auto size = InputFile(file).size();
    const auto offset =
        header.header_size < 0 ? size - std::min(size, piece.bytes()) : std::uint64_t(header.header_size);
    return stored_source(
        piece, {.file = file, .offset = offset, .big_endian = header.big_endian, .type = piece.type});
  });
}

/// The offset of one file's voxels. HeaderSize applies only to uncompressed voxels in a file of their own.
std::uint64_t voxel_offset(const MetaHeader& header, std::uint64_t file_bytes, std::uint64_t voxel_bytes) {
  if (header.is_local()) return header.end;
  if (header.compressed) return 0;
  if (header.header_size < 0) return file_bytes - std::min(file_bytes, voxel_bytes);
  return std::uint64_t(header.header_size);
}

/// The interleaved voxels of one frame, which the header describes.
std::unique_ptr<VolumeSource> source_of(const std::filesystem::path& path, const MetaHeader& header,
                                        const Grid& grid, int frame) {
  if (is_list(header) || header.data_file.find('%') != std::string::npos)
    return open_slice_files(path, header, grid, frame);
  const auto file = header.is_local() ? path : path.parent_path() / header.data_file;
  if (!header.binary && header.frames > 1)
    fail_data_file(path, header, fmt::format("has {} volumes in text", header.frames),
                   "write them in binary");
  if (!header.binary)
    return text_source(
        grid, file,
        header.is_local() ? header.end : std::uint64_t(std::max<std::int64_t>(0, header.header_size)));
  const auto size = InputFile(file).size();
  const auto total = bytes_of_volumes(path, grid.bytes(), std::uint64_t(header.frames));
  const auto offset = voxel_offset(header, size, total);
  if (header.compressed)
    require_compressed_bytes(file, size - std::min(size, offset), total, deflate_best_ratio);
  else
    require_bytes(file, size, offset, total);
  const auto before = std::uint64_t(frame) * grid.bytes();
  return stored_source(grid, {.file = file,
                              .offset = offset + (header.compressed ? 0 : before),
                              .compressed = header.compressed,
                              .skip = header.compressed ? before : 0,
                              .big_endian = header.big_endian,
                              .type = grid.type});
}

}  // namespace

std::unique_ptr<VolumeSource> open_meta(const std::filesystem::path& path, const VolumeChoice& choice) {
  const auto header = read_meta_header(path);
  const auto wide = interleaved_grid(header.grid, header.channels, path.string());
  auto source = source_of(path, header, wide, std::clamp(choice.frame.value_or(0), 0, header.frames - 1));
  if (header.channels > 1) {
    const auto taken = choose_channel(choice.channel, header.channels,
                                      are_colours(header.grid.type, header.channels), path.string());
    source = channel_source(std::move(source), header.grid, header.channels, taken);
  }
  return with_notes(
      std::move(source),
      {.world = World::patient, .unit = "mm", .frames = header.frames, .channels = header.channels});
}

}  // namespace ringsplat::detail
