#include "decode/dicom/planes.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <numeric>
#include <utility>

#include "base/log.hpp"
#include "base/text.hpp"
#include "decode/dicom/checks.hpp"
#include "formats/channels.hpp"
#include "formats/limits.hpp"

namespace ringsplat::detail {
namespace {

double number_or_0(const DicomItem& item, DicomTag tag) {
  const auto numbers = item.numbers(tag);
  return numbers.size() != 1 || std::isnan(numbers[0]) ? 0 : numbers[0];
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
  if (!turned || !measures) return {};
  const auto n = checked_numbers(file, *turned, dicom::orientation);
  const auto spacing = checked_numbers(file, *measures, dicom::pixel_spacing);
  if (n.empty() || spacing.empty()) return {};
  return DicomPlanes{.row = glm::normalize(glm::make_vec3(n.data())),
                     .column = glm::normalize(glm::make_vec3(n.data() + 3)),
                     .spacing = {spacing[1], spacing[0]}};
}

bool alike(const DicomPlanes& a, const DicomPlanes& b) {
  constexpr double tolerated = 1e-3;
  return glm::distance(a.row, b.row) < tolerated && glm::distance(a.column, b.column) < tolerated &&
         glm::distance(a.spacing, b.spacing) < tolerated * a.spacing.x;
}

using Images = std::vector<std::size_t>;

/// What is to be said of the planes, beside themselves.
struct Placing {
  const std::string& where;
  const std::function<std::string(std::size_t)>& name_of;
};

/// The images at each place, places in ascending order along the normal, images in that of their times.
std::vector<Images> images_by_place(const std::vector<DicomPlane>& planes, const Grid& grid) {
  const auto normal = glm::normalize(glm::cross(grid.direction[0], grid.direction[1]));
  const auto heights = mapped(planes, [&](const auto& plane) { return glm::dot(normal, plane.position); });
  Images order(planes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return heights[a] < heights[b]; });
  const double same_place = 0.01 * std::min(grid.spacing.x, grid.spacing.y);  // no slices are so near
  std::vector<Images> places;
  for (const auto image : order) {
    const bool same = !places.empty() && heights[image] - heights[places.back().front()] <= same_place;
    if (!same) places.emplace_back();
    places.back().push_back(image);
  }
  for (auto& images : places)
    std::ranges::stable_sort(images, [&](auto a, auto b) { return planes[a].times < planes[b].times; });
  return places;
}

void require_even_counts(const std::vector<Images>& places, const Placing& placing) {
  const auto [least, most] =
      std::ranges::minmax_element(places, {}, [](const Images& images) { return images.size(); });
  if (places.size() == 1 && most->size() > 1)
    refuse(placing.where, "the folder may hold several series: give one file of the right one",
           "the {} slices have no different positions (Image Position Patient)", most->size());
  if (least->size() == most->size()) return;
  refuse(placing.where,
         fmt::format("move images away until every place has as many; {} is where there are {}",
                     placing.name_of(least->front()), least->size()),
         "{} places have {} to {} images each, so they are no whole time points", places.size(),
         least->size(), most->size());
}

/// An even lattice through the positions: which of its places each one has.
struct Lattice {
  std::vector<std::size_t> places;
  glm::dvec3 step{0};
  double off = 0;  ///< how far the worst position is off, in steps
  std::size_t missing() const { return places.back() + 1 - places.size(); }
};

/// `step`: a guess. Nothing when positions share a place.
std::optional<Lattice> lattice_through(const std::vector<glm::dvec3>& positions, double step) {
  constexpr std::size_t most_places = 1 << 20;
  Lattice lattice{.places = {0}, .step = {}, .off = 0};
  for (std::size_t i = 1; i < positions.size(); ++i) {
    const double steps = std::round(glm::distance(positions[i], positions[i - 1]) / step);
    if (!(steps >= 1) || steps > double(most_places)) return {};
    lattice.places.push_back(lattice.places.back() + std::size_t(steps));
  }
  if (lattice.places.back() > most_places) return {};
  lattice.step = (positions.back() - positions.front()) / double(lattice.places.back());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const auto even = positions.front() + double(lattice.places[i]) * lattice.step;
    lattice.off = std::max(lattice.off, glm::distance(positions[i], even) / glm::length(lattice.step));
  }
  return lattice;
}

