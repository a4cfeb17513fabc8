#include "sheet_engine/value_table.hpp"

#include <algorithm>
#include <cmath>

#include "sheet_engine/fill_slab_table.hpp"

namespace ringsplat {

void ValueTable::set_function(const TransferFunction& transfer_function, double low, double high,
                              bool whole_numbers) {
  if (!samples_.empty() && low == low_ && high == high_ && whole_numbers == whole_numbers_ &&
      transfer_function == transfer_function_)
    return;
  transfer_function_ = transfer_function;
  low_ = low;
  high_ = high;
  whole_numbers_ = whole_numbers;
  length_ = 0;
  const double range = high - low, steps = std::floor((whole_numbers ? 1 : fine_steps) / range);
  steps_a_unit_ = std::min(std::max(1.0, steps), most_steps / range);
  samples_.clear();
  for (double step = 0; step <= std::ceil(range * steps_a_unit_); ++step) {
    const auto sample = transfer_function.evaluate(low + step / steps_a_unit_);
    samples_.push_back({extinction(sample.opacity), sample.colour});
  }
}

void ValueTable::set_length(double length) {
  if (length == length_) return;
  length_ = length;
  entries_.resize(samples_.size());
  std::transform(samples_.begin(), samples_.end(), entries_.begin(), [&](const Sample& sample) {
    return uniform_slab(sample.extinction, sample.colour, length);
  });
}

}  // namespace ringsplat
