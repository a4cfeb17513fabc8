#include "sheet_engine/slab_table.hpp"

#include <algorithm>

#include "sheet_engine/fill_slab_table.hpp"

namespace ringsplat {
namespace {

/// At a jump a value has the opacity behind it, also when its entry lies a rounding before.
double jump_nudge(const TableAxis& axis) { return 0.5 * TableAxis::narrowest * axis.ramps[0].width; }

SlabTable::Curve integrate(const TransferFunction& tf, const TableAxis& axis) {
  using Curve = SlabTable::Curve;
  constexpr int samples = 8;  // between two nodes
  const double nudge = jump_nudge(axis);
  Curve curve;
  const auto count = std::size_t(Curve::nodes);
  for (auto* integral : {&curve.extinction, &curve.red, &curve.green, &curve.blue})
    integral->resize(count, 0.0);
  for (int node = 0; node < Curve::nodes; ++node)
    curve.value.push_back(axis.value_at(double(node) / SlabTable::nodes_an_entry));
  for (std::size_t node = 1; node < count; ++node) {
    const double start = curve.value[node - 1], step = (curve.value[node] - start) / samples;
    double sums[4] = {};
    for (int k = 0; k < samples; ++k) {
      const auto sample = tf.evaluate(start + (k + 0.5) * step + nudge);
      const double here = extinction(sample.opacity) * step;
      sums[0] += here;
      for (int c = 0; c < 3; ++c) sums[c + 1] += here * sample.colour[c];
    }
    curve.extinction[node] = curve.extinction[node - 1] + sums[0];
    curve.red[node] = curve.red[node - 1] + sums[1];
    curve.green[node] = curve.green[node - 1] + sums[2];
    curve.blue[node] = curve.blue[node - 1] + sums[3];
  }
  for (int entry = 0; entry < TableAxis::entries; ++entry) {
    const auto here = tf.evaluate(curve.value[std::size_t(entry) * SlabTable::nodes_an_entry] + nudge);
    curve.at_entry.push_back(extinction(here.opacity));
    curve.colour.push_back(here.colour);
  }
  return curve;
}

/// Depths along an even axis. Between two nodes the curve is taken as a quadratic, or as linear: at a jump,
/// so that it never falls, and at the ends, beyond which it goes on.
std::vector<SlabTable::Depth> depths_of(const TransferFunction& tf, const SlabTable::Curve& curve,
                                        double nudge) {
  const double entry = curve.value[SlabTable::nodes_an_entry] - curve.value[0];
  const auto quantum = std::exp2(std::ceil(std::log2(curve.extinction.back() / entry + 1)) - 24);
  std::vector<SlabTable::Depth> depths;
  const std::size_t last = curve.value.size() - 2;
  for (std::size_t node = 0; node <= last; ++node) {
    const double depth = curve.extinction[node] / entry,
                 change = (curve.extinction[node + 1] - curve.extinction[node]) / entry,
                 whole = std::nearbyint(depth / quantum) * quantum,
                 here = extinction(tf.evaluate(curve.value[node] + nudge).opacity),
                 tangent = here / SlabTable::nodes_an_entry;
    const bool linear = tangent > 2 * change || node == 0 || node == last;
    const double slope = linear ? change : tangent;
    depths.push_back({float(whole), float(depth - whole), float(slope), float(change - slope)});
  }
  return depths;
}

/// By entry: the steepness' code of values near it.
std::vector<int> steepness(const std::vector<double>& extinctions, double length) {
  const int last = TableAxis::last;
  std::vector<double> through;
  for (const double e : extinctions) through.push_back(std::exp(-2 * length * e));
  std::vector<int> codes;
  for (int entry = 0; entry <= last; ++entry) {
    double most = 0;
    for (int k = std::max(entry - SlabTable::steep_reach, 0);
         k < std::min(entry + SlabTable::steep_reach, last); ++k)
      most = std::max(most, std::abs(through[std::size_t(k)] - through[std::size_t(k) + 1]));
    codes.push_back(std::clamp(static_cast<int>(std::ceil(std::log2(std::max(most, 1e-9)) + 15)), 0, 15));
  }
  return codes;
}

}  // namespace

void SlabTable::make(const TransferFunction& transfer_function, double low, double high, double length) {
  const bool same_curve = axis_ && low == low_ && high == high_ && transfer_function == transfer_function_;
  if (same_curve && length == length_) return;
  if (!same_curve) {
    transfer_function_ = transfer_function;
    low_ = low;
    high_ = high;
    axis_.emplace(transfer_function_, low, high);
    curve_ = integrate(transfer_function_, *axis_);
    depths_.clear();
    if (axis_->coarse) depths_ = depths_of(transfer_function_, curve_, jump_nudge(*axis_));
  }
  length_ = length;
  constexpr std::size_t size = TableAxis::entries;
  entries_.resize(size * size);
  fill_slab_table(curve_, length, entries_);
  for (std::size_t i = 0; i < size; ++i)
    entries_[i * size + i] = uniform_slab(curve_.at_entry[i], curve_.colour[i], length);
  const std::vector<int> codes = steepness(curve_.at_entry, length);
  for (std::size_t front = 0; front < size; ++front) {
    int code = 0;
    for (std::size_t back = front; back < size; ++back) {
      code = std::max(code, codes[back]);
      const auto bits = std::uint64_t(code) << 60;
      entries_[front * size + back] |= bits;
      if (front != back) entries_[back * size + front] |= bits;
    }
  }
  if (!axis_->coarse) return;
  // A slab that no entry shows may have been rounded away: it keeps its colour.
  for (std::size_t i = 0; i < size * size; ++i) {
    if ((entries_[i] & 0xffff) != 0) continue;
    const glm::dvec3& colour = curve_.colour[(i / size + i % size) / 2];
    entries_[i] = packed({0, colour.r, colour.g, colour.b, 0.5, std::sqrt(1.0 / 12)});
  }
}

void ValueTable::make(const TransferFunction& transfer_function, double low, double high, bool whole_numbers,
                      double length) {
  const bool same_samples = !samples_.empty() && low == low_ && high == high_ &&
                            whole_numbers == whole_numbers_ && transfer_function == transfer_function_;
  if (same_samples && length == length_) return;
  if (!same_samples) {
    transfer_function_ = transfer_function;
    low_ = low;
    high_ = high;
    whole_numbers_ = whole_numbers;
    const double range = high - low, steps = std::floor((whole_numbers ? 1 : fine_steps) / range);
    steps_a_unit_ = std::min(std::max(1.0, steps), most_steps / range);
    samples_.clear();
    for (double step = 0; step <= std::ceil(range * steps_a_unit_); ++step) {
      const auto sample = transfer_function.evaluate(low + step / steps_a_unit_);
      samples_.push_back({extinction(sample.opacity), sample.colour});
    }
  }
  length_ = length;
  entries_.resize(samples_.size());
  std::transform(samples_.begin(), samples_.end(), entries_.begin(), [&](const Sample& sample) {
    return uniform_slab(sample.extinction, sample.colour, length);
  });
}

}  // namespace ringsplat
