#include <algorithm>
#include <set>
#include <utility>

#include "base/input_file.hpp"
#include "base/log.hpp"
#include "base/text.hpp"
#include "formats/channels.hpp"
#include "formats/formats.hpp"
#include "formats/label_notes.hpp"
#include "formats/limits.hpp"
#include "formats/signatures.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/formats/open.hpp"
#include "volume/clipped.hpp"
#include "volume/forwarding_source.hpp"

namespace ringsplat {
namespace {

using detail::Open;

/// By the endings of files' names.
constexpr std::pair<const char*, Open*> formats[] = {
    {".nrrd .nhdr", detail::open_nrrd},
    {".mha .mhd", detail::open_meta},
    {".nii .nii.gz .hdr .img .img.gz", detail::open_nifti},
    {".tif .tiff", detail::open_tiff},
    {".vtk", detail::open_vtk},
    {".vti .pvti", detail::open_vti},
    {".npy", detail::open_npy},
    {".npz", detail::refuse_npz},
    {".dcm", detail::open_dicom},
    {".mgh .mgz .mgh.gz", detail::open_mgh},
    {".fits .fit .fts .fits.gz", detail::open_fits},
    {".mrc .map .rec .ccp4 .mrc.gz .map.gz", detail::open_mrc},
    {".h5 .hdf5 .he5 .hdf .nc .nc4 .vtkhdf .mnc", detail::open_hdf5}};

Open* find_format(const std::filesystem::path& path) {
  const std::string name = detail::lower_case(path.filename().string());
  for (const auto& [endings, open] : formats)
    for (const auto& ending : detail::words_of(endings))
      if (name.size() > ending.size() && name.ends_with(ending)) return open;
  return nullptr;
}

std::unique_ptr<VolumeSource> open_described(const std::filesystem::path& path, Open* open,
                                             const RawDescription& raw, const VolumeChoice& choice) {
  if (raw.dims || raw.type || raw.big_endian || raw.offset)
    detail::refuse(path, "leave them out; only --spacing may be given",
                   "it describes itself: dimensions, type, endianness and offset are for raw files");
  auto source = open(path, choice);
  if (!raw.spacing) return source;
  // The file has no spacing, or a wrong one.
  Grid grid = source->grid();
  grid.spacing = *raw.spacing;
  return std::make_unique<ForwardingSource>(std::move(source), grid);
}

/// A choice that nothing in the file answers must not be ignored. What a format has several of, its own
/// function chooses.
void require_choice_there(const VolumeNotes& notes, const VolumeChoice& choice,
                          const std::filesystem::path& path) {
  detail::chosen_frame(choice, notes.frames, path);
  if (!choice.channel.empty() && choice.channel != "all" && notes.channels == 1)
    throw InputError(fmt::format("--channel {}: {} has one value a voxel", choice.channel, path.string()),
                     "leave --channel out");
  if (!choice.series.empty() && notes.modality.empty())
    throw InputError(fmt::format("--series {}: {} is no DICOM series", choice.series, path.string()),
                     "leave --series out");
}

bool is_zarr(const std::filesystem::path& folder) {
  return std::ranges::any_of(std::array{"zarr.json", ".zarray", ".zgroup", "attributes.json"},
                             [&](const char* name) { return std::filesystem::exists(folder / name); });
}

/// A folder's volume is a stack of TIFF pages, of PNG files or of DICOM images, beside which there may be
/// pictures, unless the folder is a format of its own.
Open* format_of_folder(const std::filesystem::path& folder) {
  const auto has = [&](const char* name) { return std::filesystem::exists(folder / name); };
  if (is_zarr(folder)) return detail::open_zarr;
  if (has("Header") && has("Level_0")) return detail::open_amrex;
  int files = 0, pngs = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (detail::is_tiff(entry.path())) return detail::open_tiff;
    pngs += detail::is_png(entry.path());
    ++files;
  }
  return pngs > files / 2 ? detail::open_tiff : detail::open_dicom;
}

std::unique_ptr<VolumeSource> open_existing(const std::filesystem::path& path, const RawDescription& raw,
                                            const VolumeChoice& choice) {
  if (std::filesystem::is_directory(path)) return open_described(path, format_of_folder(path), raw, choice);
  if (const auto [file, dataset] = detail::split_dataset(path); !dataset.empty())
    return open_described(path, detail::open_hdf5, raw, choice);
  { const detail::InputFile readable(path); }
  if (Open* const open = find_format(path)) return open_described(path, open, raw, choice);
  const bool named_raw = detail::lower_case(path.extension().string()) == ".raw";
  if (named_raw || raw.dims) return detail::open_raw(path, raw);
  if (detail::is_hdf5(path)) return open_described(path, detail::open_hdf5, raw, choice);
  // Scanners often name their files without an ending.
  if (detail::is_dicom(path)) return open_described(path, detail::open_dicom, raw, choice);
  detail::refuse(
      path,
      "use .nrrd .nhdr .mha .mhd .nii .nii.gz .mgz .vtk .vti .tif .dcm .h5 .nc .npy .mrc .fits .raw or a "
      "folder, or describe a raw file with --dims and --type",
      "it has no ending of a known volume format");
}

}  // namespace

