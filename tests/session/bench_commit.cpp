// Times Session::commit() against a plain all-to-all of the same bytes, and says what memory it takes:
//
//     mpirun -n 8 bench_commit [VOXELS [ROUNDS]]
//
// The volume has VOXELS^3 voxels of 16 bits, a brick on each rank.
#include <fmt/format.h>
#include <mpi.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "ringsplat/ringsplat.hpp"

namespace {

constexpr double mebi = 1 << 20;

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

/// This process's line of /proc/self/status, in MiB.
double memory(const std::string& field) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with(field + ":")) return std::stod(line.substr(field.size() + 1)) / 1024;
  return 0;
}

void forget_peak() { std::ofstream("/proc/self/clear_refs") << "5"; }

template <class Work>
std::vector<double> timed(int rounds, const Work& work) {
  std::vector<double> seconds;
  for (int k = 0; k < rounds; ++k) {
    MPI_Barrier(MPI_COMM_WORLD);
    const double begin = MPI_Wtime();
    work();
    MPI_Barrier(MPI_COMM_WORLD);
    seconds.push_back(MPI_Wtime() - begin);
  }
  return seconds;
}

ringsplat::VoxelBox brick_of(int rank, int ranks, int voxels) {
  std::array<int, 3> counts{};
  MPI_Dims_create(ranks, 3, counts.data());
  const glm::ivec3 place(rank % counts[0], rank / counts[0] % counts[1], rank / (counts[0] * counts[1]));
  const glm::ivec3 dims(counts[0], counts[1], counts[2]);
  return {voxels * place / dims, voxels * (place + 1) / dims};
}

}  // namespace

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  int rank = 0, ranks = 1;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  const int voxels = argc > 1 ? std::atoi(argv[1]) : 512, rounds = argc > 2 ? std::atoi(argv[2]) : 5;
  const ringsplat::VoxelBox brick = brick_of(rank, ranks, voxels);
  const glm::ivec3 dims = brick.dims();
  std::vector<unsigned short> values(std::size_t(dims.x) * std::size_t(dims.y) * std::size_t(dims.z), 7);
  const double block = double(values.size()) * sizeof(unsigned short) / mebi;

  ringsplat::Grid grid;
  grid.dims = glm::ivec3(voxels);
  grid.type = ringsplat::ScalarType::uint16;
  std::vector<double> commits;
  double before = 0, during = 0;
  {
    ringsplat::Session session(MPI_COMM_WORLD);
    session.set_grid(grid);
    session.add_block(brick, values.data());
    before = memory("VmRSS");
    forget_peak();
    session.commit();
    during = memory("VmHWM");
    commits = timed(rounds, [&] { session.commit(); });
  }
  const std::size_t all = std::size_t(voxels) * std::size_t(voxels) * std::size_t(voxels);
  const std::size_t each = all / std::size_t(ranks) / std::size_t(ranks);
  values.resize(each * std::size_t(ranks), 7);
  std::vector<unsigned short> received(values.size());
  const auto exchange = timed(rounds, [&] {
    MPI_Alltoall(values.data(), int(each), MPI_UINT16_T, received.data(), int(each), MPI_UINT16_T,
                 MPI_COMM_WORLD);
  });
  double extra = during - before, most = 0;
  MPI_Reduce(&extra, &most, 1, MPI_DOUBLE, MPI_MAX, 0, MPI_COMM_WORLD);
  if (rank == 0)
    fmt::print(
        "{}^3 of 16 bits on {} ranks: commit {:.3f} s, all-to-all of the same bytes {:.3f} s: {:.2f} times; "
        "at "
        "most {:.0f} MiB above the blocks a rank, which has {:.0f} MiB of data: {:.2f} times\n",
        voxels, ranks, median(commits), median(exchange), median(commits) / median(exchange), most, block,
        most / block);
  MPI_Finalize();
}
