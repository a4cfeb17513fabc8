#pragma once
#include <zlib.h>

#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <span>
#include <string_view>

namespace ringsplat::detail {

/// A file that appears under its name only when it is whole: written beside it, then renamed.
/// Removes what it wrote when it is destroyed before commit().
class OutputFile {
 public:
  /// Throws InputError when the folder cannot be written.
  explicit OutputFile(std::filesystem::path path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// Everything written from here on is one gzip stream.
  void begin_gzip();
  /// Throws RunError when the disk is full or fails.
  void write(std::span<const std::byte> bytes);
  void write(std::string_view text) { write(std::as_bytes(std::span(text))); }
  void commit();

 private:
  [[noreturn]] void fail(const char* what);
  void close();

  std::filesystem::path path_, beside_;
  std::FILE* file_ = nullptr;
  gzFile gzip_ = nullptr;
};

}  // namespace ringsplat::detail
