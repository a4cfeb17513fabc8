#include <fmt/format.h>

#include <array>
#include <string_view>
#include <utility>

#include "ringsplat/base/error.hpp"
#include "ringsplat/volume/source.hpp"
#include "volume/dicom_elements.hpp"
#include "volume/formats.hpp"
#include "volume/input_file.hpp"
#include "volume/text.hpp"

namespace ringsplat {
namespace {

using Open = std::unique_ptr<VolumeSource> (*)(const std::filesystem::path&);

constexpr std::array<std::pair<std::string_view, Open>, 13> formats{{{".nrrd", detail::open_nrrd},
                                                                     {".nhdr", detail::open_nrrd},
                                                                     {".mha", detail::open_meta},
                                                                     {".mhd", detail::open_meta},
                                                                     {".nii", detail::open_nifti},
                                                                     {".nii.gz", detail::open_nifti},
                                                                     {".hdr", detail::open_nifti},
                                                                     {".img", detail::open_nifti},
                                                                     {".img.gz", detail::open_nifti},
                                                                     {".tif", detail::open_tiff},
                                                                     {".tiff", detail::open_tiff},
                                                                     {".vtk", detail::open_vtk},
                                                                     {".dcm", detail::open_dicom}}};

Open find_format(const std::filesystem::path& path) {
  const std::string name = detail::lower_case(path.filename().string());
  for (const auto& [ending, open] : formats)
    if (name.size() > ending.size() && name.ends_with(ending)) return open;
  return nullptr;
}

/// Replaces the spacing of a source whose file has none, or a wrong one.
class RespacedSource final : public VolumeSource {
 public:
  RespacedSource(std::unique_ptr<VolumeSource> source, const glm::dvec3& spacing)
      : source_(std::move(source)), grid_(source_->grid()) {
    grid_.spacing = spacing;
    check(grid_, "--spacing");
  }
  const Grid& grid() const override { return grid_; }
  bool concurrent() const override { return source_->concurrent(); }
  void read_slices(int first, int count, std::span<std::byte> out) override {
    source_->read_slices(first, count, out);
  }
  Facts facts() const override { return source_->facts(); }

 private:
  std::unique_ptr<VolumeSource> source_;
  Grid grid_;
};

bool describes_encoding(const RawDescription& raw) {
  return raw.dims || raw.type || raw.big_endian || raw.offset;
}

std::unique_ptr<VolumeSource> open_described(const std::filesystem::path& path, Open open,
                                             const RawDescription& raw) {
  if (describes_encoding(raw))
    throw InputError(
        fmt::format("{} describes itself: dimensions, type, endianness and offset are for raw files",
                    path.string()),
        "leave them out; only --spacing may be given");
  auto source = open(path);
  if (!raw.spacing && open == detail::open_tiff) detail::warn_of_tiff_spacing(path);
  if (!raw.spacing) return source;
  return std::make_unique<RespacedSource>(std::move(source), *raw.spacing);
}

bool has_tiff(const std::filesystem::path& folder) {
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (detail::is_tiff(entry.path())) return true;
  return false;
}

std::unique_ptr<VolumeSource> open_existing(const std::filesystem::path& path, const RawDescription& raw) {
  if (std::filesystem::is_directory(path))
    return open_described(path, has_tiff(path) ? detail::open_tiff : detail::open_dicom, raw);
  { const detail::InputFile readable(path); }
  if (const Open open = find_format(path)) return open_described(path, open, raw);
  const bool named_raw = detail::lower_case(path.extension().string()) == ".raw";
  if (named_raw || raw.dims) return detail::open_raw(path, raw);
  // Scanners often name their files without an ending.
  if (detail::is_dicom(path)) return open_described(path, detail::open_dicom, raw);
  throw InputError(
      fmt::format("{} has no ending of a known volume format", path.string()),
      "use .nrrd .nhdr .mha .mhd .nii .nii.gz .vtk .tif .dcm .raw or a folder, or describe a raw "
      "file with --dims and --type");
}

}  // namespace

std::unique_ptr<VolumeSource> open_volume(const std::filesystem::path& path, const RawDescription& raw) {
  try {
    return open_existing(path, raw);
  } catch (const std::filesystem::filesystem_error& error) {
    throw InputError(fmt::format("cannot open {}: {}", path.string(), error.code().message()),
                     "check the path and the permissions");
  } catch (const std::bad_alloc&) {
    throw InputError(fmt::format("{} needs more memory than there is", path.string()), "check its sizes");
  }
}

}  // namespace ringsplat
