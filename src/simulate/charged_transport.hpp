#pragma once
#include <utility>

#include "base/clock.hpp"
#include "net/transport_decorator.hpp"
#include "simulate/charge.hpp"
#include "simulate/counted_payload.hpp"
#include "simulate/machine.hpp"

namespace ringsplat {

/// Charges the software costs of messages between ranks. The simulator adds the network's time itself.
class ChargedTransport final : public TransportDecorator {
 public:
  /// `transport` must outlive it. `count_only`: payloads only count.
  ChargedTransport(Transport& transport, const Machine& machine, bool count_only)
      : TransportDecorator(transport),
        machine_(machine),
        count_only_(count_only),
        shared_(shares_cores(machine, transport.ranks())) {}

  void send(int destination, Message message) override {
    Header& h = message.header;
    charge(sending_seconds(machine_, static_cast<double>(sizeof(Header) + h.bytes)));
    if (h.kind == Kind::token) charge(machine_.gp.token);
    if (h.kind == Kind::payload && count_only_) h.magic = counted_magic;
    inner_.send(destination, std::move(message));
  }
  std::optional<Message> receive() override {
    auto message = inner_.receive();
    if (message) charge(machine_.message.receive);
    return message;
  }
  /// A rank that waits has yielded its core, where others may compute.
  void wait_next() override {
    const double since = now_seconds();
    inner_.wait_next();
    if (shared_ && now_seconds() > since) sleep_simulated(machine_.message.wake);
  }
  void only_first_work(int ranks) override {
    shared_ = shares_cores(machine_, ranks);
    inner_.only_first_work(ranks);
  }

 private:
  Machine machine_;
  bool count_only_;
  bool shared_;  ///< more ranks work than there are cores
};

}  // namespace ringsplat