/// The lattice by the median of the distances, or by the least where most slices are missing.
Lattice even_lattice(const std::vector<glm::dvec3>& positions, const Placing& placing) {
  constexpr double accepted = 0.01, accepted_mm = 0.01, warned = 0.05, warned_mm = 0.05, most_warned = 0.25;
  std::vector<double> distances;
  for (std::size_t i = 1; i < positions.size(); ++i)
    distances.push_back(glm::distance(positions[i], positions[i - 1]));
  std::sort(distances.begin(), distances.end());
  std::optional<Lattice> best;
  for (const double guess : {distances[distances.size() / 2], distances.front()}) {
    auto found = lattice_through(positions, guess);
    if (found && (!best || found->off < best->off)) best = std::move(found);
  }
  const double step = best ? glm::length(best->step) : 0;
  const bool few_missing = best && 2 * best->missing() <= positions.size();
  const auto within = [&](double part, double mm) { return best->off <= std::max(part, mm / step); };
  if (few_missing && within(accepted, accepted_mm)) return *best;
  if (few_missing && best->missing() == 0 && best->off <= most_warned && within(warned, warned_mm)) {
    log_warning_once("{}: slices are off their even places by up to {:.2g} mm, {:.2g} % of their distance",
                     placing.where, best->off * step, 100 * best->off);
    return *best;
  }
  refuse(placing.where, "resample them to even distances, or choose another series with --series",
         "not one stack of evenly spaced slices: {} of them are {:g} to {:g} mm apart{}", positions.size(),
         distances.front(), distances.back(),
         best && best->missing() == 0 ? fmt::format(", and up to {:.2g} mm off even places", best->off * step)
                                      : std::string());
}

/// The lattice's places as slices; a missing one lies between the images before and behind it.
std::vector<DicomSlice> slices_of(const Images& images, const Lattice& lattice) {
  std::vector<DicomSlice> slices;
  for (std::size_t i = 0; i < images.size(); ++i) {
    slices.push_back({.image = images[i], .next = images[i]});
    if (i + 1 == images.size()) break;
    const auto steps = lattice.places[i + 1] - lattice.places[i];
    for (std::size_t k = 1; k < steps; ++k)
      slices.push_back({images[i], images[i + 1], double(k) / double(steps)});
  }
  return slices;
}

void warn_of_missing(const Images& images, const Lattice& lattice, const Placing& placing) {
  if (lattice.missing() == 0) return;
  constexpr std::size_t most = 5;
  std::vector<std::string> gaps;
  for (std::size_t i = 0; i + 1 < images.size(); ++i)
    if (const auto steps = lattice.places[i + 1] - lattice.places[i]; steps > 1)
      gaps.push_back(fmt::format("{} between {} and {}", steps - 1, placing.name_of(images[i]),
                                 placing.name_of(images[i + 1])));
  const bool more = gaps.size() > most;
  if (more) gaps.resize(most);
  log_warning_once("{}: {} slices are missing and filled in from their neighbours: {}{}", placing.where,
                   lattice.missing(), joined(gaps), more ? " and elsewhere" : "");
}

}  // namespace

DicomTimes dicom_times(const DicomFile& file) {
  DicomTimes times{};
  std::size_t k = 0;
  for (const auto& tag : {dicom::time_position, dicom::b_value, dicom::echo_time, dicom::trigger_time,
                          dicom::acquisition, dicom::acquisition_time, dicom::number})
    times[k++] = number_or_0(file.elements, tag);
  return times;
}

std::optional<DicomPlanes> dicom_planes(const DicomFile& file, int frames) {
  const auto& found = file.elements.items(dicom::frame_groups);
  if (found.size() != std::size_t(frames)) return {};
  const auto* const all = file.elements.first_item(dicom::shared_groups);
  std::optional<DicomPlanes> planes;
  for (const auto& own : found) {
    const auto* const place = own.first_item(dicom::plane_position);
    auto lattice = lattice_of(file, all, own);
    if (!place || !lattice) return {};
    const auto position = checked_numbers(file, *place, dicom::position);
    if (position.empty()) return {};
    if (!planes) planes = lattice;
    if (!alike(*planes, *lattice))
      refuse(file.path, "give the frames as a series of files, one stack a folder",
             "frame {} is turned or scaled otherwise than those before it", planes->planes.size());
    DicomPlane plane{.position = glm::make_vec3(position.data()), .times = {}};
    if (const auto* const content = own.first_item(dicom::frame_content))
      plane.times.front() = number_or_0(*content, dicom::time_index);
    plane.times.back() = double(planes->planes.size());
    planes->planes.push_back(plane);
  }
  return planes;
}

DicomStack stack_planes(const std::vector<DicomPlane>& planes, const std::optional<int>& frame,
                        const std::string& where, const std::function<std::string(std::size_t)>& name_of,
                        Grid& grid) {
  const Placing placing{where, name_of};
  const auto places = images_by_place(planes, grid);
  require_even_counts(places, placing);
  DicomStack stack;
  stack.frames = int(places.front().size());
  const auto chosen = std::size_t(chosen_frame({.frame = frame}, stack.frames, where, "time points"));
  Images images;
  std::vector<glm::dvec3> positions;
  for (const auto& place : places) {
    images.push_back(place[chosen]);
    positions.push_back(planes[place[chosen]].position);
  }
  Lattice lattice{.places = {0}};
  if (images.size() > 1) {
    lattice = even_lattice(positions, placing);
    warn_of_missing(images, lattice, placing);
    grid.spacing.z = glm::length(lattice.step);
    grid.direction[2] = lattice.step / grid.spacing.z;
  }
  stack.slices = slices_of(images, lattice);
  grid.dims.z = int(stack.slices.size());
  grid.origin = positions.front();
  check_lattice(grid, where);
  return stack;
}

}  // namespace ringsplat::detail
