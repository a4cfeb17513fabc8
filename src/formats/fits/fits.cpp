#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "base/input_file.hpp"
#include "base/text.hpp"
#include "formats/axes.hpp"
#include "formats/channels.hpp"
#include "formats/encoded_bytes.hpp"
#include "formats/formats.hpp"
#include "formats/limits.hpp"
#include "formats/stored_source.hpp"
#include "volume/forwarding_source.hpp"

namespace ringsplat::detail {
namespace {

constexpr std::uint64_t block_bytes = 2880;

/// A header of a file: its cards that have a value ("Definition of the FITS standard", version 4.0).
class FitsHeader {
 public:
  FitsHeader(EncodedBytes& bytes, std::uint64_t begin, const std::filesystem::path& path)
      : path_(path), end_(begin) {
    constexpr std::uint64_t most = 1000 * block_bytes;
    for (std::string card(80, ' '); !card.starts_with("END     "); end_ += card.size()) {
      if (end_ - begin > most) fail("a header has no end");
      bytes.read(end_, std::as_writable_bytes(std::span(card)));
      if (end_ == 0 && !card.starts_with("SIMPLE  =")) fail("it does not begin as FITS files do");
      if (card.compare(8, 2, "= ") == 0) values_[trimmed(card.substr(0, 8))] = trimmed(card.substr(10));
    }
    end_ = (end_ + block_bytes - 1) / block_bytes * block_bytes;
  }

  std::uint64_t end() const { return end_; }  ///< where its data begin
  [[noreturn]] void fail(const std::string& what, const char* hint = "write it with astropy") const {
    refuse(path_, hint, "{}", what);
  }
  /// Between quotes, or before a comment; empty when it is missing.
  std::string text(const std::string& key) const {
    const auto found = values_.find(key);
    const auto value = found == values_.end() ? std::string() : found->second;
    const bool quoted = value.starts_with('\'');
    return trimmed(quoted ? value.substr(1, value.find('\'', 1) - 1) : value.substr(0, value.find('/')));
  }
  double real(const std::string& key, double otherwise) const {
    auto value = text(key);
    if (value.empty()) return otherwise;
    std::ranges::replace(value, 'D', 'E');  // of Fortran
    const auto number = number_in<double>(value);
    if (!number || !std::isfinite(*number)) fail(fmt::format("{} is '{}'", key, excerpt(value)));
    return *number;
  }
  int whole(const std::string& key, int least, int otherwise) const {
    const double number = real(key, otherwise);
    if (number < least || number > std::numeric_limits<int>::max() || number != std::trunc(number))
      fail(fmt::format("{} is {}", key, number));
    return int(number);
  }
  std::vector<int> sizes() const {
    std::vector<int> sizes(std::size_t(std::min(whole("NAXIS", 0, 0), 999)));
    for (std::size_t k = 0; k < sizes.size(); ++k) sizes[k] = whole(fmt::format("NAXIS{}", k + 1), 0, 0);
    return sizes;
  }
  /// Where the next header begins.
  std::uint64_t next() const {
    auto bytes = std::uint64_t(sizes().empty() ? 0 : std::abs(whole("BITPIX", -64, 8)) / 8);
    for (const int size : sizes()) bytes = bytes_of_volumes(path_, bytes, std::uint64_t(size));
    bytes = bytes_of_volumes(path_, bytes, std::uint64_t(whole("GCOUNT", 0, 1)),
                             std::uint64_t(whole("PCOUNT", 0, 0)));
    return bytes_of_volumes(path_, 1, bytes, end_ + block_bytes - 1) / block_bytes * block_bytes;
  }

