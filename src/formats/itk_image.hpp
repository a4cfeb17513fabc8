#pragma once
#include <itkImageIOBase.h>

#include <filesystem>
#include <iostream>
#include <memory>
#include <sstream>

#include "base/text.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/volume/source.hpp"

namespace ringsplat::detail {

/// Discards what ITK and its libraries print while it lives: errors come as exceptions, and stdout is for
/// results. Of what libraries in C write to stderr, as libjpeg does, the first line becomes a warning that
/// names the file, unless an exception says more. Not for several threads at once.
class QuietItk {
 public:
  explicit QuietItk(std::filesystem::path path);
  ~QuietItk();
  QuietItk(const QuietItk&) = delete;
  QuietItk& operator=(const QuietItk&) = delete;

 private:
  std::ostringstream sink_;
  std::streambuf *out_, *err_;
  bool warnings_;
  std::filesystem::path path_;
  int stderr_ = -1, caught_ = -1;  ///< descriptors: where stderr went before, where it goes now
  int exceptions_;
};

/// The message in one line, without the class and the address that ITK puts in front.
std::string description_of(const itk::ExceptionObject& error);

/// Runs `f` with ITK quiet; turns its exceptions into an InputError naming the file.
template <class F>
decltype(auto) with_itk(const std::filesystem::path& path, F&& f) {
  std::string problem;
  try {
    const QuietItk quiet(path);
    return f();
  } catch (const Error&) {
    throw;
  } catch (const itk::ExceptionObject& error) {
    problem = description_of(error);
  } catch (const std::exception& error) {
    problem = one_line(error.what());
  }
  throw InputError("cannot read " + path.string() + ": " + problem, "check the file with another viewer");
}

/// The C++ type of ITK's component; throws InputError for types no volume may have (64-bit integers).
ScalarType scalar_type_of(const itk::ImageIOBase& io, const std::filesystem::path& path);

/// The first three axes that ReadImageInformation found, without the type. Throws InputError for what check()
/// refuses. A 2D image is one slice.
Grid lattice_of(const itk::ImageIOBase& io, const std::filesystem::path& path);

/// The grid that ReadImageInformation found. Throws InputError for vectors, colours, 64-bit integers, more
/// than three dimensions, and what lattice_of() refuses.
Grid grid_of(const itk::ImageIOBase& io, const std::filesystem::path& path);

/// A source for encodings that only ITK can decode, and only as a whole: the first read keeps the whole
/// volume. Not concurrent.
std::unique_ptr<VolumeSource> itk_source(itk::ImageIOBase::Pointer io, const Grid& grid,
                                         const std::filesystem::path& path);

}  // namespace ringsplat::detail
