#include "decode/hdf5/datasets.hpp"

#include <bit>
#include <limits>
#include <set>

#include "formats/limits.hpp"

namespace ringsplat::detail::hdf5 {
namespace {

constexpr int most_objects = 10'000, deepest = 32;
constexpr std::size_t most_listed = 20;

/// A dataset that could be a volume.
struct Found {
  std::string path, type;
  std::vector<int> dims;
};

/// Names of what lies in the group itself: links to elsewhere are not followed.
std::vector<std::string> names_in(hid_t group) {
  std::vector<std::string> names;
  const auto add = [](hid_t, const char* name, const H5L_info_t* info, void* data) -> herr_t {
    if (info->type == H5L_TYPE_HARD) static_cast<std::vector<std::string>*>(data)->emplace_back(name);
    return 0;
  };
  H5Literate(group, H5_INDEX_NAME, H5_ITER_NATIVE, nullptr, add, &names);
  return names;
}

/// Collects a group's datasets of numbers with two dimensions and more.
class Walk {
 public:
  explicit Walk(hid_t file) : file_(file) {}

  void group(const std::string& path, int depth = 0) {
    const Id id(H5Gopen2(file_, path.c_str(), H5P_DEFAULT));
    if (!id || depth > deepest || !first_visit(id.get())) return;
    for (const std::string& name : names_in(id.get())) {
      const std::string below = fmt::format("{}/{}", path == "/" ? "" : path, name);
      if (++objects_ > most_objects) return;
      const Id object(H5Oopen(id.get(), name.c_str(), H5P_DEFAULT));
      if (!object) {
        if (unreadable.empty()) unreadable = fmt::format("{} (HDF5: {})", below, innermost_reason());
        continue;
      }
      const H5I_type_t kind = H5Iget_type(object.get());
      if (kind == H5I_GROUP) group(below, depth + 1);
      if (kind == H5I_DATASET) dataset(object.get(), below);
    }
  }
  void dataset(hid_t id, const std::string& path) {
    const Id type(H5Dget_type(id));
    auto dims = dims_of(id);
    if (!type || dims.size() < 2) return;
    const auto value = value_type_of(type.get());
    if (value) found.push_back({path, value->name, std::move(dims)});
  }
  bool complete() const { return objects_ <= most_objects; }

  std::vector<Found> found;
  std::string unreadable;  ///< the first object that could not be opened, and why

 private:
  bool first_visit(hid_t group) {
    H5O_info_t info{};
    if (H5Oget_info2(group, &info, H5O_INFO_BASIC) < 0) return false;
    return visited_.insert(std::uint64_t(info.addr)).second;
  }