 private:
  std::filesystem::path path_;
  std::uint64_t end_;
  std::map<std::string, std::string> values_;
};

/// Skips what is no image of at least three axes.
FitsHeader find_image(EncodedBytes& bytes, const std::filesystem::path& path) {
  FitsHeader header(bytes, 0, path);
  while (header.sizes().size() < 3 || (header.text("XTENSION") != "" && header.text("XTENSION") != "IMAGE")) {
    if (header.text("ZIMAGE") == "T")
      header.fail("its image is compressed in tiles", "decompress it with funpack");
    if (header.next() >= bytes.most()) header.fail("it holds no image of three axes");
    header = FitsHeader(bytes, header.next(), path);
  }
  return header;
}

ScalarType stored_type(const FitsHeader& header) {
  constexpr std::pair<int, ScalarType> types[] = {{8, ScalarType::uint8},
                                                  {16, ScalarType::int16},
                                                  {32, ScalarType::int32},
                                                  {-32, ScalarType::float32},
                                                  {-64, ScalarType::float64}};
  const int bits = header.whole("BITPIX", -64, 0);
  if (const auto type = found(types, bits)) return *type;
  header.fail(fmt::format("voxels of BITPIX {} cannot be rendered", bits), "convert them to 32 bits first");
}

/// That of the rescaled voxels. Integers of the other sign are stored less half of their range.
ScalarType type_of(ScalarType stored, const Rescale& rescale) {
  using enum ScalarType;
  const bool shifted = rescale.slope == 1;
  if (shifted && stored == uint8 && rescale.intercept == -0x1p7) return int8;
  if (shifted && stored == int16 && rescale.intercept == 0x1p15) return uint16;
  if (shifted && stored == int32 && rescale.intercept == 0x1p31) return uint32;
  return stored == float64 ? float64 : float32;
}

/// Where the first three of `axes`, as the header numbers them, are of one unit of length, which it returns;
/// else a step is 1.
std::string place(const FitsHeader& header, const std::vector<int>& axes, Grid& grid) {
  const auto key = [&](const char* name, int k) { return fmt::format("{}{}", name, axes[std::size_t(k)]); };
  const auto unit = header.text(key("CUNIT", 0));
  const auto astronomic = words_of("pc kpc Mpc AU lyr solRad");
  if (!micrometres_in(unit) && std::ranges::count(astronomic, unit) == 0) return "";
  if (unit != header.text(key("CUNIT", 1)) || unit != header.text(key("CUNIT", 2))) return "";
  for (int k = 0; k < 3; ++k) {
    const double step = header.real(key("CDELT", k), 1);
    grid.spacing[k] = std::abs(step);
    grid.direction[k][k] = step < 0 ? -1 : 1;
    grid.origin[k] = header.real(key("CRVAL", k), 0) + (1 - header.real(key("CRPIX", k), 0)) * step;
  }
  return unit;
}

}  // namespace

std::unique_ptr<VolumeSource> open_fits(const std::filesystem::path& path, const VolumeChoice& choice) {
  auto stored = stored_in(path);
  stored.big_endian = true;
  const InputFile file(path);
  const auto header = find_image(*encoded_bytes(file, stored.encoding, 0, file.size()), path);
  const auto sizes = header.sizes();
  // Axes of one voxel are none where there are enough others; volumes follow along those behind the third.
  std::vector<int> axes;
  for (int k = 1; k <= int(sizes.size()); ++k) axes.push_back(k);
  for (auto k = axes.size(); axes.size() > 3 && k-- > 0;)
    if (sizes[k] == 1) axes.erase(axes.begin() + std::ptrdiff_t(k));
  Grid grid;
  std::int64_t frames = 1;
  for (std::size_t k = 0; k < axes.size(); ++k) {
    const int size = sizes[std::size_t(axes[k]) - 1];
    if (k < 3) grid.dims[int(k)] = size;
    if (k >= 3) frames *= size;
    if (frames > std::numeric_limits<int>::max()) header.fail("its axes behind the third are too long");
  }
  grid.type = stored.type = stored_type(header);
  const auto unit = place(header, axes, grid);
  check_lattice(grid, path.string());
  stored.before() = header.end();
  stored.choose(grid.bytes(), frames, chosen_frame(choice, int(frames), path));
  const Rescale rescale{header.real("BSCALE", 1), header.real("BZERO", 0)};
  if (rescale.slope != 1 || rescale.intercept != 0) {
    stored.rescale = rescale;
    grid.type = type_of(stored.type, rescale);
  }
  VolumeNotes notes{.unit = unit, .quantity = header.text("BUNIT"), .frames = int(frames)};
  if (!header.text("BLANK").empty()) notes.fill = rescale.slope * header.real("BLANK", 0) + rescale.intercept;
  return with_notes(stored_source(grid, {stored}), notes);
}

}  // namespace ringsplat::detail
