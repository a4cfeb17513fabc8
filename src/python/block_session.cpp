#include "python/block_session.hpp"

#include <utility>

#include "app/render_job.hpp"
#include "base/log.hpp"
#include "net/agree.hpp"
#include "options/option_tables.hpp"
#include "options/transfer_function_option.hpp"
#include "python/picture_options.hpp"
#include "ringsplat/base/error.hpp"
#include "session/session_parts.hpp"

namespace ringsplat::python {

/// What rank 0 wants drawn.
struct BlockSession::Request {
  app::RenderOptions options;
  std::vector<FrameSpec> frames;
  std::optional<app::Annotation> annotation;
};

BlockSession::BlockSession(Processes processes, const std::vector<std::string>& layout,
                           const SessionOptions& options, const std::string& problem)
    : collectives_(processes.collectives()), session_([&] {
        const bool over_mpi = processes.transport() != nullptr;
        Layout nodes;
        agree_after(processes.collectives(), [&] {
          if (!problem.empty()) throw InputError(problem);
          nodes = parse_layout(layout, over_mpi, processes.ranks());
        });
        return Session(std::move(processes), nodes, options);
      }()) {}

void BlockSession::set_grid(const Grid& grid, const VolumeNotes& notes) {
  check(grid, "the grid");
  session_.set_grid(grid);
  grid_ = grid;
  notes_ = notes;
}

void BlockSession::commit() {
  session_.commit();
  committed_ = grid_;
  committed_notes_ = notes_;
}

BlockSession::Request BlockSession::request(const std::vector<std::string>& words,
                                            const std::vector<app::ViewAngles>& views,
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
  for (const Camera& camera : cameras) {
    made.frames.push_back(o.frame);
    made.frames.back().shown.camera = camera;
  }
  return made;
}

std::vector<Picture> BlockSession::render(const std::vector<std::string>& words,
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

}  // namespace ringsplat::python
