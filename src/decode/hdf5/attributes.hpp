#pragma once
#include <optional>
#include <string>
#include <vector>

#include "decode/hdf5/library.hpp"

/// Attributes as conventions use them. One that is missing, of another kind, unreadable or unreasonably long
/// gives nothing: attributes only describe, the voxels can be drawn without them.
namespace ringsplat::detail::hdf5 {

/// A text, of fixed or variable length; the first of several.
std::optional<std::string> text_of(hid_t object, const char* attribute);
/// All texts of a one-dimensional attribute.
std::vector<std::string> texts_of(hid_t object, const char* attribute);
/// All numbers, integers as double.
std::vector<double> numbers_of(hid_t object, const char* attribute);
/// The first of the numbers.
std::optional<double> number_of(hid_t object, const char* attribute);
/// All numbers of a dataset with at most 2²⁰ of them that lie in its own file.
std::vector<double> numbers_in(hid_t dataset);
/// The objects that a netCDF variable's DIMENSION_LIST names for its axes, each its first one; no identifier
/// where an axis has none. Empty without such an attribute.
std::vector<Id> scales_of(hid_t dataset, int axes);

}  // namespace ringsplat::detail::hdf5
