#include "ringsplat/net/processes.hpp"

#include "net/collectives.hpp"
#include "net/transport.hpp"

namespace ringsplat {

Processes::Processes() : Processes(std::make_unique<SoloCollectives>(), nullptr) {}
Processes::Processes(std::unique_ptr<Collectives> collectives, std::unique_ptr<Transport> transport)
    : collectives_(std::move(collectives)), transport_(std::move(transport)) {}
Processes::Processes(Processes&&) noexcept = default;
Processes& Processes::operator=(Processes&&) noexcept = default;
Processes::~Processes() = default;

Processes Collectives::part(int) { return {}; }

int Processes::rank() const { return collectives_->process(); }
int Processes::ranks() const { return collectives_->processes(); }

}  // namespace ringsplat
