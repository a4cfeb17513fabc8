#pragma once
#include <memory>
#include <type_traits>

namespace ringsplat {

class Collectives;
class Transport;
class Processes;

/// Duplicates a communicator and connects its processes; collective. Specialised for MPI_Comm in
/// ringsplat/mpi/communicator.hpp.
template <class Communicator>
Processes connected(Communicator) = delete;

/// The processes that share a volume and its pictures: this one alone, or those of a communicator.
class Processes {
 public:
  /// This process alone, without MPI.
  Processes();
  /// Those of an MPI_Comm. All of them call it; the communicator itself carries no message of ours.
  template <class Communicator>
  requires std::is_integral_v<Communicator> || std::is_pointer_v<Communicator> Processes(Communicator comm)
      : Processes(connected<Communicator>(comm)) {}
  /// Without a transport all nodes run in this process.
  Processes(std::unique_ptr<Collectives> collectives, std::unique_ptr<Transport> transport);
  Processes(Processes&&) noexcept;
  Processes& operator=(Processes&&) noexcept;
  ~Processes();

  int rank() const;
  int ranks() const;
  Collectives& collectives() { return *collectives_; }
  Transport* transport() { return transport_.get(); }

 private:
  std::unique_ptr<Collectives> collectives_;
  std::unique_ptr<Transport> transport_;
};

}  // namespace ringsplat
