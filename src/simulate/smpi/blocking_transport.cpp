#include <sys/mman.h>

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <deque>
#include <list>
#include <vector>

#include "base/byte_stream.hpp"
#include "base/process.hpp"
#include "mpi/connections.hpp"
#include "ringsplat/base/error.hpp"
#include "simulate/counted_payload.hpp"

namespace ringsplat {
namespace {

constexpr int message_tag = 1;
/// Number of receives that are always posted: as many messages can be on their way to a rank at once. A
/// further one starts when one of these is over. More would be slow to simulate, since each wait is
/// registered with all of them.
constexpr std::size_t receives = 12;

/// Reserves address space for messages of any size; only touched pages take memory.
class ReceiveBuffers {
 public:
  explicit ReceiveBuffers(std::size_t largest) : largest_(largest), memory_(map_memory(receives * largest)) {}

  std::byte* at(std::size_t index) const { return memory_.get() + index * largest_; }
  /// Whether a message has come since `clear`. The simulator copies it within this process when its transfer
  /// ends, so looking costs nothing. MPI_Testany would call the simulator for each look; and SimGrid 3.32
  /// leaves requests completed by a test in a list that every later event walks, while it removes those that
  /// were waited for.
  bool written(std::size_t index) const {
    decltype(Header::magic) magic;
    std::memcpy(&magic, at(index) + offsetof(Header, magic), sizeof(magic));
    return magic != 0;
  }
  void clear(std::size_t index) const {
    const auto nothing = decltype(Header::magic){};
    std::memcpy(at(index) + offsetof(Header, magic), &nothing, sizeof(nothing));
  }
  /// Gives the memory of a long message back.
  void forget(std::size_t index, std::size_t used) const {
    constexpr std::size_t worth_it = 256 << 10;
    if (used > worth_it) madvise(at(index), used, MADV_DONTNEED);
  }

 private:
  std::size_t largest_;
  MappedMemory memory_;
};

/// Blocks in MPI until a message is here or one has left: with simulated MPI polling an empty queue costs
/// simulated time, and a blocked rank holds no core.
class BlockingTransport final : public Transport {
 public:
  BlockingTransport(MPI_Comm comm, std::size_t largest_message)
      : comm_(comm), largest_(largest_message), buffers_(largest_message), receiving_(receives) {
    for (std::size_t k = 0; k < receives; ++k) post_receive(k);
  }

  ~BlockingTransport() override {
    for (auto& request : receiving_) {
      MPI_Cancel(&request);
      MPI_Request_free(&request);
    }
    for (auto& sending : sending_) MPI_Request_free(&sending.request);
  }

  int rank() const override { return comm_.rank(); }
  int ranks() const override { return comm_.ranks(); }

  void send(int destination, Message message) override {
    sending_.push_back({std::move(message), MPI_REQUEST_NULL});
    Sending& sending = sending_.back();
    const auto block = sending.message.seal();
    if (block.size() > largest_)
      throw RunError(
          fmt::format("a message of {} bytes is too long for a simulated run, which takes up to {}",
                      block.size(), largest_),
          "use more Renderers, smaller regions or a smaller --bundle");
    checked(MPI_Isend(block.data(), static_cast<int>(block.size()), MPI_BYTE, destination, message_tag,
                      comm_.get(), &sending.request),
            "MPI_Isend");
  }

  std::optional<Message> receive() override {
    for (std::size_t k = 0; k < receives && here_.empty(); ++k) {
      if (!buffers_.written(k)) continue;
      MPI_Status status;
      checked(MPI_Wait(&receiving_[k], &status), "MPI_Wait");
      take(k, status);
    }
    if (here_.empty()) return std::nullopt;
    Message message = std::move(here_.front());
    here_.pop_front();
    return message;
  }

  bool sends_done() override {
    sending_.remove_if([](Sending& sending) {
      int done = 0;
      checked(MPI_Test(&sending.request, &done, MPI_STATUS_IGNORE), "MPI_Test");
      return done != 0;
    });
    return sending_.empty();
  }

  void note_progress() override {
    if (sending_.size() > 16) sends_done();
  }

  void wait_next() override {
    std::vector<MPI_Request> any = receiving_;
    for (const auto& sending : sending_) any.push_back(sending.request);
    int index = 0;
    MPI_Status status;
    checked(MPI_Waitany(static_cast<int>(any.size()), any.data(), &index, &status), "MPI_Waitany");
    const auto done = static_cast<std::size_t>(index);
    if (done < receives) {
      receiving_[done] = any[done];
      take(done, status);
    } else {
      sending_.erase(std::next(sending_.begin(), static_cast<std::ptrdiff_t>(done - receives)));
    }
  }

 private:
  struct Sending {
    Message message;
    MPI_Request request;
  };

  void post_receive(std::size_t index) {
    buffers_.clear(index);
    checked(MPI_Irecv(buffers_.at(index), static_cast<int>(largest_), MPI_BYTE, MPI_ANY_SOURCE, message_tag,
                      comm_.get(), &receiving_[index]),
            "MPI_Irecv");
  }

  void take(std::size_t index, const MPI_Status& status) {
    int count = 0;
    checked(MPI_Get_count(&status, MPI_BYTE, &count), "MPI_Get_count");
    const auto size = static_cast<std::size_t>(count);
    const std::byte* first = buffers_.at(index);
    Header header;
    std::memcpy(&header, first, std::min(size, sizeof(Header)));
    // The rest of a payload that only counts was never written; not reading it saves its memory.
    const bool counted = header.magic == counted_magic;
    Bytes block(size);
    std::memcpy(block.data(), first, counted ? std::min(size, counted_bytes) : size);
    if (counted) {
      header.magic = Header{}.magic;
      std::memcpy(block.data(), &header, sizeof(Header));
    }
    buffers_.forget(index, size);
    post_receive(index);
    here_.push_back(Message::from_wire(std::move(block), status.MPI_SOURCE));
  }

  OwnedComm comm_;
  std::size_t largest_;
  ReceiveBuffers buffers_;
  std::vector<MPI_Request> receiving_;  ///< by buffer; always posted
  std::list<Sending> sending_;
  std::deque<Message> here_;
};

}  // namespace

std::unique_ptr<Transport> make_mpi_transport(MPI_Comm comm, std::size_t) {
  constexpr std::size_t largest_message = std::size_t{64} << 20;
  return std::make_unique<BlockingTransport>(comm, largest_message);
}

}  // namespace ringsplat
