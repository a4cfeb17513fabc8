#pragma once
#include <cfenv>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace ringsplat {

/// Peak resident memory of this process so far, in bytes (Linux: VmHWM).
std::uint64_t peak_memory_bytes();

/// Memory of this machine, or what a batch system or a container leaves this process of it (cgroups, version
/// 2), in bytes.
double machine_memory_bytes();

/// The name of this machine; empty when it is not known.
std::string host_name();

/// Names the clock behind now_seconds() (Linux: the machine's boot). Processes with the same name read the
/// same clock. Empty when it is not known.
std::string clock_identity();

/// Cores that this process may run on (Linux: its affinity mask, which launchers narrow, and no more than its
/// control group's time is for). Each is named by the first of its hardware threads. At least one.
std::vector<int> allowed_cores();

/// Opens /dev/null in place of stdin, stdout and stderr where they are closed. Otherwise the next file opened
/// would take their descriptor, and printed text would go into it.
void keep_standard_descriptors();

/// The folder of the program, or of the shared library, that this code is part of; empty where it is unknown.
std::filesystem::path own_folder();

/// The folders where the loader looks for that program's or library's own libraries.
std::vector<std::filesystem::path> own_search_path();

struct Unmap {
  std::size_t bytes = 0;
  void operator()(std::byte* memory) const;
};
/// Its deleter knows how many bytes there are.
using MappedMemory = std::unique_ptr<std::byte[], Unmap>;
/// Zeros, of which only pages that are touched take memory. Throws std::bad_alloc.
MappedMemory map_memory(std::size_t bytes);

/// Asks for large pages for memory that is not yet in use. Slices, tables and pictures are read all over, and
/// finding a page takes longer than reading from it, above all in virtual machines. Only a hint: the system
/// may ignore it.
void prefer_huge_pages(void* memory, std::size_t bytes);

/// The same for the heap, up to some 256 MiB, which the process then keeps. Call it once, at the start,
/// before there are threads (glibc only).
void prefer_huge_pages_in_heap();

/// Makes this thread treat denormal floats as zero, as operands and as results, where the processor can. They
/// cost hundreds of cycles and weigh nothing in a picture.
void flush_denormals();

/// While it lives this thread computes as programs do by default: rounding to nearest, denormals, no traps.
/// So what is read or derived of a volume does not depend on whether frames were drawn before. Then the
/// caller's environment is restored, with its flags.
class PlainFloats {
 public:
  PlainFloats();
  ~PlainFloats();
  PlainFloats(const PlainFloats&) = delete;
  PlainFloats& operator=(const PlainFloats&) = delete;

 private:
  std::fenv_t before_;
};

}  // namespace ringsplat
