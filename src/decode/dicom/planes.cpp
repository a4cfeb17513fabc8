#include "decode/dicom/planes.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <utility>

#include "base/text.hpp"
#include "decode/dicom/checks.hpp"
#include "decode/dicom/schema.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::detail {
namespace {

double number_or_0(const DicomItem& item, DicomTag tag) {
  const auto* const text = item.find(tag);
  if (text == nullptr) return 0;
  const auto number = number_in<double>(trimmed(*text)).value_or(0);
  return std::isfinite(number) ? number : 0;
}

/// A binary number; 0 where it is missing or has another size.
template <class T>
double binary_or_0(const DicomItem& item, DicomTag tag) {
  const auto* const bytes = item.find(tag);
  T number = 0;
  if (bytes == nullptr || bytes->size() != sizeof number) return 0;
  std::memcpy(&number, bytes->data(), sizeof number);
  return std::isfinite(double(number)) ? double(number) : 0;
}

glm::dvec3 three(const std::vector<double>& n, std::size_t from) {
  return {n[from], n[from + 1], n[from + 2]};
}

/// A frame's item of a functional group: its own, or that of all frames.
const DicomItem* item_of(const DicomItem* all, const DicomItem& own, DicomTag group) {
  const auto* const found = own.first_item(group);
  return found != nullptr || all == nullptr ? found : all->first_item(group);
}

/// A frame's orientation and spacing; nothing when one is missing.
std::optional<DicomPlanes> lattice_of(const DicomFile& file, const DicomItem* all, const DicomItem& own) {
  const auto* const turned = item_of(all, own, dicom::plane_orientation);
  const auto* const measures = item_of(all, own, dicom::pixel_measures);
  if (turned == nullptr || measures == nullptr) return {};
  const auto n = dicom_numbers(file, *turned, dicom::orientation, dicom::plane_orientation);
  const auto spacing = dicom_numbers(file, *measures, dicom::pixel_spacing, dicom::pixel_measures);
  if (n.empty() || spacing.empty()) return {};
  return DicomPlanes{.row = glm::normalize(three(n, 0)),
                     .column = glm::normalize(three(n, 3)),
                     .spacing = {spacing[1], spacing[0]},
                     .planes = {}};
}

bool alike(const DicomPlanes& a, const DicomPlanes& b) {
  constexpr double tolerated = 1e-3;
  return glm::distance(a.row, b.row) < tolerated && glm::distance(a.column, b.column) < tolerated &&
         glm::distance(a.spacing, b.spacing) < tolerated * a.spacing.x;
}

}  // namespace

DicomTimes dicom_times(const DicomFile& file) {
  const auto& root = file.elements;
  return {number_or_0(root, dicom::time_position), binary_or_0<double>(root, dicom::b_value),
          number_or_0(root, dicom::echo_time),     number_or_0(root, dicom::trigger_time),
          number_or_0(root, dicom::acquisition),   number_or_0(root, dicom::acquisition_time),
          number_or_0(root, dicom::number)};
}

std::optional<DicomPlanes> dicom_planes(const DicomFile& file, int frames) {
  const auto found = file.elements.sequences.find(dicom::frame_groups);
  if (found == file.elements.sequences.end() || found->second.size() != std::size_t(frames)) return {};
  const auto* const all = file.elements.first_item(dicom::shared_groups);
  std::optional<DicomPlanes> planes;
  for (const auto& own : found->second) {
    const auto* const place = own.first_item(dicom::plane_position);
    auto lattice = lattice_of(file, all, own);
    if (place == nullptr || !lattice) return {};
    const auto position = dicom_numbers(file, *place, dicom::position, dicom::plane_position);
    if (position.empty()) return {};
    if (!planes) planes = lattice;
    if (!alike(*planes, *lattice))
      throw InputError(fmt::format("{}: frame {} is turned or scaled otherwise than those before it",
                                   file.path.string(), planes->planes.size()),
                       "give the frames as a series of files, one stack a folder");
    DicomPlane plane{.position = three(position, 0), .times = {}};
    if (const auto* const content = own.first_item(dicom::frame_content))
      plane.times.front() = binary_or_0<std::uint32_t>(*content, dicom::time_index);
    plane.times.back() = double(planes->planes.size());
    planes->planes.push_back(plane);
  }
  return planes;
}

}  // namespace ringsplat::detail