  hid_t file_;
  int objects_ = 0;
  std::set<std::uint64_t> visited_;
};

/// A dataset's path from the group `below`.
std::string name_of(const Found& found, const std::string& below) {
  const bool within = below != "/" && found.path.starts_with(below + "/");
  return excerpt(within ? found.path.substr(below.size() + 1) : found.path, 120);
}

std::string listed(const std::vector<Found>& found, const std::string& below) {
  std::string text;
  for (std::size_t k = 0; k < found.size() && k < most_listed; ++k)
    text += fmt::format("{}{} ({} {})", k == 0 ? "" : ", ", name_of(found[k], below),
                        joined(found[k].dims, "x"), found[k].type);
  if (found.size() > most_listed) text += fmt::format(" and {} more", found.size() - most_listed);
  return text;
}

/// The only dataset of three dimensions; in files without any, of two.
std::string only_one(const Walk& walk, const std::filesystem::path& path, const std::string& below) {
  auto found = walk.found;
  std::sort(found.begin(), found.end(), [](const Found& a, const Found& b) { return a.path < b.path; });
  for (const int least : {3, 2, 0}) {
    std::vector<Found> fit;
    std::copy_if(found.begin(), found.end(), std::back_inserter(fit), [&](const Found& one) {
      return std::count_if(one.dims.begin(), one.dims.end(), [](int size) { return size > 1; }) >= least;
    });
    if (fit.size() == 1 && walk.complete()) return fit.front().path;
    if (fit.empty()) continue;
    throw InputError(fmt::format("{} holds several datasets: {}{}", path.string(), listed(fit, below),
                                 walk.complete() ? "" : " and more"),
                     fmt::format("name one: {}:{}", path.string(), name_of(fit.front(), below)));
  }
  if (!walk.unreadable.empty())
    refuse(path, "the file is damaged, or a newer HDF5 wrote it: copy it again, or h5repack it there",
           "cannot open {}", excerpt(walk.unreadable, 300));
  throw InputError(fmt::format("{} holds no dataset of numbers with three dimensions", path.string()),
                   "h5dump -n lists what it holds");
}

/// openPMD's iterations in one file: the numbers in place of %T.
Iterations choose_iteration(hid_t file, const std::filesystem::path& path, const VolumeChoice& choice) {
  const Id root(H5Gopen2(file, "/", H5P_DEFAULT));
  Iterations all;
  if (!root || !text_of(root.get(), "openPMD")) return all;
  const auto base = text_of(root.get(), "basePath").value_or("/data/%T/");
  const auto at = base.find("%T");
  if (at == std::string::npos) return all;
  const std::string before = base.substr(0, at);
  const Id group(H5Gopen2(file, before.c_str(), H5P_DEFAULT));
  if (!group || base.substr(at + 2) != "/") return all;
  std::vector<std::uint64_t> numbers;
  for (const auto& name : names_in(group.get()))
    if (const auto number = number_in<std::uint64_t>(name)) numbers.push_back(*number);
  if (numbers.empty()) return all;
  std::sort(numbers.begin(), numbers.end());
  all.count = int(numbers.size());
  const int frame = chosen_frame(choice, all.count, path, "iterations");
  all.group = before + fmt::format("{}", numbers[std::size_t(frame)]);
  return all;
}

}  // namespace

std::optional<ValueType> value_type_of(hid_t type) {
  const std::size_t size = H5Tget_size(type);
  const H5T_class_t kind = H5Tget_class(type);
  if (kind == H5T_ENUM) {
    const Id base(H5Tget_super(type));
    auto value = base ? value_type_of(base.get()) : std::nullopt;
    if (!value) return {};
    value->labels = true;
    value->name = H5Tget_nmembers(type) == 2 && size == 1 ? "bool" : "enumeration of " + value->name;
    return value;
  }
  const bool whole = kind == H5T_INTEGER;
  if ((!whole && kind != H5T_FLOAT) || size > sizeof(double)) return {};
  const char* const numbers = !whole ? "float" : H5Tget_sign(type) == H5T_SGN_2 ? "int" : "uint";
  const auto name_of = [&](std::size_t bytes) { return fmt::format("{}{}", numbers, 8 * bytes); };
  const auto* const held = number_type(name_of(std::bit_ceil(whole ? size : std::max<std::size_t>(size, 2))));
  return ValueType{held->type, whole && size > sizeof(std::int32_t), false, name_of(size)};
}

std::vector<int> dims_of(hid_t dataset) {
  const Id space(H5Dget_space(dataset));
  if (!space || H5Sget_simple_extent_type(space.get()) != H5S_SIMPLE) return {};
  const int rank = H5Sget_simple_extent_ndims(space.get());
  if (rank < 1 || rank > H5S_MAX_RANK) return {};
  std::vector<hsize_t> sizes(std::size_t(rank), 0);
  H5Sget_simple_extent_dims(space.get(), sizes.data(), nullptr);
  std::vector<int> dims;
  for (const hsize_t size : sizes) {
    if (size < 1 || size > hsize_t(std::numeric_limits<int>::max())) return {};
    dims.push_back(int(size));
  }
  return dims;
}

Id open_object(hid_t file, const std::string& path, const std::string& where) {
  // At a link to another file it fails.
  const Id access(H5Pcreate(H5P_LINK_ACCESS));
  const auto refuse = [](const char*, const char*, const char*, const char*, unsigned*, hid_t,
                         void*) -> herr_t { return -1; };
  H5Pset_elink_cb(access.get(), refuse, nullptr);
  Id object(H5Oopen(file, path.c_str(), access.get()));
  if (!object)
    fail(fmt::format("{}: it is not there, damaged, or in another file that a link names", where),
         "h5dump -n lists what the file holds; links to other files are not followed");
  return object;
}

std::string choose_dataset(hid_t file, const std::filesystem::path& path, const std::string& named,
                           const VolumeChoice& choice, Iterations& iterations) {
  iterations = choose_iteration(file, path, choice);
  Walk walk(file);
  if (named.empty() || named == "/") {
    if (H5Lexists(file, "VTKHDF", H5P_DEFAULT) > 0) {
      walk.group("/VTKHDF/PointData");
      walk.group("/VTKHDF/CellData");
    }
    if (walk.found.empty()) walk.group(iterations.group);
    return only_one(walk, path, iterations.group);
  }
  std::string full = named.front() == '/' ? named : fmt::format("/{}", named);
  const bool whole = H5Lexists(file, named.substr(0, named.find('/', 1)).c_str(), H5P_DEFAULT) > 0;
  if (iterations.group != "/" && !whole)
    full = iterations.group + full;
  else
    iterations = {};
  while (full.size() > 1 && full.back() == '/') full.pop_back();
  const Id object = open_object(file, full, path.string() + ":" + excerpt(named, 200));
  if (H5Iget_type(object.get()) == H5I_DATASET) return full;
  walk.group(full);
  return only_one(walk, path, iterations.group);
}

}  // namespace ringsplat::detail::hdf5
