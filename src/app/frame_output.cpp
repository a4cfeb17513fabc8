#include "app/frame_output.hpp"

#include <nlohmann/json.hpp>

#include "app/error_map.hpp"
#include "app/measuring.hpp"
#include "app/render_job.hpp"
#include "app/views.hpp"
#include "base/log.hpp"
#include "base/median.hpp"
#include "base/output_file.hpp"
#include "frame/frame_spec_bytes.hpp"
#include "images/image_io.hpp"
#include "program/text_output.hpp"

namespace ringsplat::app {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// All but the time, which differs from run to run.
json to_json(const MeasuredError& m) {
  json all{{"truth", name(m.truth)},         {"pixels", m.error.pixels},
           {"outside", m.error.outside},     {"seed", m.seed},
           {"rmse", m.error.rmse},           {"rmse_low", m.error.rmse_low},
           {"rmse_high", m.error.rmse_high}, {"largest", m.error.largest},
           {"mean", m.error.mean},           {"unit", "1/255"}};
  if (m.certificate) {
    const Certificate& c = *m.certificate;
    all.update(
        {{"largest_low", c.least}, {"widest", c.widest}, {"proved", c.proved}, {"proved_within", c.limits}});
    if (c.replaced) all["replaced"] = *c.replaced;
  }
  return all;
}

/// What slices are kept, and foreseen to take.
json memory_of(const Job& job) {
  std::string axes;
  for (const Axis axis : all_axes)
    if (job.load.kept_axes[std::size_t(axis)]) axes += name(axis);
  return {{"kept_axes", axes}, {"predicted_slice_bytes", job.slice_bytes}};
}

double busy_seconds(const NodeStats& s) { return s.computing + s.drawing + s.compositing + s.delivering; }
double megabytes(std::uint64_t bytes) { return double(bytes) / 1e6; }

/// A frame's settings. Of channels that were added each has its transfer function.
json settings_of(const FrameSpec& spec, const std::vector<DrawnChannel>& channels) {
  json all = to_json(spec);
  for (const DrawnChannel& channel : channels)
    all["channels"].push_back({{"channel", channel.choice},
                               {"name", channel.name},
                               {"transfer_function", to_json(channel.function)}});
  if (!channels.empty()) all.erase("transfer_function");
  return all;
}

}  // namespace

/// The file of --stats, to which each frame goes as soon as all is known of it.
class StatsOutput {
 public:
  /// No file where the options name none. What is passed by reference must outlive it.
  explicit StatsOutput(const Job& job)
      : job_(job),
        file_(job.options.stats),
        lines_(std::filesystem::path(file_).extension() == ".jsonl"),
        items_(items_of(job.options.frame.how)),
        gps_(std::size_t(job.layout.gps)),
        renderers_(std::size_t(job.layout.renderers)) {}

  /// `picture`: the frame's file; empty when none was written. `error` may be null. Throws RunError when the
  /// file cannot be written.
  void add(const FrameResult& frame, const std::string& picture, const MeasuredError* error,
           const std::string& volume) {
    if (job_.options.stats_as_table) {
      ++frames_;
      for (std::size_t g = 0; g < frame.stats.gps.size(); ++g) gps_.at(g) += frame.stats.gps[g];
      for (std::size_t r = 0; r < frame.stats.renderers.size(); ++r)
        renderers_.at(r) += frame.stats.renderers[r];
      items_ = items_of(frame.spec.how);
    }
    if (job_.options.stats_as_table || file_.empty()) return;
    json j = to_json(frame.stats, job_.layout, settings_of(frame.spec, job_.channels), name(frame.axis));
    if (!picture.empty()) j["file"] = picture;
    j["volume"] = volume;
    j["memory"] = memory_of(job_);
    if (error != nullptr) {
      j["error"] = to_json(*error);
      j["error"]["seconds"] = error->seconds;
    }
    if (std::exchange(begun_, true))
      put(lines_ ? "\n" : ",\n");
    else if (!lines_)
      put("[\n");
    put(plain_json_text(std::move(j)));
  }

  void finish() {
    if (file_.empty()) return;
    if (job_.options.stats_as_table) return write_text_output(file_, table());
    put(lines_ ? "\n" : begun_ ? "\n]\n" : "[\n\n]\n");
    if (output_)
      output_->commit();
    else
      flush_stdout();
  }

