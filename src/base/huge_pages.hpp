#pragma once
#include <cstddef>

namespace ringsplat {

/// Asks for large pages for memory that is not yet in use. Slices, tables and pictures are read all over, and
/// finding a page takes longer than reading from it, above all in virtual machines. Only a hint: the system
/// may ignore it.
void prefer_huge_pages(void* memory, std::size_t bytes);

/// The same for the heap, up to some 256 MiB, which the process then keeps. Call it once, at the start,
/// before there are threads (glibc only).
void prefer_huge_pages_in_heap();

}  // namespace ringsplat
