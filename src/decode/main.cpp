#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdio>
#include <string_view>

#include "decode/server.hpp"
#include "formats/decode/messages.hpp"

/// Reads volumes for a process that starts it with a socket and memory that both share.
int main(int argc, char** argv) {
  int type = 0;
  socklen_t size = sizeof type;
  if (argc != 2 || getsockopt(ringsplat::detail::decode_socket, SOL_SOCKET, SO_TYPE, &type, &size) != 0) {
    std::fputs("ringsplat-decode reads DICOM, TIFF and HDF5 for ringsplat, which starts it\n", stderr);
    return 2;
  }
  if (std::string_view(argv[1]) != RINGSPLAT_VERSION) return ringsplat::detail::other_version_code;
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  ringsplat::decode::serve();
  _exit(0);  // libraries cannot always close damaged files
}
