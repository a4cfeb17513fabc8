// Fails on purpose, on one rank only, while the others wait for it; check_failing_rank.cmake says what must
// come of it.
#include <mpi.h>

#include <stdexcept>

#include "support/catch.hpp"

namespace {
int my_rank() {
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  return rank;
}
}  // namespace

TEST_CASE("an assertion fails on one rank", "[assertion]") {
  INFO("the planted fault");
  if (my_rank() == 1) REQUIRE(my_rank() == 7);
  MPI_Barrier(MPI_COMM_WORLD);
}

TEST_CASE("an exception leaves the test on one rank", "[exception]") {
  if (my_rank() == 1) throw std::runtime_error("the planted fault");
  MPI_Barrier(MPI_COMM_WORLD);
}

TEST_CASE("nothing fails", "[fine]") {
  CHECK(my_rank() >= 0);
  MPI_Barrier(MPI_COMM_WORLD);
}
