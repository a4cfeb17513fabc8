#include "formats/stored_source.hpp"

#include <glm/gtc/packing.hpp>

#include "base/byte_order.hpp"
#include "formats/limits.hpp"
#include "formats/volume_files.hpp"
#include "volume/scalars.hpp"

namespace ringsplat::detail {
namespace {

void require_room(const StoredVoxels& stored, std::uint64_t size, std::uint64_t bytes) {
  if (stored.encoding == Encoding::deflate)
    return require_compressed_bytes(stored.file, size - std::min(size, stored.offset), bytes,
                                    deflate_best_ratio);
  if (stored.encoding == Encoding::hex) bytes *= 2;
  // A digit and a blank for each number, but for the last.
  if (stored.encoding == Encoding::text) bytes = bytes / size_of(stored.type) * 2 - 1;
  require_bytes(stored.file, std::min(size, stored.end), stored.offset, bytes);
}

class StoredSource final : public VolumeSource {
 public:
  StoredSource(const Grid& grid, std::vector<StoredVoxels> pieces)
      : grid_(grid),
        pieces_(std::move(pieces)),
        files_(mapped(pieces_, &StoredVoxels::file)),
        piece_bytes_(std::uint64_t(grid.voxels()) / pieces_.size() * size_of(pieces_[0].type)) {
    for (std::size_t number = 0; number < pieces_.size(); ++number) open(number);
  }

  const Grid& grid() const override { return grid_; }
  bool concurrent() const override { return pieces_[0].encoding == Encoding::raw; }

  void read_slices(int first, int count, std::span<std::byte> out) override {
    const auto& stored = pieces_[0];
    if (!stored.rescale && !stored.half) return read_stored(first, count, out);
    const auto values = grid_.slice_voxels(Axis::z) * std::size_t(count);
    std::vector<std::byte> raw(values * size_of(stored.type));
    read_stored(first, count, raw);
    if (stored.half) return widen_halves(raw, out);
    apply(*stored.rescale, stored.type, raw, grid_.type, out);
  }

  Facts facts() const override {
    const auto& stored = pieces_[0];
    Facts facts{{"encoding", stored.encoding == Encoding::raw       ? "raw"
                             : stored.encoding == Encoding::deflate ? "compressed"
                                                                    : "text"},
                {"stored type", to_string(stored.type)}};
    if (size_of(stored.type) > 1) facts.push_back({"byte order", stored.big_endian ? "big" : "little"});
    if (stored.rescale)
      facts.push_back({"rescaling", fmt::format("slope {}, intercept {}", stored.rescale->slope,
                                                stored.rescale->intercept)});
    facts.push_back({"offset", fmt::format("{} bytes", stored.offset)});
    const auto rest = file_->size() - std::min(file_->size(), stored.offset);
    const bool raw = stored.encoding == Encoding::raw;
    std::ranges::copy(
        pieces_.size() > 1 ? files_.facts() : files_.facts(stored.offset, raw ? piece_bytes_ : rest),
        std::back_inserter(facts));
    return facts;
  }

 private:
  void open(std::size_t number) {
    const auto& piece = pieces_[number];
    files_.require_unchanged(piece.file);
    bytes_.reset();
    file_ = std::make_unique<InputFile>(piece.file);
    require_room(piece, file_->size(), piece_bytes_);
    bytes_ = encoded_bytes(*file_, piece.encoding, piece.offset, piece.end, piece.type);
    number_ = number;
  }

  void read_stored(int first, int count, std::span<std::byte> out) {
    const auto type = pieces_[0].type;
    const auto slice_bytes = grid_.slice_voxels(Axis::z) * size_of(type);
    const auto wanted = out.first(std::size_t(count) * slice_bytes);
    auto position = std::uint64_t(first) * slice_bytes;
    for (auto rest = wanted; !rest.empty();) {
      const auto within = position % piece_bytes_;
      const auto part = std::size_t(std::min<std::uint64_t>(rest.size(), piece_bytes_ - within));
      if (const auto number = std::size_t(position / piece_bytes_); number != number_) open(number);
      file_->require_unchanged();
      bytes_->read(pieces_[number_].skip + within, rest.first(part));
      if (within + part == piece_bytes_) bytes_->verify_end();
      file_->require_unchanged();
      position += part;
      rest = rest.subspan(part);
    }
    if (pieces_[0].encoding != Encoding::text) to_native_order(wanted, size_of(type), pieces_[0].big_endian);
  }

