#include <utility>

#include "net/message.hpp"
#include "sheet_engine/sheet_payload.hpp"
#include "simulate/meter.hpp"
#include "simulate/sample_counter.hpp"

namespace ringsplat {
namespace {

class SheetMeter final : public Meter {
 public:
  explicit SheetMeter(std::shared_ptr<const SheetFrame> frame)
      : frame_(std::move(frame)), samples_(*frame_) {}

  std::vector<PaintWork> work_of(int step, const std::vector<EncodedPart>& parts) override {
    std::vector<PaintWork> work(parts.size());
    samples_.begin(step, int(parts.size()));
    for (std::size_t r = 0; r < parts.size(); ++r)
      if (!parts[r].payload.empty())
        work[r].blocks = look_at(std::span<const std::byte>(parts[r].payload).subspan(sizeof(Header)));
    for (std::size_t r = 0; r < parts.size(); ++r) work[r].samples = samples_.samples()[r];
    return work;
  }

 private:
  /// Returns how many blocks the payload has a byte for.
  std::uint64_t look_at(std::span<const std::byte> body) {
    const Grid& grid = frame_->geometry.grid;
    const Axis axis = frame_->geometry.traversal.axis;
    const SheetPayload payload =
        read_sheet_payload(body, grid.slice_width(axis), grid.slice_height(axis), grid.type);
    std::uint64_t blocks = 0;
    for (std::size_t row = 0; row < payload.rows.size(); ++row) {
      const auto [first, end] = payload.rows[row];
      blocks += std::uint64_t(end - first);
      for (int column = first; column < end; ++column)
        if ((payload.bytes[row][column - first] & cells_visible) != 0)
          samples_.add(column, payload.header.first_row + int(row));
    }
    return blocks;
  }

  std::shared_ptr<const SheetFrame> frame_;
  SampleCounter samples_;
};

}  // namespace

std::unique_ptr<Meter> make_sheet_meter(std::shared_ptr<const SheetFrame> frame) {
  return std::make_unique<SheetMeter>(std::move(frame));
}

}  // namespace ringsplat
