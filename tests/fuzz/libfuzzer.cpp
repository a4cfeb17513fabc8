// The drivers for clang's libFuzzer, which finds inputs by the code that they reach; tests/fuzz/README.md
// says how. RINGSPLAT_FUZZ_DRIVER names the driver, and the words and seeds are in this folder.
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "fuzz/driver.hpp"
#include "ringsplat/base/error.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const ringsplat::fuzz::Driver* const driver = [] {
    const char* const wanted = std::getenv("RINGSPLAT_FUZZ_DRIVER");
    for (const auto& one : ringsplat::fuzz::drivers())
      if (wanted != nullptr && std::string_view(wanted) == one.name) return &one;
    std::fputs("RINGSPLAT_FUZZ_DRIVER names no driver\n", stderr);
    std::exit(2);
  }();
  try {
    driver->run(std::as_bytes(std::span(data, size)));
  } catch (const ringsplat::Error&) {
    // The right answer to bad input.
  }
  return 0;
}
