#include "decode/hdf5/library.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/printable.hpp"

namespace ringsplat::detail::hdf5 {
namespace {

constexpr hssize_t most_values = 64;
constexpr std::size_t longest_text = 4096;

struct Attribute {
  Id id, type, space;
  hssize_t values = 0;
};

std::optional<Attribute> find(hid_t object, const char* name) {
  if (H5Aexists(object, name) <= 0) return {};
  Attribute found;
  found.id = Id(H5Aopen(object, name, H5P_DEFAULT));
  if (!found.id) return {};
  found.type = Id(H5Aget_type(found.id.get()));
  found.space = Id(H5Aget_space(found.id.get()));
  if (!found.type || !found.space) return {};
  found.values = H5Sget_simple_extent_npoints(found.space.get());
  if (found.values < 1 || found.values > most_values) return {};
  return found;
}

std::string up_to_end(const char* text, std::size_t most) {
  std::string found(text, std::find(text, text + most, '\0'));
  while (!found.empty() && found.back() == ' ') found.pop_back();
  return found;
}

std::vector<std::string> variable_texts(const Attribute& from) {
  std::vector<char*> pointers(std::size_t(from.values), nullptr);
  const Id type(H5Tcopy(H5T_C_S1));
  H5Tset_size(type.get(), H5T_VARIABLE);
  H5Tset_cset(type.get(), H5Tget_cset(from.type.get()));
  if (H5Aread(from.id.get(), type.get(), pointers.data()) < 0) return {};
  std::vector<std::string> texts;
  for (const char* pointer : pointers)
    texts.push_back(pointer == nullptr ? "" : up_to_end(pointer, longest_text));
  H5Dvlen_reclaim(type.get(), from.space.get(), H5P_DEFAULT, pointers.data());
  return texts;
}

}  // namespace

std::string innermost_reason() {
  std::string reason;
  const auto keep_first = [](unsigned, const H5E_error2_t* error, void* kept) -> herr_t {
    if (error->desc != nullptr) *static_cast<std::string*>(kept) = error->desc;
    return 1;  // ends the walk
  };
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, keep_first, &reason);
  constexpr std::size_t longest = 200;
  return excerpt(reason, longest);
}

void fail(const std::string& problem, const std::string& hint) {
  const std::string reason = innermost_reason();
  throw InputError(reason.empty() ? problem : fmt::format("{} (HDF5: {})", problem, reason), hint);
}

Id open_file(const std::filesystem::path& file) {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // prints nothing
  const Id access(H5Pcreate(H5P_FILE_ACCESS));
  H5Pset_file_locking(access.get(), false, true);
  H5Pset_fclose_degree(access.get(), H5F_CLOSE_WEAK);
  H5Pset_cache(access.get(), 0, 0, 0, 0);  // whole layers are read at once, so no chunk is asked for twice
  return made(H5Fopen(file.c_str(), H5F_ACC_RDONLY, access.get()),
              fmt::format("cannot open {}", file.string()));
}

std::vector<std::string> texts_of(hid_t object, const char* attribute) {
  const auto found = find(object, attribute);
  if (!found || H5Tget_class(found->type.get()) != H5T_STRING) return {};
  if (H5Tis_variable_str(found->type.get()) > 0) return variable_texts(*found);
  const std::size_t size = H5Tget_size(found->type.get());
  if (size < 1 || size > longest_text) return {};
  std::vector<char> bytes(size * std::size_t(found->values));
  if (H5Aread(found->id.get(), found->type.get(), bytes.data()) < 0) return {};
  std::vector<std::string> texts;
  for (std::size_t at = 0; at < bytes.size(); at += size) texts.push_back(up_to_end(&bytes[at], size));
  return texts;
}

std::vector<double> numbers_of(hid_t object, const char* attribute) {
  const auto found = find(object, attribute);
  if (!found) return {};
  const H5T_class_t kind = H5Tget_class(found->type.get());
  if (kind != H5T_INTEGER && kind != H5T_FLOAT) return {};
  std::vector<double> numbers(std::size_t(found->values), NAN);
  if (H5Aread(found->id.get(), H5T_NATIVE_DOUBLE, numbers.data()) < 0) return {};
  return numbers;
}

std::vector<double> numbers_in(hid_t dataset) {
  constexpr hssize_t most = 1 << 20;
  if (H5Iget_type(dataset) != H5I_DATASET) return {};
  const Id space(H5Dget_space(dataset)), type(H5Dget_type(dataset)), creation(H5Dget_create_plist(dataset));
  if (!space || !type || !creation) return {};
  const auto count = H5Sget_simple_extent_npoints(space.get());
  if (count < 1 || count > most) return {};
  if (H5Pget_layout(creation.get()) == H5D_VIRTUAL || H5Pget_external_count(creation.get()) != 0) return {};
  const H5T_class_t kind = H5Tget_class(type.get());
  if (kind != H5T_INTEGER && kind != H5T_FLOAT) return {};
  std::vector<double> values(std::size_t(count), NAN);
  if (H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0) return {};
  return values;
}

std::vector<Id> scales_of(hid_t dataset, int axes) {
  const auto found = find(dataset, "DIMENSION_LIST");
  if (!found || found->values != axes || H5Tget_class(found->type.get()) != H5T_VLEN) return {};
  const Id of_list(H5Tget_super(found->type.get()));
  if (!of_list || H5Tequal(of_list.get(), H5T_STD_REF_OBJ) <= 0) return {};
  const Id type(H5Tvlen_create(H5T_STD_REF_OBJ));
  std::vector<hvl_t> lists(std::size_t(axes), hvl_t{0, nullptr});
  if (H5Aread(found->id.get(), type.get(), lists.data()) < 0) return {};
  std::vector<Id> scales;
  for (const hvl_t& list : lists) {
    const bool named = list.len > 0 && list.p != nullptr;
    scales.emplace_back(named ? H5Rdereference2(dataset, H5P_DEFAULT, H5R_OBJECT, list.p) : H5I_INVALID_HID);
  }
  H5Dvlen_reclaim(type.get(), found->space.get(), H5P_DEFAULT, lists.data());
  return scales;
}

}  // namespace ringsplat::detail::hdf5
