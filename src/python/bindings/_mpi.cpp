// The Python module ringsplat._mpi: connects the processes of an mpi4py communicator. Built for one MPI
// library.
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include "mpi/session.hpp"
#include "ringsplat/base/error.hpp"

namespace nb = nanobind;
using namespace ringsplat;

namespace {

/// Makes what _core's BlockSession takes over.
nb::capsule connect(int number) {
  Processes processes;
  try {
    const nb::gil_scoped_release without;
    processes = connected_by_number(number);
  } catch (const RunError& error) {
    // An exception type of this module's own would come in place of _core's in the whole process.
    PyErr_SetString(nb::module_::import_("ringsplat._core").attr("RunError").ptr(), error.what());
    throw nb::python_error();
  }
  const auto destroy = [](void* held) noexcept { delete static_cast<Processes*>(held); };
  return nb::capsule(new Processes(std::move(processes)), "ringsplat.Processes", destroy);
}

}  // namespace

NB_MODULE(_mpi, m) {
  m.doc() = "Sessions on the ranks of an MPI communicator. Not for users.";
  m.def("library", &MpiSession::library, "The MPI library that this module is linked with.");
  m.def("connect", &connect,
        "Connects the processes of the communicator with this number in Fortran; collective.");
}
