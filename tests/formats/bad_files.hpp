#pragma once
#include <functional>
#include <string>
#include <vector>

#include "formats/files.hpp"
#include "ringsplat/formats/open.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"

namespace files {

/// A file that must be refused.
struct Bad {
  const char* what;
  const char* message;  ///< part of the expected message
  std::function<fs::path(const Folder&)> make;
  RawDescription raw = {};
};

inline Bad file(const char* what, const char* message, const char* name, const std::string& bytes,
                RawDescription raw = {}) {
  return {what, message, [=](const Folder& f) { return write(f / name, bytes); }, raw};
}

/// With the first `from` made `to`.
inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  REQUIRE(text.find(from) != std::string::npos);
  return text.replace(text.find(from), from.size(), to);
}

inline std::string complaint_about(const Bad& bad, const Folder& folder) {
  return message_of([&] {
    const auto source = open_volume(bad.make(folder), bad.raw);
    std::vector<std::byte> slice(source->grid().slice_bytes(Axis::z));
    for (int z = 0; z < source->grid().dims.z; ++z) source->read_slices(z, 1, slice);
  });
}

inline void check_all(const std::vector<Bad>& list) {
  for (const auto& bad : list) {
    const Folder folder;
    const auto text = complaint_about(bad, folder);
    CAPTURE(bad.what, text);
    CHECK(says(text, bad.message));
    CHECK(text.find('\n') == std::string::npos);
    CHECK(says(text, "hint: "));
  }
}

}  // namespace files
