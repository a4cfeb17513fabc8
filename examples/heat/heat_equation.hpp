#pragma once
#include <mpi.h>

#include <array>
#include <vector>

/// The heat equation on a cube of side 1 whose faces are cold, in blocks on the ranks of a communicator: an
/// explicit scheme of second order, with one layer of ghost cells around each block.
class HeatEquation {
 public:
  /// `cells` along each axis of the cube.
  HeatEquation(MPI_Comm comm, int cells);
  ~HeatEquation();
  HeatEquation(const HeatEquation&) = delete;
  HeatEquation& operator=(const HeatEquation&) = delete;

  /// Moves on by the longest stable step. A hot spot that circles heats the cube by so much.
  void step(float heating = 1);
  /// Seconds for a diffusivity of 1.
  double time() const { return steps_ / (6.0 * cells_ * cells_); }

  int cells() const { return cells_; }
  MPI_Comm comm() const { return comm_; }
  /// This rank's cells first[k] ... end[k] - 1 along each axis; there may be none.
  const std::array<int, 3>& first() const { return first_; }
  const std::array<int, 3>& end() const { return end_; }
  bool has_cells() const { return width_[0] > 0 && width_[1] > 0 && width_[2] > 0; }
  /// The temperature of cell first(). Its neighbour along x is 1 float away, along y row(), along z plane().
  const float* temperature() const { return now_.data() + at(0, 0, 0); }
  std::ptrdiff_t row() const { return width_[0] + 2; }
  std::ptrdiff_t plane() const { return row() * (width_[1] + 2); }

 private:
  std::size_t at(int x, int y, int z) const {
    return std::size_t((z + 1) * plane() + (y + 1) * row() + x + 1);
  }
  void exchange_ghosts();
  void exchange_ghosts(int axis);
  float source(int x, int y, int z) const;

  MPI_Comm comm_ = MPI_COMM_NULL;
  int cells_, steps_ = 0;
  std::array<int, 3> first_{}, end_{}, width_{};
  std::vector<float> now_, next_;
};
