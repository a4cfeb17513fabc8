#pragma once
#include <cstddef>
#include <memory>
#include <type_traits>
#include <vector>

namespace ringsplat {

/// Leaves new elements uninitialised: payload buffers are written whole right after they grow.
template <class T>
struct UninitialisedAllocator : std::allocator<T> {
  using std::allocator<T>::allocator;
  template <class U>
  void construct(U* p) noexcept(std::is_nothrow_default_constructible_v<U>) {
    ::new (static_cast<void*>(p)) U;
  }
};

using Bytes = std::vector<std::byte, UninitialisedAllocator<std::byte>>;

}  // namespace ringsplat
