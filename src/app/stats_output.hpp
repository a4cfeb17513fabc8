#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/output_file.hpp"
#include "options/options.hpp"
#include "record/stats.hpp"
#include "session/director.hpp"
#include "study/measured_error.hpp"

namespace ringsplat::app {

/// The memory that --stats predicts.
struct SliceMemory {
  std::array<bool, 3> kept_axes{};
  std::vector<std::uint64_t> predicted;  ///< bytes of slices by GP
};

/// All but the time, which differs from run to run.
nlohmann::json to_json(const MeasuredError& error);

/// Statistics of a refined view's coarse frame: seconds from the view's announcement to its picture, and its
/// error against the full picture.
struct RefinementStep {
  double seconds, rmse, largest;  ///< errors in 1/255
};
using RefinementSteps = std::map<std::int64_t, RefinementStep>;  ///< by frame

/// The file of --stats, to which each frame goes as soon as all is known of it.
class StatsOutput {
 public:
  /// No file where the options name none. What is passed by reference must outlive it.
  StatsOutput(const RenderOptions& options, const Layout& layout, SliceMemory memory);

  /// `picture`: the frame's file; empty when none was written. `error` may be null. Throws RunError when the
  /// file cannot be written.
  void add(const FrameResult& frame, const std::string& picture, const MeasuredError* error,
           const std::string& volume);
  /// Writes the frames that were added since the last call.
  void write(const RefinementSteps& steps);
  void finish();

 private:
  void put(const std::string& text);
  std::string table() const;

  const std::string& file_;
  const bool lines_;  ///< not an array
  const Layout& layout_;
  const SliceMemory memory_;
  const bool as_table_;  ///< of sums, in place of JSON
  const char* items_;    ///< what payloads hold
  int frames_ = 0;
  std::vector<NodeStats> gps_, renderers_;                        ///< sums
  std::vector<std::pair<std::int64_t, nlohmann::json>> waiting_;  ///< entries, with their frames
  std::unique_ptr<OutputFile> output_;  ///< null before the first frame, or for stdout
  bool begun_ = false;
};

}  // namespace ringsplat::app
