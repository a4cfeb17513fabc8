#pragma once
#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "images/drawing.hpp"
#include "ringsplat/base/bytes.hpp"
#include "ringsplat/base/image.hpp"
#include "ringsplat/images/write_image.hpp"

/// Pictures in files, by OpenImageIO: rendered images out, any picture in.
namespace ringsplat {

/// Throws InputError naming `option` unless the file's ending is one that write_image knows (.exr .png .tif
/// .tiff .tga .jpg .jpeg). `transparent`: the picture keeps its alpha, which JPEG cannot hold.
void check_image_name(const std::filesystem::path& file, const std::string& option, bool transparent);

/// The same with `settings`, a JSON text, as the metadata "ImageDescription" and, where the format has free
/// names, "ringsplat:settings". The overlay lies above all.
void write_image(const Image& image, const std::filesystem::path& file,
                 const std::optional<glm::dvec3>& background, const std::string& settings,
                 const Overlay& overlay = {});

/// What write_image() would write into a file with that ending, such as ".png". Throws RunError when there is
/// no memory for it.
Bytes image_bytes(const Image& image, const std::string& ending, const std::optional<glm::dvec3>& background,
                  const std::string& settings, const Overlay& overlay = {});

/// The display values that write_image() would write into a .png: four bytes a pixel, or over a background
/// three.
std::vector<std::uint8_t> display_bytes(const Image& image, const std::optional<glm::dvec3>& background,
                                        const Overlay& overlay = {});

/// A picture's values for comparing: premultiplied RGBA, rows from the top. Those of float files are linear
/// light; those of integer files are display (sRGB) values from 0 to 1.
struct StoredImage {
  Image image;
  bool linear = false, has_alpha = false;
  std::string settings;  ///< what write_image was given, or empty
};

/// Throws InputError naming the file when it is no picture.
StoredImage read_image(const std::filesystem::path& file);

/// Converts display values to linear light, still premultiplied; a linear picture is unchanged.
StoredImage to_linear(StoredImage stored);

}  // namespace ringsplat
