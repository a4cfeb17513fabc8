#include "volume/forwarding_source.hpp"

namespace ringsplat {
namespace {

class NotedSource final : public ForwardingSource {
 public:
  NotedSource(std::unique_ptr<VolumeSource> source, VolumeNotes notes)
      : ForwardingSource(std::move(source)), notes_(std::move(notes)) {}
  VolumeNotes notes() const override { return notes_; }

 private:
  VolumeNotes notes_;
};

}  // namespace

std::unique_ptr<VolumeSource> with_notes(std::unique_ptr<VolumeSource> source, VolumeNotes notes) {
  return std::make_unique<NotedSource>(std::move(source), std::move(notes));
}

}  // namespace ringsplat
