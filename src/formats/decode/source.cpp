#include <algorithm>
#include <atomic>

#include "formats/decode/program.hpp"
#include "formats/formats.hpp"
#include "volume/forwarding_source.hpp"

namespace ringsplat::detail {
namespace {

/// Of each answer, so that it is copied while it lies in the processor's caches.
constexpr std::uint64_t usual_bytes = std::uint64_t{4} << 20;

/// A volume as the program has it open. Other files may end the program; then it is opened again in the next.
class DecodedSource final : public VolumeSource {
 public:
  DecodedSource(DecodedFormat format, const std::filesystem::path& path, const VolumeChoice& choice)
      : request_{.format = format,
                 .folder = std::filesystem::current_path().string(),
                 .path = path.string(),
                 .choice = choice},
        volume_(open_anew()) {}
  ~DecodedSource() override { program_->close(request_.source); }
  DecodedSource(const DecodedSource&) = delete;
  DecodedSource& operator=(const DecodedSource&) = delete;

  const std::optional<StoredVoxels>& in_place() const { return volume_.in_place; }
  const Grid& grid() const override { return volume_.grid; }
  bool concurrent() const override { return volume_.concurrent; }
  int layer_depth() const override { return volume_.layer_depth; }
  VolumeNotes notes() const override { return volume_.notes; }
  Facts facts() const override { return ask(DecodeRequest::Kind::facts).facts; }

  void read_slices(int first, int count, std::span<std::byte> out) override {
    const auto bytes = grid().slice_bytes(Axis::z);
    const int depth = layer_depth();
    const int layers = int(std::max<std::uint64_t>(1, usual_bytes / (bytes * std::uint64_t(depth))));
    for (int z = first, end = first + count; z < end;) {
      const int stop = int(std::min<std::int64_t>(end, (z / depth + std::int64_t{layers}) * depth));
      ask(DecodeRequest::Kind::read, z, stop - z,
          out.subspan(std::size_t(z - first) * bytes, std::size_t(stop - z) * bytes));
      z = stop;
    }
  }

 private:
  DecodedVolume open_anew() const {
    program_ = DecodeProgram::running();
    static std::atomic<std::uint32_t> sources = 0;  // that were ever opened
    request_.source = ++sources;
    return program_->ask(request_).volume;
  }

  DecodeAnswer ask(DecodeRequest::Kind kind, int first = 0, int count = 0,
                   std::span<std::byte> out = {}) const {
    if (program_->ended()) open_anew();
    DecodeRequest request = request_;
    request.kind = kind;
    request.first = first;
    request.count = count;
    return program_->ask(request, out);
  }

  mutable DecodeRequest request_;  ///< that opens it
  mutable std::shared_ptr<DecodeProgram> program_;
  DecodedVolume volume_;
};

std::unique_ptr<VolumeSource> open_decoded(DecodedFormat format, const std::filesystem::path& path,
                                           const VolumeChoice& choice) {
  auto source = std::make_unique<DecodedSource>(format, path, choice);
  if (!source->in_place()) return source;
  return with_notes(stored_source(source->grid(), {*source->in_place()}), source->notes());
}

}  // namespace

std::unique_ptr<VolumeSource> open_hdf5(const std::filesystem::path& path, const VolumeChoice& choice) {
  return open_decoded(DecodedFormat::hdf5, path, choice);
}
std::unique_ptr<VolumeSource> open_tiff(const std::filesystem::path& path, const VolumeChoice& choice) {
  return open_decoded(DecodedFormat::tiff, path, choice);
}
std::unique_ptr<VolumeSource> open_dicom(const std::filesystem::path& path, const VolumeChoice& choice) {
  return open_decoded(DecodedFormat::dicom, path, choice);
}

}  // namespace ringsplat::detail