 private:
  void put(const std::string& text) {
    if (is_stdout(file_)) {
      std::fwrite(text.data(), 1, text.size(), stdout);
      return;
    }
    if (!output_) output_ = std::make_unique<OutputFile>(file_);
    output_->write(text);
  }

  /// What each rank did in all frames, for people.
  std::string table() const {
    std::string text = fmt::format(
        "{} frame{}, sums\n{:>6}  {:<24}{:>10}{:>11}{:>7}{:>11}{:>13}{:>11}{:>15}{:>15}\n", frames_,
        frames_ == 1 ? "" : "s", "rank", "nodes", "busy s", "waiting s", "busy", "sent MB", "received MB",
        "memory MB", fmt::format("{} sent", items_), fmt::format("{} drawn", items_));
    for (int rank = 0; rank < job_.layout.working_ranks(); ++rank) {
      NodeStats sum;
      std::string nodes;
      double there = 0;  // a rank's nodes take turns: while one works the other waits
      for (const NodeId node : job_.layout.nodes_on(rank)) {
        if (node == frame_buffer_id) continue;
        const NodeStats& one = (node.role == Role::gp ? gps_ : renderers_).at(std::size_t(node.index));
        sum += one;
        there = std::max(there, busy_seconds(one) + one.waiting_for_token + one.sending + one.idle);
        nodes += (nodes.empty() ? "" : ", ") + to_string(node);
      }
      const double busy = busy_seconds(sum), waiting = std::max(0.0, there - busy);
      text += fmt::format(
          "{:>6}  {:<24}{:>10.3f}{:>11.3f}{:>5.0f} %{:>11.2f}{:>13.2f}{:>11.0f}{:>15}{:>15}\n", rank, nodes,
          busy, waiting, busy > 0 ? 100 * busy / (busy + waiting) : 0.0,
          megabytes(sum.payload_bytes_sent + sum.tile_bytes), megabytes(sum.payload_bytes_received),
          megabytes(sum.peak_memory), sum.splats_sent, sum.splats_drawn);
    }
    if (job_.layout.idle > 0) text += fmt::format("{:>6}  idle\n", fmt::format("+{}", job_.layout.idle));
    return text;
  }

  const Job& job_;
  const std::string& file_;
  const bool lines_;   ///< not an array
  const char* items_;  ///< what payloads hold
  int frames_ = 0;
  std::vector<NodeStats> gps_, renderers_;  ///< sums
  std::unique_ptr<OutputFile> output_;      ///< null before the first frame, or for stdout
  bool begun_ = false;
};

std::string picture_settings(const FrameSpec& spec, const std::string& volume, bool annotated,
                             const std::vector<DrawnChannel>& channels, const MeasuredError* error) {
  json j = settings_of(spec, channels);
  j.erase("region");  // follows from the layout, and no pixel from it
  if (error != nullptr) j["error"] = to_json(*error);
  if (annotated) j["annotated"] = true;
  j["volume"] = fs::path(volume).filename().string();
  return plain_json_text(std::move(j));
}

namespace {

fs::path find_ffmpeg(const std::string& output) {
  const auto ffmpeg = find_program("ffmpeg");
  if (!ffmpeg)
    throw InputError(fmt::format("-o {} needs ffmpeg, and no folder in PATH has it", output),
                     "install it (apt-get install ffmpeg), or write pictures: -o frame.png");
  return *ffmpeg;
}

}  // namespace

