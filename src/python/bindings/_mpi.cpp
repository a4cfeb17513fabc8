// The Python module ringsplat._mpi: connects the processes of an mpi4py communicator. Built for one MPI
// library.
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include "mpi/communicator_handle.hpp"
#include "mpi/session.hpp"
#include "ringsplat/base/error.hpp"

namespace nb = nanobind;
using namespace ringsplat;

NB_MODULE(_mpi, m) {
  m.doc() = "Sessions on the ranks of an MPI communicator. Not for users.";
  nb::exception<RunError>(m, "RunError", PyExc_RuntimeError);
  m.def(
      "library", [] { return MpiSession::library(); }, "The MPI library that this module is linked with.");
  m.def("handle_bytes", &communicator_handle_bytes, "Bytes of an MPI_Comm.");
  m.def(
      "connect",
      [](std::uintptr_t handle) {
        std::unique_ptr<Processes> made;
        {
          const nb::gil_scoped_release without;
          made = std::make_unique<Processes>(connected_at(reinterpret_cast<const void*>(handle)));
        }
        const auto destroy = [](void* processes) noexcept { delete static_cast<Processes*>(processes); };
        return nb::capsule(made.release(), "ringsplat.Processes", destroy);
      },
      "Connects the processes of the communicator whose MPI_Comm is at this address; collective. A "
      "BlockSession of this "
      "build takes the capsule over.");
}
