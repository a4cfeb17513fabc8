#pragma once
#include <mpi.h>

#include <memory>

#include "net/collectives.hpp"
#include "net/transport.hpp"

namespace ringsplat {

/// Largest number of bytes in one MPI message; longer ones go in parts, since counts are `int`.
inline constexpr std::size_t largest_mpi_part = std::size_t{1} << 30;

/// Both duplicate `comm` (a collective call) and return errors as exceptions (RunError). All ranks
/// must give the same `largest_part` (at least a header's size); tests use small ones. Simulated ranks have a
/// transport of their own (simulate/smpi).
std::unique_ptr<Transport> make_mpi_transport(MPI_Comm comm, std::size_t largest_part = largest_mpi_part);
std::unique_ptr<Collectives> make_mpi_collectives(MPI_Comm comm, std::size_t largest_part = largest_mpi_part);

}  // namespace ringsplat
