#include "simulate/simgrid/link_monitor.hpp"

#include <smpi/smpi.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "net/message.hpp"
#include "simulate/counted_payload.hpp"

namespace ringsplat::simgrid_platform {
namespace {

using Callback = std::function<void(std::size_t)>;

/// Never freed: SimGrid copies until the process ends, when statics may be gone.
Callback& payload_callback() {
  static auto* const callback = new Callback();
  return *callback;
}

void copy(smx_activity_t transfer, void* buffer, std::size_t size) {
  Header header;
  bool payload = false, counted = false;
  if (size >= sizeof(Header)) {
    std::memcpy(&header, buffer, sizeof(Header));
    counted = header.magic == counted_magic;
    payload = (counted || header.magic == Header{}.magic) && header.kind == Kind::payload;
  }
  if (payload && payload_callback()) payload_callback()(size);
  const std::size_t said = payload && counted ? std::min(size, counted_bytes) : size;
  // SimGrid declares the same type under two names and installs neither.
  smpi_comm_copy_buffer_callback(reinterpret_cast<simgrid::kernel::activity::CommImpl*>(transfer), buffer,
                                 said);
}

}  // namespace

void copy_only_what_counts() { smpi_comm_set_copy_data_callback(copy); }

void on_payload_copied(Callback callback) { payload_callback() = std::move(callback); }

}  // namespace ringsplat::simgrid_platform