std::string why_empty(const FrameResult& result, const ValueRange& range) {
  const Shown& shown = result.spec.shown;
  if (shown.mode != Mode::composite) {
    const auto& rgba = result.image.rgba;
    for (std::size_t k = 3; k < rgba.size(); k += 4)
      if (rgba[k] > 0) return {};
    if (shown.mode == Mode::surface)
      return fmt::format(
          "the picture is empty: no ray meets a surface of --isovalue {:g}; the volume's values "
          "run from {:g} to {:g}",
          shown.isovalue, plain(range.low), plain(range.high));
  }
  const NodeStats sum = result.stats.total();
  if (sum.splats_drawn > 0) return {};
  const TransferFunction& tf = shown.transfer_function;
  const auto span = visible_span(tf, {tf.opacities.front().value, tf.opacities.back().value});
  const std::string opaque =
      span ? fmt::format("from {:g} to {:g}", plain(span->low), plain(span->high)) : "nowhere";
  const double low = plain(range.low), high = plain(range.high);
  if (!tf.visible_within(range.low, range.high))
    return fmt::format(
        "the picture is empty: transfer function '{}' is opaque {}, but the volume's values run from {:g} to "
        "{:g}; hint: try --tf auto",
        tf.name, opaque, low, high);
  if (sum.visible_voxels + sum.voxels_outside == 0 && !shown.clip_planes.empty())
    return fmt::format(
        "the picture is empty: {} leave nothing of the volume that is visible; hint: distances count from "
        "its middle, and clip planes' directions point to what is left",
        shown.cut ? "the cut and clip planes" : "clip planes");
  if (sum.visible_voxels + sum.voxels_outside == 0)
    return fmt::format(
        "the picture is empty: transfer function '{}' is opaque {}, and no voxel has such a value though the "
        "volume's run from {:g} to {:g}; hint: ringsplat info shows the histogram, or try --tf auto",
        tf.name, opaque, low, high);
  return fmt::format(
      "the picture is empty: no visible voxel lies in it (values from {:g} to {:g}, transfer function '{}' "
      "opaque {}); hint: check --zoom or --matrix, or try --tf auto",
      low, high, tf.name, opaque);
}

std::string why_nearly_empty(const FrameResult& result) {
  // A useful picture has a tenth of all light stopped in the mean, and often more; a thousandth of that is
  // nearly nothing.
  constexpr double least_mean_opacity = 0.1 / 1000;
  const auto& rgba = result.image.rgba;
  double sum = 0;
  for (std::size_t k = 3; k < rgba.size(); k += 4) sum += double(rgba[k]);
  const double opacity = rgba.empty() ? 0 : 4 * sum / double(rgba.size());  // in the mean
  if (result.spec.shown.mode != Mode::composite || result.stats.total().splats_drawn == 0 ||
      opacity >= least_mean_opacity)
    return {};
  return fmt::format(
      "the picture is nearly empty: its pixels stop {:.2g} of the light in the mean; hint: try --opacity {}, "
      "a larger --zoom{}",
      opacity, opacity > 1e-6 ? 10 : 1000,
      result.spec.shown.transfer_function.name == "auto" ? "" : " or --tf auto");
}

FrameOutput::FrameOutput(const Job& job, const ValueRange& range, Progress& progress)
    : job_(job),
      options_(job.options),
      volume_(job.options.volume.path),
      range_(range),
      progress_(progress),
      stats_(std::make_unique<StatsOutput>(job)),
      writer_([this](FinishedFrame&& frame) {
        write(frame, nullptr);
        progress_.at(double(seconds_.size()));
      }) {}

FrameOutput::~FrameOutput() = default;

void FrameOutput::take(FrameResult&& result) {
  auto file = file_of_view(options_, options_.output, std::size_t(result.spec.frame));
  FinishedFrame frame{std::move(result), std::move(file), volume_, range_};
  if (options_.error.truth) {
    kept_.push_back({std::move(frame)});
    progress_.at(double(kept_.size()));
  } else {
    writer_.put(std::move(frame));
  }
}

void FrameOutput::show(const std::string& volume, const ValueRange& range) {
  volume_ = volume;
  range_ = range;
}

std::vector<Judged> FrameOutput::judge(Launch& launch) {
  std::vector<Judged> judged;
  std::vector<KeptFrame*> open;
  for (KeptFrame& kept : kept_)
    if (!kept.error) open.push_back(&kept);
  if (!launch.of_rank_0(!open.empty())) return judged;
  progress_.begin("measuring errors", double(open.size()));
  measure_together(job_, launch, [&](truth::Scene& scene, const Measure& measure) {
    scene.poll = [&](double done) { progress_.at(double(judged.size()) + done); };
    for (KeptFrame* const kept : open) {
      const auto& [result, file, volume, range] = kept->frame;
      scene.frame = result.spec;
      scene.frame.how = options_.frame.how;  // an error budget may have chosen a cheaper one
      kept->error = measure(kept->frame.result.image);
      if (!options_.budget.max_error) kept->of_level = level_error(result.image, scene, options_);
      judged.push_back({result.spec, file.string(), kept->error->held()});
    }
  });
  progress_.end();
  return judged;
}

void FrameOutput::replace(FrameResult&& result) {
  for (KeptFrame& kept : kept_) {
    if (kept.frame.result.spec.frame != result.spec.frame) continue;
    kept.frame.result = std::move(result);
    kept.error.reset();
    return;
  }
}

