#pragma once
#include <functional>
#include <vector>

#include "app/render_job.hpp"

namespace ringsplat::app {

/// By rank: whether it brings cores that earlier ranks of its machine have not, so that those chosen may use
/// all cores together; at most so many of a machine, and always rank 0.
std::vector<bool> ranks_for_all_cores(const std::vector<Binding>& bindings, double most_of_machine);

/// Measures a picture of the scene's frame.
using Measure = std::function<MeasuredError(Image& image)>;

/// Has rank 0 measure pictures with `measure_all`, which sets the scene's frame before each. As many other
/// ranks as bring further cores, and as memory lets, read the whole volume, too, and evaluate their share of
/// the truths. All ranks call it; the InputError that one throws all throw.
void measure_together(const Job& job, Launch& launch,
                      const std::function<void(truth::Scene& scene, const Measure& measure)>& measure_all);

}  // namespace ringsplat::app
