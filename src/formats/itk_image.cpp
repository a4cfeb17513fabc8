#include "formats/itk_image.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <limits>
#include <utility>
#include <vector>

#include "base/log.hpp"
#include "formats/limits.hpp"
#include "formats/volume_files.hpp"
#include "formats/whole_source.hpp"

namespace ringsplat::detail {
namespace {

/// A 2D image's axes have two components; the third becomes 0, and the third axis stays z.
glm::dvec3 vec3(const std::vector<double>& values) {
  glm::dvec3 v(0);
  for (std::size_t i = 0; i < 3 && i < values.size(); ++i) v[int(i)] = values[i];
  return v;
}

class ItkSource final : public WholeSource {
 public:
  ItkSource(itk::ImageIOBase::Pointer io, const Grid& grid, std::filesystem::path path)
      : WholeSource(grid), io_(std::move(io)), path_(std::move(path)), files_({path_}) {}
  Facts facts() const override {
    Facts facts = files_.facts();
    facts.insert(facts.begin(), {"encoding", "decoded as a whole"});
    return facts;
  }

 private:
  void decode(std::span<std::byte> voxels) override {
    files_.require_unchanged(path_);
    with_itk(path_, [&] {
      itk::ImageIORegion whole(io_->GetNumberOfDimensions());
      for (unsigned i = 0; i < io_->GetNumberOfDimensions(); ++i) whole.SetSize(i, io_->GetDimensions(i));
      io_->SetIORegion(whole);
      io_->Read(voxels.data());
    });
    files_.require_unchanged(path_);
  }

  itk::ImageIOBase::Pointer io_;
  std::filesystem::path path_;
  VolumeFiles files_;
};

/// Passes our own lines, which other threads may have logged meanwhile, on to stderr.
std::string first_foreign_line(int caught) {
  std::string text(std::size_t(std::max<off_t>(0, ::lseek(caught, 0, SEEK_END))), '\0');
  text.resize(std::size_t(std::max<ssize_t>(0, ::pread(caught, text.data(), text.size(), 0))));
  std::istringstream lines(text);
  std::string first;
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("ringsplat"))
      std::fprintf(stderr, "%s\n", line.c_str());
    else if (first.empty())
      first = line;
  return first;
}

}  // namespace

QuietItk::QuietItk(std::filesystem::path path)
    : out_(std::cout.rdbuf(sink_.rdbuf())),
      err_(std::cerr.rdbuf(sink_.rdbuf())),
      warnings_(itk::Object::GetGlobalWarningDisplay()),
      path_(std::move(path)),
      exceptions_(std::uncaught_exceptions()) {
  itk::Object::SetGlobalWarningDisplay(false);
  std::fflush(stderr);
  stderr_ = ::fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 0);
  caught_ = ::memfd_create("stderr", MFD_CLOEXEC);
  if (stderr_ >= 0 && caught_ >= 0) ::dup2(caught_, STDERR_FILENO);
}

QuietItk::~QuietItk() {
  std::fflush(stderr);
  std::string theirs;
  if (stderr_ >= 0 && caught_ >= 0) {
    ::dup2(stderr_, STDERR_FILENO);
    theirs = first_foreign_line(caught_);
  }
  for (const int descriptor : {stderr_, caught_})
    if (descriptor >= 0) ::close(descriptor);
  if (!theirs.empty() && std::uncaught_exceptions() == exceptions_)
    log_warning_once("{}: {}", path_.string(), theirs);
  itk::Object::SetGlobalWarningDisplay(warnings_);
  std::cout.rdbuf(out_);
  std::cerr.rdbuf(err_);
}

std::string description_of(const itk::ExceptionObject& error) {
  const std::string text = one_line(error.GetDescription());
  const auto address = text.rfind("(0x", text.find("): "));
  return address == std::string::npos ? text : text.substr(text.find("): ") + 3);
}

ScalarType scalar_type_of(const itk::ImageIOBase& io, const std::filesystem::path& path) {
  using Component = itk::IOComponentEnum;
  switch (io.GetComponentType()) {
    case Component::CHAR:
      return ScalarType::int8;
    case Component::UCHAR:
      return ScalarType::uint8;
    case Component::SHORT:
      return ScalarType::int16;
    case Component::USHORT:
      return ScalarType::uint16;
    case Component::INT:
      return ScalarType::int32;
    case Component::UINT:
      return ScalarType::uint32;
    case Component::FLOAT:
      return ScalarType::float32;
    case Component::DOUBLE:
      return ScalarType::float64;
    default:
      break;
  }
  throw InputError(fmt::format("{}: voxels of type {} cannot be rendered", path.string(),
                               itk::ImageIOBase::GetComponentTypeAsString(io.GetComponentType())),
                   "convert them to int32, uint32 or float32 first");
}

Grid lattice_of(const itk::ImageIOBase& io, const std::filesystem::path& path) {
  Grid grid;
  const unsigned dimensions = std::min(io.GetNumberOfDimensions(), 3U);
  for (unsigned i = 0; i < dimensions; ++i)
    if (io.GetDimensions(i) > std::size_t(std::numeric_limits<int>::max()))
      throw InputError(fmt::format("{}: {} voxels along axis {}", path.string(), io.GetDimensions(i), i),
                       "correct the sizes in the header");
  grid.dims = glm::ivec3(1);
  for (unsigned i = 0; i < dimensions; ++i) {
    grid.dims[int(i)] = int(io.GetDimensions(i));
    grid.spacing[int(i)] = io.GetSpacing(i);
    grid.origin[int(i)] = io.GetOrigin(i);
    grid.direction[int(i)] = vec3(io.GetDirection(i));
  }
  check_lattice(grid, path.string());
  return grid;
}

Grid grid_of(const itk::ImageIOBase& io, const std::filesystem::path& path) {
  if (io.GetNumberOfComponents() != 1)
    throw InputError(fmt::format("{}: {} values per voxel", path.string(), io.GetNumberOfComponents()),
                     "only scalar volumes can be rendered: extract one channel");
  const auto type = scalar_type_of(io, path);
  for (unsigned i = 3; i < io.GetNumberOfDimensions(); ++i)
    if (io.GetDimensions(i) > 1)
      throw InputError(fmt::format("{}: {} dimensions", path.string(), io.GetNumberOfDimensions()),
                       "extract one volume of the series");
  Grid grid = lattice_of(io, path);
  grid.type = type;
  check_lattice(grid, path.string());
  return grid;
}

std::unique_ptr<VolumeSource> itk_source(itk::ImageIOBase::Pointer io, const Grid& grid,
                                         const std::filesystem::path& path) {
  return std::make_unique<ItkSource>(std::move(io), grid, path);
}

}  // namespace ringsplat::detail