void FrameOutput::warn(const std::string& label, const std::string& why, int& frames) {
  if (why.empty() || frames++ > 0) return;
  progress_.clear();
  log_warning("{}: {}", label, why);
}

void FrameOutput::write(const FinishedFrame& frame, const MeasuredError* error) {
  const auto& [result, file, volume, range] = frame;
  const bool drawn = !options_.run.simulation.count_only, written = !options_.output.empty();
  const std::string label =
      written && !names_film(options_.output) ? file.string() : fmt::format("frame {}", result.spec.frame);
  const Overlay overlay =
      written && job_.annotation ? job_.annotation->overlay(result.spec, range) : Overlay{};
  if (written && names_film(options_.output))
    add_to_film(result.image, overlay);
  else if (written)
    write_image(result.image, file, options_.background,
                picture_settings(result.spec, volume, options_.annotate, job_.channels, error), overlay);
  if (error != nullptr && !options_.error.map.empty())
    write_error_map(*error, result.image,
                    file_of_view(options_, options_.error.map, std::size_t(result.spec.frame)),
                    picture_settings(result.spec, volume, false, job_.channels, error));
  const NodeStats sum = result.stats.total();
  warn(label, drawn ? why_empty(result, range) : std::string(), empty_frames_);
  warn(label, drawn ? why_nearly_empty(result) : std::string(), nearly_empty_frames_);
  const std::string after =
      seconds_.empty() ? "" : fmt::format(", {:.4f} s after the one before", result.stats.period);
  const std::string shown =
      options_.frames
          ? fmt::format("  {}: {:g} to {:g}", fs::path(volume).filename().string(), range.low, range.high)
          : "";
  progress_.print(fmt::format("{}  {:.4f} s{}  {} visible voxels  {} {}{}", label, result.stats.seconds,
                              after, sum.visible_voxels, sum.splats_sent, items_of(result.spec.how), shown));
  seconds_.push_back(result.stats.seconds);
  period_sum_ += result.stats.period;
  stats_->add(result, written ? file.string() : std::string(), error, volume);
}

void FrameOutput::finish() {
  writer_.finish();
  for (KeptFrame& kept : kept_) {
    write(kept.frame, kept.error ? &*kept.error : nullptr);
    if (kept.error) progress_.print(to_text(*kept.error));
    if (!kept.of_level.empty()) progress_.print(kept.of_level);
  }
  stats_->finish();
  if (empty_frames_ > 1) log_warning("{} of {} frames are empty", empty_frames_, seconds_.size());
  if (nearly_empty_frames_ > 1)
    log_warning("{} of {} frames are nearly empty", nearly_empty_frames_, seconds_.size());
  if (seconds_.size() > 1)  // with a rate, as frames overlap
    progress_.print(fmt::format("{} frames, median {:.4f} s from start to end, one every {:.4f} s",
                                seconds_.size(), median(seconds_), period_sum_ / double(seconds_.size())));
}

void FrameOutput::make_film() {
  if (!names_film(options_.output)) return;
  progress_.begin("making the film", 0);
  if (film_) write_text(options_.output, film_->encode(serve::Movie::Clock::now() + std::chrono::hours(1)));
  film_.reset();
  progress_.end();
  progress_.print(options_.output);
}

bool names_film(const fs::path& output) { return output.extension() == ".mp4"; }

void check_film(const RenderOptions& o) {
  if (o.orbit == 0 && o.path.empty() && !o.frames)
    throw InputError(fmt::format("-o {} is a film, and one view is none", o.output),
                     "turn around the volume with --orbit 120, or write a picture: -o picture.png");
  find_ffmpeg(o.output);
}

void FrameOutput::add_to_film(const Image& image, const Overlay& overlay) {
  if (!film_)
    film_.emplace(find_ffmpeg(options_.output),
                  serve::MoviePlan{.width = image.width, .height = image.height});
  const glm::dvec3 background = options_.background.value_or(glm::dvec3(0));
  film_->add(int(seconds_.size()), image_bytes(image, ".png", background, {}, overlay));
}

fs::path file_of_view(const RenderOptions& options, const std::string& name, std::size_t view) {
  const bool several = options.orbit > 0 || !options.path.empty() || options.frames;
  return several && !names_film(name) ? numbered(name, view) : fs::path(name);
}

}  // namespace ringsplat::app
