#include "app/series_loader.hpp"

#include <fmt/format.h>

#include <utility>

#include "ringsplat/base/error.hpp"

namespace ringsplat::app {

SeriesLoader::SeriesLoader(std::vector<SeriesEntry> entries, OpenedVolume first, Plan plan,
                           Progress& progress, Launch& launch)
    : entries_(std::move(entries)),
      plan_(std::move(plan)),
      progress_(progress),
      launch_(launch),
      grid_(first.grid),
      ahead_(std::move(first)) {}

Scene SeriesLoader::load(std::size_t k) {
  OpenedVolume volume = opened(k);
  const SeriesEntry& entry = entries_[k];
  if (volume.source && entries_.size() > 1)
    volume.source = std::make_unique<NotingSource>(std::move(volume.source), runs_);
  try {
    Progress& progress = std::exchange(loaded_one_, true) ? silent_ : progress_;
    return app::load(volume, plan_.load, plan_.layout, plan_.wiring, progress);
  } catch (const InputError& e) {
    const std::string what = e.what();
    if (entries_.size() == 1 || what.find(entry.volume.path) != std::string::npos) throw;
    throw InputError(fmt::format("{}: {}", entry.name, what));
  }
}

void SeriesLoader::read_ahead(std::size_t k) {
  ahead_.reset();
  if (k >= entries_.size()) return;
  try {
    ahead_ = open_like_the_first(k);
  } catch (const InputError&) {
    return;
  }
  ahead_at_ = k;
  if (ahead_->source && plan_.ahead_bytes > 0 && !runs_.empty())
    ahead_->source = std::make_unique<ReadAheadSource>(std::move(ahead_->source), runs_, plan_.ahead_bytes);
}

OpenedVolume SeriesLoader::opened(std::size_t k) {
  std::optional<OpenedVolume> volume = std::exchange(ahead_, std::nullopt);
  if (volume && ahead_at_ == k) return std::move(*volume);
  volume.reset();  // its thread must not read while another is opened
  return open_like_the_first(k);
}

OpenedVolume SeriesLoader::open_like_the_first(std::size_t k) {
  OpenedVolume volume = open(entries_[k].volume, launch_);
  const Facts here = facts_of(volume.grid), first = facts_of(grid_);
  for (std::size_t fact = 0; fact < here.size(); ++fact)
    if (here[fact] != first[fact])
      throw InputError(
          fmt::format("{} has {} {}, but {}, the first, has {}", entries_[k].volume.path, here[fact].field,
                      here[fact].value, entries_.front().name, first[fact].value),
          "the volumes of a series must lie on one grid: render the others by themselves");
  return volume;
}

}  // namespace ringsplat::app
