#pragma once
#include <string>

#include "ringsplat/classify/transfer_function.hpp"
#include "ringsplat/volume/statistics.hpp"

namespace ringsplat::app {

/// The largest rise or fall of opacity, 0 to 1, within 1/64 of the values' range.
double steepness(const TransferFunction& tf, const ValueRange& range);

/// Why splats err with such a transfer function, by how much, and what to do; empty where it is gentle.
std::string why_splats_err(const TransferFunction& tf, const ValueRange& range);

/// The same of sheets, whose tables have a thousand nodes for all values; empty where these suffice.
std::string why_sheets_err(const TransferFunction& tf, const ValueRange& range);

/// Why sheets give labels each other's colours; empty where there are not too many values for that.
std::string why_labels_merge(const ValueRange& range);

}  // namespace ringsplat::app
