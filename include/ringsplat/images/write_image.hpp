#pragma once
#include <filesystem>
#include <glm/vec3.hpp>
#include <optional>

#include "ringsplat/base/image.hpp"

namespace ringsplat {

/// Writes a picture; the file's ending (.exr .png .tif .tiff .tga .jpg .jpeg) names the format.
///
/// .exr: premultiplied linear float32, with depths in the channel Z where the image has any. All others: 8
/// bits, straight (not premultiplied) sRGB, rounded to nearest. A background (linear light) is blended behind
/// the picture in linear light; the file then has no alpha channel, and JPEG needs one. Nothing in the file
/// depends on when or where it was made. Throws InputError for another ending, RunError when the file cannot
/// be written; an existing file is then left untouched.
void write_image(const Image& image, const std::filesystem::path& file,
                 const std::optional<glm::dvec3>& background = std::nullopt);

}  // namespace ringsplat
