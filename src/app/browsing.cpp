#include "app/browsing.hpp"

#include <fmt/format.h>

#include <utility>

#include "base/clock.hpp"
#include "truth/metrics.hpp"

namespace ringsplat::app {

std::vector<Reduction> Browsing::levels(const FrameSpec& frame, bool progressive) {
  if (!progressive) return {frame.shown.reduction};
  const bool prefilter = frame.shown.reduction.prefilter;
  return {{4, prefilter}, {2, prefilter}, {1, prefilter}};
}

Browsing::Browsing(const FrameSpec& frame, std::vector<Camera> views, std::unique_ptr<ViewStream> stream,
                   bool progressive)
    : frame_(frame),
      levels_(levels(frame, progressive)),
      views_(std::move(views)),
      stream_(std::move(stream)),
      next_level_(levels_.size()) {}

Director Browsing::director(FrameOutput& output, Progress& progress) {
  Director director{
      [this, &progress] {
        auto frame = next();
        say_whether_waiting(frame.has_value(), progress);
        return frame;
      },
      [this, &output, &progress](FrameResult&& result) { take(std::move(result), output, progress); }};
  if (stream_) {
    director.may_come = [this] { return stream_->may_come(); };
    director.unwanted = [this](const FrameSpec& spec) { return unwanted(spec); };
  }
  return director;
}

bool Browsing::newer_view_waits() { return stream_ && stream_->has_next(); }

std::optional<Camera> Browsing::next_view() {
  if (next_listed_ < views_.size()) return views_[next_listed_++];
  return stream_ ? stream_->next() : std::nullopt;
}

std::optional<FrameSpec> Browsing::next() {
  const bool refine = next_level_ < levels_.size() && !(next_level_ > 0 && newer_view_waits());
  if (!refine) {
    dropped_ += levels_.size() - next_level_;
    next_level_ = levels_.size();
    const auto view = next_view();
    if (!view) return std::nullopt;
    current_ = view;
    next_level_ = 0;
    asked_[shown_views_++] = now_seconds();
  }
  FrameSpec spec = frame_;
  spec.shown.camera = *current_;
  spec.shown.reduction = levels_[next_level_];
  steps_[next_frame_++] = {shown_views_ - 1, next_level_++};
  return spec;
}

void Browsing::say_whether_waiting(bool frame_comes, Progress& progress) {
  const bool waiting = !frame_comes && steps_.empty() && stream_ && stream_->may_come();
  if (waiting == waiting_) return;
  waiting_ = waiting;
  if (waiting)
    progress.wait_for("waiting for views on stdin");
  else
    progress.go_on();
}

void Browsing::check_stream() {
  if (stream_) stream_->check_all_was_read();
}

bool Browsing::unwanted(const FrameSpec& spec) {
  const auto step = steps_.find(spec.frame);
  if (step == steps_.end() || step->second.level == 0) return false;
  if (step->second.view + 1 == shown_views_ && !newer_view_waits()) return false;
  ++dropped_;
  steps_.erase(step);
  return true;
}

void Browsing::take(FrameResult&& result, FrameOutput& output, Progress& progress) {
  const auto found = steps_.find(result.spec.frame);
  if (found == steps_.end()) return;  // unwanted() dropped it, but it was already complete
  const Step step = found->second;
  steps_.erase(found);
  const double seconds = now_seconds() - asked_.at(step.view);
  const bool full = step.level + 1 == levels_.size();
  if (levels_.size() > 1) {
    if (full)
      compare_with_full(step, result.image, seconds, output, progress);
    else
      coarse_[step.view].push_back({result.spec.shown.reduction, result.image, result.spec.frame, seconds});
  }
  output.take(std::move(result), step.view, full ? 1 : levels_[step.level].factor);
  if (!full) return;
  // Earlier views that are not yet fully refined never will be.
  coarse_.erase(coarse_.begin(), coarse_.upper_bound(step.view));
  asked_.erase(asked_.begin(), asked_.upper_bound(step.view));
}

void Browsing::compare_with_full(const Step& step, const Image& full, double seconds, FrameOutput& output,
                                 Progress& progress) {
  std::string line = fmt::format("view {}:", step.view);
  for (const Shown& shown : coarse_[step.view]) {
    const truth::ErrorFigures error = truth::compare(shown.image, full).total;
    line += fmt::format(" 1/{} after {:.4f} s, {:.3g}/255 rms;", shown.reduction.factor, shown.seconds,
                        error.rmse);
    output.add_refinement(shown.frame, {shown.seconds, error.rmse, error.largest});
  }
  progress.print(line + fmt::format(" full after {:.4f} s", seconds));
}

std::string Browsing::summary() const {
  if (dropped_ == 0) return {};
  return fmt::format("{} views, {} refinements dropped for newer ones", shown_views_, dropped_);
}

}  // namespace ringsplat::app
