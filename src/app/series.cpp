#include "app/render_job.hpp"

#include <fmt/printf.h>
#include <glob.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <limits>
#include <utility>

#include "base/printable.hpp"
#include "base/text.hpp"
#include "formats/volume_files.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/volume/reduced.hpp"
#include "volume/clipped.hpp"

namespace ringsplat::app {
namespace {

namespace fs = std::filesystem;
using Numbered = std::vector<std::pair<int, std::string>>;

constexpr std::size_t most_volumes = 1'000'000;

/// True for a file's name with one %d or %04d in it.
bool has_number(const std::string& name) { return !detail::numbered_names(name, 0, 1, 1).empty(); }

Numbered numbered_files(const fs::path& path) {
  Numbered found;
  const fs::path folder = path.parent_path();
  const std::string form = path.filename().string();
  for (const auto& entry : fs::directory_iterator(folder.empty() ? fs::path(".") : folder)) {
    const std::string name = entry.path().filename().string();
    int number = -1;
    std::from_chars(name.data() + std::min(form.find('%'), name.size()), name.data() + name.size(), number);
    if (number >= 0 && name == fmt::sprintf(form, number))
      found.emplace_back(number, (folder / name).string());
  }
  std::sort(found.begin(), found.end());
  return found;
}

Numbered globbed_files(const std::string& pattern) {
  glob_t names{};
  const int result = glob(pattern.c_str(), GLOB_NOSORT, nullptr, &names);
  std::vector<std::string> found(names.gl_pathv, names.gl_pathv + names.gl_pathc);
  globfree(&names);
  if (result != 0 && result != GLOB_NOMATCH)
    throw InputError(fmt::format("the files of {} cannot be listed", printable(pattern)),
                     "check the folder's permissions");
  std::sort(found.begin(), found.end(), detail::naturally_before);
  Numbered numbered;
  for (auto& name : found) numbered.emplace_back(int(numbered.size()), std::move(name));
  return numbered;
}

bool has_wildcard(const std::string& path) { return path.find_first_of("*?[") != std::string::npos; }

/// Where "FILES:/place within each" has its place; the whole length without one.
std::size_t place_in(const std::string& path) { return std::min(path.rfind(":/"), path.size()); }

bool is_pattern(const std::string& whole) {
  const std::string path = whole.substr(0, place_in(whole));
  std::error_code error;
  return !fs::exists(whole, error) && !fs::exists(path, error) &&
         (has_wildcard(path) || has_number(fs::path(path).filename().string()));
}

std::string base_name(const std::string& path) {
  const fs::path whole = path;
  return (whole.has_filename() ? whole : whole.parent_path()).filename().string();
}

std::vector<SeriesEntry> volumes_in_file(const VolumeOptions& volume, const FrameRange& range) {
  VolumeOptions first = volume;
  first.choice.frame = 0;  // so that nobody is told which one is shown
  const int count = open_volume(first)->notes().frames;
  if (count == 1)
    throw InputError(fmt::format("--frames {}: {} holds one volume", range.text, printable(volume.path)),
                     "for a series of files give a pattern in quotes, such as 'step_*.nrrd'");
  std::vector<SeriesEntry> entries;
  for (int number = 0; number < count; ++number)
    entries.push_back(
        {number, volume.path, number, fmt::format("{}, frame {}", base_name(volume.path), number)});
  return entries;
}

/// Those that are called the same, in other folders, by their paths.
std::vector<SeriesEntry> named_volumes(const VolumeOptions& first, std::vector<std::string> paths) {
  paths.insert(paths.begin(), first.path);
  std::vector<SeriesEntry> entries;
  for (const std::string& path : paths) {
    if (is_pattern(path))
      throw InputError(
          fmt::format("{} is no file, but a pattern for several", printable(path)),
          paths.size() == 1 ? "add --frames all, or name one file" : "name the files one by one");
    const bool alone = std::ranges::count(paths, base_name(path), base_name) == 1;
    entries.push_back({int(entries.size()), path, first.choice.frame, alone ? base_name(path) : path});
  }
  return entries;
}

}  // namespace

Numbered files_of_pattern(const std::string& pattern) {
  const std::string path = pattern.substr(0, place_in(pattern)), within = pattern.substr(path.size());
  const bool numbered = has_number(fs::path(path).filename().string());
  if (!numbered && !has_wildcard(path))
    throw InputError(fmt::format("{} is no pattern", printable(pattern)), "such as 'step_*.nrrd'");
  Numbered files = numbered ? numbered_files(path) : globbed_files(path);
  if (files.empty())
    throw InputError(
        fmt::format("no file is named like {}", printable(path)),
        "put the pattern in quotes: 'step_*.nrrd', or step_%04d.nrrd for names with four digits");
  if (files.size() > most_volumes)
    throw InputError(fmt::format("{} means more than {} files", printable(path), most_volumes),
                     "give a narrower pattern");
  for (auto& [number, file] : files) file += within;
  return files;
}

std::vector<int> chosen_frames(const FrameRange& range, const std::vector<int>& numbers,
                               const std::string& what) {
  const int first = range.first.value_or(numbers.front()),
            end = range.end.value_or(numbers.back() == std::numeric_limits<int>::max() ? numbers.back()
                                                                                       : numbers.back() + 1);
  const std::string there = fmt::format("{} has {} volume{}, numbered from {} to {}", what, numbers.size(),
                                        numbers.size() == 1 ? "" : "s", numbers.front(), numbers.back());
  const auto is_there = [&](std::int64_t number) { return std::ranges::binary_search(numbers, number); };
  std::vector<int> chosen;
  for (const int number : numbers)
    if (number >= first && number < end && (number - first) % range.step == 0) chosen.push_back(number);
  // With both ends given, each number between them was asked for.
  for (std::int64_t number = first; range.first && range.end && number < end; number += range.step)
    if (!is_there(number))
      throw InputError(fmt::format("--frames {}: there is no frame {}", range.text, number),
                       there + "; leave an end open for all that there are");
  if (chosen.empty()) throw InputError(fmt::format("--frames {}: there is no such frame", range.text), there);
  return chosen;
}

std::vector<SeriesEntry> find_series(const VolumeOptions& volume, const std::optional<FrameRange>& frames,
                                     const std::vector<std::string>& more) {
  try {
    if (!frames) return named_volumes(volume, more);
    const bool pattern = is_pattern(volume.path);
    std::vector<SeriesEntry> entries;
    if (!pattern) entries = volumes_in_file(volume, *frames);
    for (const auto& [number, file] : pattern ? files_of_pattern(volume.path) : Numbered())
      entries.push_back({number, file, volume.choice.frame, base_name(file)});
    const auto numbers = detail::mapped(entries, &SeriesEntry::number);
    const auto chosen = chosen_frames(*frames, numbers, printable(volume.path));
    std::erase_if(
        entries, [&](const SeriesEntry& entry) { return !std::ranges::binary_search(chosen, entry.number); });
    return entries;
  } catch (const fs::filesystem_error& error) {
    throw InputError(fmt::format("cannot look for {}: {}", printable(volume.path), error.code().message()),
                     "check the path and the permissions");
  }
}

VolumeOptions Job::part(std::size_t k) const {
  VolumeOptions one = options.volume;
  const SeriesEntry& entry = series[k / channels_drawn()];
  one.path = entry.path;
  one.choice.frame = entry.frame;
  if (!channels.empty()) one.choice.channel = channels[k % channels.size()].choice;
  return one;
}

std::string Job::name_of_part(std::size_t k) const {
  const std::string& name = series[k / channels_drawn()].name;
  return channels.empty() ? name : name + ", " + channels[k % channels.size()].name;
}

SeriesLoader::SeriesLoader(Job& job, std::size_t pictures, Progress& progress, Launch& launch)
    : job_(job),
      ahead_bytes_(room_to_read_ahead(job, pictures, launch)),
      progress_(progress),
      launch_(launch),
      grid_(job.volume.grid),
      ahead_(std::move(job.volume)) {
  job.volume.facts = ahead_->facts;
}

Scene SeriesLoader::load(std::size_t k) {
  std::optional<OpenedVolume> volume = std::exchange(ahead_, std::nullopt);
  if (!volume || ahead_at_ != k) {
    volume.reset();  // its thread must not read while another is opened
    volume = open_like_the_first(k);
  }
  if (job_.load.half_of) volume = half_of(k, std::move(*volume));
  if (volume->source && job_.parts() > 1)
    volume->source = std::make_unique<NotingSource>(std::move(volume->source), runs_);
  try {
    Progress& progress = std::exchange(loaded_one_, !job_.load.half_of) ? silent_ : progress_;
    return app::load(job_, *volume, progress, launch_);
  } catch (const InputError& e) {
    const std::string what = e.what();
    if (job_.parts() == 1 || what.find(job_.part(k).path) != std::string::npos) throw;
    throw InputError(fmt::format("{}: {}", job_.name_of_part(k), what));
  }
}

void SeriesLoader::load_channels(Scene& scene, std::size_t volume) {
  for (std::size_t k = 0; k < job_.channels_drawn(); ++k) {
    Scene& next = scene.grid.voxels() == 0 ? scene : scene.others.emplace_back();
    next = load(volume * job_.channels_drawn() + k);
  }
}

void SeriesLoader::check_all() {
  for (std::size_t k = 1; k < job_.parts(); ++k) static_cast<void>(open_like_the_first(k));
}

void SeriesLoader::read_ahead(std::size_t k) {
  ahead_.reset();
  if (k >= job_.parts()) return;
  try {
    ahead_ = open_like_the_first(k);
  } catch (const InputError&) {
    return;
  }
  ahead_at_ = k;
  if (ahead_->source && ahead_bytes_ > 0 && !runs_.empty())
    ahead_->source = std::make_unique<ReadAheadSource>(std::move(ahead_->source), runs_, ahead_bytes_);
}

OpenedVolume SeriesLoader::half_of(std::size_t k, OpenedVolume whole) {
  const Grid full = whole.grid;
  std::optional<Grid> finest = whole.notes.finest;
  if (whole.layer_depth > 1) {
    VolumeOptions part = job_.part(k);
    part.choice.coarser = true;
    whole = open(part, launch_);
  } else {
    whole.grid = reduced_grid(whole.grid, {2});
    if (whole.source) whole.source = skipping_source(std::move(whole.source), whole.grid, 2);
  }
  // It is shown as the volume undersampled, and is as dense by that.
  if (finest) finest->spacing *= whole.grid.spacing / full.spacing;
  whole.notes.finest = finest;
  return whole;
}

OpenedVolume SeriesLoader::open_like_the_first(std::size_t k) {
  const VolumeOptions part = job_.part(k);
  OpenedVolume volume = open(part, launch_);
  const Facts here = facts_of(volume.grid), first = facts_of(grid_);
  for (std::size_t fact = 0; fact < here.size(); ++fact)
    if (here[fact] != first[fact])
      throw InputError(fmt::format("{} has {} {}, but {}, the first, has {}", part.path, here[fact].field,
                                   here[fact].value, job_.name_of_part(0), first[fact].value),
                       "the volumes of a series must lie on one grid: render the others by themselves");
  return volume;
}

}  // namespace ringsplat::app