void detail::refuse_without_images(const std::filesystem::path& folder) {
  std::set<std::filesystem::path> volumes, pictures;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const auto ending = lower_case(entry.path().extension().string());
    std::error_code broken;
    if (!entry.is_regular_file(broken)) continue;
    if (ending == ".png" || ending == ".jpg" || ending == ".jpeg" || ending == ".bmp" || ending == ".jp2")
      pictures.insert(entry.path());
    if (find_format(entry.path()) || ending == ".raw") volumes.insert(entry.path());
  }
  if (!volumes.empty())
    refuse(folder, fmt::format("name one of them, as {}", volumes.begin()->string()),
           "it holds volume files ({})", volumes.size());
  if (!pictures.empty())
    refuse(
        folder,
        "slices are read from DICOM, TIFF and PNG: convert them to .tif, for example with 'mogrify -format "
        "tif', in a folder of their own",
        "it holds pictures ({} files, {})", pictures.size(), pictures.begin()->extension().string());
  throw InputError(fmt::format("{} holds no DICOM, TIFF or PNG images", folder.string()),
                   "give a folder with one series or stack, or a volume file");
}

std::unique_ptr<VolumeSource> open_volume(const std::filesystem::path& path, const RawDescription& raw,
                                          const VolumeChoice& choice) {
  try {
    auto source = open_existing(path, raw, choice);
    check(source->grid(), raw.spacing ? "--spacing" : path.string());
    // Zarr's reader has left out all other chunks.
    if (choice.crop && !is_zarr(path)) {
      const VoxelBox box = choice.crop(source->grid());
      source = clipped_source(std::move(source), box);
    }
    const VolumeNotes notes = source->notes();
    require_choice_there(notes, choice, path);
    if (notes.frames > 1 && !choice.frame)
      log_info_once("{}: time point 1 of {} is shown; --frame N takes another, 0 to {}", path.string(),
                    notes.frames, notes.frames - 1);
    return source;
  } catch (const std::filesystem::filesystem_error& error) {
    throw InputError(fmt::format("cannot open {}: {}", path.string(), error.code().message()),
                     "check the path and the permissions");
  } catch (const std::bad_alloc&) {
    throw InputError(fmt::format("{} needs more memory than there is", path.string()), "check its sizes");
  }
}

std::map<double, detail::LabelNotes> detail::label_notes(const std::filesystem::path& file) try {
  return is_zarr(file) ? zarr_label_notes(file) : nrrd_label_notes(file);
} catch (const InputError&) {
  return {};
}

}  // namespace ringsplat
