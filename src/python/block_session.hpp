#pragma once
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/render_job.hpp"
#include "base/log.hpp"
#include "net/agree.hpp"
#include "options/option_tables.hpp"
#include "options/transfer_function_option.hpp"
#include "python/picture.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/session/session.hpp"
#include "session/session_parts.hpp"

namespace ringsplat::python {

/// A session whose pictures are described by the command line's options.
class BlockSession {
 public:
  /// `layout`: words for parse_layout(). Throws InputError on all ranks when one has a `problem` or wrong
  /// words.
  BlockSession(Processes processes, const std::vector<std::string>& layout, const SessionOptions& options,
               const std::string& problem)
      : collectives_(processes.collectives()), session_([&] {
          const bool over_mpi = processes.transport() != nullptr;
          Layout nodes;
          agree_after(processes.collectives(), [&] {
            if (!problem.empty()) throw InputError(problem);
            nodes = parse_layout(layout, over_mpi, processes.ranks());
          });
          return Session(std::move(processes), nodes, options);
        }()) {}

  /// For its blocks and what else has nothing to do with pictures.
  Session& session() { return session_; }

  void set_grid(const Grid& grid, const VolumeNotes& notes) {
    check(grid, "the grid");
    session_.set_grid(grid);
    grid_ = grid;
    notes_ = notes;
  }

  void commit() {
    session_.commit();
    committed_ = grid_;
    committed_notes_ = notes_;
  }

  /// Rank 0's words and views count. The pictures are returned on rank 0.
  std::vector<Picture> render(const std::vector<std::string>& words,
                              const std::vector<app::ViewAngles>& views, const Hooks& hooks) {
    const ValueStatistics& values = SessionParts::values(session_);
    Request wanted;
    agree_after(collectives_, [&] {
      if (values.range.empty())
        throw InputError("the volume has no finite value: every voxel is not-a-number or infinite",
                         "check the blocks' values");
      if (session_.rank() == 0) wanted = request(words, views, values);
    });
    const ValueRange range = values.range;
    std::vector<Picture> pictures;
    SessionParts::render(session_, wanted.frames, [&](FrameResult&& result) {
      pictures.push_back(picture_of(std::move(result), wanted.options, range, wanted.annotation));
      if (hooks.told) hooks.told("rendering", double(pictures.size()), double(wanted.frames.size()));
    });
    return pictures;
  }

 private:
  /// What rank 0 wants drawn.
  struct Request {
    app::RenderOptions options;
    std::vector<FrameSpec> frames;
    std::optional<app::Annotation> annotation;
  };

  Request request(const std::vector<std::string>& words, const std::vector<app::ViewAngles>& views,
                  const ValueStatistics& values) const {
    Request made{parse_picture(words, views, From::session), {}, {}};
    app::RenderOptions& o = made.options;
    o.volume.path = "session";
    o.frame.shown.clip = app::clip_box(o.clip, committed_);
    const std::string note = app::complete_view(o, committed_, committed_notes_);
    if (!note.empty()) log_info("{}", note);
    if (o.annotate) made.annotation.emplace(committed_, committed_notes_, o.background, o.colour.range);
    const auto cameras = app::views_of(o);
    const app::MadeFunction function =
        app::TransferFunctionChoice(o.transfer_function, o.colour).make(values, committed_);
    check(function.function, o.transfer_function);
    if (!function.said.empty()) log_info("{}", function.said);
    function.set(o.frame.shown);
    made.frames = frames_of(o.frame, cameras);
    return made;
  }

  Collectives& collectives_;  ///< the session's
  Session session_;
  Grid grid_, committed_;
  VolumeNotes notes_, committed_notes_;
};

}  // namespace ringsplat::python
