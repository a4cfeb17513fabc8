#include "formats/decode/source.hpp"

#include <algorithm>
#include <utility>

#include "formats/decode/program.hpp"
#include "volume/forwarding_source.hpp"

namespace ringsplat::detail {
namespace {

/// Of each answer, so that it is copied while it lies in the processor's caches.
constexpr std::uint64_t usual_bytes = std::uint64_t{4} << 20;

std::string library_of(DecodedFormat format) {
  switch (format) {
    case DecodedFormat::hdf5:
      return "HDF5";
    case DecodedFormat::tiff:
      return "OpenImageIO";
    case DecodedFormat::dicom:
      break;
  }
  return "GDCM";
}

/// A volume as the program has it open. Other files may end the program; then it is opened again in the next.
class Decoding {
 public:
  Decoding(DecodedFormat format, const std::filesystem::path& path, const VolumeChoice& choice)
      : library_(library_of(format)) {
    open_.format = format;
    open_.folder = std::filesystem::current_path().string();
    open_.path = path.string();
    open_.choice = choice;
  }
  ~Decoding() {
    if (program_) program_->close(open_.source);
  }
  Decoding(const Decoding&) = delete;
  Decoding& operator=(const Decoding&) = delete;

  DecodedVolume open() {
    program_ = DecodeProgram::running();
    open_.source = program_->new_source();
    return program_->ask(open_, library_, open_.path).volume;
  }
  Facts facts() { return ask(DecodeRequest::Kind::facts).facts; }
  void read(int first, int count, std::span<std::byte> out) {
    ask(DecodeRequest::Kind::read, first, count, out);
  }

 private:
  DecodeAnswer ask(DecodeRequest::Kind kind, int first = 0, int count = 0, std::span<std::byte> out = {}) {
    if (program_->ended()) open();
    DecodeRequest request = open_;
    request.kind = kind;
    request.first = first;
    request.count = count;
    return program_->ask(request, library_, open_.path, out);
  }

  std::string library_;
  DecodeRequest open_;
  std::shared_ptr<DecodeProgram> program_;
};

class DecodedSource final : public VolumeSource {
 public:
  DecodedSource(DecodedVolume volume, std::unique_ptr<Decoding> decoding)
      : volume_(std::move(volume)), decoding_(std::move(decoding)) {}
  const Grid& grid() const override { return volume_.grid; }
  bool concurrent() const override { return volume_.concurrent; }
  int layer_depth() const override { return volume_.layer_depth; }
  VolumeNotes notes() const override { return volume_.notes; }
  Facts facts() const override { return decoding_->facts(); }

  void read_slices(int first, int count, std::span<std::byte> out) override {
    const auto bytes = grid().slice_bytes(Axis::z);
    const int depth = layer_depth();
    const int layers = int(std::max<std::uint64_t>(1, usual_bytes / (bytes * std::uint64_t(depth))));
    for (int z = first, end = first + count; z < end;) {
      const int stop = int(std::min<std::int64_t>(end, (z / depth + std::int64_t{layers}) * depth));
      decoding_->read(z, stop - z,
                      out.subspan(std::size_t(z - first) * bytes, std::size_t(stop - z) * bytes));
      z = stop;
    }
  }

 private:
  DecodedVolume volume_;
  std::unique_ptr<Decoding> decoding_;
};

}  // namespace

std::unique_ptr<VolumeSource> decoded_source(DecodedFormat format, const std::filesystem::path& path,
                                             const VolumeChoice& choice) {
  auto decoding = std::make_unique<Decoding>(format, path, choice);
  DecodedVolume volume = decoding->open();
  if (volume.in_place) return with_notes(stored_source(volume.grid, *volume.in_place), volume.notes);
  return std::make_unique<DecodedSource>(std::move(volume), std::move(decoding));
}

}  // namespace ringsplat::detail
