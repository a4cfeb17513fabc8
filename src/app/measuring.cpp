#include "app/measuring.hpp"

#include "frame/frame_spec_bytes.hpp"
#include "net/launcher.hpp"

namespace ringsplat::app {
namespace {

/// The ranks that measure. Rank 0 calls the others to a picture, and there to each exchange, until it ends.
class Measuring {
 public:
  Measuring(const Job& job, Launch& launch)
      : error_(job.options.error), all_(launch.collectives()), rank_(std::size_t(launch.rank())) {
    launch.check_on_all_ranks([&] {
      const double scene = 8.0 * double(job.volume.grid.voxels());
      const double most_of_machine = simulated() ? 0 : machine_memory_bytes() / 2 / scene;
      if (ranks_for_all_cores(job.bindings, most_of_machine).at(rank_))
        scene_ = read_whole(*open_volume(job.options.volume)).scene;
    });
    for (const Block& measures : all_.all_gather(to_bytes(scene_.has_value())))
      measures_.push_back(value_of<bool>(measures, "whether it measures"));
    const auto in = [&](std::size_t ranks) {
      return std::size_t(std::count(measures_.begin(), measures_.begin() + std::ptrdiff_t(ranks), true));
    };
    if (in(measures_.size()) > 1)
      crew_ = {in(rank_), in(measures_.size()), [this](const auto& work) { return exchange(work); }};
  }

  truth::Scene& scene() { return *scene_; }

  /// On rank 0.
  MeasuredError measure(Image& image) {
    if (crew_.exchange)
      all_.broadcast(to_bytes(encode(scene_->frame), image.width, image.height, image.rgba), 0);
    return app::measure(image, *scene_, error_, crew_);
  }
  void end() { all_.broadcast({}, 0); }

  /// On the other ranks. An InputError is rank 0's, too.
  void work() {
    for (Block told; !(told = all_.broadcast({}, 0)).empty();)
      static_cast<void>(input_error_of([&] {
        if (told == to_exchange())
          gather([] { return Bytes(); });
        else if (scene_)
          measure_as(told);
      }));
  }

 private:
  static Block to_exchange() { return to_bytes(true); }

  void measure_as(const Block& told) {
    Bytes frame;
    Image image;
    read_block(told, "a picture", frame, image.width, image.height, image.rgba);
    scene_->frame = decode_frame_spec(frame);
    app::measure(image, *scene_, error_, crew_);
  }

  std::vector<Bytes> exchange(const std::function<Bytes()>& work) {
    all_.broadcast(rank_ == 0 ? to_exchange() : Block(), 0);
    return gather(work);
  }
  std::vector<Bytes> gather(const std::function<Bytes()>& work) {
    Bytes mine;
    agree_after(all_, [&] { mine = work(); });
    std::vector<Bytes> parts = all_.all_gather(mine);
    std::size_t rank = 0;
    std::erase_if(parts, [&](const Bytes&) { return !measures_[rank++]; });
    return parts;
  }

  const ErrorOptions& error_;
  Collectives& all_;
  const std::size_t rank_;
  std::optional<truth::Scene> scene_;  ///< where this rank measures
  std::vector<bool> measures_;         ///< by rank
  Crew crew_;
};

}  // namespace

std::vector<bool> ranks_for_all_cores(const std::vector<Binding>& bindings, double most_of_machine) {
  std::vector<bool> chosen;
  std::map<std::string, std::set<int>> cores;  // of those chosen, by machine
  std::map<std::string, int> ranks;
  for (const auto& [machine, own] : bindings) {
    const std::size_t before = cores[machine].size();
    cores[machine].insert(own.begin(), own.end());
    const bool brings = cores[machine].size() > before && ranks[machine] + 1 <= most_of_machine;
    ranks[machine] += brings;
    chosen.push_back(brings || chosen.empty());
  }
  return chosen;
}

void measure_together(const Job& job, Launch& launch,
                      const std::function<void(truth::Scene& scene, const Measure& measure)>& measure_all) {
  const auto watch = launch.collectives().watched("measuring errors");  // which leaves cores to those at work
  Measuring measuring(job, launch);
  std::string error;
  if (launch.rank() == 0) {
    error = input_error_of(
        [&] { measure_all(measuring.scene(), [&](Image& image) { return measuring.measure(image); }); });
    measuring.end();
  } else {
    measuring.work();
  }
  agree(launch.collectives(), error);
}

}  // namespace ringsplat::app