  Grid grid_;
  std::vector<StoredVoxels> pieces_;
  VolumeFiles files_;
  std::uint64_t piece_bytes_;
  // Of the piece that was read last.
  std::size_t number_ = 0;
  std::unique_ptr<InputFile> file_;
  std::unique_ptr<EncodedBytes> bytes_;
};

}  // namespace

const NumberType* number_type(std::string_view name) {
  using enum ScalarType;
  static constexpr NumberType types[] = {
      {"b1", "bool", uint8},      {"i1", "int8", int8},       {"u1", "uint8", uint8},
      {"i2", "int16", int16},     {"u2", "uint16", uint16},   {"i4", "int32", int32},
      {"u4", "uint32", uint32},   {"i8", "int64", float64},   {"u8", "uint64", float64},
      {"f2", "float16", float32}, {"f4", "float32", float32}, {"f8", "float64", float64}};
  for (const auto& type : types)
    if (name == type.code || name == type.name) return &type;
  return nullptr;
}

ScalarType voxel_type(const std::filesystem::path& file, const std::string& name) try {
  return scalar_type_from(name);
} catch (const InputError&) {
  refuse(file, "convert them to int32, uint32 or float32 first", "voxels of type '{}' cannot be rendered",
         excerpt(name));
}

void widen_halves(std::span<const std::byte> halves, std::span<std::byte> floats) {
  std::ranges::transform(typed<std::uint16_t>(halves), reinterpret_cast<float*>(floats.data()),
                         glm::unpackHalf1x16);
}

void doubles_of_integers(std::span<std::byte> values, bool is_signed, const std::string& where) {
  const auto convert = [&]<class Integer>(Integer zero) {
    constexpr auto largest = Integer{1} << 53;
    for (std::size_t at = 0; at < values.size(); at += sizeof(double)) {
      const auto integer = load<Integer>(values.data() + at, 0);
      if (integer > largest || (is_signed && integer < zero - largest))
        refuse(where, "convert the dataset to 32-bit integers or floats first",
               "the 64-bit integer {} has no exact float64", integer);
      const auto value = double(integer);
      std::memcpy(values.data() + at, &value, sizeof(value));
    }
  };
  is_signed ? convert(std::int64_t{0}) : convert(std::uint64_t{0});
}

void apply(const Rescale& rescale, ScalarType from, std::span<const std::byte> in, ScalarType to,
           std::span<std::byte> out) {
  for_values(from, in, [&](auto stored) {
    visit_type(to, [&](auto zero) {
      auto* result = reinterpret_cast<decltype(zero)*>(out.data());
      for (const auto value : stored)
        *result++ = decltype(zero)(rescale.slope * double(value) + rescale.intercept);
    });
  });
}

void StoredVoxels::choose(std::uint64_t bytes, std::int64_t count, std::int64_t index) {
  const auto total = bytes_of_volumes(file, bytes, std::uint64_t(count), before());
  const auto size = InputFile(file).size();
  if (encoding == Encoding::deflate)
    require_compressed_bytes(file, size, total, deflate_best_ratio);
  else
    require_bytes(file, size, before(), total - before());
  before() += std::uint64_t(index) * bytes;
}

void StoredVoxels::read_head(std::span<std::byte> head) const {
  const InputFile input(file);
  encoded_bytes(input, encoding, 0, input.size())->read(0, head);
}

std::unique_ptr<VolumeSource> stored_source(const Grid& grid, std::vector<StoredVoxels> pieces) {
  return std::make_unique<StoredSource>(grid, std::move(pieces));
}

}  // namespace ringsplat::detail
