#include "heat_equation.hpp"

#include <cmath>
#include <utility>

HeatEquation::HeatEquation(MPI_Comm comm, int cells) : cells_(cells) {
  int ranks = 0, rank = 0;
  MPI_Comm_size(comm, &ranks);
  std::array<int, 3> blocks{}, place{};
  const std::array<int, 3> periodic{};
  MPI_Dims_create(ranks, 3, blocks.data());
  MPI_Cart_create(comm, 3, blocks.data(), periodic.data(), 0, &comm_);
  MPI_Comm_rank(comm_, &rank);
  MPI_Cart_coords(comm_, rank, 3, place.data());
  for (std::size_t k = 0; k < 3; ++k) {
    first_[k] = cells * place[k] / blocks[k];
    end_[k] = cells * (place[k] + 1) / blocks[k];
    width_[k] = end_[k] - first_[k];
  }
  now_.assign(std::size_t(plane() * (width_[2] + 2)), 0.0F);
  next_ = now_;
}

HeatEquation::~HeatEquation() { MPI_Comm_free(&comm_); }

void HeatEquation::step(float heating) {
  exchange_ghosts();
  constexpr float share = 1.0F / 6;  // diffusivity * time step / cell width^2: the largest that is stable
  for (int z = 0; z < width_[2]; ++z)
    for (int y = 0; y < width_[1]; ++y) {
      const std::size_t first = at(0, y, z);
      for (std::size_t k = first; k < first + std::size_t(width_[0]); ++k) {
        const float around = now_[k - 1] + now_[k + 1] + now_[k - std::size_t(row())] +
                             now_[k + std::size_t(row())] + now_[k - std::size_t(plane())] +
                             now_[k + std::size_t(plane())];
        next_[k] = now_[k] + share * (around - 6 * now_[k]);
      }
      for (int x = 0; x < width_[0]; ++x)
        next_[at(x, y, z)] += heating * source(first_[0] + x, first_[1] + y, first_[2] + z);
    }
  std::swap(now_, next_);
  ++steps_;
}

float HeatEquation::source(int x, int y, int z) const {
  const float angle = 0.02F * float(steps_), middle = 0.5F * float(cells_), turn = 0.3F * float(cells_);
  const float dx = float(x) - middle - turn * std::cos(angle),
              dy = float(y) - middle - turn * std::sin(angle);
  const float dz = float(z) - middle - 0.5F * turn * std::sin(2 * angle), radius = 0.05F * float(cells_);
  const float distance = dx * dx + dy * dy + dz * dz;
  return distance < radius * radius ? 1.0F : 0.0F;
}

void HeatEquation::exchange_ghosts() {
  for (int axis = 0; axis < 3; ++axis) exchange_ghosts(axis);
}

void HeatEquation::exchange_ghosts(int axis) {
  int before = 0, after = 0;
  MPI_Cart_shift(comm_, axis, 1, &before, &after);
  const std::array<int, 3> sizes{width_[2] + 2, width_[1] + 2, width_[0] + 2};
  const std::size_t k = 2 - std::size_t(axis);  // MPI counts the slowest axis first
  std::array<int, 3> face = sizes, start{};
  face[k] = 1;
  const auto side = [&](int layer) {
    start[k] = layer;
    MPI_Datatype type = MPI_DATATYPE_NULL;
    MPI_Type_create_subarray(3, sizes.data(), face.data(), start.data(), MPI_ORDER_C, MPI_FLOAT, &type);
    MPI_Type_commit(&type);
    return type;
  };
  const int width = width_[std::size_t(axis)];
  for (const auto& [from, to, out, in] :
       {std::array{before, after, width, 0}, std::array{after, before, 1, width + 1}}) {
    MPI_Datatype sent = side(out), received = side(in);
    MPI_Sendrecv(now_.data(), 1, sent, to, axis, now_.data(), 1, received, from, axis, comm_,
                 MPI_STATUS_IGNORE);
    MPI_Type_free(&sent);
    MPI_Type_free(&received);
  }
}
