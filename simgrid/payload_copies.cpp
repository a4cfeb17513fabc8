#include "payload_copies.hpp"

#include <smpi/smpi.h>

#include <algorithm>
#include <cstring>

#include "ringsplat/net/message.hpp"

namespace ringsplat::simgrid_platform {
namespace {

bool only_counts(const void* buffer, std::size_t size) {
  Header header;
  if (size <= counted_bytes) return false;
  std::memcpy(&header, buffer, sizeof(Header));
  return header.magic == Header{}.magic && header.kind == Kind::payload && header.counted != 0;
}

}  // namespace

void copy_only_what_counts() {
  smpi_comm_set_copy_data_callback([](smx_activity_t transfer, void* buffer, std::size_t size) {
    // SimGrid declares the same thing by two names and installs neither type.
    auto* const comm = reinterpret_cast<simgrid::kernel::activity::CommImpl*>(transfer);
    smpi_comm_copy_buffer_callback(comm, buffer, only_counts(buffer, size) ? counted_bytes : size);
  });
}

}  // namespace ringsplat::simgrid_platform
