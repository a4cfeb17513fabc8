#pragma once
#include "base/clock.hpp"
#include "model/charge.hpp"
#include "model/machine.hpp"
#include "net/transport.hpp"

namespace ringsplat {

/// Charges the software costs of messages between ranks. The simulator adds the network's time itself.
class ChargedTransport final : public Transport {
 public:
  /// Both must outlive it.
  ChargedTransport(Transport& transport, const Machine& machine)
      : transport_(transport), machine_(machine), shared_(shares_cores(machine, transport.ranks())) {}
  int rank() const override { return transport_.rank(); }
  int ranks() const override { return transport_.ranks(); }

  void send(int destination, Message message) override {
    const Header& h = message.header;
    charge(sending_seconds(machine_, static_cast<double>(sizeof(Header) + h.bytes)));
    if (h.kind == Kind::token) charge(machine_.gp.token);
    transport_.send(destination, std::move(message));
  }
  std::optional<Message> receive() override {
    auto message = transport_.receive();
    if (message) charge(machine_.message.receive);
    return message;
  }
  bool sends_done() override { return transport_.sends_done(); }
  /// A rank that waits has yielded its core, where others may compute.
  void wait_next() override {
    const double since = now_seconds();
    transport_.wait_next();
    if (shared_ && now_seconds() > since) sleep_simulated(machine_.message.wake);
  }
  void wait_between_frames(const Sleep& sleep) override { transport_.wait_between_frames(sleep); }
  void note_progress() override { transport_.note_progress(); }
  void only_first_work(int ranks) override { transport_.only_first_work(ranks); }

 private:
  Transport& transport_;
  const Machine& machine_;
  bool shared_;  ///< there are more ranks than cores
};

}  // namespace ringsplat
