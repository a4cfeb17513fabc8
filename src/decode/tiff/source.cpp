#include "decode/tiff/source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "base/byte_order.hpp"
#include "base/input_file.hpp"
#include "base/text.hpp"
#include "formats/slice_by_slice.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::detail {
namespace {

/// Which sample type gives which scalar type. Samples are read as the first one listed for their scalar type.
constexpr std::pair<ScalarType, SampleType> sample_types[] = {
    {ScalarType::int8, SampleType::int8},       {ScalarType::uint8, SampleType::uint8},
    {ScalarType::int16, SampleType::int16},     {ScalarType::uint16, SampleType::uint16},
    {ScalarType::int32, SampleType::int32},     {ScalarType::uint32, SampleType::uint32},
    {ScalarType::float32, SampleType::float32}, {ScalarType::float32, SampleType::float16},
    {ScalarType::float64, SampleType::float64}};

SampleType sample_type_of(ScalarType type) {
  return std::find_if(std::begin(sample_types), std::end(sample_types),
                      [type](const auto& pair) { return pair.first == type; })
      ->second;
}

/// What the library says; of tiles that are larger than any image, why they are not read.
std::string in_words(const std::string& problem) {
  const bool too_large = problem.find("bad_alloc") != std::string::npos;
  return too_large ? "its parts are too large for a file of its size" : one_line(problem);
}

class TiffSource final : public SliceBySlice {
 public:
  TiffSource(const Grid& grid, std::vector<TiffSlice> slices, const TiffSamples& samples)
      : SliceBySlice(grid, files_of(slices), {{"encoding", "TIFF"}}),
        slices_(std::move(slices)),
        samples_(samples) {}

 private:
  static std::vector<std::filesystem::path> files_of(const std::vector<TiffSlice>& slices) {
    std::vector<std::filesystem::path> files;
    for (const TiffSlice& slice : slices) files.push_back(slice.file);
    return files;
  }

  void read_slice(int z, std::span<std::byte> out) override {
    const TiffSlice& slice = slices_[std::size_t(z)];
    require_unchanged(slice.file);
    if (samples_.count == 1) {
      read_samples(slice, out);
    } else {
      std::vector<std::byte> interleaved(out.size() * std::size_t(samples_.count));
      read_samples(slice, interleaved);
      take_channel(grid().type, samples_.count, samples_.taken, interleaved, out);
    }
    require_unchanged(slice.file);
  }

  void read_samples(const TiffSlice& slice, std::span<std::byte> out) {
    if (slice.raw_begin) {
      InputFile(slice.file).read(*slice.raw_begin, out);
      return to_native_order(out, size_of(grid().type), slice.big_endian);
    }
    if (!image_ || opened_ != slice.file) {
      image_ = open_tiff_image(slice.file);
      opened_ = slice.file;
    }
    const std::string problem =
        image_->read(slice.page, samples_.count, sample_type_of(grid().type), out.data());
    if (!problem.empty())
      throw InputError(
          fmt::format("cannot read page {} of {}: {}", slice.page, slice.file.string(), in_words(problem)),
          "the file was cut short or damaged");
  }

  std::vector<TiffSlice> slices_;
  TiffSamples samples_;
  std::unique_ptr<ImageFile> image_;
  std::filesystem::path opened_;
};

}  // namespace

std::unique_ptr<ImageFile> open_tiff_image(const std::filesystem::path& path) {
  const InputFile readable(path);
  auto [file, problem] = open_image_file(path);
  if (!file)
    throw InputError(fmt::format("{} is not a readable TIFF file: {}", path.string(), in_words(problem)),
                     "check the file with another viewer");
  return std::move(file);
}

std::optional<ScalarType> scalar_type_of(SampleType type) {
  for (const auto& [scalar, sample] : sample_types)
    if (sample == type) return scalar;
  return {};
}

std::unique_ptr<VolumeSource> tiff_source(const Grid& grid, std::vector<TiffSlice> slices,
                                          const TiffSamples& samples) {
  return std::make_unique<TiffSource>(grid, std::move(slices), samples);
}

}  // namespace ringsplat::detail
